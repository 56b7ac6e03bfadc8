// The smooth projection that keeps parameter estimates in a ball (Pomet and Praly 1992), as de Ruiter, Eqs. (23)-(26).
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

/// d(v) of Eqs. (25), (26) at v = centre + offset: 0 on the sphere of radius eta, 1 on that of radius sqrt(1 + eps) eta.
template <class T, int N>
T ball_level(const Eigen::Matrix<T, N, 1>& offset, const T& eta, const T& eps) {
    return (offset.dot(offset) - eta * eta) / (eps * eta * eta);
}

/// Proj(v, y) of Eq. (23) at v = centre + offset.
///
/// y - d grad(d) grad(d)^T y / |grad(d)|^2 where both d > 0 and grad(d)^T y > 0, else y; the printed "v, otherwise" is a
/// misprint for y. With grad(d) along the offset n and |n|^2 = (1 + eps d) eta^2, both cases are one expression in the
/// positive parts of d and n^T y, without a branch and without a division by |n| = 0.
template <class T, int N>
Eigen::Matrix<T, N, 1> project(const Eigen::Matrix<T, N, 1>& offset, const Eigen::Matrix<T, N, 1>& y, const T& eta,
                               const T& eps) {
    const T d = ball_level(offset, eta, eps), outward = offset.dot(y);
    const T d_positive = 0.5 * (d + abs(d)), outward_positive = 0.5 * (outward + abs(outward));
    return y - d_positive * outward_positive / ((1.0 + eps * d_positive) * eta * eta) * offset;
}

}  // namespace adcs

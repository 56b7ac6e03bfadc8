// The 24 parameters in which a rigid body's angular acceleration is linear without knowing its inertia J, with
// P = J^-1: de Ruiter, Eqs. (14)-(18).
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

template <class T>
using Vec6 = Eigen::Matrix<T, 6, 1>;
template <class T>
using Vec18 = Eigen::Matrix<T, 18, 1>;

/// phi(omega) = [wx^2 wy^2 wz^2 wx wy wx wz wy wz]^T, Eq. (16).
template <class T>
Vec6<T> phi(const Vec3<T>& w) {
    Vec6<T> products;
    products << w[0] * w[0], w[1] * w[1], w[2] * w[2], w[0] * w[1], w[0] * w[2], w[1] * w[2];
    return products;
}

/// Phi(omega) theta with Phi = diag{phi^T, phi^T, phi^T}, Eq. (15).
template <class T>
Vec3<T> Phi_times(const Vec3<T>& omega, const Vec18<T>& theta) {
    const Vec6<T> row = phi(omega);
    return {row.dot(theta.template segment<6>(0)), row.dot(theta.template segment<6>(6)),
            row.dot(theta.template segment<6>(12))};
}

/// Phi(omega)^T x.
template <class T>
Vec18<T> PhiT_times(const Vec3<T>& omega, const Vec3<T>& x) {
    const Vec6<T> row = phi(omega);
    Vec18<T> stacked;
    stacked << x[0] * row, x[1] * row, x[2] * row;
    return stacked;
}

/// Psi(tau)^T x, with Psi of Eq. (18).
template <class T>
Vec6<T> PsiT_times(const Vec3<T>& tau, const Vec3<T>& x) {
    Vec6<T> stacked;
    stacked << tau[0] * x[0], tau[1] * x[1], tau[2] * x[2],  //
        tau[1] * x[0] + tau[0] * x[1], tau[2] * x[0] + tau[0] * x[2], tau[2] * x[1] + tau[1] * x[2];
    return stacked;
}

/// theta_p = [P11 P22 P33 P12 P13 P23]^T of a symmetric P.
template <class T>
Vec6<T> theta_p_of(const Mat3<T>& P) {
    Vec6<T> theta_p;
    theta_p << P(0, 0), P(1, 1), P(2, 2), P(0, 1), P(0, 2), P(1, 2);
    return theta_p;
}

/// The symmetric P of a theta_p.
template <class T>
Mat3<T> P_of(const Vec6<T>& theta_p) {
    Mat3<T> P;
    P << theta_p[0], theta_p[3], theta_p[4],  //
        theta_p[3], theta_p[1], theta_p[5],   //
        theta_p[4], theta_p[5], theta_p[2];
    return P;
}

/// The theta with Phi(omega) theta = P (omega x J omega) for every omega, Eq. (14).
template <class T>
Vec18<T> theta_of(const Mat3<T>& P, const Mat3<T>& J) {
    const T none = 0.0;
    Eigen::Matrix<T, 3, 6> gyroscopic;  // omega x J omega = gyroscopic * phi(omega)
    gyroscopic << none, J(1, 2), -J(1, 2), J(0, 2), -J(0, 1), J(2, 2) - J(1, 1),  //
        -J(0, 2), none, J(0, 2), -J(1, 2), J(0, 0) - J(2, 2), J(0, 1),            //
        J(0, 1), -J(0, 1), none, J(1, 1) - J(0, 0), J(1, 2), -J(0, 2);
    Vec18<T> theta;
    for (int row = 0; row < 3; ++row) {
        theta.template segment<6>(6 * row) =
            P(row, 0) * gyroscopic.row(0) + P(row, 1) * gyroscopic.row(1) + P(row, 2) * gyroscopic.row(2);
    }
    return theta;
}

}  // namespace adcs

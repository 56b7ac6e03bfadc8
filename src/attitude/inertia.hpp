// Inertia that is unknown or changes with time.
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

/// The elements J11, J12, J13, J22, J23, J33 of a symmetric matrix.
template <class T>
using Vec6 = Eigen::Matrix<T, 6, 1>;

/// One position or velocity a row, of two point masses.
template <class T>
using TwoPoints = Eigen::Matrix<T, 2, 3, Eigen::RowMajor>;

/// Y(v) with Y(v) theta = J v, where theta are the six elements of the symmetric J.
template <class T>
Eigen::Matrix<T, 3, 6> inertia_regressor(const Vec3<T>& v) {
    const T zero = 0.0;
    Eigen::Matrix<T, 3, 6> Y;
    Y << v[0], v[1], v[2], zero, zero, zero,  //
        zero, v[0], zero, v[1], v[2], zero,   //
        zero, zero, v[0], zero, v[1], v[2];
    return Y;
}

/// Inertia of a unit point mass at r: r^T r I - r r^T.
template <class T>
Mat3<T> point_inertia(const Vec3<T>& r) {
    const T xx = r[0] * r[0], yy = r[1] * r[1], zz = r[2] * r[2];
    const T xy = -r[0] * r[1], xz = -r[0] * r[2], yz = -r[1] * r[2];
    Mat3<T> M;
    M << yy + zz, xy, xz,  //
        xy, xx + zz, yz,   //
        xz, yz, xx + yy;
    return M;
}

/// Its time derivative where the point moves with the velocity v.
template <class T>
Mat3<T> point_inertia_rate(const Vec3<T>& r, const Vec3<T>& v) {
    const T xx = 2.0 * r[0] * v[0], yy = 2.0 * r[1] * v[1], zz = 2.0 * r[2] * v[2];
    const T xy = -r[0] * v[1] - r[1] * v[0], xz = -r[0] * v[2] - r[2] * v[0], yz = -r[1] * v[2] - r[2] * v[1];
    Mat3<T> M;
    M << yy + zz, xy, xz,  //
        xy, xx + zz, yz,   //
        xz, yz, xx + yy;
    return M;
}

/// Angular acceleration from J omegaDot = -JDot omega - omega x J omega + torque.
template <class T>
Vec3<T> angular_acceleration(const Mat3<T>& J, const Mat3<T>& JDot, const Vec3<T>& omega, const Vec3<T>& torque) {
    const Vec3<T> H = J * omega;
    return J.inverse() * (torque - JDot * omega - omega.cross(H));
}

/// |v|, with derivative 0 at v = 0, where it has none.
template <class T>
T norm_of(const Vec3<T>& v) {
    const T square = v.dot(v);
    return square > 0.0 ? sqrt(square) : square;
}

}  // namespace adcs

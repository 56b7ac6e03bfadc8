// Attitude quaternions, scalar first. q_BN is the attitude of B relative to N: dcm(q_BN) = C_BN takes the
// components of a vector in N to its components in B.
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

template <class T>
using Quat = Eigen::Matrix<T, 4, 1>;

/// The vector part [q1 q2 q3].
template <class T>
Vec3<T> vec(const Quat<T>& q) {
    return q.template tail<3>();
}

/// C(q) = (q0^2 - |qv|^2) I + 2 qv qv^T - 2 q0 S(qv).
template <class T>
Mat3<T> dcm(const Quat<T>& q) {
    const T& a = q[0];
    const T& x = q[1];
    const T& y = q[2];
    const T& z = q[3];
    Mat3<T> C;
    C << a * a + x * x - y * y - z * z, 2.0 * (x * y + a * z), 2.0 * (x * z - a * y),  //
        2.0 * (x * y - a * z), a * a - x * x + y * y - z * z, 2.0 * (y * z + a * x),   //
        2.0 * (x * z + a * y), 2.0 * (y * z - a * x), a * a - x * x - y * y + z * z;
    return C;
}

/// The quaternion q_BR with C(q_BR) = C(q_BN) C(q_RN)^T.
template <class T>
Quat<T> relative(const Quat<T>& q_BN, const Quat<T>& q_RN) {
    const Vec3<T> b = vec(q_BN);
    const Vec3<T> r = vec(q_RN);
    const Vec3<T> v = q_RN[0] * b - q_BN[0] * r - r.cross(b);
    return {q_BN[0] * q_RN[0] + b.dot(r), v[0], v[1], v[2]};
}

/// Of q and -q, which are one attitude, the one nearer to another quaternion: the smaller turn from it. That term of 0
/// changes no bit; it lets the model structure show that the sign depends on the other.
template <class T>
Quat<T> nearest(const Quat<T>& q, const Quat<T>& to) {
    const T product = q.dot(to);
    const T sign = 0.0 * product + (product < 0.0 ? -1.0 : 1.0);
    return sign * q;
}

/// The attitude error q_BR. Laws that bring it to [1 0 0 0] turn B by less than 180 degrees if its scalar part is positive,
/// else the long way round. Without `short_way` the sign is what the signs of q_BN and q_RN make it; with it the scalar part
/// is never negative.
template <class T>
Quat<T> attitude_error(const Quat<T>& q_BN, const Quat<T>& q_RN, bool short_way) {
    const Quat<T> q_BR = relative(q_BN, q_RN);
    return short_way && q_BR[0] < 0.0 ? Quat<T>(-q_BR) : q_BR;
}

/// Declares `short_way` of a law that uses attitude_error().
template <class V>
void declare_short_way(V& v, bool& short_way) {
    v.parameter("short_way", short_way, "takes of the attitude error q and -q the shorter turn").fixed();
}

/// The quaternion q_BN with C(q_BN) = C(q_BR) C(q_RN).
template <class T>
Quat<T> compose(const Quat<T>& q_BR, const Quat<T>& q_RN) {
    const Vec3<T> b = vec(q_BR);
    const Vec3<T> r = vec(q_RN);
    const Vec3<T> v = q_RN[0] * b + q_BR[0] * r + r.cross(b);
    return {q_BR[0] * q_RN[0] - b.dot(r), v[0], v[1], v[2]};
}

/// qDot_BN = 1/2 [-qv^T; q0 I + S(qv)] omega_BN_B.
template <class T>
Quat<T> kinematics(const Quat<T>& q_BN, const Vec3<T>& omega_BN_B) {
    const Vec3<T> b = vec(q_BN);
    const Vec3<T> v = q_BN[0] * omega_BN_B + b.cross(omega_BN_B);
    return 0.5 * Quat<T>(-b.dot(omega_BN_B), v[0], v[1], v[2]);
}

}  // namespace adcs

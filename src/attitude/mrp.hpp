// Modified Rodrigues parameters (MRP): sigma = k tan(theta / 4), written sigma_BO for the attitude of B relative to O.
// sigma and its shadow -sigma / |sigma|^2 are the same attitude; the one with |sigma| <= 1 is within 180 degrees.
// Equation numbers: thesis on five backstepping attitude controllers, chapter 3 and appendix A.
#pragma once

#include "attitude/quaternion.hpp"

namespace adcs {

template <class T>
using Mrp = Vec3<T>;

/// S(v), with S(v) w = v x w.
template <class T>
Mat3<T> skew(const Vec3<T>& v) {
    const T zero = 0.0;
    Mat3<T> S;
    S << zero, -v[2], v[1], v[2], zero, -v[0], -v[1], v[0], zero;
    return S;
}

/// C(sigma) of (3.19): C(sigma_BO) takes components in O to components in B.
template <class T>
Mat3<T> mrp_dcm(const Mrp<T>& sigma) {
    const T square = sigma.dot(sigma);
    const Mat3<T> S = skew(sigma);
    return Mat3<T>::Identity() + (8.0 * S * S - 4.0 * (1.0 - square) * S) / ((1.0 + square) * (1.0 + square));
}

/// N(sigma) of (3.41): sigmaDot_BO = N(sigma_BO) omega_BO_B.
template <class T>
Mat3<T> mrp_kinematics(const Mrp<T>& sigma) {
    return 0.25 *
           ((1.0 - sigma.dot(sigma)) * Mat3<T>::Identity() + 2.0 * skew(sigma) + 2.0 * sigma * sigma.transpose());
}

/// The MRP with |sigma| <= 1 of a unit quaternion (3.8), (3.12): the shadow where the scalar part is negative.
template <class T>
Mrp<T> mrp_of(const Quat<T>& q) {
    return q[0] < 0.0 ? Mrp<T>(vec(q) / (q[0] - 1.0)) : Mrp<T>(vec(q) / (q[0] + 1.0));
}

/// sigma_2 (x) sigma_1 of (A.11): the attitude with C = C(sigma_2) C(sigma_1).
template <class T>
Mrp<T> mrp_compose(const Mrp<T>& sigma_2, const Mrp<T>& sigma_1) {
    const T a = sigma_1.dot(sigma_1), b = sigma_2.dot(sigma_2);
    return ((1.0 - a) * sigma_2 + (1.0 - b) * sigma_1 - 2.0 * sigma_2.cross(sigma_1)) /
           (1.0 + a * b - 2.0 * sigma_1.dot(sigma_2));
}

/// The error sigma_e of (A.18), attitude of R relative to B, and its Jacobians of (A.19).
template <class T>
struct MrpError {
    Mrp<T> sigma_RB;
    Mat3<T> by_sigma_BO, by_sigma_RO;
};

/// Printed (A.20) and (A.21) lack the factor 2 of the squared norm in dDen; it stands here.
template <class T>
MrpError<T> mrp_error(const Mrp<T>& sigma_BO, const Mrp<T>& sigma_RO) {
    const Mrp<T>&s = sigma_BO, &r = sigma_RO;
    const Mat3<T> I = Mat3<T>::Identity();
    const T a = s.dot(s), b = r.dot(r), den = 1.0 + a * b + 2.0 * s.dot(r);
    const Vec3<T> e = ((1.0 - a) * r - (1.0 - b) * s - 2.0 * s.cross(r)) / den;
    const Vec3<T> dDen_s = 2.0 * b * s + 2.0 * r, dDen_r = 2.0 * a * r + 2.0 * s;
    const Mat3<T> dNum_s = -2.0 * r * s.transpose() - (1.0 - b) * I + 2.0 * skew(r);
    const Mat3<T> dNum_r = 2.0 * s * r.transpose() + (1.0 - a) * I - 2.0 * skew(s);
    return {e, (dNum_s - e * dDen_s.transpose()) / den, (dNum_r - e * dDen_r.transpose()) / den};
}

/// sigma_BO or its shadow, whichever is nearer to sigma_RO: the error is then at most 180 degrees.
template <class T>
Mrp<T> mrp_nearest(const Mrp<T>& sigma_BO, const Mrp<T>& sigma_RO) {
    const T a = sigma_BO.dot(sigma_BO), b = sigma_RO.dot(sigma_RO);
    const T q_0 = (1.0 - a) * (1.0 - b) + 4.0 * sigma_BO.dot(sigma_RO);  // scalar part of the error, times (1+a)(1+b)
    return q_0 < 0.0 && a > 0.0 ? Mrp<T>(-sigma_BO / a) : sigma_BO;
}

}  // namespace adcs

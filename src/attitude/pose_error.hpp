// The pose error of Pan, Wong and Kapila in scaled units, shared by their velocity filter and control law. The equations
// are those of the paper after SI quantities have been divided by units of length, time and mass.
#pragma once

#include "attitude/quaternion.hpp"

namespace adcs {

/// The units in which the law is applied.
template <class T>
struct ScaledUnits {
    T length, time, mass;

    T force() const { return mass * length / (time * time); }
    T torque() const { return force() * length; }
    T inertia() const { return mass * length * length; }
    T mu() const { return length * length * length / (time * time); }
};

/// r0 = [e_R; e_eps] (31) and what follows from it; position error in scaled units, in B.
template <class T>
struct PoseError {
    Quat<T> q_BR;                // [e_zeta; e_eps]
    Mat3<T> C_BR;                // C_b^d (17)
    Vec3<T> e_R, e_eps;          // (4), (17)
    Mat3<T> P;                   // inverse of T (29)
    Vec3<T> omega_RN_B;          // C_b^d omega_d
    T attitude_gain;             // k1 / (1 - e_eps.e_eps)^2, the lower block of Gamma
    Vec3<T> gamma_R, gamma_eps;  // Gamma r0

    /// (P (e_f2 + e_eps) - C omega_d) x e_R: minus the upper block of Omega_2 (39).
    Vec3<T> minus_omega_2(const Vec3<T>& e_f2) const {
        const Vec3<T> turn = P * (e_f2 + e_eps) - omega_RN_B;
        return turn.cross(e_R);
    }
};

/// T = 1/2 (e_zeta I + e_eps^x) has the determinant e_zeta/8 (in print e_zeta) because of 1 - e_eps.e_eps = e_zeta^2, and
/// the inverse P = 2/e_zeta (e_zeta^2 I + e_eps e_eps^T - e_zeta e_eps^x): it grows without bound towards 180 degrees.
template <class T>
PoseError<T> pose_error(const ScaledUnits<T>& units, const Vec3<T>& r_BN_N, const Vec3<T>& r_RN_N, const Quat<T>& q_BN,
                        const Quat<T>& q_RN, const Vec3<T>& omega_RN_R, const T& k_0, const T& k_1) {
    PoseError<T> e;
    e.q_BR = relative(q_BN, q_RN);
    e.C_BR = dcm(e.q_BR);
    const Vec3<T> difference_N = (r_RN_N - r_BN_N) / units.length;
    e.e_R = dcm(q_BN) * difference_N;
    e.e_eps = vec(e.q_BR);
    const T& zeta = e.q_BR[0];
    const Vec3<T>& x = e.e_eps;
    Mat3<T> cross;
    cross << 0.0, -x[2], x[1], x[2], 0.0, -x[0], -x[1], x[0], 0.0;
    e.P = 2.0 / zeta * (x * x.transpose() - zeta * cross);
    for (int i = 0; i < 3; ++i) e.P(i, i) += 2.0 * zeta;
    e.omega_RN_B = units.time * (e.C_BR * omega_RN_R);
    const T room = 1.0 - x.dot(x);
    e.attitude_gain = k_1 / (room * room);
    e.gamma_R = k_0 * e.e_R;
    e.gamma_eps = e.attitude_gain * e.e_eps;
    return e;
}

}  // namespace adcs

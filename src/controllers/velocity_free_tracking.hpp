/// # Velocity-free attitude tracking
///
/// Passivity-based law that tracks a reference attitude without any rate measurement, Eqs. (32) and (90):
///
/// $$u = -a\,\delta\hat q_v - \tfrac b2 E(\delta\hat q)^T\dot\sigma + \hat\omega\times\hat J\hat\omega
///   + \hat J\,C(\delta\hat q)\,\dot\omega_r, \qquad \hat\omega = C(\delta\hat q)\,\omega_r$$
///
/// with $C(\delta\hat q) = C(\hat q)\,C(q_r)^T$, $E(q) = \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix}$, the
/// measured attitude $\hat q$, the assumed inertia $\hat J$, and $\dot\sigma$ from the filter
/// (AttitudeErrorFilter). In print the dot on $\sigma$ is lost; with $\sigma$ in
/// its place the law does not damp. With an exact attitude, the true inertia and no disturbance
///
/// $$V_0 = a\left[\delta q_v^T\delta q_v + (\delta q_0 - 1)^2\right] + \tfrac12\,\delta\omega^T J\,\delta\omega
///   + \tfrac b2\,\dot\sigma^T\dot\sigma, \qquad \dot V_0 = -b\,\lVert\dot\sigma\rVert^2$$
///
/// **Sign.** The law brings $\delta\hat q$ to $[1\ 0\ 0\ 0]$, so from $\delta\hat q_0 < 0$ it turns B by more than 180 degrees
/// though a smaller turn would do. It has no `short_way`: the filter would take a change of sign for a motion. Give $q_r$ the
/// sign with which $\delta\hat q_0(0) \ge 0$.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct VelocityFreeTracking {
    static constexpr auto summary = "Passivity-based attitude tracking without any rate measurement";
    static constexpr auto reference =
        "Velocity-free passivity-based attitude tracking with measurement errors, disturbances and inertia mismatch, "
        "Eqs. (32), (90)";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};
    Quat<T> sigmaDot_BR{0.0, 0.0, 0.0, 0.0};
    Mat3<T> J_B{{0.0465, -0.0007, 0.0004}, {-0.0007, 0.0486, -0.0021}, {0.0004, -0.0021, 0.0482}};
    T a = 0.2, b = 0.8;
    Vec3<T> torque_B{0.0, 0.0, 0.0};
    Quat<T> q_BR{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "measured attitude of B relative to N").unit_quaternion();
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.input("sigmaDot_BR", sigmaDot_BR, unit::one_per_s, "rate of the filtered error quaternion");
        v.parameter("J_B", J_B, unit::kg_m2, "inertia that the law assumes, in B").inertia();
        v.parameter("a", a, unit::N_m, "attitude gain").above(0);
        v.parameter("b", b, unit::N_m_s, "damping gain").above(0);
        v.output("torque_B", torque_B, unit::N_m, "u, commanded torque, in B");
        v.output("q_BR", q_BR, unit::one, "measured attitude error, B relative to R").unit_quaternion();
    }

    void outputs() {
        q_BR = relative(q_BN, q_RN);
        const Mat3<T> C_BR = dcm(q_BR);
        const Vec3<T> omega = C_BR * omega_RN_R;
        const Vec3<T> feed_forward = omega.cross(J_B * omega) + J_B * (C_BR * omegaDot_RN_R);
        const Vec3<T> damping = vec(relative(sigmaDot_BR, q_BR));  // E(q)^T x is the vector part of q^-1 x
        torque_B = -a * vec(q_BR) - 0.5 * b * damping + feed_forward;
    }
};

}  // namespace adcs

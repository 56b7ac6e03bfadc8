/// # Smooth angular velocity observer
///
/// Estimates the angular velocity from the measured attitude and the commanded torque, without a gyro and without
/// switching, Eqs. (5.11) and (5.12). The estimate is the attitude and rate of a frame E:
///
/// $$\dot{\hat q} = \tfrac12 E(\hat q)\left(\hat\omega + \lambda\, C(\tilde q)^T \tilde q_v\right)$$
/// $$\dot{\hat\omega} = C(\tilde q)^T J^{-1}\left[\gamma\,\tilde q_v - \hat\omega_B\times J\hat\omega_B + \tau
///   - \lambda J\,(\tilde q_v\times\hat\omega_B)\right]$$
///
/// with $C(\tilde q) = C(q)\,C(\hat q)^T$ and $\hat\omega_B = C(\tilde q)\,\hat\omega$, the estimate in B. With
/// $\tilde\omega = \omega - \hat\omega_B$, exact measurements and the true inertia
///
/// $$V_o = \gamma\left[(1 - \tilde q_0)^2 + \tilde q_v^T\tilde q_v\right] + \tfrac12\,\tilde\omega^T J\tilde\omega,
///   \qquad \dot V_o = -\gamma\lambda\,\lVert\tilde q_v\rVert^2$$
///
/// **Sign.** The observer brings $\tilde q$ to $[1\ 0\ 0\ 0]$, so from $\tilde q_0 < 0$ the estimate turns by more than 180
/// degrees though a smaller turn would do. With `short_way` it takes that of $\tilde q$ and $-\tilde q$ with
/// $\tilde q_0 \ge 0$; $V_o$ then has $1 - \lvert\tilde q_0\rvert$ in place of $1 - \tilde q_0$ in
/// $2\gamma(1 - \tilde q_0)$, its first term, and still does not jump or grow.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct SmoothRateObserver {
    static constexpr auto summary = "Smooth angular velocity observer from attitude and torque, no gyro";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (5.11)-(5.12)";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> torque_B{0.0, 0.0, 0.0};
    Mat3<T> J_B{{10.0, 1.2, 0.5}, {1.2, 19.0, 1.5}, {0.5, 1.5, 25.0}};
    T lambda = 1.0, gamma = 3.0;
    bool short_way = false;
    Quat<T> q_EN{1.0, 0.0, 0.0, 0.0}, qDot_EN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_EN_E{0.0, 0.0, 0.0}, omegaDot_EN_E{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B_est{0.0, 0.0, 0.0};
    Quat<T> q_BE{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "measured attitude of B relative to N").unit_quaternion();
        v.input("torque_B", torque_B, unit::N_m, "torque acting on the body, in B");
        v.parameter("J_B", J_B, unit::kg_m2, "inertia that the observer assumes, in B").inertia();
        v.parameter("lambda", lambda, unit::one_per_s, "attitude correction gain").above(0);
        v.parameter("gamma", gamma, unit::N_m, "rate correction gain").above(0);
        declare_short_way(v, short_way);
        v.state("q_EN", q_EN, qDot_EN, unit::one, "estimated attitude: E relative to N").unit_quaternion();
        v.state("omega_EN_E", omega_EN_E, omegaDot_EN_E, unit::rad_per_s, "angular velocity of E relative to N, in E")
            .nominal(0.1);
        v.output("omega_BN_B_est", omega_BN_B_est, unit::rad_per_s, "estimate of omega_BN_B: omega_EN_E turned into B")
            .nominal(0.1);
        v.output("q_BE", q_BE, unit::one, "estimation error of the attitude, B relative to E").unit_quaternion();
    }

    void outputs() {
        q_BE = attitude_error(q_BN, q_EN, short_way);
        omega_BN_B_est = dcm(q_BE) * omega_EN_E;
    }

    void derivatives() {
        const Mat3<T> C_EB = dcm(q_BE).transpose();
        const Vec3<T> error = vec(q_BE);
        const Vec3<T>& omega = omega_BN_B_est;
        const Vec3<T> H_B = J_B * omega;
        qDot_EN = kinematics<T>(q_EN, omega_EN_E + lambda * (C_EB * error));
        omegaDot_EN_E =
            C_EB * (J_B.inverse() * (gamma * error - omega.cross(H_B) + torque_B) - lambda * error.cross(omega));
    }
};

}  // namespace adcs

/// # PD attitude tracking
///
/// Proportional-derivative law with feed-forward, Eq. (5.1):
///
/// $$\tau = -k_p\,q_{e,v} - k_v\,\omega_e + J\,C(q_e)\,\dot\omega_r + \omega_r^B \times J\omega_r^B$$
///
/// with $C(q_e) = C(q)\,C(q_r)^T$, $\omega_r^B = C(q_e)\,\omega_r$ and $\omega_e = \omega - \omega_r^B$. Fed with the
/// estimate of an angular velocity observer instead of $\omega$ it is Eq. (5.27). With exact feedback
///
/// $$V_c = k_p\left[(1 - q_{e0})^2 + q_{e,v}^T q_{e,v}\right] + \tfrac12\,\omega_e^T J\omega_e, \qquad
///   \dot V_c = -k_v\,\lVert\omega_e\rVert^2$$
///
/// **Sign.** The law brings $q_e$ to $[1\ 0\ 0\ 0]$, so from $q_{e0} < 0$ it turns B by more than 180 degrees though a smaller
/// turn would do. With `short_way` it takes that of $q_e$ and $-q_e$ with $q_{e0} \ge 0$; $V_c$ then has
/// $1 - \lvert q_{e0}\rvert$ in place of $1 - q_{e0}$ in $2 k_p (1 - q_{e0})$, its first term, and still does not jump or
/// grow; the torque jumps by $2 k_p\,q_{e,v}$ where $q_{e0} = 0$, at which noise can keep it busy.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct PdTracking {
    static constexpr auto summary = "Proportional-derivative attitude tracking with feed-forward";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (5.1), (5.27)";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};
    Mat3<T> J_B{{10.0, 1.2, 0.5}, {1.2, 19.0, 1.5}, {0.5, 1.5, 25.0}};
    T k_p = 1.5, k_v = 5.0;
    bool short_way = false;
    Vec3<T> torque_B{0.0, 0.0, 0.0}, omega_BR_B{0.0, 0.0, 0.0};
    Quat<T> q_BR{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B, or its estimate")
            .nominal(0.1);
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.parameter("J_B", J_B, unit::kg_m2, "inertia that the law assumes, in B").inertia();
        v.parameter("k_p", k_p, unit::N_m, "attitude gain").above(0);
        v.parameter("k_v", k_v, unit::N_m_s, "rate gain").above(0);
        declare_short_way(v, short_way);
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
        v.output("q_BR", q_BR, unit::one, "attitude error, B relative to R").unit_quaternion();
        v.output("omega_BR_B", omega_BR_B, unit::rad_per_s, "rate error, B relative to R, in B").nominal(0.1);
    }

    void outputs() {
        q_BR = attitude_error(q_BN, q_RN, short_way);
        const Mat3<T> C_BR = dcm(q_BR);
        const Vec3<T> omega_RN_B = C_BR * omega_RN_R;
        omega_BR_B = omega_BN_B - omega_RN_B;
        const Vec3<T> H_RN_B = J_B * omega_RN_B;
        torque_B = -k_p * vec(q_BR) - k_v * omega_BR_B + J_B * (C_BR * omegaDot_RN_R) + omega_RN_B.cross(H_RN_B);
    }
};

}  // namespace adcs

/// # Immersion and invariance disturbance observer
///
/// Estimates a disturbance torque as $\hat T_d + \beta(\omega)$ with $\beta = \gamma J_0^{-1}\omega$ (8.63) and, Eq. (8.61),
///
/// $$\dot{\hat T}_d = -\gamma J_0^{-1}\left(\dot x_{2,c} - c_2\bar z_2 - K\bar z_2 - W^T\bar z_1 + \dot\chi_2\right)$$
///
/// The bracket is the acceleration that the controller expects of its torque and its estimate. The error
/// $\eta = \hat T_d + \beta - T_d$ then obeys $\dot\eta = -\dot T_d - \gamma J_0^{-1}J_0^{-1}\eta$ (8.62), whatever the
/// tracking error does. Sampled with a period, by Euler steps; the estimate starts at 0. With `update_first` 1 the step is
/// made before the estimate is used, with 0 after.
#pragma once

#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct ImmersionInvarianceObserver {
    static constexpr auto summary =
        "Disturbance torque from the rate and the expected acceleration, by immersion and invariance";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Sec. 8.6";

    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, acceleration_expected_B{0.0, 0.0, 0.0};
    Mat3<T> J0_B{{37.0 / 12.0, 0.0, 0.0}, {0.0, 37.0 / 12.0, 0.0}, {0.0, 0.0, 25.0 / 12.0}};
    T gamma = 50.0, period = 0.1;
    std::int32_t update_first = 1;
    Vec3<T> state{0.0, 0.0, 0.0}, torque_disturbance_B_est{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.01);
        v.input("acceleration_expected_B", acceleration_expected_B, unit::rad_per_s2,
                "acceleration that the controller expects, in B")
            .nominal(1e-3);
        v.parameter("J0_B", J0_B, unit::kg_m2, "J_0, inertia that the observer assumes, in B").inertia();
        v.parameter("gamma", gamma, unit::kg2_m4_per_s, "gamma, gain").above(0);
        v.parameter("period", period, unit::s, "sampling period").fixed().above(0);
        v.parameter("update_first", update_first, "1: update, then use; 0: use, then update")
            .fixed()
            .at_least(0)
            .at_most(1);
        v.sampled(period);
        v.held("state", state, unit::N_m, "state of the estimator");
        v.held("torque_disturbance_B_est", torque_disturbance_B_est, unit::N_m,
               "estimate of the disturbance torque, in B")
            .output()
            .nominal(1e-4);
    }

    void sample(const Sample& s) {
        const Mat3<T> J0_inverse = J0_B.inverse();
        const Vec3<T> beta = gamma * (J0_inverse * omega_BN_B);                         // (8.63)
        const Vec3<T> step = -period * gamma * (J0_inverse * acceleration_expected_B);  // (8.61)
        if (s.first) state -= beta;  // so that the first estimate is 0
        if (update_first == 1 && !s.first) state += step;
        torque_disturbance_B_est = state + beta;
        if (update_first == 0) state += step;
    }
};

}  // namespace adcs

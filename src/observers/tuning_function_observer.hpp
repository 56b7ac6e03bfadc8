/// # Tuning-function disturbance observer
///
/// Estimates a disturbance torque from the tracking error of the controller, so that the error and the estimation error
/// share one Lyapunov function, Eq. (8.55) with $\Gamma = G J_0$ (8.81):
///
/// $$\dot{\hat T}_d = \mathrm{Proj}(\Gamma J_0^{-1}\bar z_2) = \mathrm{Proj}(G\,\bar z_2)$$
///
/// $\bar z_2$ is the rate error that the command filters have been taken out of: while the torque saturates, the estimate
/// does not unlearn. The projection (C.16) keeps the estimate in a ball. Sampled with a period, by Euler steps; with
/// `update_first` 1 the step is made before the estimate is used, with 0 after.
#pragma once

#include "controllers/ball_projection.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct TuningFunctionObserver {
    static constexpr auto summary =
        "Disturbance torque from the tracking error of a backstepping law, by tuning functions";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Secs. 8.5 and "
        "C.2";

    Vec3<T> z_2_bar_B{0.0, 0.0, 0.0};
    Mat3<T> G = 15.0 * Mat3<T>::Identity();
    T limit = 0.1, margin = 0.1, period = 0.1;
    std::int32_t update_first = 1;
    Vec3<T> state{0.0, 0.0, 0.0}, torque_disturbance_B_est{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("z_2_bar_B", z_2_bar_B, unit::rad_per_s, "compensated rate error of the controller, in B")
            .nominal(1e-4);
        v.parameter("G", G, unit::N_m, "gain: Gamma J_0^-1").positive_definite();
        v.parameter("limit", limit, unit::N_m, "M, radius of the ball that holds the estimate").above(0);
        v.parameter("margin", margin, unit::one, "delta / M^2, width of the projection's boundary").above(0);
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
        const Vec3<T> step = period * project<T, 3>(state, G * z_2_bar_B, limit, margin);
        if (update_first == 1 && !s.first) state += step;  // no step before the first error was acted upon
        torque_disturbance_B_est = state;
        if (update_first == 0) state += step;
    }
};

}  // namespace adcs

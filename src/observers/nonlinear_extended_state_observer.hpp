/// # Nonlinear extended state observer
///
/// Estimates angular velocity and disturbance torque from the measured rate, Eq. (8.38) with $e = \hat\omega - \omega$:
///
/// $$\dot{\hat\omega} = \mathrm{Proj}\left(J_0^{-1}(-\omega\times J_0\omega + 3n^2\,c_3\times J_0c_3 + T_c + \xi)
///   - \beta_1\,\mathrm{fal}(e,\alpha_1,\delta_1)\right), \qquad
///   \dot\xi = \mathrm{Proj}\left(-\beta_2\,\mathrm{fal}(e,\alpha_2,\delta_2)\right)$$
///
/// with the gain (8.42), linear near the origin: $\mathrm{fal} = |e|^{\alpha}\,\mathrm{sign}(e)$ for $|e| > \delta$, else
/// $e/\delta^{1-\alpha}$, by components. In print a $J_0^{-1}$ stands inside the gravity term. In the linear zone and for a
/// diagonal inertia each axis has the characteristic polynomial (8.80); the estimate is $\hat T_d = \xi$.
///
/// Sampled with a period, by Euler steps: the estimate is used, then propagated. With `torque_delay` 1 the torque of the
/// step before enters the propagation, with 0 the one commanded at this instant.
#pragma once

#include "attitude/definite.hpp"
#include "attitude/gravity_gradient.hpp"
#include "attitude/mrp.hpp"
#include "controllers/ball_projection.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct NonlinearExtendedStateObserver {
    static constexpr auto summary =
        "Disturbance torque and angular velocity from the rate, with high gain near the origin";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Secs. 8.4.1 "
        "and C.2";

    Mrp<T> sigma_BO{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, torque_B{0.0, 0.0, 0.0};
    Mat3<T> J0_B{{37.0 / 12.0, 0.0, 0.0}, {0.0, 37.0 / 12.0, 0.0}, {0.0, 0.0, 25.0 / 12.0}};
    Mat3<T> beta_1 = Mat3<T>::Identity(), beta_2 = 5.0 * J0_B;
    T alpha_1 = 0.2, alpha_2 = 0.4, delta_1 = 0.1, delta_2 = 0.3;
    T orbital_rate = 1.073e-3, rate_limit = 0.034906585039886591, torque_limit = 0.1;
    T rate_margin = 0.005, torque_margin = 0.1, period = 0.1;
    std::int32_t torque_delay = 0;
    Vec3<T> omega_next{0.0, 0.0, 0.0}, xi_next{0.0, 0.0, 0.0}, torque_before{0.0, 0.0, 0.0};
    Vec3<T> torque_disturbance_B_est{0.0, 0.0, 0.0}, omega_BN_B_est{0.0, 0.0, 0.0}, innovation_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("sigma_BO", sigma_BO, unit::one, "measured attitude of B relative to O as MRP").at_least(-1).at_most(1);
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "measured angular velocity of B relative to N, in B")
            .nominal(0.01);
        v.input("torque_B", torque_B, unit::N_m, "T_c, commanded torque, in B");
        v.parameter("J0_B", J0_B, unit::kg_m2, "J_0, inertia that the observer assumes, in B").inertia();
        v.parameter("beta_1", beta_1, unit::one, "gain of the rate estimate").positive_definite();
        v.parameter("beta_2", beta_2, unit::one, "gain of the torque estimate");
        v.parameter("alpha_1", alpha_1, unit::one, "exponent of the rate gain").above(0).at_most(1);
        v.parameter("alpha_2", alpha_2, unit::one, "exponent of the torque gain").above(0).at_most(1);
        v.parameter("delta_1", delta_1, unit::rad_per_s, "half-width of the linear zone of the rate gain").above(0);
        v.parameter("delta_2", delta_2, unit::rad_per_s, "half-width of the linear zone of the torque gain").above(0);
        v.parameter("orbital_rate", orbital_rate, unit::rad_per_s, "n, rate of the circular orbit").at_least(0);
        v.parameter("rate_limit", rate_limit, unit::rad_per_s, "radius of the ball that holds the rate estimate")
            .above(0);
        v.parameter("rate_margin", rate_margin, unit::one, "delta / M^2 of its projection").above(0);
        v.parameter("torque_limit", torque_limit, unit::N_m, "radius of the ball that holds the torque estimate")
            .above(0);
        v.parameter("torque_margin", torque_margin, unit::one, "delta / M^2 of its projection").above(0);
        v.parameter("period", period, unit::s, "sampling period").fixed().above(0);
        v.parameter("torque_delay", torque_delay,
                    "1: propagates with the torque of the step before; 0: with the present one")
            .fixed()
            .at_least(0)
            .at_most(1);
        v.sampled(period);
        v.held("omega_next", omega_next, unit::rad_per_s, "rate estimate for the next sample");
        v.held("xi_next", xi_next, unit::N_m, "torque estimate for the next sample");
        v.held("torque_before", torque_before, unit::N_m, "torque of the sample before");
        v.held("torque_disturbance_B_est", torque_disturbance_B_est, unit::N_m,
               "xi, estimate of the disturbance torque, in B")
            .output()
            .nominal(1e-4);
        v.held("omega_BN_B_est", omega_BN_B_est, unit::rad_per_s, "estimate of the angular velocity, in B")
            .output()
            .nominal(0.01);
        v.held("innovation_B", innovation_B, unit::rad_per_s, "omega_BN_B - omega_BN_B_est (8.40), in B")
            .output()
            .nominal(1e-5);
    }

    void sample(const Sample& s) {
        const Vec3<T>& w = omega_BN_B;
        torque_disturbance_B_est = xi_next;
        omega_BN_B_est = s.first ? w : omega_next;
        innovation_B = w - omega_BN_B_est;

        const Vec3<T> c_3 = mrp_dcm(sigma_BO).col(2);
        const Vec3<T> torque = torque_delay == 1 ? torque_before : torque_B;
        const Vec3<T>&omega = omega_BN_B_est, &xi = torque_disturbance_B_est, &e = innovation_B;
        const Vec3<T> known = gravity_gradient(orbital_rate, c_3, J0_B) - w.cross(J0_B * w) + torque + xi;
        const Vec3<T> omegaDot = J0_B.inverse() * known - beta_1 * fal(-e, alpha_1, delta_1);
        const Vec3<T> xiDot = -beta_2 * fal(-e, alpha_2, delta_2);
        omega_next = omega + period * project<T, 3>(omega, omegaDot, rate_limit, rate_margin);
        xi_next = xi + period * project<T, 3>(xi, xiDot, torque_limit, torque_margin);
        torque_before = torque_B;
    }

    void validate(Words& refuse) const {
        const T determinant = beta_2.determinant();
        if (!(determinant > 0.0))
            refuse("beta_2 has no positive determinant, but %g: the estimate would not converge", determinant);
    }

private:
    static Vec3<T> fal(const Vec3<T>& e, const T& alpha, const T& delta) {  // (8.42)
        Vec3<T> gained;
        for (int i = 0; i < 3; ++i) {
            const T size = abs(e[i]), base = size > delta ? size : delta;
            gained[i] = e[i] * exp((alpha - 1.0) * log(base));
        }
        return gained;
    }
};

}  // namespace adcs

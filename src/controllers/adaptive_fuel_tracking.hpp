/// # Adaptive attitude tracking with fuel loss
///
/// The thrusters that make the torque burn fuel, and the inertia falls with the norm of the torque, Eq. (3.13):
///
/// $$J = J_0 - J_1\int\lVert\tau\rVert\,dt, \qquad \Psi = \psi I, \qquad \dot\psi = \lVert\tau\rVert$$
///
/// The inertia thus changes at a rate that the torque itself sets, which the torque has to account for,
/// Eqs. (3.33), (3.34), (3.40):
///
/// $$\tau = \tau_0 - \lVert\tau\rVert\,\hat J_1\Omega, \qquad
///   \tau_0 = -\beta\,q_{e,v} - k_v\,\omega_e - W_1\hat\theta - W_2\hat\sigma, \qquad
///   \Omega = \omega - \tfrac12\left(\omega_e + q_{e,v}\right)$$
/// $$\lVert\tau\rVert = \frac{-\tau_0^T v + \sqrt{(\tau_0^T v)^2 + (1 - \lVert v\rVert^2)\lVert\tau_0\rVert^2}}
///   {1 - \lVert v\rVert^2}, \qquad v = \hat J_1\Omega$$
///
/// This holds where $\lVert\hat J_1\Omega\rVert < 1$, Eq. (3.39). The output `implementability`,
/// $1 - \lVert\hat J_1\Omega\rVert$, says how far that limit is; beyond it, at zero or below, the torque stays finite
/// but is not this law's. The law estimates the six elements $\theta$ of $J_0$ and the three diagonal elements
/// $\sigma$ of $J_1$, its minimal parametrisation for a tank whose axes are those of the body;
/// AdaptiveFuelTrackingFull estimates all nine. With the regressors $W_i$ explained in AdaptiveAppendageTracking,
///
/// $$\dot{\hat\theta} = \gamma_1\,\mathrm{Proj}(\hat\theta,\; W_1^T s), \qquad
///   \dot{\hat\sigma} = \gamma_2\,\mathrm{Proj}(\hat\sigma,\; (W_2 + W_3)^T s)$$
///
/// and the smooth projection (3.26)-(3.31) keeps $\lVert\hat\sigma\rVert^2 < \varepsilon_2 + \delta_2$ and
/// $\lVert\hat\theta\rVert^2 < \varepsilon_1 + \delta_1$. Along the closed loop
///
/// $$V = \tfrac12 s^T J s + (\beta + k_v)\left[q_{e,v}^T q_{e,v} + (q_{e0} - 1)^2\right] +
///   \tfrac{1}{2\gamma_1}\lVert\hat\theta - \theta\rVert^2 + \tfrac{1}{2\gamma_2}\lVert\hat\sigma - \sigma\rVert^2$$
/// $$\dot V \le -k_v\,\lVert\omega_e\rVert^2 - \beta\,\lVert q_{e,v}\rVert^2$$
///
/// with equality where the projection does not act. With the printed gains the loop is stiff: the adaptation oscillates
/// at 100 rad/s and more, and the projection acts at up to 5000 1/s. Solve it in coupled Model Exchange with an implicit
/// method. For co-simulation set `max_internal_step` to 0.1 ms and exchange every millisecond or more often.
///
/// **Sign.** What AdaptiveTracking says of $q_e$ and $-q_e$, and of `short_way`, holds here too.
#pragma once

#include "controllers/fuel_compensation.hpp"

namespace adcs {

template <class T>
struct AdaptiveFuelTracking : FuelCompensation<T> {
    static constexpr auto summary = "Adaptive attitude tracking while fuel is lost, diagonal of J_1 estimated";

    Vec3<T> sigma_est{0.0, 0.0, 0.0}, sigma_estDot{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        this->declare_compensation(v);
        v.state("sigma_est", sigma_est, sigma_estDot, unit::s, "estimate of the diagonal of J_1, in B").nominal(0.001);
    }

    void outputs() { this->command(Mat3<T>(sigma_est.asDiagonal())); }

    void derivatives() {
        const Vec3<T> Gamma = this->adapt_all().diagonal();
        sigma_estDot = this->update(sigma_est, Gamma, this->gamma_2, this->sigma_bound, this->sigma_margin);
    }

    void validate(Words& refuse) const {
        this->refuse_starts(sigma_est, this->sigma_bound, this->sigma_margin, refuse);
    }
};

}  // namespace adcs

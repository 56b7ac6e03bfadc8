/// # Adaptive attitude tracking with moving appendages, full parametrisation
///
/// The law of AdaptiveAppendageTracking, Eqs. (3.20)-(3.22), with all 18 elements of the unknown $J_1$ as parameters
/// $\sigma\in\mathbb{R}^{3n}$, $n = 6$, as the text introduces it:
///
/// $$\tau = -\beta\,q_{e,v} - k_v\,\omega_e - W_1\hat\theta + \hat J_1\Psi a - \omega\times\hat J_1\Psi\omega
///   - \hat J_1\dot\Psi\,\Omega$$
/// $$\dot{\hat J}_1 = \gamma_2\,\mathrm{Proj}\left(\hat J_1,\; -s\,(\Psi a)^T + (s\times\omega)(\Psi\omega)^T
///   + s\,(\dot\Psi\,\Omega)^T\right)$$
///
/// with the symbols explained there, and the Frobenius norm of $\hat J_1$ in the projection. Any $J_1$ with
/// $J = J_0 - J_1\Psi$ can be tracked; with so many parameters the estimate does not become the true one, which is
/// $-[m_1 I\ \ m_2 I]$. Along the closed loop, without projection,
///
/// $$V = \tfrac12 s^T J s + (\beta + k_v)\left[q_{e,v}^T q_{e,v} + (q_{e0} - 1)^2\right] +
///   \tfrac{1}{2\gamma_1}\lVert\hat\theta - \theta\rVert^2 + \tfrac{1}{2\gamma_2}\lVert\hat J_1 - J_1\rVert_F^2$$
/// $$\dot V = -k_v\,\lVert\omega_e\rVert^2 - \beta\,\lVert q_{e,v}\rVert^2$$
///
/// **Sign.** What AdaptiveTracking says of $q_e$ and $-q_e$, and of `short_way`, holds here too.
#pragma once

#include "controllers/appendage_compensation.hpp"

namespace adcs {

template <class T>
struct AdaptiveAppendageTrackingFull : AppendageCompensation<T> {
    static constexpr auto summary =
        "Adaptive attitude tracking with two moving masses, all 18 elements of J_1 estimated";

    using Parameters = typename AppendageCompensation<T>::Variable::Parameters;
    Parameters J_1_est = Parameters::Zero(), J_1_estDot = Parameters::Zero();

    template <class V>
    void declare(V& v) {
        this->declare_compensation(v);
        v.state("J_1_est", J_1_est, J_1_estDot, unit::kg, "estimate of J_1, in B");
    }

    void outputs() { this->command(J_1_est); }

    void derivatives() {
        const TrackingError<T> e = this->tracking_error();
        this->adapt(e);
        const Parameters Gamma = this->variable_part(e).gradient();
        J_1_estDot = this->update(J_1_est, Gamma, this->gamma_2, this->sigma_bound, this->sigma_margin);
    }

    void validate(Words& refuse) const { this->refuse_starts(J_1_est, this->sigma_bound, this->sigma_margin, refuse); }
};

}  // namespace adcs

/// # Adaptive attitude tracking with fuel loss, full parametrisation
///
/// The law of AdaptiveFuelTracking, Eqs. (3.33), (3.34) and (3.40), with all nine elements of the unknown $J_1$ as
/// parameters $\sigma\in\mathbb{R}^{3n}$, $n = 3$, as the text introduces it:
///
/// $$\dot{\hat J}_1 = \gamma_2\,\mathrm{Proj}\left(\hat J_1,\; -\psi\,s\,a^T + \psi\,(s\times\omega)\,\omega^T
///   + \lVert\tau\rVert\,s\,\Omega^T\right)$$
///
/// with the symbols explained there, and the Frobenius norm of $\hat J_1$ in the projection. It needs no assumption
/// about the tank; with so many parameters the estimate does not become the true $J_1$.
///
/// **Sign.** What AdaptiveTracking says of $q_e$ and $-q_e$, and of `short_way`, holds here too.
#pragma once

#include "controllers/fuel_compensation.hpp"

namespace adcs {

template <class T>
struct AdaptiveFuelTrackingFull : FuelCompensation<T> {
    static constexpr auto summary = "Adaptive attitude tracking while fuel is lost, all nine elements of J_1 estimated";

    Mat3<T> J_1_est = Mat3<T>::Zero(), J_1_estDot = Mat3<T>::Zero();

    template <class V>
    void declare(V& v) {
        this->declare_compensation(v);
        v.state("J_1_est", J_1_est, J_1_estDot, unit::s, "estimate of J_1, in B").nominal(0.001);
    }

    void outputs() { this->command(J_1_est); }

    void derivatives() {
        const Mat3<T> Gamma = this->adapt_all();
        J_1_estDot = this->update(J_1_est, Gamma, this->gamma_2, this->sigma_bound, this->sigma_margin);
    }

    void validate(Words& refuse) const { this->refuse_starts(J_1_est, this->sigma_bound, this->sigma_margin, refuse); }
};

}  // namespace adcs

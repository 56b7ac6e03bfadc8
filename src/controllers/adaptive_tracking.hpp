/// # Adaptive attitude tracking
///
/// Certainty-equivalence law for a rigid body with unknown inertia: Eqs. (3.20) and (3.21) without the part for
/// variable inertia.
///
/// $$\tau = -\beta\,q_{e,v} - k_v\,\omega_e - W_1\hat\theta, \qquad
///   \dot{\hat\theta} = \gamma_1\,\mathrm{Proj}(\hat\theta,\; W_1^T s), \qquad s = \omega_e + q_{e,v}$$
/// $$W_1\theta = J_0 a - \omega\times J_0\omega, \qquad a = \tfrac12\left[q_{e0} I + S(q_{e,v})\right]\omega_e + \phi,
///   \qquad \phi = \omega_e\times C(q_e)\omega_r - C(q_e)\dot\omega_r$$
///
/// with $C(q_e) = C(q)\,C(q_r)^T$ and $\omega_e = \omega - C(q_e)\,\omega_r$. With `gamma_1 = 0` and the true inertia in
/// `theta_est` it is the law for known inertia. The projection, Eqs. (3.26) and (3.27), keeps
/// $\lVert\hat\theta\rVert^2 < \varepsilon_1 + \delta_1$; the default bound is so large that it never acts. Along the
/// closed loop, without projection,
///
/// $$V = \tfrac12 s^T J s + (\beta + k_v)\left[q_{e,v}^T q_{e,v} + (q_{e0} - 1)^2\right] +
///   \tfrac{1}{2\gamma_1}\lVert\hat\theta - \theta\rVert^2, \qquad
///   \dot V = -k_v\,\lVert\omega_e\rVert^2 - \beta\,\lVert q_{e,v}\rVert^2$$
///
/// **Sign.** The law brings $q_e$ to $[1\ 0\ 0\ 0]$, so from $q_{e0} < 0$ it turns B by more than 180 degrees though a smaller
/// turn would do. With `short_way` it takes that of $q_e$ and $-q_e$ with $q_{e0} \ge 0$. Where $q_{e0}$ passes 0, $V$ then
/// jumps by $-2\,\omega_e^T J q_{e,v}$, with $q_{e,v}$ as it was before, which is downwards for a sphere, but can be upwards
/// for other bodies; the torque jumps too.
#pragma once

#include "controllers/certainty_equivalence.hpp"

namespace adcs {

template <class T>
struct AdaptiveTracking : CertaintyEquivalence<T> {
    static constexpr auto summary = "Adaptive attitude tracking of a rigid body with unknown inertia";

    template <class V>
    void declare(V& v) {
        this->declare_tracking(v);
    }
    void outputs() { this->torque_B = this->feedback(this->tracking_error()); }
    void derivatives() { this->adapt(this->tracking_error()); }
    void validate(Words& refuse) const { this->refuse_start(refuse); }
};

}  // namespace adcs

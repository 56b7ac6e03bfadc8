/// # Filter of the attitude error
///
/// Low-pass filter in $\mathbb{R}^4$ that takes the place of a rate measurement, Eq. (33): it is driven by the error
/// quaternion $\delta\hat q$ of the measured attitude,
///
/// $$\dot\sigma = -\sigma + \delta\hat q, \qquad C(\delta\hat q) = C(\hat q)\,C(q_r)^T$$
///
/// and its rate $\dot\sigma$, a difference and not a differentiation, is what a velocity-free control law feeds back. The
/// time constant is 1 s by definition. Start it at the attitude error, $\sigma(0) = \delta\hat q(0)$, so that
/// $\dot\sigma(0) = 0$: the law then starts without a jolt, and $\lVert\sigma\rVert \le 1$ for all time. $\sigma$ is not
/// normalised.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct AttitudeErrorFilter {
    static constexpr auto summary = "Low-pass filter of the attitude error quaternion, whose rate replaces a gyro";
    static constexpr auto reference =
        "Velocity-free passivity-based attitude tracking with measurement errors, disturbances and inertia mismatch, "
        "Eq. (33)";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Quat<T> sigma_BR{1.0, 0.0, 0.0, 0.0}, rate{0.0, 0.0, 0.0, 0.0}, sigmaDot_BR{0.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "measured attitude of B relative to N").unit_quaternion();
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.state("sigma_BR", sigma_BR, rate, unit::one, "sigma, the filtered error quaternion");
        v.output("sigmaDot_BR", sigmaDot_BR, unit::one_per_s, "time derivative of sigma_BR");
    }

    void outputs() { sigmaDot_BR = relative(q_BN, q_RN) - sigma_BR; }

    void derivatives() { rate = sigmaDot_BR; }
};

}  // namespace adcs

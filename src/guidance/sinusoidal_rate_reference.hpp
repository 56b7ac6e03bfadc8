/// # Sinusoidal rate reference
///
/// Reference attitude whose angular velocity is a bias and a sinusoid on each axis of the reference frame R,
///
/// $$\omega_{RN,i}(t) = b_i + a_i \sin(\nu_i t + \varphi_i), \qquad
///   \dot\omega_{RN,i}(t) = a_i \nu_i \cos(\nu_i t + \varphi_i), \qquad i = 1, 2, 3$$
///
/// Rate and acceleration are analytic. The axis of rotation wanders, so the attitude has no elementary form and is
/// a state,
///
/// $$\dot q_{RN} = \tfrac12 \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix} \omega_{RN}$$
///
/// With $t$ the simulation time; the attitude at the start of the run is the start value of $q_{RN}$, whenever that is.
/// Bounds for laws that want them: $\lVert\omega_{RN}\rVert \le \sqrt{\sum_i (|b_i| + |a_i|)^2}$ and
/// $\lVert\dot\omega_{RN}\rVert \le \sqrt{\sum_i a_i^2 \nu_i^2}$.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct SinusoidalRateReference {
    static constexpr auto summary = "Reference attitude with a bias and a sinusoid as angular velocity on each axis";
    static constexpr auto reference = "Made for this project, from no publication";

    T time = 0.0;
    Vec3<T> rate_bias{0.0, 0.0, 0.0};
    Vec3<T> rate_amplitude{0.01, 0.008, 0.006};
    Vec3<T> rate_frequency{0.05, 0.04, 0.03};
    Vec3<T> rate_phase{0.0, 1.0, 1.5707963267948966};
    Quat<T> q_RN{1.0, 0.0, 0.0, 0.0}, qDot_RN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("rate_bias", rate_bias, unit::rad_per_s, "b, constant part of the angular velocity, in R")
            .nominal(0.1);
        v.parameter("rate_amplitude", rate_amplitude, unit::rad_per_s, "a, amplitude of the sinusoid on each axis of R")
            .nominal(0.1);
        v.parameter("rate_frequency", rate_frequency, unit::rad_per_s,
                    "nu, frequency of the sinusoid on each axis of R")
            .nominal(0.1);
        v.parameter("rate_phase", rate_phase, unit::rad, "phi, phase of the sinusoid on each axis of R at time 0");
        v.state("q_RN", q_RN, qDot_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.output("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.output("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
    }

    void outputs() {
        for (int i = 0; i < 3; ++i) {
            const auto [s, c] = sincos(rate_frequency[i] * time + rate_phase[i]);
            omega_RN_R[i] = rate_bias[i] + rate_amplitude[i] * s;
            omegaDot_RN_R[i] = rate_amplitude[i] * rate_frequency[i] * c;
        }
    }

    void derivatives() { qDot_RN = kinematics(q_RN, omega_RN_R); }
};

}  // namespace adcs

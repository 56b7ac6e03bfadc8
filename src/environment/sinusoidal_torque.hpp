/// # Sinusoidal torque
///
/// A disturbance torque with a constant part and a sinusoid on each axis of B,
///
/// $$\tau_i(t) = b_i + a_i \sin(\nu_i t + \varphi_i), \qquad \lVert\tau\rVert \le \sqrt{\sum_i (|b_i| + |a_i|)^2}$$
///
/// The default stays within 1 mN m.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct SinusoidalTorque {
    static constexpr auto summary = "Disturbance torque, a bias and a sinusoid on each axis of the body";
    static constexpr auto reference = "Made for this project, from no publication";

    T time = 0.0;
    Vec3<T> torque_bias{0.0, 0.0, 0.0};
    Vec3<T> torque_amplitude{5e-4, 5e-4, 5e-4};
    Vec3<T> torque_frequency{0.02, 0.03, 0.05};
    Vec3<T> torque_phase{0.0, 2.0, 4.0};
    Vec3<T> torque_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("torque_bias", torque_bias, unit::N_m, "b, constant part, in B").nominal(1e-3);
        v.parameter("torque_amplitude", torque_amplitude, unit::N_m, "a, amplitude on each axis of B").nominal(1e-3);
        v.parameter("torque_frequency", torque_frequency, unit::rad_per_s, "nu, frequency on each axis of B")
            .nominal(0.1);
        v.parameter("torque_phase", torque_phase, unit::rad, "phi, phase on each axis of B at time 0");
        v.output("torque_B", torque_B, unit::N_m, "disturbance torque, in B").nominal(1e-3);
    }

    void outputs() {
        for (int i = 0; i < 3; ++i) {
            torque_B[i] = torque_bias[i] + torque_amplitude[i] * sin(torque_frequency[i] * time + torque_phase[i]);
        }
    }
};

}  // namespace adcs

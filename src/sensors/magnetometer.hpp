/// # Magnetometer
///
/// Measures the magnetic flux density along the axes of B, with a constant bias $b$ and white noise:
///
/// $$B_{meas} = C(q)\,B^N + b + \sigma\,\nu_k$$
///
/// The numbers $\nu_k$ are standard normal and independent on all axes; draw $k$ is a pure function of `seed` and $k$.
/// Measurements are taken every `period` and held in between. With `period` 0 the magnetometer measures continuously, and
/// without noise. The field in N is an input, so that it may come from any model of the Earth's field.
#pragma once

#include "attitude/gaussian.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct Magnetometer {
    static constexpr auto summary = "Magnetic field in the body frame with bias and noise";
    static constexpr auto reference =
        "Markley, Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, 2014, chapter 4";
    static constexpr Stream stream{"Magnetometer"};

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> magnetic_field_N{0.0, 0.0, 0.0}, bias{0.0, 0.0, 0.0};
    T noise = 0.0, period = 0.0;
    std::int32_t seed = 1;
    Vec3<T> noise_B{0.0, 0.0, 0.0}, magnetic_field_B_meas{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "true attitude of B relative to N").unit_quaternion();
        v.input("magnetic_field_N", magnetic_field_N, unit::T, "magnetic flux density at the body, in N").nominal(1e-5);
        v.parameter("bias", bias, unit::T, "b, constant error, in B").fixed().nominal(1e-7);
        v.parameter("noise", noise, unit::T, "sigma, standard deviation per axis").fixed().at_least(0).nominal(1e-7);
        v.parameter("period", period, unit::s, "sampling period; 0: continuous").fixed().at_least(0);
        v.seed("seed", seed, "seed of the noise");
        v.sampled(period);
        v.held("noise_B", noise_B, unit::T, "noise of the last draw, in B").nominal(1e-7);
        v.output("magnetic_field_B_meas", magnetic_field_B_meas, unit::T, "measured magnetic flux density, in B")
            .sampled()
            .nominal(1e-5);
    }

    void sample(const Sample& s) {
        Random random = stream.draw(seed, s.k);
        noise_B = noise * gaussian(random).template cast<T>();
    }

    void outputs() { magnetic_field_B_meas = dcm(q_BN) * magnetic_field_N + bias + noise_B; }

    void validate(Words& refuse) const {
        if (!(period > 0.0) && noise > 0.0)
            refuse("noise is above 0, but period is 0: noise is drawn per sample, give a period");
    }
};

}  // namespace adcs

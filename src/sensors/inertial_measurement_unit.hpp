/// # Inertial measurement unit
///
/// A gyro and an accelerometer along the axes of B, with a constant bias $b$ and white noise:
///
/// $$\omega_{meas} = \omega_{BN}^B + b_g + \sigma_g\,\nu_k, \qquad a_{meas} = f^B + b_a + \sigma_a\,\mu_k$$
///
/// The numbers $\nu_k$ and $\mu_k$ are standard normal and independent on all axes; draw $k$ of the gyro and
/// that of the accelerometer are pure functions of `seed` and $k$. Measurements are taken every `period` and held in
/// between. A noise density $N$, as data sheets give it (rad/s/√Hz), makes the standard deviation
/// $\sigma = N/\sqrt{period}$. With `period` 0 the unit measures continuously, and without noise.
///
/// An accelerometer feels specific force: all forces but gravity, divided by the mass, at the place of the unit. In free
/// fall that is zero, whatever the orbit, and only bias and noise are left.
#pragma once

#include "attitude/gaussian.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct InertialMeasurementUnit {
    static constexpr auto summary = "Gyro and accelerometer with bias and noise";
    static constexpr auto reference =
        "Markley, Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, 2014, chapter 4; without "
        "the drift of the bias";
    static constexpr Stream stream{"InertialMeasurementUnit"};

    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, specific_force_B{0.0, 0.0, 0.0};
    Vec3<T> gyro_bias{0.0, 0.0, 0.0}, accelerometer_bias{0.0, 0.0, 0.0};
    T gyro_noise = 0.0, accelerometer_noise = 0.0, period = 0.0;
    std::int32_t seed = 1;
    Vec3<T> gyro_noise_B{0.0, 0.0, 0.0}, accelerometer_noise_B{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B_meas{0.0, 0.0, 0.0}, specific_force_B_meas{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "true angular velocity of B relative to N, in B")
            .nominal(0.01);
        v.input("specific_force_B", specific_force_B, unit::m_per_s2,
                "force but gravity over mass, at the unit, in B; 0 in free fall");
        v.parameter("gyro_bias", gyro_bias, unit::rad_per_s, "b_g, bias of the gyro, in B").fixed().nominal(1e-4);
        v.parameter("gyro_noise", gyro_noise, unit::rad_per_s, "sigma_g, standard deviation of the rate per axis")
            .fixed()
            .at_least(0)
            .nominal(1e-4);
        v.parameter("accelerometer_bias", accelerometer_bias, unit::m_per_s2, "b_a, bias of the accelerometer, in B")
            .fixed()
            .nominal(1e-2);
        v.parameter("accelerometer_noise", accelerometer_noise, unit::m_per_s2,
                    "sigma_a, standard deviation of the specific force per axis")
            .fixed()
            .at_least(0)
            .nominal(1e-2);
        v.parameter("period", period, unit::s, "sampling period; 0: continuous").fixed().at_least(0);
        v.seed("seed", seed, "seed of the noise");
        v.sampled(period);
        v.held("gyro_noise_B", gyro_noise_B, unit::rad_per_s, "noise of the last draw, in B").nominal(1e-4);
        v.held("accelerometer_noise_B", accelerometer_noise_B, unit::m_per_s2, "noise of the last draw, in B")
            .nominal(1e-2);
        v.output("omega_BN_B_meas", omega_BN_B_meas, unit::rad_per_s, "measured angular velocity, in B")
            .sampled()
            .nominal(0.01);
        v.output("specific_force_B_meas", specific_force_B_meas, unit::m_per_s2, "measured specific force, in B")
            .sampled();
    }

    void sample(const Sample& s) {
        Random gyro = stream["gyro"].draw(seed, s.k), accelerometer = stream["accelerometer"].draw(seed, s.k);
        const Vec3<double> nu = gaussian(gyro), mu = gaussian(accelerometer);
        gyro_noise_B = gyro_noise * nu.template cast<T>();
        accelerometer_noise_B = accelerometer_noise * mu.template cast<T>();
    }

    void outputs() {
        omega_BN_B_meas = omega_BN_B + gyro_bias + gyro_noise_B;
        specific_force_B_meas = specific_force_B + accelerometer_bias + accelerometer_noise_B;
    }

    void validate(Words& refuse) const {
        if (!(period > 0.0) && (gyro_noise > 0.0 || accelerometer_noise > 0.0))
            refuse(
                "gyro_noise or accelerometer_noise is above 0, but period is 0: noise is drawn per sample, give a "
                "period");
    }
};

}  // namespace adcs

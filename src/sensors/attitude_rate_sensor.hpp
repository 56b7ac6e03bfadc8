/// # Attitude and rate sensor
///
/// Measures attitude and angular velocity, exactly or with noise. With `period` 0 both pass through unchanged at every
/// instant. With a period they are sampled and held, and each sample can carry independent Gaussian noise per axis: a small
/// turn $\varphi$ of standard deviation `attitude_noise` about the body axes, and $\nu$ of `rate_noise`:
///
/// $$\sigma \leftarrow \tfrac14\varphi \otimes \sigma, \qquad \omega \leftarrow \omega + \nu$$
///
/// Draw $k$ of each is a function of `seed` and $k$ alone. The measured MRP is that of the shadow set, $|\sigma|\le 1$.
#pragma once

#include "attitude/gaussian.hpp"
#include "attitude/mrp.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct AttitudeRateSensor {
    static constexpr auto summary = "Attitude (MRP) and angular velocity, exact or sampled with Gaussian noise";
    static constexpr auto reference = "Made for this project, from no publication";
    static constexpr Stream stream{"AttitudeRateSensor"};

    Mrp<T> sigma_BO{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    T attitude_noise = 0.0, rate_noise = 0.0, period = 0.0;
    std::int32_t seed = 1;
    Vec3<T> turn_B{0.0, 0.0, 0.0}, rate_noise_B{0.0, 0.0, 0.0};
    Mrp<T> sigma_BO_meas{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B_meas{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("sigma_BO", sigma_BO, unit::one, "true attitude of B relative to O as MRP").at_least(-1).at_most(1);
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "true angular velocity of B relative to N, in B")
            .nominal(0.01);
        v.parameter("attitude_noise", attitude_noise, unit::rad, "standard deviation of the attitude per axis")
            .fixed()
            .at_least(0);
        v.parameter("rate_noise", rate_noise, unit::rad_per_s, "standard deviation of the rate per axis")
            .fixed()
            .at_least(0);
        v.parameter("period", period, unit::s, "sampling period; 0: continuous").fixed().at_least(0);
        v.seed("seed", seed, "seed of the noise");
        v.sampled(period);
        v.held("turn_B", turn_B, unit::rad, "phi, turn of the last draw, in B").nominal(1e-4);
        v.held("rate_noise_B", rate_noise_B, unit::rad_per_s, "nu, noise of the last draw, in B").nominal(1e-4);
        v.output("sigma_BO_meas", sigma_BO_meas, unit::one, "measured attitude of B relative to O as MRP").sampled();
        v.output("omega_BN_B_meas", omega_BN_B_meas, unit::rad_per_s, "measured angular velocity, in B")
            .sampled()
            .nominal(0.01);
    }

    void sample(const Sample& s) {
        Random attitude = stream["attitude"].draw(seed, s.k), rate = stream["rate"].draw(seed, s.k);
        const Vec3<double> phi = gaussian(attitude), nu = gaussian(rate);
        turn_B = attitude_noise * phi.template cast<T>();
        rate_noise_B = rate_noise * nu.template cast<T>();
    }

    void outputs() {
        const Mrp<T> turned = mrp_compose<T>(0.25 * turn_B, sigma_BO);
        const T square = turned.dot(turned);
        sigma_BO_meas = !(period > 0.0) ? sigma_BO : square > 1.0 ? Mrp<T>(-turned / square) : turned;
        omega_BN_B_meas = omega_BN_B + rate_noise_B;
    }

    void validate(Words& refuse) const {
        if (!(period > 0.0) && (attitude_noise > 0.0 || rate_noise > 0.0))
            refuse(
                "attitude_noise or rate_noise is above 0, but period is 0: noise is drawn per sample, give a period");
    }
};

}  // namespace adcs

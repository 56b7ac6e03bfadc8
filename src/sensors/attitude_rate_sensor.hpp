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
    static constexpr auto reference = "";
    static constexpr Stream stream{"AttitudeRateSensor"};

    Mrp<T> sigma_BO{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    T attitude_noise = 0.0, rate_noise = 0.0, period = 0.0;
    std::int32_t seed = 1;
    Mrp<T> held_sigma_BO{0.0, 0.0, 0.0}, sigma_BO_meas{0.0, 0.0, 0.0};
    Vec3<T> held_omega_BN_B{0.0, 0.0, 0.0}, omega_BN_B_meas{0.0, 0.0, 0.0};

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
        v.held("held_sigma_BO", held_sigma_BO, unit::one, "attitude of the last sample");
        v.held("held_omega_BN_B", held_omega_BN_B, unit::rad_per_s, "rate of the last sample");
        v.output("sigma_BO_meas", sigma_BO_meas, unit::one, "measured attitude of B relative to O as MRP");
        v.output("omega_BN_B_meas", omega_BN_B_meas, unit::rad_per_s, "measured angular velocity, in B").nominal(0.01);
    }

    SampleTimes sample_times() const { return {value_of(period), 0.0}; }

    void sample(std::int64_t k) {
        Random attitude = stream["attitude"].draw(seed, k), rate = stream["rate"].draw(seed, k);
        const Vec3<double> phi = gaussian(attitude), nu = gaussian(rate);
        const Mrp<T> tilted = mrp_compose<T>(0.25 * attitude_noise * phi.template cast<T>(), sigma_BO);
        const T square = tilted.dot(tilted);
        held_sigma_BO = square > 1.0 ? Mrp<T>(-tilted / square) : tilted;
        held_omega_BN_B = omega_BN_B + rate_noise * nu.template cast<T>();
    }

    void outputs() {
        sigma_BO_meas = period > 0.0 ? held_sigma_BO : sigma_BO;
        omega_BN_B_meas = period > 0.0 ? held_omega_BN_B : omega_BN_B;
    }

    const char* validate() const {
        return period > 0.0 || (attitude_noise == 0.0 && rate_noise == 0.0)
                   ? nullptr
                   : "attitude_noise or rate_noise is above 0, but period is 0: noise is drawn per sample, give a "
                     "period";
    }
};

}  // namespace adcs

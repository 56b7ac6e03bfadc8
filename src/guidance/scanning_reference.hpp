/// # Slew and scan
///
/// Turns a reference frame R away from the local-vertical local-horizontal frame O about an axis fixed in both, Sec. 9.2:
/// a ramp of constant rate up to `angle`, smoothed by a first-order low-pass, a rest, and from `scan_start` on a cosine
/// between `angle` and `-angle`:
///
/// $$u(t) = \min(\max(r\,(t - t_0),\,0),\,A), \qquad \tau\dot\theta = u - \theta$$
/// $$\theta(t) = A\cos\left(2\pi (t - t_s)/T\right)\ \text{for}\ t\ge t_s, \qquad \sigma_{RO} = a\tan(\theta/4)$$
///
/// With `period` 0 all this is evaluated in closed form at every instant. With a period it is what a flight computer does:
/// the filter becomes (D.6), $\theta_k = \lambda\theta_{k-1} + (1-\lambda)u_k$ with $\lambda = \tau/(\tau+\Delta t)$, and
/// the rate of $\sigma$ is analytic, or, with `difference` 1, the backward difference $(\sigma_k - \sigma_{k-1})/\Delta t$.
/// `lag` says by how many periods the time that the reference is computed for lies behind.
#pragma once

#include "attitude/mrp.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct ScanningReference {
    static constexpr auto summary = "Reference attitude as MRP: smoothed slew from nadir, rest, then a sinusoidal scan";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Sec. 9.2 and "
        "appendix D";

    T time = 0.0;
    Vec3<T> axis{-1.0, 1.0, 0.5};
    T angle = 0.52359877559829887, slew_rate = 0.0052359877559829887;  // 30 deg, 0.3 deg/s
    T slew_start = 0.0, time_constant = 30.0, scan_start = 500.0, scan_period = 300.0, period = 0.0;
    std::int32_t lag = 0, difference = 0;
    T held_theta = 0.0, held_thetaDot = 0.0, filtered = 0.0;
    Vec3<T> held_sigma{0.0, 0.0, 0.0}, held_sigmaDot{0.0, 0.0, 0.0};
    T theta = 0.0;
    Mrp<T> sigma_RO{0.0, 0.0, 0.0}, sigmaDot_RO{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("axis", axis, unit::one, "direction of a, the axis of the turn").fixed().directions();
        v.parameter("angle", angle, unit::rad, "A, angle of the slew and amplitude of the scan")
            .fixed()
            .at_least(0)
            .at_most(3.1415926535897931);
        v.parameter("slew_rate", slew_rate, unit::rad_per_s, "r, rate of the ramp").fixed().above(0);
        v.parameter("slew_start", slew_start, unit::s, "t_0, when the ramp starts").fixed();
        v.parameter("time_constant", time_constant, unit::s, "tau, time constant of the low-pass").fixed().above(0);
        v.parameter("scan_start", scan_start, unit::s, "t_s, when the scan starts").fixed();
        v.parameter("scan_period", scan_period, unit::s, "T, period of the scan").fixed().above(0);
        v.parameter("period", period, unit::s, "sampling period; 0: continuous").fixed().at_least(0);
        v.parameter("lag", lag, "periods by which the reference lies behind").fixed().at_least(0);
        v.parameter("difference", difference, "1: rate by backward difference; 0: analytic")
            .fixed()
            .at_least(0)
            .at_most(1);
        v.sampled(period);
        v.held("held_theta", held_theta, unit::rad, "angle of the last sample");
        v.held("held_thetaDot", held_thetaDot, unit::rad_per_s, "rate of the angle of the last sample");
        v.held("filtered", filtered, unit::rad, "state of the low-pass");
        v.held("held_sigma", held_sigma, unit::one, "sigma_RO of the last sample");
        v.held("held_sigmaDot", held_sigmaDot, unit::one_per_s, "sigmaDot_RO of the last sample");
        v.output("theta", theta, unit::rad, "angle of the turn about the axis");
        v.output("sigma_RO", sigma_RO, unit::one, "attitude of R relative to O as MRP");
        v.output("sigmaDot_RO", sigmaDot_RO, unit::one_per_s, "time derivative of sigma_RO").nominal(0.001);
    }

    void sample(const Sample& s) {
        const T now = static_cast<double>(s.k - lag) * period;
        const T ramp = limited(slew_rate * (now - slew_start));
        const T lambda = time_constant / (time_constant + period);
        filtered = lambda * filtered + (1.0 - lambda) * ramp;  // (D.6)
        held_theta = filtered;
        held_thetaDot = (ramp - filtered) / time_constant;
        scan(now, held_theta, held_thetaDot);
        const Vec3<T> before = held_sigma;
        held_sigma = mrp(held_theta);
        const double past = s.first ? 0.0 : 1.0;  // no difference before there are two
        held_sigmaDot =
            difference == 1 ? Vec3<T>(past / period * (held_sigma - before)) : mrpDot(held_theta, held_thetaDot);
    }

    void outputs() {
        if (period > 0.0) {
            theta = held_theta;
            sigma_RO = held_sigma;
            sigmaDot_RO = held_sigmaDot;
        } else {
            T thetaDot;
            smoothed_ramp(theta, thetaDot);
            scan(time, theta, thetaDot);
            sigma_RO = mrp(theta);
            sigmaDot_RO = mrpDot(theta, thetaDot);
        }
    }

    void validate(Words& refuse) const {
        if (!(period > 0.0) && (lag != 0 || difference != 0))
            refuse("lag and difference belong to a sampled reference: give a period above 0, or set both to 0");
    }

private:
    T limited(const T& x) const { return x < 0.0 ? T(0.0) : x > angle ? angle : x; }

    /// Low-pass of a ramp that ends at `angle`: of one that starts at t_0, less one that starts where it ends.
    void smoothed_ramp(T& value, T& rate) const {
        value = rate = 0.0;
        for (const double sign : {1.0, -1.0}) {
            const T since = time - slew_start - (sign > 0.0 ? T(0.0) : angle / slew_rate);
            if (since > 0.0) {
                const T rising = 1.0 - exp(-since / time_constant);
                value += sign * slew_rate * (since - time_constant * rising);
                rate += sign * slew_rate * rising;
            }
        }
    }

    void scan(const T& now, T& value, T& rate) const {
        if (now < scan_start - 1e-9 * scan_period) return;
        const T frequency = 6.2831853071795865 / scan_period;
        const auto [s, c] = sincos(frequency * (now - scan_start));
        value = angle * c;
        rate = -frequency * angle * s;
    }

    Vec3<T> direction() const { return axis / sqrt(axis.dot(axis)); }
    Vec3<T> mrp(const T& turn) const {
        const auto [s, c] = sincos(0.25 * turn);
        return s / c * direction();
    }
    Vec3<T> mrpDot(const T& turn, const T& turnDot) const {
        const T c = cos(0.25 * turn);
        return 0.25 * turnDot / (c * c) * direction();
    }
};

}  // namespace adcs

/// # Star tracker with a wandering error
///
/// Measures the attitude with an error that is itself a motion, Eqs. (25)-(29): the measured frame E turns relative to the
/// body with a random rate,
///
/// $$C(\hat q) = C(\tilde q)\,C(q), \qquad \dot{\tilde q} = \tfrac12 E(\tilde q)\,\tilde\omega$$
///
/// whose size is uniform on $[0, \bar\omega]$ and whose direction is uniform on the sphere. The text draws "at each
/// simulation time". Then the error would depend on the integrator: after a time $t$ it grows like
/// $\bar\omega\sqrt{t\,h}$ with the time $h$ between draws, and vanishes with it. So here each draw is held for
/// `hold_time`, and draw $k$ is a pure function of `seed` and $k$.
///
/// The text also assumes $\lVert\tilde q_v\rVert \le \mu_v$, which a random walk does not respect. With `error_bound` below
/// 1, a draw that would lead out of this ball within its hold is reversed, or dropped if that leads out as well. The error
/// then keeps both assumptions for any `hold_time`. With `max_rate` 0 the measurement is exact.
#pragma once

#include "attitude/random.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct RandomWalkStarTracker {
    static constexpr auto summary = "Attitude sensor whose error turns with a random rate";
    static constexpr auto reference =
        "Velocity-free passivity-based attitude tracking with measurement errors, disturbances and inertia mismatch, "
        "Eqs. (25)-(29)";
    static constexpr Stream stream{"RandomWalkStarTracker"};

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    T max_rate = 0.02, hold_time = 0.1, error_bound = 1.0;
    std::int32_t seed = 1;
    Quat<T> q_EB{1.0, 0.0, 0.0, 0.0}, qDot_EB{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_EB_E{0.0, 0.0, 0.0};
    Quat<T> q_BN_meas{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "true attitude of B relative to N").unit_quaternion();
        v.parameter("max_rate", max_rate, unit::rad_per_s, "largest rate of the error; 0: exact")
            .fixed()
            .at_least(0)
            .nominal(0.01);
        v.parameter("hold_time", hold_time, unit::s, "how long a rate is held").fixed().above(0);
        v.parameter("error_bound", error_bound, unit::one, "mu_v, bound kept by the vector part of q_EB; 1: none")
            .fixed()
            .above(0)
            .at_most(1);
        v.seed("seed", seed, "seed of the draws");
        v.sampled(max_rate > 0.0 ? hold_time : 0.0);
        v.held("omega_EB_E", omega_EB_E, unit::rad_per_s, "random rate of the error");
        v.state("q_EB", q_EB, qDot_EB, unit::one, "error of the measurement: attitude of E relative to B")
            .unit_quaternion();
        v.output("q_BN_meas", q_BN_meas, unit::one, "measured attitude of B relative to N: that of E")
            .unit_quaternion();
    }

    void sample(const Sample& s) {
        Random random = stream.draw(seed, s.k);
        const T size = max_rate * random.uniform();
        omega_EB_E = size * random.direction().template cast<T>();
        if (!stays_within(omega_EB_E)) {
            omega_EB_E = -omega_EB_E;
            if (!stays_within(omega_EB_E)) omega_EB_E = {0.0, 0.0, 0.0};
        }
    }

    void outputs() { q_BN_meas = compose(q_EB, q_BN); }

    void derivatives() { qDot_EB = kinematics(q_EB, omega_EB_E); }

private:
    /// Whether the error keeps its bound if it turns with this rate until the next draw. In between q_EB[0] is concave, so
    /// it is enough to look at the end.
    bool stays_within(const Vec3<T>& rate) const {
        const T size = sqrt(rate.dot(rate));
        if (!(size > 0.0) || !(error_bound < 1.0)) return true;
        const T half = 0.5 * size * hold_time;
        const Vec3<T> v = vec(q_EB);
        const auto [s, c] = sincos(half);
        const Vec3<T> end = c * v + s / size * Vec3<T>(q_EB[0] * rate + v.cross(rate));
        return end.dot(end) <= error_bound * error_bound;
    }
};

}  // namespace adcs

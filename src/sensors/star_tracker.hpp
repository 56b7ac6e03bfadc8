/// # Star tracker
///
/// Measures the attitude with the error model of Sec. 5.4.2: the eigenaxis $e$ of the true attitude is tilted to a
/// direction drawn uniformly from the spherical cone of half-angle $\alpha$ around it; the eigenangle is exact.
/// A tilt angle $\beta$ with $1-\cos\beta$ uniform on $[0,\,1-\cos\alpha]$, towards $d = a\times e/|a\times e|$ with
/// $a$ uniform on the sphere, is uniform on the cone's cap:
///
/// $$q_v \leftarrow \cos\beta\; q_v + \sin\beta\,\lVert q_v\rVert\; d, \qquad q_0 \leftarrow q_0$$
///
/// The text redraws "at each time t". Here each draw is held for `redraw_period`, and draw $k$ is a pure function of
/// `seed` and $k$: equal on every platform, and independent of how the run is stepped. The model has no error at the
/// identity attitude, where the eigenaxis is undefined. With `half_angle` 0 the measurement is exact.
#pragma once

#include "attitude/random.hpp"
#include "attitude/tilt.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct StarTracker {
    static constexpr auto summary = "Attitude sensor whose eigenaxis errs within a cone";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 5.4.2";
    static constexpr Stream stream{"StarTracker"};

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    T half_angle = 0.0, redraw_period = 0.1;
    std::int32_t seed = 1;
    Vec3<T> tilt_direction{0.0, 0.0, 1.0};
    T tilt_versine = 0.0;
    Quat<T> q_BN_meas{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "true attitude of B relative to N").unit_quaternion();
        v.parameter("half_angle", half_angle, unit::rad, "half-angle of the cone of the eigenaxis; 0: exact")
            .fixed()
            .at_least(0)
            .at_most(1.5707963267948966);
        v.parameter("redraw_period", redraw_period, unit::s, "how long a draw is held").fixed().above(0);
        v.seed("seed", seed, "seed of the draws");
        v.sampled(half_angle > 0.0 ? redraw_period : 0.0);
        v.held("tilt_direction", tilt_direction, unit::one, "a, unit vector that sets the direction of the tilt");
        v.held("tilt_versine", tilt_versine, unit::one, "1 - cos(beta), beta the angle of the tilt");
        v.output("q_BN_meas", q_BN_meas, unit::one, "measured attitude of B relative to N").unit_quaternion();
    }

    void sample(const Sample& s) {
        Random random = stream.draw(seed, s.k);
        const T half = sin(0.5 * half_angle);
        tilt_versine = random.uniform() * 2.0 * half * half;  // 1 - cos(alpha) without cancellation
        tilt_direction = random.direction().template cast<T>();
    }

    void outputs() {
        q_BN_meas = q_BN;
        q_BN_meas.template tail<3>() = tilted(vec(q_BN), tilt_direction, tilt_versine);
    }
};

}  // namespace adcs

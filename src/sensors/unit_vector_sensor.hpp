/// # Unit vector sensor
///
/// Sees three directions that are known in N, for instance those of stars or of the Sun, as unit vectors in B,
/// $y_j = C(q)\,x_j$, Sec. 4.2. Each errs within a cone of half-angle $\alpha$ around the true direction, "a normal
/// distribution contained in a cone", Sec. 4.3.2. The text says no more; here it is the normal distribution of the
/// sphere (von Mises and Fisher's) cut off at the cone. With $\sigma$ its standard deviation per axis, given as
/// `spread` $= \sigma/\alpha$, the angle $\beta$ of the error follows from $u$ uniform on $[0, 1)$:
///
/// $$1-\cos\beta = -\sigma^2\ln\left[1 - u\left(1 - e^{-(1-\cos\alpha)/\sigma^2}\right)\right]$$
///
/// The side it errs to is uniform. A large spread makes the direction uniform on the cone's cap: at 10 its density falls
/// by 0.5 % from the centre to the rim. The three errors are independent, each draw is held for `redraw_period`, and draw
/// $k$ of each is a pure function of `seed` and $k$. With `half_angle` 0 the measurement is exact.
///
/// Lengths of the rows of `directions_N` do not matter.
#pragma once

#include "attitude/directions.hpp"
#include "attitude/random.hpp"
#include "attitude/tilt.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct UnitVectorSensor {
    static constexpr auto summary = "Sensor of three known directions, each of which errs within a cone";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Secs. 4.2, 4.3.2";
    static constexpr Stream stream{"UnitVectorSensor"};

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    Directions<T> directions_N{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
    T half_angle = 0.0, spread = 1.0 / 3.0, redraw_period = 0.1;
    std::int32_t seed = 1;
    Directions<T> tilt_directions{{0.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, {0.0, 0.0, 1.0}};
    Weights<T> tilt_versines{0.0, 0.0, 0.0};
    Directions<T> directions_B_meas{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "true attitude of B relative to N").unit_quaternion();
        v.parameter("directions_N", directions_N, unit::one, "x_j, the directions in N, a row for each")
            .fixed()
            .directions();
        v.parameter("half_angle", half_angle, unit::rad, "half-angle of the cone around each direction; 0: exact")
            .fixed()
            .at_least(0)
            .at_most(1.5707963267948966);
        v.parameter("spread", spread, unit::one, "standard deviation per axis over half_angle; 10: nearly uniform")
            .fixed()
            .above(0)
            .at_most(10);
        v.parameter("redraw_period", redraw_period, unit::s, "how long a draw is held").fixed().above(0);
        v.seed("seed", seed, "seed of the draws");
        v.sampled(half_angle > 0.0 ? redraw_period : 0.0);
        v.held("tilt_directions", tilt_directions, unit::one, "unit vectors that set the sides of the errors");
        v.held("tilt_versines", tilt_versines, unit::one, "1 - cos(beta), beta the angles of the errors");
        v.output("directions_B_meas", directions_B_meas, unit::one, "y_j, the unit vectors measured in B, a row each");
    }

    void sample(const Sample& s) {
        const T half = sin(0.5 * half_angle);
        const T variance = spread * spread * half_angle * half_angle;
        const T inside = 1.0 - exp(-2.0 * half * half / variance);  // how much of the distribution the cone holds
        for (int j = 0; j < n_directions; ++j) {
            Random random = stream[j].draw(seed, s.k);
            tilt_versines[j] = -variance * log(1.0 - random.uniform() * inside);
            tilt_directions.row(j) = random.direction().template cast<T>();
        }
    }

    void outputs() {
        const Directions<T> y_B = seen(dcm(q_BN), directions_N);
        for (int j = 0; j < n_directions; ++j) {
            const Vec3<T> side = tilt_directions.row(j), y_j = y_B.row(j);
            directions_B_meas.row(j) = tilted(y_j, side, tilt_versines[j]);
        }
    }
};

}  // namespace adcs

/// # Appendage paths
///
/// Two masses that move out and back in along fixed directions of the body, Eqs. (3.59) and (3.60):
///
/// $$\rho_i(t) = \rho_i(0)\left[1 + e\,\sin^2(\nu t)\right]$$
///
/// As printed $\rho_1(0) = 0.5\,b_1$, $\rho_2(0) = 0.8\,b_2$, $e = 1$ and $\nu = 0.1$ rad/s: persistent motion, as of an
/// articulated boom, with a period of $\pi/\nu$. The velocities are analytic.
#pragma once

#include "attitude/inertia.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct AppendagePaths {
    static constexpr auto summary = "Positions and velocities of two masses that move out and in periodically";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (3.59)-(3.60)";

    T time = 0.0;
    TwoPoints<T> position_B_0{{0.5, 0.0, 0.0}, {0.0, 0.8, 0.0}};
    T extension = 1.0, frequency = 0.1;
    TwoPoints<T> position_B{{0.5, 0.0, 0.0}, {0.0, 0.8, 0.0}}, velocity_B{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("position_B_0", position_B_0, unit::m,
                    "retracted positions from the centre of mass, in B, one a row");
        v.parameter("extension", extension, unit::one, "e, by which part of that they move further out").at_least(0);
        v.parameter("frequency", frequency, unit::rad_per_s, "nu, half of the frequency of the motion").at_least(0);
        v.output("position_B", position_B, unit::m, "positions of the two masses from the centre of mass, in B");
        v.output("velocity_B", velocity_B, unit::m_per_s, "time derivative of position_B").nominal(0.1);
    }

    void outputs() {
        const auto [s, c] = sincos(frequency * time);
        position_B = (1.0 + extension * s * s) * position_B_0;
        velocity_B = 2.0 * extension * frequency * s * c * position_B_0;
    }
};

}  // namespace adcs

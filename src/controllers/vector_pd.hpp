/// # PD attitude stabilisation from unit vectors and rate
///
/// Brings a body to rest at the attitude $C_r$ from unit vectors $y_j$ and the angular velocity, both measured in B; the
/// full-state law with which Sec. 4.3 compares the gyro-free one. With $y_{rj} = C_r x_j$ and weights $k_j$
///
/// $$\Omega = \tfrac12\sum k_j\, y_j\times y_{rj}, \qquad \tau = -k_p\,\Omega - k_\omega\,\omega$$
///
/// and for exact measurements
///
/// $$V = \tfrac12\,\omega^T J\omega + \tfrac12 k_p\sum k_j\left(1 - y_j^T y_{rj}\right), \qquad
///   \dot V = -k_\omega\,\lVert\omega\rVert^2$$
#pragma once

#include "attitude/directions.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct VectorPd {
    static constexpr auto summary = "Proportional-derivative attitude stabilisation from unit vectors and rate";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 4.3";

    Directions<T> directions_B{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {0.6, 0.8, 0.0}};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    Directions<T> directions_N{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
    Weights<T> weights{1.0, 1.0, 1.0};
    Quat<T> q_RN{1.0, 0.0, 0.0, 0.0};
    T k_p = 0.03, k_w = 0.06;
    Vec3<T> torque_B{0.0, 0.0, 0.0}, Omega_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("directions_B", directions_B, unit::one, "y_j, unit vectors measured in B, a row for each")
            .unit_vectors();
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.1);
        v.parameter("directions_N", directions_N, unit::one, "x_j, the same directions in N").fixed().directions();
        v.parameter("weights", weights, unit::one, "k_j; 0: the vector does not count").at_least(0);
        v.parameter("q_RN", q_RN, unit::one, "attitude to come to rest at, R relative to N").unit_quaternion();
        v.parameter("k_p", k_p, unit::N_m, "attitude gain").above(0);
        v.parameter("k_w", k_w, unit::N_m_s, "rate gain").above(0);
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
        v.output("Omega_B", Omega_B, unit::one, "attitude error that the measurements show, in B");
    }

    void outputs() {
        Omega_B = 0.5 * cross_sum(weights, directions_B, seen(dcm(q_RN), directions_N));
        torque_B = -k_p * Omega_B - k_w * omega_BN_B;
    }

    void validate(Words& refuse) const { refuse_blindness(directions_N, weights, refuse); }
};

}  // namespace adcs

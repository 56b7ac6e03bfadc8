/// # Spinning wheel
///
/// Disturbance torque of a wheel whose axis $a$ is fixed in the body and which nobody controls, Eq. (4.24) with the sign
/// of the second term set right:
///
/// $$T_d = -\omega\times H - \dot H, \qquad H = (J_s + J_p)\,a\,\Omega(t), \qquad \Omega(t) = \Omega_0 + \alpha t$$
///
/// Spin momentum is that of the rotation about the wheel's own centre, $J_s$ about its axis. The parallel-axis term
/// $J_p = -m\,S_R^2$, which the thesis includes in $J_b$, belongs to the inertia of the whole body and not here: it is 0
/// by default, and a parameter for those who compare with the thesis.
///
/// With a `period` the torque is computed at the sampling instants and held in between, as the thesis' figures require.
#pragma once

#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct SpinningWheel {
    static constexpr auto summary = "Gyroscopic disturbance torque of a wheel that spins uncontrolled";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Secs. 4.2.1 "
        "and 9.1.2";

    T time = 0.0;
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    Vec3<T> axis{0.0, 0.0, 1.0};
    T inertia = 0.0015125, speed = 439.82297150257105, acceleration = 0.0, period = 0.0;  // 1 kg, 55 mm; 4200 rpm
    Mat3<T> J_offset_B = Mat3<T>::Zero();
    Vec3<T> torque_B{0.0, 0.0, 0.0}, H_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.01);
        v.parameter("axis", axis, unit::one, "direction of a, the spin axis in B").fixed().directions();
        v.parameter("inertia", inertia, unit::kg_m2, "J_s, inertia about the spin axis").above(0);
        v.parameter("speed", speed, unit::rad_per_s, "Omega_0, spin rate relative to B at t = 0");
        v.parameter("acceleration", acceleration, unit::rad_per_s2, "alpha, change of the spin rate");
        v.parameter("J_offset_B", J_offset_B, unit::kg_m2, "J_p, added to the spin inertia; 0 is physically right");
        v.parameter("period", period, unit::s, "sampling period of the torque; 0: continuous").fixed().at_least(0);
        v.sampled(period);
        v.output("torque_B", torque_B, unit::N_m, "disturbance torque on the body, in B").sampled().nominal(1e-3);
        v.output("H_B", H_B, unit::N_m_s, "spin momentum, in B");
    }

    void outputs() {
        H_B = spin(speed + acceleration * time);
        torque_B = torque();
    }

private:
    Vec3<T> spin(const T& rate) const {
        const Vec3<T> a = axis / sqrt(axis.dot(axis));
        return rate * (inertia * a + J_offset_B * a);
    }
    Vec3<T> torque() const {
        return -omega_BN_B.cross(spin(speed + acceleration * time)) - spin(acceleration);  // (4.24)
    }
};

}  // namespace adcs

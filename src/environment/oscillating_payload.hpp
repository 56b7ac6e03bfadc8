/// # Oscillating payload
///
/// Disturbance torque of a rigid part that swings about its own centre of mass, whose axis $a$ is fixed in the body, by
/// $\theta(t) = A\sin(2\pi t/T)$, Eq. (4.34). The part's own axes A turn about the third one relative to A', and A' is
/// fixed in B by the 3-2-1 Euler angles $(\theta_1,\theta_2,\theta_3)$. Its inertia in B changes with the angle,
///
/// $$J_b(\theta) = C_{BA'}C_3(\theta)\,J_A\,C_3(\theta)^T C_{BA'}^T, \qquad \Delta J = J_b(\theta) - J_b(\theta_0)$$
///
/// where the known inertia $J_0$ of the body contains the part at rest at $\theta_0$. With $J = J_0 + \Delta J$,
/// $\omega_b = a\dot\theta$ and $H = J_b\omega_b$ the body moves like one of inertia $J_0$ under
///
/// $$T_d = J_0(J^{-1} - J_0^{-1})(-\omega\times J\omega + T_c + T_g) - \omega\times\Delta J\omega + \Delta T_g
///   - J_0J^{-1}\left(\omega\times H + \dot J_b(\omega + \omega_b) + J_b\dot\omega_b\right)$$
///
/// In the terms with $\omega_b$ the thesis' $J_b$ includes the parallel-axis term $J_p = -m\,S_R^2$. The part turns about
/// its own centre, so that term is not its own to spin: it is 0 by default. With the thesis' value it is nearly all of
/// the disturbance.
///
/// With a `period` the torque is computed at the sampling instants and held in between.
#pragma once

#include "attitude/gravity_gradient.hpp"
#include "attitude/mrp.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct OscillatingPayload {
    static constexpr auto summary = "Disturbance torque of a part that swings about its own centre of mass";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Secs. 4.2.2 "
        "and 9.1.3";

    T time = 0.0;
    Mrp<T> sigma_BO{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, torque_control_B{0.0, 0.0, 0.0};
    Mat3<T> J0_B{{37.0 / 12.0, 0.0, 0.0}, {0.0, 37.0 / 12.0, 0.0}, {0.0, 0.0, 25.0 / 12.0}};
    Vec3<T> J_A{1.25e-5, 6.3125e-6, 6.3125e-6};  // 30 g of 5 x 50 x 50 mm
    Vec3<T> euler{0.0, 0.78539816339744831, 0.78539816339744831};
    T amplitude = 0.78539816339744831, swing_period = 15.0, angle_0 = 0.78539816339744831;
    T orbital_rate = 1.073e-3, period = 0.0;
    Mat3<T> J_offset_B = Mat3<T>::Zero();
    Vec3<T> torque_B{0.0, 0.0, 0.0};
    T angle = 0.0;

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.input("sigma_BO", sigma_BO, unit::one, "attitude of B relative to O as MRP").at_least(-1).at_most(1);
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.01);
        v.input("torque_control_B", torque_control_B, unit::N_m, "T_c, control torque on the body, in B");
        v.parameter("J0_B", J0_B, unit::kg_m2, "J_0, inertia of the body with the part at angle_0, in B").inertia();
        v.parameter("J_A", J_A, unit::kg_m2,
                    "principal moments of the part about its own centre; axis 3 is that of the swing")
            .above(0);
        v.parameter("euler", euler, unit::rad, "theta_1, theta_2, theta_3 that turn B into A', in the order 3-2-1")
            .fixed();
        v.parameter("amplitude", amplitude, unit::rad, "A, amplitude of the swing");
        v.parameter("swing_period", swing_period, unit::s, "T, period of the swing").above(0);
        v.parameter("angle_0", angle_0, unit::rad, "theta_0, angle at which J_0 contains the part");
        v.parameter("J_offset_B", J_offset_B, unit::kg_m2, "J_p, added to the spin inertia; 0 is physically right");
        v.parameter("orbital_rate", orbital_rate, unit::rad_per_s, "n, rate of the circular orbit").at_least(0);
        v.parameter("period", period, unit::s, "sampling period of the torque; 0: continuous").fixed().at_least(0);
        v.sampled(period);
        v.output("torque_B", torque_B, unit::N_m, "disturbance torque on a body of inertia J_0, in B")
            .sampled()
            .nominal(1e-4);
        v.output("angle", angle, unit::rad, "theta, angle of the swing");
    }

    void outputs() {
        angle = amplitude * sin(6.2831853071795865 / swing_period * time);
        torque_B = torque();
    }

private:
    static Mat3<T> turn(int axis, const T& angle) {
        const int i = (axis + 1) % 3, j = (axis + 2) % 3;
        Mat3<T> R = Mat3<T>::Identity();
        const auto [s, c] = sincos(angle);
        R(i, i) = R(j, j) = c;
        R(i, j) = s;
        R(j, i) = -s;
        return R;
    }

    Vec3<T> torque() const {
        const T frequency = 6.2831853071795865 / swing_period, phase = frequency * time;
        const auto [s, c] = sincos(phase);
        const T theta = amplitude * s, thetaDot = amplitude * frequency * c;
        const T thetaDDot = -frequency * frequency * theta;
        const Mat3<T> C_BP = (turn(0, euler[0]) * turn(1, euler[1]) * turn(2, euler[2])).transpose();
        const Vec3<T> a = C_BP.col(2);

        const auto inertia = [&](const T& at) -> Mat3<T> {  // (4.29) without its last term
            const Mat3<T> C_BA = C_BP * turn(2, at).transpose();
            return C_BA * J_A.asDiagonal() * C_BA.transpose();
        };
        const Mat3<T> J_b = inertia(theta), dJ = J_b - inertia(angle_0);
        const Mat3<T> S = thetaDot * skew(a);
        const Mat3<T> JDot = S * J_b - J_b * S;  // (4.30)
        const Mat3<T> J = J0_B + dJ, spin = J_b + J_offset_B;

        const Vec3<T>& w = omega_BN_B;
        const Vec3<T> c_3 = mrp_dcm(sigma_BO).col(2), w_b = thetaDot * a;
        const Vec3<T> outer = torque_control_B + gravity_gradient(orbital_rate, c_3, J) - w.cross(J * w);
        const Vec3<T> inner = w.cross(spin * w_b) + JDot * (w + w_b) + thetaDDot * (spin * a);
        // J_0 (J^-1 - J_0^-1) x = J_0 J^-1 x - x, written without the difference of the inverses
        return -(dJ * (J.inverse() * outer)) - w.cross(dJ * w) + gravity_gradient(orbital_rate, c_3, dJ) -
               J0_B * (J.inverse() * inner);  // (4.34)
    }
};

}  // namespace adcs

/// # Body that loses fuel
///
/// Rotation of a spacecraft whose thrusters burn fuel in proportion to the norm of the control torque,
/// Eqs. (3.1), (3.3) and (3.13):
///
/// $$\dot q_{BN} = \tfrac12 \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix} \omega, \qquad
///   J\dot\omega = -\dot J\omega - \omega\times J\omega + \tau + \tau_d$$
/// $$J = J_0 - J_1\psi, \qquad \dot\psi = \lVert\tau\rVert, \qquad \dot J = -J_1\lVert\tau\rVert$$
///
/// $J_0$ is the inertia with a full tank, $\psi$ the torque impulse spent so far. The fuel lasts for an impulse of
/// `fuel`. A `fuel` for which $J$ would not stay positive definite is refused. Once it is spent, which is an event, the
/// thrusters give no torque: $\psi$, $J$ and the output `fuel_left` = 0 stay as they are, and the body coasts. The default
/// is the text's dry mass, at which the least eigenvalue of $J$ is 0.5 kg m².
#pragma once

#include "attitude/definite.hpp"
#include "attitude/inertia.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct FuelLossBody {
    static constexpr auto summary = "Rotation of a spacecraft whose inertia falls with the torque impulse it has spent";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (3.1), (3.13)";

    Vec3<T> torque_B{0.0, 0.0, 0.0}, torque_disturbance_B{0.0, 0.0, 0.0};
    Mat3<T> J_0_B{{20.0, 1.2, 0.9}, {1.2, 17.0, 1.4}, {0.9, 1.4, 15.0}};
    Mat3<T> J_1_B{{4e-3, 0.0, 0.0}, {0.0, 4e-3, 0.0}, {0.0, 0.0, 5e-3}};
    T fuel = 2816.67;
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, qDot_BN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omegaDot_BN_B{0.0, 0.0, 0.0};
    T torque_impulse = 0.0, torque_impulseDot = 0.0;
    Mat3<T> J_B = Mat3<T>::Zero();
    Vec3<T> H_N{0.0, 0.0, 0.0};
    T fuel_left = 2816.67, unspent = 2816.67, thrusting = 1.0;

    template <class V>
    void declare(V& v) {
        v.input("torque_B", torque_B, unit::N_m, "control torque of the thrusters, in B");
        v.input("torque_disturbance_B", torque_disturbance_B, unit::N_m, "disturbance torque, in B");
        v.parameter("J_0_B", J_0_B, unit::kg_m2, "inertia with a full tank about the centre of mass, in B").inertia();
        v.parameter("J_1_B", J_1_B, unit::s, "inertia lost per torque impulse, in B: kg m2 per N m s")
            .positive_definite()
            .nominal(0.001);
        v.parameter("fuel", fuel, unit::N_m_s, "torque impulse that a full tank lasts for").above(0).nominal(100.0);
        v.state("q_BN", q_BN, qDot_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.state("omega_BN_B", omega_BN_B, omegaDot_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B")
            .nominal(0.1);
        v.state("torque_impulse", torque_impulse, torque_impulseDot, unit::N_m_s,
                "psi, integral of the norm of the control torque")
            .at_least(0)
            .nominal(100.0);
        v.event("unspent", unspent, unit::N_m_s, "torque impulse until the tank is empty");
        v.held("thrusting", thrusting, unit::one, "1 while there is fuel, else 0");
        v.output("J_B", J_B, unit::kg_m2, "inertia, in B").nominal(10.0);
        v.output("H_N", H_N, unit::N_m_s, "angular momentum, in N; that of the lost fuel is not in it");
        v.output("fuel_left", fuel_left, unit::N_m_s, "torque impulse that the fuel still lasts for").nominal(100.0);
    }

    void outputs() {
        const T spent = torque_impulse < fuel ? torque_impulse : fuel;
        unspent = fuel - torque_impulse;
        fuel_left = fuel - spent;
        J_B = J_0_B - J_1_B * spent;
        H_N = dcm(q_BN).transpose() * (J_B * omega_BN_B);
    }

    void events(const Events& /*e*/) { thrusting = unspent > 0.0 ? 1.0 : 0.0; }

    void derivatives() {
        torque_impulseDot = thrusting * norm_of(torque_B);
        const Mat3<T> JDot_B = -J_1_B * torque_impulseDot;
        qDot_BN = kinematics(q_BN, omega_BN_B);
        omegaDot_BN_B = angular_acceleration<T>(J_B, JDot_B, omega_BN_B, thrusting * torque_B + torque_disturbance_B);
    }

    const char* validate() const {
        if (!positive_definite<T>(J_0_B - fuel * J_1_B)) {
            return "J_0_B - fuel J_1_B is not positive definite: without fuel no inertia would be left, choose less "
                   "fuel "
                   "or a smaller J_1_B";
        }
        return nullptr;
    }
};

}  // namespace adcs

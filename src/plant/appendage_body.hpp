/// # Body with moving appendages
///
/// Rotation of a spacecraft with two point masses on given paths, Eqs. (3.1) and (3.7):
///
/// $$\dot q_{BN} = \tfrac12 \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix} \omega, \qquad
///   J\dot\omega = -\dot J\omega - \omega\times J\omega + \tau + \tau_d$$
/// $$J = J_0 + \sum_{i=1}^2 m_i\left[\rho_i^T\rho_i\,I - \rho_i\rho_i^T\right]$$
///
/// As in the text the centre of mass stays where it is, and the masses' own motion in B carries no angular momentum:
/// none does if each moves along a line through the centre of mass. The angular momentum in N is an output for checking:
/// without torque it is constant, however the masses move. The kinetic energy is not, since moving them takes work.
#pragma once

#include "attitude/inertia.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct AppendageBody {
    static constexpr auto summary = "Rotation of a spacecraft with two point masses that move on given paths";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (3.1), (3.7)";

    Vec3<T> torque_B{0.0, 0.0, 0.0}, torque_disturbance_B{0.0, 0.0, 0.0};
    TwoPoints<T> position_B{{0.5, 0.0, 0.0}, {0.0, 0.8, 0.0}}, velocity_B{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    Mat3<T> J_0_B{{20.0, 1.2, 0.9}, {1.2, 17.0, 1.4}, {0.9, 1.4, 15.0}};
    Eigen::Matrix<T, 2, 1> mass{1.0, 1.3};
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, qDot_BN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omegaDot_BN_B{0.0, 0.0, 0.0};
    Mat3<T> J_B = Mat3<T>::Zero();
    Vec3<T> H_N{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("torque_B", torque_B, unit::N_m, "control torque, in B");
        v.input("torque_disturbance_B", torque_disturbance_B, unit::N_m, "disturbance torque, in B");
        v.input("position_B", position_B, unit::m, "positions of the two masses from the centre of mass, in B");
        v.input("velocity_B", velocity_B, unit::m_per_s, "time derivative of position_B").nominal(0.1);
        v.parameter("J_0_B", J_0_B, unit::kg_m2, "inertia without the two masses about the centre of mass, in B")
            .inertia();
        v.parameter("mass", mass, unit::kg, "the two masses").at_least(0);
        v.state("q_BN", q_BN, qDot_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.state("omega_BN_B", omega_BN_B, omegaDot_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B")
            .nominal(0.1);
        v.output("J_B", J_B, unit::kg_m2, "inertia with the two masses, in B").nominal(10.0);
        v.output("H_N", H_N, unit::N_m_s, "angular momentum, in N");
    }

    void outputs() {
        J_B = J_0_B;
        for (int i = 0; i < 2; ++i) J_B += mass[i] * point_inertia<T>(position_B.row(i).transpose());
        H_N = dcm(q_BN).transpose() * (J_B * omega_BN_B);
    }

    void derivatives() {
        Mat3<T> JDot_B = Mat3<T>::Zero();
        for (int i = 0; i < 2; ++i) {
            JDot_B += mass[i] * point_inertia_rate<T>(position_B.row(i).transpose(), velocity_B.row(i).transpose());
        }
        qDot_BN = kinematics(q_BN, omega_BN_B);
        omegaDot_BN_B = angular_acceleration<T>(J_B, JDot_B, omega_BN_B, torque_B + torque_disturbance_B);
    }
};

}  // namespace adcs

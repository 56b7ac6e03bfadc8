/// # Rigid body
///
/// Rotation of a rigid spacecraft under a control and a disturbance torque, Eqs. (2.1) and (2.2):
///
/// $$\dot q_{BN} = \tfrac12 \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix} \omega, \qquad
///   J\dot\omega = -\omega\times J\omega + \tau + \tau_d$$
///
/// The angular momentum in N and the kinetic energy are outputs for checking: without torque both are constant.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct RigidBody {
    static constexpr auto summary = "Rotation of a rigid spacecraft under control and disturbance torque";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (2.1)-(2.2)";

    Vec3<T> torque_B{0.0, 0.0, 0.0}, torque_disturbance_B{0.0, 0.0, 0.0};
    Mat3<T> J_B{{10.0, 1.2, 0.5}, {1.2, 19.0, 1.5}, {0.5, 1.5, 25.0}};
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, qDot_BN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omegaDot_BN_B{0.0, 0.0, 0.0};
    Vec3<T> H_N{0.0, 0.0, 0.0};
    T kinetic_energy = 0.0;

    template <class V>
    void declare(V& v) {
        v.input("torque_B", torque_B, unit::N_m, "control torque, in B");
        v.input("torque_disturbance_B", torque_disturbance_B, unit::N_m, "disturbance torque, in B");
        v.parameter("J_B", J_B, unit::kg_m2, "inertia about the centre of mass, in B").inertia();
        v.state("q_BN", q_BN, qDot_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.state("omega_BN_B", omega_BN_B, omegaDot_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B")
            .nominal(0.1);
        v.output("H_N", H_N, unit::N_m_s, "angular momentum, in N");
        v.output("kinetic_energy", kinetic_energy, unit::J, "rotational kinetic energy");
    }

    void outputs() {
        const Vec3<T> H_B = J_B * omega_BN_B;
        H_N = dcm(q_BN).transpose() * H_B;
        kinetic_energy = 0.5 * omega_BN_B.dot(H_B);
    }

    void derivatives() {
        qDot_BN = kinematics(q_BN, omega_BN_B);
        const Vec3<T> H_B = J_B * omega_BN_B;
        omegaDot_BN_B = J_B.inverse() * (torque_B + torque_disturbance_B - omega_BN_B.cross(H_B));
    }
};

}  // namespace adcs

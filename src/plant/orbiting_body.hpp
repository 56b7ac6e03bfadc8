/// # Body in a circular orbit
///
/// Rotation of a rigid spacecraft relative to the local-vertical local-horizontal frame O: its third axis points to
/// the Earth, the second against the orbit normal, and O turns at the orbital rate $n$ about $-e_2$. With
/// $C = C_{BO} = [c_1\ c_2\ c_3]$, Eqs. (3.2), (3.27) and (3.38):
///
/// $$\omega_{BO} = \omega + n\,c_2$$
/// $$J\dot\omega = -\omega\times J\omega + 3n^2\,c_3\times J c_3 + T_c + T_d$$
///
/// The attitude is integrated as a unit quaternion and shown as modified Rodrigues parameters
/// $\sigma = k\tan(\theta/4)$ as well, those with $\lvert\sigma\rvert\le 1$: beyond 180 degrees the shadow
/// $-\sigma/\lvert\sigma\rvert^2$ (3.12). The quaternion has no attitude at which it must be switched, so the motion is
/// the same as that of $\dot\sigma = N(\sigma)\,\omega_{BO}$ (3.21), without its events.
///
/// A controller may know another inertia $J_0$ than the true $J$. `torque_unmodelled_B` is the torque that acts beside
/// the one it knows of: the disturbance of Eq. (4.5), and $T_d$,
///
/// $$T_{d,0} = J_0\dot\omega + \omega\times J_0\omega - 3n^2\,c_3\times J_0 c_3 - T_c$$
///
/// `workload` is the absolute work of the control torque, $\int\sum_i\lvert\omega_i T_{c,i}\rvert\,dt$ (9.13).
#pragma once

#include "attitude/gravity_gradient.hpp"
#include "attitude/mrp.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct OrbitingBody {
    static constexpr auto summary = "Rotation of a rigid spacecraft in a circular orbit, relative to LVLH";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Eqs. "
        "(3.2)-(3.40), (4.5), (9.13)";

    Vec3<T> torque_B{0.0, 0.0, 0.0}, torque_disturbance_B{0.0, 0.0, 0.0};
    Mat3<T> J_B{{37.0 / 12.0, 0.0, 0.0}, {0.0, 37.0 / 12.0, 0.0}, {0.0, 0.0, 25.0 / 12.0}};
    Mat3<T> J0_B = J_B;
    T orbital_rate = 1.073e-3;
    Quat<T> q_BO{1.0, 0.0, 0.0, 0.0}, qDot_BO{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omegaDot_BN_B{0.0, 0.0, 0.0};
    T workload = 0.0, power = 0.0;
    Mrp<T> sigma_BO{0.0, 0.0, 0.0};
    Vec3<T> omega_BO_B{0.0, 0.0, 0.0}, torque_unmodelled_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("torque_B", torque_B, unit::N_m, "control torque, in B");
        v.input("torque_disturbance_B", torque_disturbance_B, unit::N_m, "disturbance torque, in B");
        v.parameter("J_B", J_B, unit::kg_m2, "true inertia about the centre of mass, in B").inertia();
        v.parameter("J0_B", J0_B, unit::kg_m2, "J_0, inertia as the controller knows it, in B").inertia();
        v.parameter("orbital_rate", orbital_rate, unit::rad_per_s, "n, rate of the circular orbit").at_least(0);
        v.state("q_BO", q_BO, qDot_BO, unit::one, "attitude of B relative to O").unit_quaternion();
        v.state("omega_BN_B", omega_BN_B, omegaDot_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B")
            .nominal(0.01);
        v.state("workload", workload, power, unit::J, "absolute work of the control torque since the start")
            .nominal(0.001);
        v.output("sigma_BO", sigma_BO, unit::one, "attitude of B relative to O as MRP, shadow set |sigma| <= 1");
        v.output("omega_BO_B", omega_BO_B, unit::rad_per_s, "angular velocity of B relative to O, in B").nominal(0.01);
        v.output("torque_unmodelled_B", torque_unmodelled_B, unit::N_m,
                 "torque beside the control torque and the gravity gradient on J_0, in B")
            .nominal(1e-4);
    }

    void outputs() {
        const Vec3<T>& w = omega_BN_B;
        const Mat3<T> C_BO = dcm(q_BO);
        const Vec3<T> c_2 = C_BO.col(1), c_3 = C_BO.col(2);
        sigma_BO = mrp_of(q_BO);
        omega_BO_B = w + orbital_rate * c_2;
        omegaDot_BN_B = J_B.inverse() *
                        (torque_B + torque_disturbance_B + gravity_gradient(orbital_rate, c_3, J_B) - w.cross(J_B * w));
        torque_unmodelled_B =
            J0_B * omegaDot_BN_B + w.cross(J0_B * w) - gravity_gradient(orbital_rate, c_3, J0_B) - torque_B;
    }

    void derivatives() {
        qDot_BO = kinematics(q_BO, omega_BO_B);
        power = abs(omega_BN_B[0] * torque_B[0]) + abs(omega_BN_B[1] * torque_B[1]) + abs(omega_BN_B[2] * torque_B[2]);
    }
};

}  // namespace adcs

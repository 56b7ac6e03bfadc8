/// # Six-degree-of-freedom output feedback
///
/// Tracks an orbit and an attitude at once, without translational or angular velocity, Eq. (48):
///
/// $$\begin{bmatrix} f \\ P^T\tau \end{bmatrix} = k\,e_f - N - M\left((\Gamma - I)\,r_0 - 2 e_f - \Omega_2\right)
///   - \Gamma r_0, \qquad M = \mathrm{diag}(m I,\ P^T J P)$$
/// $$N = \begin{bmatrix} -\frac{m\mu}{|R_d|^3} R_d + \frac{m\mu}{|R|^3} R
///   + \frac{3\mu}{2|R|^4}\left\{\mathrm{tr}(J) I + 2J - 5 Z^T J Z\, I\right\} Z \\ P^T\tau_{kn} \end{bmatrix}$$
/// $$\tau_{kn} = -(C\omega_d)\times J(C\omega_d) - J C\dot\omega_d + \frac{3\mu}{|R|^5}\,R\times J R$$
///
/// with $r_0$, $\Gamma$, $\Omega_2$, $C$, $P$ and the scaled units as in the filter (PoseErrorFilter) that gives $e_f$. The
/// force on the spacecraft is $-f$, and `force_B` is that. With $\eta = v_0 + e_f + r_0$, $y = [\eta_1, P\eta_2]$ and
/// $\hat M = \mathrm{diag}(m I, J)$, Eqs. (50) and (54):
///
/// $$V = \tfrac12 k_0 e_R^T e_R + \tfrac12 e_f^T e_f
///   + \tfrac12\frac{k_1 e_\varepsilon^T e_\varepsilon}{1 - e_\varepsilon^T e_\varepsilon} + \tfrac12 y^T\hat M y$$
/// $$\dot V = -k_0 e_R^T e_R - e_f^T e_f - \frac{k_1 e_\varepsilon^T e_\varepsilon}{(1 - e_\varepsilon^T e_\varepsilon)^2}
///   - (k - 1)\,y^T\hat M y + y^T\chi_1 + e_R^T\chi_2$$
///
/// where $\chi_1, \chi_2$ (47) are what the missing velocities cost.
///
/// **Sign.** $q$ and $-q$ are answered alike, if $p(0)$ goes with them: the gain grows without bound towards 180 degrees, so
/// the smaller turn is taken.
#pragma once

#include "attitude/gravity.hpp"
#include "attitude/pose_error.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct SixDofOutputFeedback {
    static constexpr auto summary = "Force and torque that track orbit and attitude without any velocity measurement";
    static constexpr auto reference =
        "Pan, Wong, Kapila, Output feedback control for spacecraft with coupled translation and attitude dynamics, Eq. "
        "(48)";

    Vec3<T> r_BN_N{7.0e6, 0.0, 0.0}, r_RN_N{7.0e6, 0.0, 0.0};
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};
    Vec3<T> e_f_R{0.0, 0.0, 0.0}, e_f_eps{0.0, 0.0, 0.0};
    T mass = 100.0;
    Mat3<T> J_B{{22.0, 0.8, -0.5}, {0.8, 18.0, 0.6}, {-0.5, 0.6, 15.0}};
    T mu = earth_mu;
    T k = 3.0, k_0 = 2.0, k_1 = 1.5;
    T length_unit = 1.0, time_unit = 20.0, mass_unit = 20.0;
    Vec3<T> force_B{0.0, 0.0, 0.0}, torque_B{0.0, 0.0, 0.0}, r_RB_B{0.0, 0.0, 0.0};
    Quat<T> q_BR{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("r_BN_N", r_BN_N, unit::m, "measured position of the centre of mass, in N").nominal(1e7);
        v.input("r_RN_N", r_RN_N, unit::m, "position of the reference, in N").nominal(1e7);
        v.input("q_BN", q_BN, unit::one, "measured attitude of B relative to N").unit_quaternion();
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.input("e_f_R", e_f_R, unit::one, "e_f1 of the filter, in scaled units");
        v.input("e_f_eps", e_f_eps, unit::one, "e_f2 of the filter");
        v.parameter("mass", mass, unit::kg, "m, mass that the law assumes").above(0);
        v.parameter("J_B", J_B, unit::kg_m2, "inertia that the law assumes, in B").inertia();
        v.parameter("mu", mu, unit::m3_per_s2, "gravitational parameter of the Earth").above(0).nominal(4e14);
        v.parameter("k", k, unit::one, "filter gain").above(0);
        v.parameter("k_0", k_0, unit::one, "position gain").above(0);
        v.parameter("k_1", k_1, unit::one, "attitude gain").above(1);
        v.parameter("length_unit", length_unit, unit::m, "unit of length of the law").above(0);
        v.parameter("time_unit", time_unit, unit::s, "unit of time of the law").above(0);
        v.parameter("mass_unit", mass_unit, unit::kg, "unit of mass of the law").above(0);
        v.output("force_B", force_B, unit::N, "commanded force on the spacecraft, -f, in B");
        v.output("torque_B", torque_B, unit::N_m, "tau, commanded torque, in B");
        v.output("r_RB_B", r_RB_B, unit::m, "e_R, position of the reference relative to the body, in B");
        v.output("q_BR", q_BR, unit::one, "[e_zeta; e_eps], attitude error, B relative to R").unit_quaternion();
    }

    void outputs() {
        const ScaledUnits<T> units{length_unit, time_unit, mass_unit};
        const auto e = pose_error(units, r_BN_N, r_RN_N, q_BN, q_RN, omega_RN_R, k_0, k_1);
        const Mat3<T> C_BN = dcm(q_BN);
        const Vec3<T> r_B = C_BN * r_BN_N;

        // N, the known part of the dynamics; its lower half without P^T
        const Vec3<T> gravity_N = point_mass_gravity(mu, r_RN_N) - point_mass_gravity(mu, r_BN_N);
        const Vec3<T> known_force = mass * (C_BN * gravity_N) - gravity_gradient_force(mu, J_B, r_B);
        const Vec3<T> omega = e.C_BR * omega_RN_R;
        const Vec3<T> known_torque =
            gravity_gradient_torque(mu, J_B, r_B) - omega.cross(J_B * omega) - J_B * (e.C_BR * omegaDot_RN_R);

        // (48) in scaled units; its lower half multiplied by T^T = (P^T)^-1
        const T m = mass / mass_unit;
        const Mat3<T> J = J_B / units.inertia();
        const Vec3<T> f = k * e_f_R - known_force / units.force() -
                          m * (e.gamma_R - e.e_R - 2.0 * e_f_R + e.minus_omega_2(e_f_eps)) - e.gamma_R;
        const Vec3<T> x = k * e_f_eps - e.gamma_eps;
        const Vec3<T> T_x = 0.5 * (e.q_BR[0] * x - e.e_eps.cross(x));
        const Vec3<T> acceleration = e.P * (e.gamma_eps - e.e_eps - 2.0 * e_f_eps);
        const Vec3<T> tau = T_x - known_torque / units.torque() - J * acceleration;

        force_B = -units.force() * f;
        torque_B = units.torque() * tau;
        r_RB_B = length_unit * e.e_R;
        q_BR = e.q_BR;
    }
};

}  // namespace adcs

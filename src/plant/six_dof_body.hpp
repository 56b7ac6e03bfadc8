/// # Six-degree-of-freedom body
///
/// A rigid spacecraft that moves and turns in the gravity of a spherical Earth, with what its extent does to both, Eqs.
/// (1), (11) and (13):
///
/// $$\dot r = v, \qquad m\dot v = -\frac{\mu m}{|r|^3} r
///   - \frac{3\mu}{2|r|^4}\left[\mathrm{tr}(J) I + 2J - 5\,(Z\cdot J Z) I\right] Z + F$$
/// $$\dot q_{BN} = \tfrac12 \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix} \omega, \qquad
///   J\dot\omega = -\omega\times J\omega + \frac{3\mu}{|r|^3}\,Z\times J Z + \tau$$
///
/// with $Z = r/|r|$. $F$ is the force on the spacecraft; the paper's $f$ is its opposite, $F = -f$, which Eqs. (1) and (10)
/// agree on. Below the surface of the Earth `altitude` is not a number and the evaluation is refused.
#pragma once

#include "attitude/gravity.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct SixDofBody {
    static constexpr auto summary = "Coupled translation and rotation of a rigid spacecraft in the Earth's gravity";
    static constexpr auto reference =
        "Pan, Wong, Kapila, Output feedback control for spacecraft with coupled translation and attitude dynamics, "
        "Eqs. "
        "(1), (11)-(14)";

    Vec3<T> force_B{0.0, 0.0, 0.0}, torque_B{0.0, 0.0, 0.0};
    T mass = 100.0;
    Mat3<T> J_B{{22.0, 0.8, -0.5}, {0.8, 18.0, 0.6}, {-0.5, 0.6, 15.0}};
    T mu = earth_mu, earth_radius = earth_equatorial_radius;
    Vec3<T> r_BN_N{7.0e6, 0.0, 0.0}, rDot_BN_N{0.0, 0.0, 0.0};
    Vec3<T> v_BN_N{0.0, 7.546e3, 0.0}, vDot_BN_N{0.0, 0.0, 0.0};
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, qDot_BN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omegaDot_BN_B{0.0, 0.0, 0.0};
    Vec3<T> gravity_gradient_force_B{0.0, 0.0, 0.0}, gravity_gradient_torque_B{0.0, 0.0, 0.0};
    T altitude = 0.0;

    template <class V>
    void declare(V& v) {
        v.input("force_B", force_B, unit::N, "control force on the body, in B");
        v.input("torque_B", torque_B, unit::N_m, "control torque, in B");
        v.parameter("mass", mass, unit::kg, "m, mass").above(0);
        v.parameter("J_B", J_B, unit::kg_m2, "inertia about the centre of mass, in B").inertia();
        v.parameter("mu", mu, unit::m3_per_s2, "gravitational parameter of the Earth").above(0).nominal(4e14);
        v.parameter("earth_radius", earth_radius, unit::m, "radius of the Earth").above(0).nominal(1e7);
        v.state("r_BN_N", r_BN_N, rDot_BN_N, unit::m, "position of the centre of mass, in N").nominal(1e7);
        v.state("v_BN_N", v_BN_N, vDot_BN_N, unit::m_per_s, "velocity of the centre of mass, in N").nominal(1e4);
        v.state("q_BN", q_BN, qDot_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.state("omega_BN_B", omega_BN_B, omegaDot_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B")
            .nominal(0.1);
        v.output("gravity_gradient_force_B", gravity_gradient_force_B, unit::N,
                 "f_d, force of gravity that comes from the extent of the body, in B")
            .nominal(1e-6);
        v.output("gravity_gradient_torque_B", gravity_gradient_torque_B, unit::N_m, "tau_g, in B").nominal(1e-5);
        v.output("altitude", altitude, unit::m, "height above the Earth").nominal(1e6);
    }

    void outputs() {
        altitude = height_above(r_BN_N, earth_radius);
        const Vec3<T> r_B = dcm(q_BN) * r_BN_N;
        gravity_gradient_force_B = gravity_gradient_force(mu, J_B, r_B);
        gravity_gradient_torque_B = gravity_gradient_torque(mu, J_B, r_B);
    }

    void derivatives() {
        rDot_BN_N = v_BN_N;
        const Vec3<T> pushed_B = (gravity_gradient_force_B + force_B) / mass;
        vDot_BN_N = point_mass_gravity(mu, r_BN_N) + dcm(q_BN).transpose() * pushed_B;
        qDot_BN = kinematics(q_BN, omega_BN_B);
        const Vec3<T> H_B = J_B * omega_BN_B;
        omegaDot_BN_B = J_B.inverse() * (torque_B + gravity_gradient_torque_B - omega_BN_B.cross(H_B));
    }

    void validate(Words& refuse) const {
        const T distance = r_BN_N.norm();
        if (!(distance > earth_radius))
            refuse("r_BN_N lies inside the Earth, within earth_radius: |r_BN_N| = %g m", distance);
    }
};

}  // namespace adcs

/// # Environment torque
///
/// Torque of the gravity gradient, of drag and of the Earth's oblateness, Eq. (92):
///
/// $$d = \frac{3\mu}{|r|^5}\,(C r)\times J\,(C r) - \tfrac12\rho\,|v|\,C_d A\; r_c\times C v
///   + r_c\times C F_{J_2}$$
/// $$F_{J_2} = \frac{3\,m\,\mu J_2 R_e^2}{2\,|r|^7}
///   \begin{bmatrix} 5 r_x r_z^2 - r_x |r|^2 \\ 5 r_y r_z^2 - r_y |r|^2 \\ 5 r_z^3 - 3 r_z |r|^2 \end{bmatrix}$$
///
/// with $C = C(q_{BN})$. In print all three rows of the last bracket have the factor 3, which is not the gradient of the
/// oblateness potential, and the mass $m$ is missing, without which $F_{J_2}$ is no force. The lever arm $r_c$ is the one
/// free number of the model: from the centre of mass to the line of action of the force, the same for drag and oblateness.
/// Below the surface of the Earth `altitude` is not a number and the evaluation is refused.
#pragma once

#include "attitude/gravity.hpp"
#include "attitude/quaternion.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct EnvironmentTorque {
    static constexpr auto summary = "Torque of gravity gradient, drag and the Earth's oblateness";
    static constexpr auto reference =
        "Velocity-free passivity-based attitude tracking with measurement errors, disturbances and inertia mismatch, "
        "Eq. (92)";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> r_BN_N{7.136e6, 0.0, 0.0}, v_BN_N{0.0, 7.474e3, 0.0};
    Mat3<T> J_B{{0.0465, -0.0007, 0.0004}, {-0.0007, 0.0486, -0.0021}, {0.0004, -0.0021, 0.0482}};
    T mass = 1.0, drag_coefficient = 2.5, area = 0.04, density = 1.99e-14;
    Vec3<T> lever_arm_B{0.01, 0.0, 0.0};
    T mu = 398.6e12, earth_radius = 6371.0e3, j2 = 1082.6e-6;
    Vec3<T> torque_B{0.0, 0.0, 0.0};
    Vec3<T> gravity_gradient_B{0.0, 0.0, 0.0}, drag_B{0.0, 0.0, 0.0}, oblateness_B{0.0, 0.0, 0.0};
    T altitude = 0.0;

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "attitude of B relative to N; the z axis of N is the Earth's")
            .unit_quaternion();
        v.input("r_BN_N", r_BN_N, unit::m, "position of the centre of mass, in N").nominal(1e7);
        v.input("v_BN_N", v_BN_N, unit::m_per_s, "velocity of the centre of mass relative to the air, in N")
            .nominal(1e4);
        v.parameter("J_B", J_B, unit::kg_m2, "inertia about the centre of mass, in B").inertia();
        v.parameter("mass", mass, unit::kg, "m, mass of the spacecraft").above(0);
        v.parameter("drag_coefficient", drag_coefficient, unit::one, "C_d").at_least(0);
        v.parameter("area", area, unit::m2, "A, cross section that the air meets").at_least(0);
        v.parameter("density", density, unit::kg_per_m3, "rho, density of the air").at_least(0).nominal(1e-14);
        v.parameter("lever_arm_B", lever_arm_B, unit::m, "r_c, from the centre of mass to the line of action, in B");
        v.parameter("mu", mu, unit::m3_per_s2, "gravitational parameter of the Earth").above(0).nominal(4e14);
        v.parameter("earth_radius", earth_radius, unit::m, "R_e, radius of the Earth").above(0).nominal(1e7);
        v.parameter("j2", j2, unit::one, "J_2, oblateness of the Earth").nominal(1e-3);
        v.output("torque_B", torque_B, unit::N_m, "d, the three torques together, in B").nominal(1e-4);
        v.output("gravity_gradient_B", gravity_gradient_B, unit::N_m, "torque of the gravity gradient, in B")
            .nominal(1e-8);
        v.output("drag_B", drag_B, unit::N_m, "torque of drag, in B").nominal(1e-9);
        v.output("oblateness_B", oblateness_B, unit::N_m, "torque of the Earth's oblateness, in B").nominal(1e-4);
        v.output("altitude", altitude, unit::m, "height above the Earth").nominal(1e6);
    }

    void outputs() {
        altitude = height_above(r_BN_N, earth_radius);
        const Mat3<T> C_BN = dcm(q_BN);
        gravity_gradient_B = gravity_gradient_torque<T>(mu, J_B, C_BN * r_BN_N);

        const Vec3<T> drag_N = -0.5 * density * drag_coefficient * area * sqrt(v_BN_N.dot(v_BN_N)) * v_BN_N;
        const T r2 = r_BN_N.dot(r_BN_N), z2 = r_BN_N[2] * r_BN_N[2];
        const Vec3<T> bracket{r_BN_N[0] * (5.0 * z2 - r2), r_BN_N[1] * (5.0 * z2 - r2),
                              r_BN_N[2] * (5.0 * z2 - 3.0 * r2)};
        const Vec3<T> oblateness_N =
            1.5 * mass * mu * j2 * earth_radius * earth_radius / (r2 * r2 * r2 * sqrt(r2)) * bracket;
        drag_B = lever_arm_B.cross(C_BN * drag_N);
        oblateness_B = lever_arm_B.cross(C_BN * oblateness_N);
        torque_B = gravity_gradient_B + drag_B + oblateness_B;
    }

    void validate(Words& refuse) const {
        const T distance = r_BN_N.norm();
        if (!(distance > earth_radius))
            refuse("r_BN_N lies inside the Earth, within earth_radius: |r_BN_N| = %g m", distance);
    }
};

}  // namespace adcs

/// # Inertia mismatch
///
/// The torque by which a body of inertia $J = J_0 + \Delta J$ differs from one of inertia $J_0$, Eq. (4.5) with
/// $\Delta J^* = J^{-1} - J_0^{-1}$:
///
/// $$T_d = -J_0(\Delta J^* S(\omega)J + J_0^{-1}S(\omega)\Delta J)\,\omega
///   + 3n^2J_0(\Delta J^*S(c_3)J + J_0^{-1}S(c_3)\Delta J)\,c_3 + J_0\Delta J^* T_c$$
///
/// A body of inertia $J_0$ under $T_d$ moves like the true one, as long as it is continuous; then the true inertia in the
/// plant does the same with less. With a `period` the torque is computed at the sampling instants and held in between,
/// as the thesis did.
#pragma once

#include "attitude/gravity_gradient.hpp"
#include "attitude/mrp.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct InertiaMismatch {
    static constexpr auto summary = "Torque by which a body of the true inertia differs from one of the known inertia";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, Secs. 4.1 and "
        "9.1.1";

    Mrp<T> sigma_BO{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, torque_control_B{0.0, 0.0, 0.0};
    Mat3<T> J_B{{37.0 / 12.0, 0.0, 0.0}, {0.0, 37.0 / 12.0, 0.0}, {0.0, 0.0, 25.0 / 12.0}};
    Mat3<T> J0_B = J_B;
    T orbital_rate = 1.073e-3, period = 0.0;
    Vec3<T> torque_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("sigma_BO", sigma_BO, unit::one, "attitude of B relative to O as MRP").at_least(-1).at_most(1);
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.01);
        v.input("torque_control_B", torque_control_B, unit::N_m, "T_c, control torque on the body, in B");
        v.parameter("J_B", J_B, unit::kg_m2, "true inertia, in B").inertia();
        v.parameter("J0_B", J0_B, unit::kg_m2, "J_0, inertia of the body that the torque acts on, in B").inertia();
        v.parameter("orbital_rate", orbital_rate, unit::rad_per_s, "n, rate of the circular orbit").at_least(0);
        v.parameter("period", period, unit::s, "sampling period of the torque; 0: continuous").fixed().at_least(0);
        v.sampled(period);
        v.output("torque_B", torque_B, unit::N_m, "disturbance torque on a body of inertia J_0, in B")
            .sampled()
            .nominal(1e-4);
    }

    void outputs() { torque_B = torque(); }

private:
    Vec3<T> torque() const {
        const Vec3<T>& w = omega_BN_B;
        const Vec3<T> c_3 = mrp_dcm(sigma_BO).col(2);
        const Mat3<T> dJ = J_B - J0_B;
        const Vec3<T> all = torque_control_B + gravity_gradient(orbital_rate, c_3, J_B) - w.cross(J_B * w);
        // J_0 dJ* x = -dJ J^-1 x, written without the difference of the inverses
        return -(dJ * (J_B.inverse() * all)) - w.cross(dJ * w) + gravity_gradient(orbital_rate, c_3, dJ);
    }
};

}  // namespace adcs

/// # Backstepping attitude control with command filters
///
/// Tracks a reference attitude given as MRP, Chapter 8. With the error $z_1 = \sigma_e = \sigma_r\otimes(-\sigma)$ (A.18),
/// $W = \frac{\partial\sigma_e}{\partial\sigma}N(\sigma)$, the estimate $\hat T_d$ of an observer, and all the rest known:
///
/// $$x_{2,c}^0 = -n c_2 - W^{-1}\left(\frac{\partial\sigma_e}{\partial\sigma_r}\dot\sigma_r + c_1 z_1\right) - \chi_2
///   \qquad\text{(8.9), filtered to } x_{2,c},\ \dot x_{2,c}$$
/// $$z_2 = \omega - x_{2,c}, \qquad \bar z_1 = z_1 - \chi_1, \qquad \bar z_2 = z_2 - \chi_2$$
/// $$v = \dot x_{2,c} - c_2 z_2 - K\bar z_2 - W^T\bar z_1$$
/// $$T_c^0 = \omega\times J_0\omega - 3n^2\,c_3\times J_0c_3 + J_0 v - \hat T_d \qquad\text{(8.32), filtered to } T_c$$
/// $$\dot\chi_1 = -c_1\chi_1 + W(x_{2,c} - x_{2,c}^0), \qquad \dot\chi_2 = -c_2\chi_2 + J_0^{-1}(T_c - T_c^0) \qquad (8.8)$$
///
/// $K = J_0^{-1}\kappa J_0^{-1}$ is the nonlinear damping (8.77); 0 gives the standard law (8.10). The filters (C.5) limit a
/// command and its rate, in length, and what they take away goes into $\chi_1$ and $\chi_2$: neither the law nor an
/// observer takes saturation for an error. Without saturation and disturbance
///
/// $$V = \tfrac12(\bar z_1^T\bar z_1 + \bar z_2^T\bar z_2), \qquad
///   \dot V = -\bar z_1^T c_1\bar z_1 - \bar z_2^T(c_2 + K)\bar z_2 \qquad (8.13)$$
///
/// Sampled with a period. Within one sample the outputs are computed in the order above, so an observer that needs
/// $\bar z_2$ or the expected acceleration can answer at the same instant. Of the attitude and its shadow the law takes the
/// one nearer to the reference.
#pragma once

#include "attitude/gravity_gradient.hpp"
#include "attitude/mrp.hpp"
#include "controllers/command_filter.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct BacksteppingControl {
    static constexpr auto summary =
        "Backstepping attitude tracking in MRP with limited commands and disturbance rejection";
    static constexpr auto reference =
        "Trigo, Robust and Adaptive Nonlinear Attitude Control of a Spacecraft, MSc dissertation, 2011, chapter 8 and "
        "appendix C.1";

    Mrp<T> sigma_BO{0.0, 0.0, 0.0}, sigma_RO{0.0, 0.0, 0.0}, sigmaDot_RO{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, torque_disturbance_B_est{0.0, 0.0, 0.0};
    Mat3<T> J0_B{{37.0 / 12.0, 0.0, 0.0}, {0.0, 37.0 / 12.0, 0.0}, {0.0, 0.0, 25.0 / 12.0}};
    Mat3<T> c_1 = 0.1 * Mat3<T>::Identity(), c_2 = Mat3<T>::Identity(), K = Mat3<T>::Identity();
    T orbital_rate = 1.073e-3;
    T rate_limit = 0.017453292519943295, acceleration_limit = 0.0026179938779914943;  // 1 deg/s, 0.15 deg/s2
    T torque_limit = 0.057735026918962581, torque_rate_limit = 6.0, period = 0.1;     // 0.05 sqrt(4/3) N.m
    std::int32_t start_at_command = 0;

    Vec3<T> chi_1{0.0, 0.0, 0.0}, chi_2{0.0, 0.0, 0.0}, chiDot_2{0.0, 0.0, 0.0};

    Vec3<T> torque_B{0.0, 0.0, 0.0}, torque_raw_B{0.0, 0.0, 0.0};
    Vec3<T> omega_c_B{0.0, 0.0, 0.0}, omega_c_raw_B{0.0, 0.0, 0.0}, omegaDot_c_B{0.0, 0.0, 0.0};
    Mrp<T> sigma_RB{0.0, 0.0, 0.0}, z_1_bar_B{0.0, 0.0, 0.0};
    Vec3<T> z_2_B{0.0, 0.0, 0.0}, z_2_bar_B{0.0, 0.0, 0.0}, acceleration_expected_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("sigma_BO", sigma_BO, unit::one, "attitude of B relative to O as MRP").at_least(-1).at_most(1);
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.01);
        v.input("sigma_RO", sigma_RO, unit::one, "reference attitude relative to O as MRP").at_least(-1).at_most(1);
        v.input("sigmaDot_RO", sigmaDot_RO, unit::one_per_s, "time derivative of sigma_RO").nominal(0.001);
        v.input("torque_disturbance_B_est", torque_disturbance_B_est, unit::N_m,
                "estimate of the disturbance torque, in B")
            .nominal(1e-4);
        v.parameter("J0_B", J0_B, unit::kg_m2, "J_0, inertia that the law assumes, in B").inertia();
        v.parameter("c_1", c_1, unit::one_per_s, "gain of the attitude error").positive_definite();
        v.parameter("c_2", c_2, unit::one_per_s, "gain of the rate error").positive_definite();
        v.parameter("K", K, unit::one_per_s, "nonlinear damping; 0: the standard law").positive_semidefinite();
        v.parameter("orbital_rate", orbital_rate, unit::rad_per_s, "n, rate of the circular orbit").at_least(0);
        v.parameter("rate_limit", rate_limit, unit::rad_per_s, "largest commanded angular velocity").above(0);
        v.parameter("acceleration_limit", acceleration_limit, unit::rad_per_s2,
                    "largest rate of the commanded angular velocity")
            .above(0);
        v.parameter("torque_limit", torque_limit, unit::N_m, "largest torque").above(0);
        v.parameter("torque_rate_limit", torque_rate_limit, unit::N_m_per_s, "largest rate of the torque").above(0);
        v.parameter("period", period, unit::s, "sampling period").fixed().above(0);
        v.parameter("start_at_command", start_at_command, "1: the filtered rate starts at the first command; 0: at 0")
            .fixed()
            .at_least(0)
            .at_most(1);
        v.sampled(period);
        v.held("chi_1", chi_1, unit::one, "effect of the filters on the attitude error");
        v.held("chi_2", chi_2, unit::rad_per_s, "effect of the filters on the rate error");
        v.held("chiDot_2", chiDot_2, unit::rad_per_s2, "its rate");
        v.held("torque_B", torque_B, unit::N_m, "T_c, control torque, in B").output();
        v.held("torque_raw_B", torque_raw_B, unit::N_m, "T_c0, control torque before limits, in B").output();
        v.held("omega_c_B", omega_c_B, unit::rad_per_s, "x_2c, commanded angular velocity, in B")
            .output()
            .nominal(0.01);
        v.held("omega_c_raw_B", omega_c_raw_B, unit::rad_per_s, "x_2c0, commanded angular velocity before limits, in B")
            .output()
            .nominal(0.01);
        v.held("omegaDot_c_B", omegaDot_c_B, unit::rad_per_s2, "rate of omega_c_B").output().nominal(1e-3);
        v.held("sigma_RB", sigma_RB, unit::one, "z_1, attitude of R relative to B as MRP").output();
        v.held("z_2_B", z_2_B, unit::rad_per_s, "z_2, rate error omega_BN_B - omega_c_B, in B").output().nominal(1e-4);
        v.held("z_1_bar_B", z_1_bar_B, unit::one, "attitude error without the effect of the filters").output();
        v.held("z_2_bar_B", z_2_bar_B, unit::rad_per_s, "rate error without the effect of the filters, in B")
            .output()
            .nominal(1e-4);
        v.held("acceleration_expected_B", acceleration_expected_B, unit::rad_per_s2,
               "acceleration with the present torque if the estimate were true, in B")
            .output()
            .nominal(1e-3);
    }

    void sample(const Sample& s) {
        const Vec3<T>& w = omega_BN_B;
        const Mrp<T> sigma = mrp_nearest(sigma_BO, sigma_RO);
        const MrpError<T> error = mrp_error(sigma, sigma_RO);
        const Mat3<T> C = mrp_dcm(sigma), W = error.by_sigma_BO * mrp_kinematics(sigma);
        const Vec3<T> c2 = C.col(1), c3 = C.col(2);
        sigma_RB = error.sigma_RB;

        const Vec3<T> alpha_1 =
            -orbital_rate * c2 - W.inverse() * (error.by_sigma_RO * sigmaDot_RO + c_1 * sigma_RB);  // (8.9)
        omega_c_raw_B = alpha_1 - chi_2;                                                            // (8.6)
        if (start_at_command == 1 && s.first) omega_c_B = omega_c_raw_B;
        omegaDot_c_B = command_filter(omega_c_B, omega_c_raw_B, rate_limit, acceleration_limit, period);

        z_2_B = w - omega_c_B;  // (8.4)
        z_1_bar_B = sigma_RB - chi_1;
        z_2_bar_B = z_2_B - chi_2;  // (8.7)
        const Vec3<T> acceleration = omegaDot_c_B - c_2 * z_2_B - K * z_2_bar_B - W.transpose() * z_1_bar_B;
        acceleration_expected_B = acceleration + c_2 * chi_2 + chiDot_2;  // bracket of (8.61)

        torque_raw_B = w.cross(J0_B * w) - gravity_gradient(orbital_rate, c3, J0_B) + J0_B * acceleration -
                       torque_disturbance_B_est;  // (8.32)
        command_filter(torque_B, torque_raw_B, torque_limit, torque_rate_limit, period);

        const Vec3<T> chiDot_1 = -c_1 * chi_1 + W * (omega_c_B - omega_c_raw_B);
        chiDot_2 = -c_2 * chi_2 + J0_B.inverse() * (torque_B - torque_raw_B);  // (8.8)
        chi_1 += period * chiDot_1;
        chi_2 += period * chiDot_2;
    }
};

}  // namespace adcs

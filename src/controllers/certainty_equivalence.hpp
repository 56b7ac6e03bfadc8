// What the adaptive laws of Thakur's chapter 3 share: the tracking errors, the torque that an estimated inertia asks
// for, and the adaptation of its constant part J_0.
#pragma once

#include "attitude/inertia.hpp"
#include "controllers/ball_projection.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

/// Errors of B with respect to R, and what the laws make of them.
template <class T>
struct TrackingError {
    Quat<T> q_BR;
    Vec3<T> omega_BR_B;
    Vec3<T> qDot;  ///< of the vector part of q_BR
    Vec3<T> phi;   ///< omega_e x C(q_e) omega_r - C(q_e) omegaDot_r, Eq. (3.14)
    Vec3<T> s;     ///< omega_e + q_ev

    TrackingError(const Quat<T>& q_BN, const Vec3<T>& omega_BN_B, const Quat<T>& q_RN, const Vec3<T>& omega_RN_R,
                  const Vec3<T>& omegaDot_RN_R, bool short_way) {
        q_BR = attitude_error(q_BN, q_RN, short_way);
        const Mat3<T> C_BR = dcm(q_BR);
        const Vec3<T> omega_RN_B = C_BR * omega_RN_R;
        omega_BR_B = omega_BN_B - omega_RN_B;
        qDot = vec(kinematics(q_BR, omega_BR_B));
        phi = omega_BR_B.cross(omega_RN_B) - C_BR * omegaDot_RN_R;
        s = omega_BR_B + vec(q_BR);
    }
};

/// Base of the laws (3.20), (3.33): inputs, feedback, and theta_est with its update (3.26).
template <class T>
struct CertaintyEquivalence {
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Ch. 3";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};
    T beta = 20.0, k_v = 24.5, gamma_1 = 60.0;
    bool short_way = false;
    T theta_bound = 1e6, theta_margin = 1e6;  // never reached: no projection
    Vec6<T> theta_est{{21.1, 1.9, 1.4, 17.8, 2.9, 15.5}}, theta_estDot{{0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
    Vec3<T> torque_B{0.0, 0.0, 0.0}, omega_BR_B{0.0, 0.0, 0.0};
    Quat<T> q_BR{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare_tracking(V& v) {
        v.input("q_BN", q_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.1);
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.parameter("beta", beta, unit::N_m, "attitude gain").above(0);
        v.parameter("k_v", k_v, unit::N_m_s, "rate gain").above(0);
        v.parameter("gamma_1", gamma_1, unit::kg_m2_s2, "adaptation gain of theta_est; 0: it stays as it starts")
            .at_least(0);
        v.parameter("theta_bound", theta_bound, unit::kg_m2,
                    "root of epsilon_1: the norm of theta_est above which its growth is slowed down")
            .above(0)
            .nominal(10.0);
        v.parameter("theta_margin", theta_margin, unit::kg_m2,
                    "root of delta_1: the square of the norm stays below theta_bound^2 + theta_margin^2")
            .above(0)
            .nominal(10.0);
        declare_short_way(v, short_way);
        v.state("theta_est", theta_est, theta_estDot, unit::kg_m2,
                "estimate of the constant part of the inertia, in B: J11, J12, J13, J22, J23, J33")
            .nominal(10.0);
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
        v.output("q_BR", q_BR, unit::one, "attitude error, B relative to R").unit_quaternion();
        v.output("omega_BR_B", omega_BR_B, unit::rad_per_s, "rate error, B relative to R, in B").nominal(0.1);
    }

protected:
    TrackingError<T> tracking_error() const { return {q_BN, omega_BN_B, q_RN, omega_RN_R, omegaDot_RN_R, short_way}; }

    /// The error outputs, and the part of Eq. (3.20) that every law has: -beta q_ev - k_v omega_e - W_1 theta_est.
    Vec3<T> feedback(const TrackingError<T>& e) {
        q_BR = e.q_BR;
        omega_BR_B = e.omega_BR_B;
        return -beta * vec(q_BR) - k_v * omega_BR_B - W_1(e) * theta_est;
    }

    /// Eq. (3.26).
    void adapt(const TrackingError<T>& e) {
        const Vec6<T> Phi = W_1(e).transpose() * e.s;
        theta_estDot = update(theta_est, Phi, gamma_1, theta_bound, theta_margin);
    }

    /// gamma Proj(estimate, gradient), Eqs. (3.27) and (3.31), for an estimate of any shape; the norm is that of its
    /// elements.
    template <class M>
    static M update(const M& estimate, const M& gradient, const T& gamma, const T& bound, const T& margin) {
        constexpr int n = M::SizeAtCompileTime;
        using Elements = Eigen::Matrix<T, n, 1>;
        const Elements at = Eigen::Map<const Elements>(estimate.data());
        const Elements along = Eigen::Map<const Elements>(gradient.data());
        M rate;
        Eigen::Map<Elements>(rate.data()) = gamma * project<T, n>(at, along, bound, margin * margin / (bound * bound));
        return rate;
    }

    /// Whether an estimate starts where the projection can keep it, Eq. (3.28).
    template <class M>
    static bool starts_inside(const M& estimate, const T& bound, const T& margin) {
        return estimate.squaredNorm() < bound * bound + margin * margin;
    }
    void refuse_start(Words& refuse) const {
        if (starts_inside(theta_est, theta_bound, theta_margin)) return;
        refuse(
            "theta_est starts outside the set that its projection keeps it in: its norm must be below "
            "sqrt(theta_bound^2 + theta_margin^2) = %g, and is %g",
            sqrt(theta_bound * theta_bound + theta_margin * theta_margin), theta_est.norm());
    }
    /// The same of the estimate of J_1, too.
    template <class M>
    void refuse_starts(const M& sigma_est, const T& bound, const T& margin, Words& refuse) const {
        refuse_start(refuse);
        if (starts_inside(sigma_est, bound, margin)) return;
        refuse(
            "the estimate of J_1 starts outside the set that its projection keeps it in: its norm must be below "
            "sqrt(sigma_bound^2 + sigma_margin^2) = %g, and is %g",
            sqrt(bound * bound + margin * margin), sigma_est.norm());
    }

    /// W_1 theta = J_0 a - omega x J_0 omega with a = qDot_ev + phi, Eq. (3.16).
    Eigen::Matrix<T, 3, 6> W_1(const TrackingError<T>& e) const {
        return inertia_regressor<T>(e.qDot + e.phi) + inertia_regressor<T>(omega_BN_B).colwise().cross(omega_BN_B);
    }
};

/// The part -J_1 Psi of the inertia (3.3), with J_1 (3 x N) unknown and Psi (N x 3) known, in the laws' terms.
template <class T, int N>
struct VariablePart {
    using Parameters = Eigen::Matrix<T, 3, N, Eigen::RowMajor>;
    using Known = Eigen::Matrix<T, N, 3>;
    using VecN = Eigen::Matrix<T, N, 1>;

    VecN Psi_a, Psi_omega, PsiDot_Omega;
    Vec3<T> omega, s;

    VariablePart(const Known& Psi, const Known& PsiDot, const Vec3<T>& omega_BN_B, const TrackingError<T>& e)
        : omega(omega_BN_B), s(e.s) {
        Psi_a = Psi * (e.qDot + e.phi);
        Psi_omega = Psi * omega;
        PsiDot_Omega = PsiDot * Omega(omega, e);
    }
    /// Eq. (3.35).
    static Vec3<T> Omega(const Vec3<T>& omega_BN_B, const TrackingError<T>& e) { return omega_BN_B - 0.5 * e.s; }

    /// (W_2 + W_3) sigma, Eqs. (3.17), (3.18).
    Vec3<T> torque(const Parameters& J_1) const {
        const Vec3<T> H = J_1 * Psi_omega;
        return -J_1 * Psi_a + omega.cross(H) + J_1 * PsiDot_Omega;
    }
    /// (W_2 + W_3)^T s, Eq. (3.22), in the shape of J_1.
    Parameters gradient() const {
        return -s * Psi_a.transpose() + s.cross(omega) * Psi_omega.transpose() + s * PsiDot_Omega.transpose();
    }
};

}  // namespace adcs

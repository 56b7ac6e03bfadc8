/// # Adaptive tracking with guaranteed bounds
///
/// Attitude tracking without knowledge of the inertia, from estimates of attitude and rate, Eqs. (27)-(30). The estimates
/// may come from any observer with bounded errors; the tracking errors then end below bounds that are known beforehand.
///
/// With the estimated error $C(\hat q) = C(\hat q_{BN})\,C(q_{RN})^T$, $\hat\omega_d = C(\hat q)\,\omega_d$,
/// $\delta\hat\omega = \hat\omega - \hat\omega_d$ and the filtered rate error
/// $\tilde\omega = \delta\hat\omega + \lambda\,\hat q$
///
/// $$\tau = \hat P^{-1}\left[-\delta\hat\omega\times\hat\omega_d + C(\hat q)\,\dot\omega_d
///   - \tfrac{\lambda}{2}(\hat q\times\delta\hat\omega + \hat q_4\,\delta\hat\omega)
///   - k\,\tilde\omega + \Phi(\hat\omega)\,\hat\theta\right]$$
///
/// $\hat P$, of the six parameters $\hat\theta_p$, stands for the inverse inertia, and the eighteen $\hat\theta$ for
/// $\Phi(\omega)\,\theta = P\,(\omega\times J\omega)$. They adapt while $\lVert\tilde\omega\rVert$ exceeds the dead zone
/// $\Omega$, and rest below it:
///
/// $$\dot{\hat\theta} = \gamma\,\mathrm{Proj}(\hat\theta,\, -\Phi(\hat\omega)^T\tilde\omega), \qquad
///   \dot{\hat\theta}_p = \gamma_p\,\mathrm{Proj}(\hat\theta_p,\, \Psi(\tau)^T\tilde\omega)$$
///
/// They start at the values $\theta^*$, $\theta_p^*$ of the inertia `J_B`, and the projection, Eqs. (23)-(26), keeps them
/// within $\sqrt{1+\varepsilon}\,\eta$ and $\sqrt{1+\varepsilon_p}\,\eta_p$ of these. The states are the offsets from them.
/// $\hat P$ is invertible all over its ball, whatever happens, if
///
/// $$\sqrt{\tfrac53}\,\sqrt{1+\varepsilon_p}\;\eta_p < \lambda_{min}(P^*)$$
///
/// which is refused otherwise. With exact estimates, no disturbance, no dead zone, and no projection at work
///
/// $$V = \tfrac12\lVert\tilde\omega\rVert^2 + \tfrac{1}{2\gamma}\lVert\hat\theta-\theta\rVert^2
///   + \tfrac{1}{2\gamma_p}\lVert\hat\theta_p-\theta_p\rVert^2, \qquad \dot V = -k\,\lVert\tilde\omega\rVert^2$$
///
/// **Sign.** The law brings $\delta\hat q$ to $[1\ 0\ 0\ 0]$, so from $\hat q_4 < 0$ it turns B by more than 180 degrees though a smaller
/// turn would do. With `short_way` it takes that of $\delta\hat q$ and $-\delta\hat q$ with $\hat q_4 \ge 0$; where $\hat q_4$ falls
/// through 0, $V$ then jumps down by $2\lambda\,\hat q^T\delta\hat\omega > 0$, and the torque jumps too. The bounds of
/// the paper are proven without `short_way`.
///
/// In print the projection returns $v$ instead of $y$ where it does not act, and the radii of the balls read
/// $\sqrt{1+\varepsilon\eta}$. The law jumps at the edge of the dead zone, in the rates of the estimates only.
#pragma once

#include "controllers/ball_projection.hpp"
#include "controllers/inverse_inertia_regressor.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct BoundedAdaptiveTracking {
    static constexpr auto summary = "Adaptive attitude tracking from estimates, with guaranteed error bounds";
    static constexpr auto reference =
        "de Ruiter, Observer-Based Adaptive Spacecraft Attitude Control with Guaranteed Performance Bounds, Eqs. "
        "(23)-(30)";

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};
    Mat3<T> J_B{{21.0, 0.0, 0.0}, {0.0, 16.5, 0.0}, {0.0, 0.0, 14.5}};
    T k = 0.3, lambda = 0.05, gamma = 20.0, gamma_p = 0.02, dead_zone = 1e-3;
    T eta = 0.35, eta_p = 0.015, epsilon = 0.1, epsilon_p = 0.1;
    bool short_way = false;
    Vec18<T> theta_offset = Vec18<T>::Constant(0.0), thetaDot_offset = theta_offset, theta_est = theta_offset;
    Vec6<T> theta_p_offset = Vec6<T>::Constant(0.0), thetaDot_p_offset = theta_p_offset, theta_p_est = theta_p_offset;
    T theta_level = 0.0, theta_p_level = 0.0;
    Vec3<T> torque_B{0.0, 0.0, 0.0}, omega_BR_B{0.0, 0.0, 0.0}, filtered_rate_B{0.0, 0.0, 0.0};
    Quat<T> q_BR{1.0, 0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "attitude of B relative to N, or its estimate").unit_quaternion();
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B, or its estimate")
            .nominal(0.1);
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "omega_d, angular velocity of R relative to N, in R")
            .nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.parameter("J_B", J_B, unit::kg_m2,
                    "inertia about which the true one is sought: theta*, theta_p* are its values")
            .fixed()
            .inertia();
        v.parameter("k", k, unit::one_per_s, "gain of the filtered rate error").above(0);
        v.parameter("lambda", lambda, unit::one_per_s, "gain of the attitude in the filtered rate error").above(0);
        v.parameter("gamma", gamma, unit::s2, "adaptation gain of theta").above(0);
        v.parameter("gamma_p", gamma_p, unit::s2_per_kg2_m4, "adaptation gain of theta_p").above(0);
        v.parameter("dead_zone", dead_zone, unit::rad_per_s,
                    "Omega, no adaptation up to this filtered rate error; 0: none")
            .at_least(0);
        v.parameter("eta", eta, unit::one, "theta is known to lie within this distance of theta*").fixed().above(0);
        v.parameter("eta_p", eta_p, unit::one_per_kg_m2, "theta_p is known to lie within this distance of theta_p*")
            .fixed()
            .above(0);
        v.parameter("epsilon", epsilon, unit::one, "the estimate stays within sqrt(1 + epsilon) eta of theta*")
            .fixed()
            .above(0);
        v.parameter("epsilon_p", epsilon_p, unit::one,
                    "the estimate stays within sqrt(1 + epsilon_p) eta_p of theta_p*")
            .fixed()
            .above(0);
        declare_short_way(v, short_way);
        v.state("theta_offset", theta_offset, thetaDot_offset, unit::one, "estimate of theta less theta*").nominal(0.1);
        v.state("theta_p_offset", theta_p_offset, thetaDot_p_offset, unit::one_per_kg_m2,
                "estimate of theta_p less theta_p*")
            .nominal(0.01);
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
        v.output("q_BR", q_BR, unit::one, "attitude error as the law sees it, B relative to R").unit_quaternion();
        v.output("omega_BR_B", omega_BR_B, unit::rad_per_s, "rate error as the law sees it, B relative to R, in B")
            .nominal(0.1);
        v.output("filtered_rate_B", filtered_rate_B, unit::rad_per_s, "filtered rate error, omega_BR_B + lambda q_BR,v")
            .nominal(0.1);
        v.output("theta_est", theta_est, unit::one, "estimate of theta: the rows of the 3 x 6 matrix of Eq. (14)");
        v.output("theta_p_est", theta_p_est, unit::one_per_kg_m2,
                 "estimate of P11 P22 P33 P12 P13 P23, P = 1 / inertia")
            .nominal(0.1);
        v.output("theta_level", theta_level, unit::one, "d of Eq. (25): 0 at distance eta, 1 at sqrt(1 + epsilon) eta");
        v.output("theta_p_level", theta_p_level, unit::one,
                 "d of Eq. (26): 0 at distance eta_p, 1 at sqrt(1 + epsilon_p) eta_p");
    }

    void outputs() {
        q_BR = attitude_error(q_BN, q_RN, short_way);
        const Vec3<T> q = vec(q_BR);
        const Mat3<T> C = dcm(q_BR);
        const Vec3<T> omega_d = C * omega_RN_R;
        omega_BR_B = omega_BN_B - omega_d;
        filtered_rate_B = omega_BR_B + lambda * q;

        const Mat3<T> P_star = J_B.inverse();
        theta_est = theta_of(P_star, J_B) + theta_offset;
        theta_p_est = theta_p_of(P_star) + theta_p_offset;
        const Vec3<T> auxiliary =
            C * omegaDot_RN_R - omega_BR_B.cross(omega_d) - 0.5 * lambda * (q.cross(omega_BR_B) + q_BR[0] * omega_BR_B);
        torque_B = P_of(theta_p_est).inverse() * (auxiliary - k * filtered_rate_B + Phi_times(omega_BN_B, theta_est));

        theta_level = ball_level(theta_offset, eta, epsilon);
        theta_p_level = ball_level(theta_p_offset, eta_p, epsilon_p);
    }

    void derivatives() {
        // a factor instead of a branch, so that the model structure shows what the rates depend on
        const T adapting = filtered_rate_B.dot(filtered_rate_B) > dead_zone * dead_zone ? 1.0 : 0.0;
        const Vec18<T> y = -PhiT_times(omega_BN_B, filtered_rate_B);
        const Vec6<T> y_p = PsiT_times(torque_B, filtered_rate_B);
        thetaDot_offset = adapting * gamma * project(theta_offset, y, eta, epsilon);
        thetaDot_p_offset = adapting * gamma_p * project(theta_p_offset, y_p, eta_p, epsilon_p);
    }

    /// sqrt(5/3) is the largest norm of a symmetric matrix whose six elements have norm 1: 1 on and 2 off the diagonal,
    /// scaled.
    void validate(Words& refuse) const {
        const T reach = sqrt(5.0 / 3.0 * (1.0 + epsilon_p)) * eta_p;
        // lambda_min(P*) > reach, that is, 1 / reach - J_B is positive definite: its leading minors are positive
        const Mat3<T> M = Mat3<T>::Identity() / reach - J_B;
        const T second = M(0, 0) * M(1, 1) - M(0, 1) * M(1, 0);
        if (M(0, 0) > 0.0 && second > 0.0 && M.determinant() > 0.0) return;
        refuse(
            "eta_p is too large for J_B: the estimate of the inverse inertia could become singular, unless "
            "sqrt(5/3 (1 + epsilon_p)) eta_p is below 1 / (largest principal moment of J_B) (it is %g)",
            reach);
    }
};

}  // namespace adcs

/// # Non-certainty-equivalence adaptive attitude tracking
///
/// The comparison controller of Thakur's Sec. 3.4, by Seo and Akella, for a rigid body with unknown constant inertia.
/// It does not cancel with the estimate $\hat\theta$ alone but with $\hat\theta + \beta_c$, so that the estimation error
/// is drawn to a manifold. Eqs. (3.53)-(3.56):
///
/// $$\tau = -W_c(\hat\theta + \beta_c) + \gamma\,W_f W_f^T\left[k_p(\omega_f - q_{e,v}) - \omega_e\right], \qquad
///   \beta_c = \gamma\,W_f^T\omega_f$$
/// $$\dot{\hat\theta} = \gamma\,W_f^T\left[(\alpha + k_w)\,\omega_f + k_p\,q_{e,v}\right] - \gamma\,W_c^T\omega_f$$
/// $$W_c\theta = -\omega\times J\omega + J\phi + J\left(k_w\omega_e + k_p\dot q_{e,v} + \alpha k_p q_{e,v}\right)$$
/// $$\dot\omega_f = -\alpha\,\omega_f + \omega_e, \qquad \dot W_f = -\alpha\,W_f + W_c, \qquad \alpha = k_p + k_w$$
///
/// with $\phi = \omega_e\times C(q_e)\omega_r - C(q_e)\dot\omega_r$. In print the second term of the torque has a minus
/// sign, with which the loop diverges even for constant inertia: only with plus does the filtered torque become
/// $-W_f(\hat\theta + \beta_c)$, on which the law rests. With $z = \hat\theta + \beta_c - \theta$ and constant inertia
///
/// $$\eta = \dot\omega_f + k_w\,\omega_f + k_p\,q_{e,v} + J^{-1}W_f z, \qquad \dot\eta = -\alpha\,\eta, \qquad
///   \tfrac{d}{dt}\tfrac12\lVert z\rVert^2 = \gamma\,(W_f z)^T\left(\eta - J^{-1}W_f z\right)$$
///
/// **Sign.** The law brings $q_e$ to $[1\ 0\ 0\ 0]$, so from $q_{e0} < 0$ it turns B by more than 180 degrees though a smaller
/// turn would do. It has no `short_way`: $\dot\eta = -\alpha\,\eta$ needs a $q_{e,v}$ that does not jump. Give $q_{RN}$ the
/// sign with which $q_{e0}(0) \ge 0$.
#pragma once

#include "controllers/certainty_equivalence.hpp"

namespace adcs {

template <class T>
struct NonCertaintyEquivalenceTracking {
    static constexpr auto summary = "Adaptive attitude tracking with attractive manifold, for constant inertia";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (3.53)-(3.56)";

    using Regressor = Eigen::Matrix<T, 3, 6, Eigen::RowMajor>;

    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};
    T k_p = 0.5, k_w = 0.5, gamma = 100.0;
    Vec6<T> theta_est{{21.1, 1.9, 1.4, 17.8, 2.9, 15.5}}, theta_estDot{{0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
    Vec3<T> omega_f{0.0, 0.0, 0.0}, omega_fDot{0.0, 0.0, 0.0};
    Regressor W_f = Regressor::Zero(), W_fDot = Regressor::Zero();
    Vec3<T> torque_B{0.0, 0.0, 0.0}, omega_BR_B{0.0, 0.0, 0.0};
    Quat<T> q_BR{1.0, 0.0, 0.0, 0.0};
    Vec6<T> theta_sum{{0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};

    template <class V>
    void declare(V& v) {
        v.input("q_BN", q_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.1);
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.parameter("k_p", k_p, unit::one_per_s, "attitude gain").above(0);
        v.parameter("k_w", k_w, unit::one_per_s, "rate gain").above(0);
        v.parameter("gamma", gamma, unit::kg_m2_s, "adaptation gain; 0: theta_est stays as it starts").at_least(0);
        v.state("theta_est", theta_est, theta_estDot, unit::kg_m2,
                "adaptive part of the estimate of the inertia, in B: J11, J12, J13, J22, J23, J33")
            .nominal(10.0);
        v.state("omega_f", omega_f, omega_fDot, unit::rad, "filtered omega_BR_B").nominal(0.1);
        v.state("W_f", W_f, W_fDot, unit::one_per_s, "filtered regressor").nominal(0.1);
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
        v.output("q_BR", q_BR, unit::one, "attitude error, B relative to R").unit_quaternion();
        v.output("omega_BR_B", omega_BR_B, unit::rad_per_s, "rate error, B relative to R, in B").nominal(0.1);
        v.output("theta_sum", theta_sum, unit::kg_m2, "theta_est + beta_c, the estimate that the torque uses")
            .nominal(10.0);
    }

    void outputs() {
        const TrackingError<T> e(q_BN, omega_BN_B, q_RN, omega_RN_R, omegaDot_RN_R, 0);
        q_BR = e.q_BR;
        omega_BR_B = e.omega_BR_B;
        theta_sum = theta_est + gamma * (W_f.transpose() * omega_f);
        const Vec6<T> drawn = W_f.transpose() * (k_p * (omega_f - vec(q_BR)) - omega_BR_B);
        torque_B = -W_c(e) * theta_sum + gamma * (W_f * drawn);
    }

    void derivatives() {
        const TrackingError<T> e(q_BN, omega_BN_B, q_RN, omega_RN_R, omegaDot_RN_R, 0);
        const Regressor W = W_c(e);
        const T alpha = k_p + k_w;
        theta_estDot =
            gamma * (W_f.transpose() * ((alpha + k_w) * omega_f + k_p * vec(q_BR))) - gamma * (W.transpose() * omega_f);
        omega_fDot = -alpha * omega_f + omega_BR_B;
        W_fDot = -alpha * W_f + W;
    }

private:
    Regressor W_c(const TrackingError<T>& e) const {
        const Vec3<T> b = e.phi + k_w * e.omega_BR_B + k_p * e.qDot + (k_p + k_w) * k_p * vec(e.q_BR);
        return inertia_regressor<T>(b) + inertia_regressor<T>(omega_BN_B).colwise().cross(omega_BN_B);
    }
};

}  // namespace adcs

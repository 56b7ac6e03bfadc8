// What the adaptive laws for fuel loss share: an inertia that falls with the norm of the commanded torque itself.
#pragma once

#include "controllers/certainty_equivalence.hpp"

namespace adcs {

/// Norm of the torque u = tau - |u| v, Eq. (3.40): the one root of (3.38) that is not negative, if |v| < 1.
///
/// The law has no other domain. So that a solver's trial step or a poor set of gains still gives a finite number,
/// 1 - |v|^2 is not taken below 1e-3; whoever runs the law watches its output `implementability`.
template <class T>
T implicit_norm(const Vec3<T>& tau, const Vec3<T>& v) {
    const T along = tau.dot(v), room = 1.0 - v.dot(v);
    const T d = room > 1e-3 ? room : T(1e-3);
    const T square = along * along + d * tau.dot(tau);
    return square > 0.0 ? (sqrt(square) - along) / d : square;
}

/// Base of the laws for J_1 Psi with PsiDot = |u| I, Eq. (3.13); torque_impulse is the integral of |u|.
template <class T>
struct FuelCompensation : CertaintyEquivalence<T> {
    using Variable = VariablePart<T, 3>;

    T gamma_2 = 20.5;
    T sigma_bound = 0.008, sigma_margin = 0.008;
    T torque_impulse = 0.0, torque_impulseDot = 0.0;
    T torque_norm = 0.0, implementability = 1.0;

    FuelCompensation() {
        this->gamma_1 = 8.0;
        this->theta_bound = 40.0;
        this->theta_margin = 10.0;
    }

    template <class V>
    void declare_compensation(V& v) {
        this->declare_tracking(v);
        v.parameter("gamma_2", gamma_2, unit::s4_per_kg_m2,
                    "adaptation gain of the estimate of J_1; 0: it stays as it starts")
            .at_least(0);
        v.parameter("sigma_bound", sigma_bound, unit::s,
                    "root of epsilon_2: the norm of the estimate above which its growth is slowed down")
            .above(0)
            .nominal(0.01);
        v.parameter("sigma_margin", sigma_margin, unit::s,
                    "root of delta_2: the square of the norm stays below sigma_bound^2 + sigma_margin^2")
            .above(0)
            .nominal(0.01);
        v.state("torque_impulse", torque_impulse, torque_impulseDot, unit::N_m_s,
                "integral of the norm of the commanded torque: Psi is this times I")
            .nominal(100.0);
        v.output("torque_norm", torque_norm, unit::N_m, "norm of the commanded torque, Eq. (3.40)");
        v.output("implementability", implementability, unit::one,
                 "1 - |J_1_est Omega|: the law is valid where this is positive, Eq. (3.39)");
    }

protected:
    Variable variable_part(const TrackingError<T>& e, const T& PsiDot) const {
        const Mat3<T> I = Mat3<T>::Identity();
        return {torque_impulse * I, PsiDot * I, this->omega_BN_B, e};
    }

    /// Eqs. (3.33), (3.34), (3.40).
    void command(const Mat3<T>& J_1_est) {
        const TrackingError<T> e = this->tracking_error();
        const Vec3<T> tau = this->feedback(e) - variable_part(e, T(0.0)).torque(J_1_est);
        const Vec3<T> v = J_1_est * Variable::Omega(this->omega_BN_B, e);
        torque_norm = implicit_norm(tau, v);
        implementability = 1.0 - norm_of(v);
        this->torque_B = tau - torque_norm * v;
    }

    /// Updates what both parametrisations have; the gradient (3.30) by J_1.
    Mat3<T> adapt_all() {
        const TrackingError<T> e = this->tracking_error();
        this->adapt(e);
        torque_impulseDot = torque_norm;
        return variable_part(e, torque_norm).gradient();
    }
};

}  // namespace adcs

// What the adaptive laws for moving appendages share: two point masses on known paths, Eqs. (3.7)-(3.9).
#pragma once

#include "controllers/certainty_equivalence.hpp"

namespace adcs {

/// Base of the laws for J_1 Psi = J_1 [M_1; M_2], where M_i is the inertia of a unit mass at the i-th position.
template <class T>
struct AppendageCompensation : CertaintyEquivalence<T> {
    using Variable = VariablePart<T, 6>;

    TwoPoints<T> position_B{{0.5, 0.0, 0.0}, {0.0, 0.8, 0.0}}, velocity_B{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    T gamma_2 = 200.0;
    T sigma_bound = 1e6, sigma_margin = 1e6;  // never reached: no projection

    template <class V>
    void declare_compensation(V& v) {
        this->declare_tracking(v);
        v.input("position_B", position_B, unit::m, "positions of the two masses from the centre of mass, in B");
        v.input("velocity_B", velocity_B, unit::m_per_s, "time derivative of position_B").nominal(0.1);
        v.parameter("gamma_2", gamma_2, unit::kg_s2_per_m2, "adaptation gain of the masses; 0: they stay as they start")
            .at_least(0);
        v.parameter("sigma_bound", sigma_bound, unit::kg,
                    "root of epsilon_2: the norm of the estimate above which its growth is slowed down")
            .above(0);
        v.parameter("sigma_margin", sigma_margin, unit::kg,
                    "root of delta_2: the square of the norm stays below sigma_bound^2 + sigma_margin^2")
            .above(0);
    }

protected:
    Variable variable_part(const TrackingError<T>& e) const {
        typename Variable::Known Psi, PsiDot;
        for (int i = 0; i < 2; ++i) {
            const Vec3<T> r = position_B.row(i).transpose(), rDot = velocity_B.row(i).transpose();
            Psi.template middleRows<3>(3 * i) = point_inertia(r);
            PsiDot.template middleRows<3>(3 * i) = point_inertia_rate(r, rDot);
        }
        return {Psi, PsiDot, this->omega_BN_B, e};
    }

    /// Eq. (3.20).
    void command(const typename Variable::Parameters& J_1_est) {
        const TrackingError<T> e = this->tracking_error();
        this->torque_B = this->feedback(e) - variable_part(e).torque(J_1_est);
    }
};

}  // namespace adcs

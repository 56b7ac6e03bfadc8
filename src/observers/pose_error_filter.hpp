/// # Velocity filter of the pose error
///
/// High-pass filter that makes a velocity-like signal $e_f \in \mathbb{R}^6$ from position and attitude alone, Eqs. (33),
/// (34) and (39):
///
/// $$e_f = -k\,r_0 + p, \qquad \dot p = -(k+1)\,p + k^2 r_0 + \Gamma r_0 - k\,\Omega_2, \qquad p(0) = k\,r_0(0)$$
/// $$r_0 = \begin{bmatrix} e_R \\ e_\varepsilon \end{bmatrix}, \qquad
///   \Gamma = \mathrm{diag}\left(k_0 I,\ \frac{k_1}{(1 - e_\varepsilon^T e_\varepsilon)^2} I\right), \qquad
///   \Omega_2 = \begin{bmatrix} (-P(e_{f2} + e_\varepsilon) + C\omega_d)\times e_R \\ 0 \end{bmatrix}$$
///
/// with $e_R$ the position of the reference relative to the body, in B, $[e_\zeta, e_\varepsilon]$ the error quaternion,
/// $C = C(e_\zeta, e_\varepsilon)$ and $P = T^{-1}$, $T = \tfrac12(e_\zeta I + e_\varepsilon^\times)$. The law has a time
/// constant of one unit of time built in, so it is applied to quantities divided by `length_unit`, `time_unit` and
/// `mass_unit`; $p$ and $e_f$ are in these units. $p(0)$ must be given as above; then $e_f$ starts at zero. At an attitude
/// error of 180 degrees, $e_\zeta = 0$, neither $\Gamma$ nor $P$ exists: a start there is refused.
#pragma once

#include "attitude/pose_error.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct PoseErrorFilter {
    static constexpr auto summary =
        "Velocity-like signal from position and attitude errors, for six degrees of freedom";
    static constexpr auto reference =
        "Pan, Wong, Kapila, Output feedback control for spacecraft with coupled translation and attitude dynamics, "
        "Eqs. "
        "(33)-(34)";

    Vec3<T> r_BN_N{7.0e6, 0.0, 0.0}, r_RN_N{7.0e6, 0.0, 0.0};
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0};
    T k = 3.0, k_0 = 2.0, k_1 = 1.5;
    T length_unit = 1.0, time_unit = 20.0, mass_unit = 20.0;
    Vec3<T> p_R{0.0, 0.0, 0.0}, pDot_R{0.0, 0.0, 0.0}, p_eps{0.0, 0.0, 0.0}, pDot_eps{0.0, 0.0, 0.0};
    Vec3<T> e_f_R{0.0, 0.0, 0.0}, e_f_eps{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("r_BN_N", r_BN_N, unit::m, "measured position of the centre of mass, in N").nominal(1e7);
        v.input("r_RN_N", r_RN_N, unit::m, "position of the reference, in N").nominal(1e7);
        v.input("q_BN", q_BN, unit::one, "measured attitude of B relative to N").unit_quaternion();
        v.input("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.parameter("k", k, unit::one, "filter gain").fixed().above(0);
        v.parameter("k_0", k_0, unit::one, "position gain").fixed().above(0);
        v.parameter("k_1", k_1, unit::one, "attitude gain").fixed().above(1);
        v.parameter("length_unit", length_unit, unit::m, "unit of length of the law").fixed().above(0);
        v.parameter("time_unit", time_unit, unit::s, "unit of time of the law").fixed().above(0);
        v.parameter("mass_unit", mass_unit, unit::kg, "unit of mass of the law").fixed().above(0);
        v.state("p_R", p_R, pDot_R, unit::one, "p of the position error, in scaled units; start it at k e_R(0)");
        v.state("p_eps", p_eps, pDot_eps, unit::one, "p of the attitude error; start it at k e_eps(0)");
        v.output("e_f_R", e_f_R, unit::one, "e_f1, filtered position error, in scaled units");
        v.output("e_f_eps", e_f_eps, unit::one, "e_f2, filtered attitude error");
    }

    void outputs() {
        const ScaledUnits<T> units{length_unit, time_unit, mass_unit};
        const auto e = pose_error(units, r_BN_N, r_RN_N, q_BN, q_RN, omega_RN_R, k_0, k_1);
        e_f_R = p_R - k * e.e_R;
        e_f_eps = p_eps - k * e.e_eps;
        const T feedback = k + 1.0, gain = k * k;
        pDot_R = (-feedback * p_R + gain * e.e_R + e.gamma_R + k * e.minus_omega_2(e_f_eps)) / time_unit;
        pDot_eps = (-feedback * p_eps + gain * e.e_eps + e.gamma_eps) / time_unit;
    }

    /// All parameters are fixed, so this is asked at the start only.
    void validate(Words& refuse) const {
        if (p_eps.dot(p_eps) < k * k) return;
        refuse(
            "p_eps(0) = k e_eps(0) has the length k = %g or more, namely %g: an attitude error of 180 deg, "
            "e_zeta(0) = 0, where the law does not exist",
            k, p_eps.norm());
    }
};

}  // namespace adcs

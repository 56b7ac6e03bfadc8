/// # Bounded estimation error
///
/// Stands for an observer of which nothing is known but bounds: adds to the true attitude and rate smooth errors whose
/// size, and that of their rates, is guaranteed. Eqs. (7) and (8),
///
/// $$C(\hat q) = C(v)\,C(q), \qquad \hat\omega = \omega + v_\omega$$
///
/// with a sinusoid on each axis,
///
/// $$v_{q,i} = \frac{\bar v_q}{\sqrt 3}\,\sin(\nu_i t + \varphi_i), \qquad v_{q4} = \sqrt{1 - \lVert v_q\rVert^2}, \qquad
///   v_{\omega,i} = \frac{\bar v_\omega}{\sqrt 3}\,\sin(\mu_i t + \psi_i)$$
///
/// so that at all times $\lVert v_q\rVert \le \bar v_q$, $\lVert v_\omega\rVert \le \bar v_\omega$,
/// $\lVert\dot v_q\rVert \le \bar v_q\sqrt{(\nu_1^2+\nu_2^2+\nu_3^2)/3}$ and
/// $\lVert\dot v_\omega\rVert \le \bar v_\omega\sqrt{(\mu_1^2+\mu_2^2+\mu_3^2)/3}$. For frequencies without common measure
/// the bounds are approached as closely as one likes, if one waits.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct BoundedEstimationError {
    static constexpr auto summary =
        "Attitude and rate with smooth errors of guaranteed size, as of an unknown observer";
    static constexpr auto reference =
        "de Ruiter, Observer-Based Adaptive Spacecraft Attitude Control with Guaranteed Performance Bounds, Eqs. "
        "(7)-(8) and Assumption 1";

    T time = 0.0;
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    T attitude_bound = 1e-3, rate_bound = 1e-4;
    Vec3<T> attitude_frequency{0.1, 0.1414, 0.1732}, attitude_phase{0.0, 2.0, 4.0};
    Vec3<T> rate_frequency{0.13, 0.1838, 0.2252}, rate_phase{1.0, 3.0, 5.0};
    Quat<T> q_EN{1.0, 0.0, 0.0, 0.0}, q_EB{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B_est{0.0, 0.0, 0.0}, rate_error_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.input("q_BN", q_BN, unit::one, "true attitude of B relative to N").unit_quaternion();
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "true angular velocity of B relative to N, in B")
            .nominal(0.1);
        v.parameter("attitude_bound", attitude_bound, unit::one, "bound on the vector part of q_EB, below 1")
            .at_least(0);
        v.parameter("attitude_frequency", attitude_frequency, unit::rad_per_s, "nu, of the error about each axis of B")
            .nominal(0.1);
        v.parameter("attitude_phase", attitude_phase, unit::rad, "phases of the error about each axis of B at time 0");
        v.parameter("rate_bound", rate_bound, unit::rad_per_s, "bound on the error of the angular velocity")
            .at_least(0);
        v.parameter("rate_frequency", rate_frequency, unit::rad_per_s, "mu, of the error on each axis of B")
            .nominal(0.1);
        v.parameter("rate_phase", rate_phase, unit::rad, "phases of the error on each axis of B at time 0");
        v.output("q_EN", q_EN, unit::one, "estimated attitude: E relative to N").unit_quaternion();
        v.output("omega_BN_B_est", omega_BN_B_est, unit::rad_per_s, "estimate of omega_BN_B").nominal(0.1);
        v.output("q_EB", q_EB, unit::one, "(v_q4, v_q), estimation error of the attitude, E relative to B")
            .unit_quaternion();
        v.output("rate_error_B", rate_error_B, unit::rad_per_s, "v_omega, estimation error of the angular velocity")
            .nominal(1e-4);
    }

    void outputs() {
        const T third = 0.57735026918962576451;  // 1 / sqrt(3), so that the sum over three axes keeps the bound
        for (int i = 0; i < 3; ++i) {
            q_EB[1 + i] = attitude_bound * third * sin(attitude_frequency[i] * time + attitude_phase[i]);
            rate_error_B[i] = rate_bound * third * sin(rate_frequency[i] * time + rate_phase[i]);
        }
        const Vec3<T> v_q = vec(q_EB);
        q_EB[0] = sqrt(1.0 - v_q.dot(v_q));
        q_EN = compose(q_EB, q_BN);
        omega_BN_B_est = omega_BN_B + rate_error_B;
    }

    void validate(Words& refuse) const {
        if (!(attitude_bound < 1.0))
            refuse("attitude_bound is the vector part of a unit quaternion: expected below 1, and is %g",
                   attitude_bound);
    }
};

}  // namespace adcs

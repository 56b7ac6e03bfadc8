/// # Commanded reference
///
/// Stands between guidance and a tracking law, and lets an operator turn the target: the reference is that of guidance
/// while $e = 0$, and a commanded attitude with a commanded rate while $e = 1$,
///
/// $$q_S = (1 - e)\,q_R \pm e\,q_C, \qquad \omega_S = (1 - e)\,\omega_R + e\,\omega_C, \qquad
///   \dot\omega_S = (1 - e)\,\dot\omega_R$$
///
/// Only one term ever counts, so with $e = 0$ the values of guidance pass to the last bit. Of $q_C$ and $-q_C$, which are
/// one attitude, it is the one nearer to `q_BN`, the attitude that the body has: whoever sends back the attitude that he was
/// shown, with whatever sign, does not turn the body round.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct CommandedReference {
    static constexpr auto summary = "The reference of guidance, or the attitude that an operator commands";
    static constexpr auto reference = "Made for this project, from no publication";

    Quat<T> q_RN{1.0, 0.0, 0.0, 0.0}, q_CN{1.0, 0.0, 0.0, 0.0}, q_BN{1.0, 0.0, 0.0, 0.0};
    Quat<T> q_SN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0}, omega_CN_C{0.0, 0.0, 0.0};
    Vec3<T> omega_SN_S{0.0, 0.0, 0.0}, omegaDot_SN_S{0.0, 0.0, 0.0};
    bool engaged = false;

    template <class V>
    void declare(V& v) {
        v.input("q_RN", q_RN, unit::one, "attitude of guidance's R relative to N").unit_quaternion();
        v.input("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.input("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
        v.input("q_CN", q_CN, unit::one, "commanded attitude, of C relative to N").unit_quaternion();
        v.input("omega_CN_C", omega_CN_C, unit::rad_per_s, "commanded angular velocity of C relative to N, in C")
            .nominal(0.1);
        v.input("q_BN", q_BN, unit::one, "attitude of B relative to N, by which the sign of q_CN is chosen")
            .unit_quaternion();
        v.parameter("engaged", engaged, "whether the command counts, not guidance");
        v.output("q_SN", q_SN, unit::one, "attitude of the reference S relative to N").unit_quaternion();
        v.output("omega_SN_S", omega_SN_S, unit::rad_per_s, "angular velocity of S relative to N, in S").nominal(0.1);
        v.output("omegaDot_SN_S", omegaDot_SN_S, unit::rad_per_s2, "time derivative of omega_SN_S").nominal(0.1);
    }

    void outputs() {
        const double e = engaged ? 1.0 : 0.0;
        q_SN = (1.0 - e) * q_RN + e * nearest(q_CN, q_BN);
        omega_SN_S = (1.0 - e) * omega_RN_R + e * omega_CN_C;
        omegaDot_SN_S = (1.0 - e) * omegaDot_RN_R;
    }
};

}  // namespace adcs

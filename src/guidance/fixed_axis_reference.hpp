/// # Fixed-axis reference
///
/// Reference attitude that turns about an axis fixed in the reference frame R, with the angular velocity used
/// throughout the dissertation's simulations:
///
/// $$\omega_{RN} = r(t)\,a$$
/// $$r(t) = A\cos(\omega_1 t)\,(1 - e^{-d t^2}) + (b + c\sin(\omega_1 t))\,t\,e^{-d t^2}$$
///
/// with $a = [1\ 1\ 1]^T$ by default. Rate and acceleration are analytic. The attitude needs the integral of $r$,
/// which has no elementary form, so the angle is the one continuous state, $\dot\vartheta = r(t)$, and
///
/// $$q_{RN} = q_{RN}(0)\ \text{turned by}\ |a|\vartheta\ \text{about}\ a/|a|$$
///
/// has unit norm by construction. In print the minus sign of the first exponent is lost; with a plus the profile
/// grows without bound.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct FixedAxisReference {
    static constexpr auto summary =
        "Reference attitude turning about a fixed axis, with analytic rate and acceleration";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 5.4";

    T time = 0.0;
    T amplitude = 0.1;
    T frequency = 1.0;
    T decay = 0.01;
    T ramp = 0.25132741228718347;  // 0.08 pi
    T wobble = 0.006;
    Vec3<T> axis{1.0, 1.0, 1.0};
    Quat<T> q_RN_0{1.0, 0.0, 0.0, 0.0};
    T angle = 0.0, angleDot = 0.0;
    Quat<T> q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0}, omegaDot_RN_R{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("amplitude", amplitude, unit::rad_per_s, "A, amplitude of the lasting oscillation");
        v.parameter("frequency", frequency, unit::rad_per_s, "omega_1, frequency of the oscillation").at_least(0);
        v.parameter("decay", decay, unit::one_per_s2, "d, how fast the initial transient fades").at_least(0);
        v.parameter("ramp", ramp, unit::rad_per_s2, "b, slope of the initial transient");
        v.parameter("wobble", wobble, unit::rad_per_s2, "c, oscillation of the initial transient");
        v.parameter("axis", axis, unit::one, "a, axis times gain: omega_RN_R = r(t) a").fixed().directions();
        v.parameter("q_RN_0", q_RN_0, unit::one, "attitude of R relative to N at the start").fixed().unit_quaternion();
        v.state("angle", angle, angleDot, unit::rad, "integral of r(t)");
        v.output("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.output("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
        v.output("omegaDot_RN_R", omegaDot_RN_R, unit::rad_per_s2, "time derivative of omega_RN_R").nominal(0.1);
    }

    void outputs() {
        const T t = time;
        const auto [s, c] = sincos(frequency * t);
        const T e = exp(-decay * t * t);
        const T eDot = -2.0 * decay * t * e;
        const T r = amplitude * c * (1.0 - e) + (ramp + wobble * s) * t * e;
        const T rDot = -amplitude * frequency * s * (1.0 - e) - amplitude * c * eDot + wobble * frequency * c * t * e +
                       (ramp + wobble * s) * (e + t * eDot);
        angleDot = r;
        omega_RN_R = r * axis;
        omegaDot_RN_R = rDot * axis;

        const T gain = sqrt(axis.dot(axis));
        const auto [s_half, c_half] = sincos(0.5 * gain * angle);
        const Vec3<T> turn = s_half / gain * axis;
        q_RN = compose<T>({c_half, turn[0], turn[1], turn[2]}, q_RN_0);
    }
};

}  // namespace adcs

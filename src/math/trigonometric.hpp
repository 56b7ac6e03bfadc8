// sin and cos: polynomials up to an eighth of a turn, exchanged and negated by the quarter turns before it.
#pragma once

#include "math/polynomial.hpp"
#include "math/quarter_turns.hpp"

namespace adcs::math {

/// (sin(y) / y - 1) / y^2 in powers of y^2 up to 0.6169, to 1.2e-20;
/// mpmath.chebyfit(lambda z: (sin(sqrt(z)) / sqrt(z) - 1) / z, [0, 0.6169], 7).
inline constexpr double sin_coefficients[] = {-0x1.5555555555555p-3, 0x1.1111111111110p-7,   -0x1.a01a01a019937p-13,
                                              0x1.71de3a54607fap-19, -0x1.ae6454129f078p-26, 0x1.61217eed1c04ap-33,
                                              -0x1.ab17c21adf462p-41};
/// (cos(y) - 1 + y^2/2) / y^4 in powers of y^2 up to 0.6169, to 1.3e-18;
/// mpmath.chebyfit(lambda z: (cos(sqrt(z)) - 1 + z / 2) / z**2, [0, 0.6169], 6).
inline constexpr double cos_coefficients[] = {0x1.5555555555555p-5,   -0x1.6c16c16c16967p-10, 0x1.a01a019f4e9f4p-16,
                                              -0x1.27e4fa17c44e0p-22, 0x1.1eeb68d2958ddp-29,  -0x1.907d9316a965fp-37};

template <class T>
struct SinCos {
    T sin, cos;
};

/// Both for the part of x beyond its quarter turns; the rest counts to first order.
template <class T>
SinCos<T> sincos_of_part(const QuarterTurns<T>& x) {
    const auto y2 = square(x.angle);
    const T &y = x.angle, z = y2.value, half = 0.5 * z;
    const T s = y + (y * z * polynomial(z, sin_coefficients) + x.rest * (1.0 - half));
    const auto [one_less, left] = fast_two_sum(T(1.0), -half);
    const T c = one_less + (left + (z * z * polynomial(z, cos_coefficients) - (0.5 * y2.rest + y * x.rest)));
    return {s, c};
}

/// sin(x) and cos(x), each to the same digits as alone.
template <class T, IfReal<T> = 0>
SinCos<T> sincos(const T& x) {
    const QuarterTurns<T> parts = quarter_turns(x);
    const auto [s, c] = sincos_of_part(parts);
    const T turn = parts.quarters - 4.0 * nearest(0.25 * parts.quarters);  // -2 to 2, and -2 is 2
    const auto exchanged = abs(turn) == 1.0;
    const T sine = select(exchanged, c, s), cosine = select(exchanged, s, c);
    return {select(abs(x) < 0x1p-27, x, select(abs(turn - 0.5) > 1.0, -sine, sine)),  // x: keeps -0 and subnormals
            select(abs(turn + 0.5) > 1.0, -cosine, cosine)};
}

template <class T, IfReal<T> = 0>
T sin(const T& x) {
    return sincos(x).sin;
}

template <class T, IfReal<T> = 0>
T cos(const T& x) {
    return sincos(x).cos;
}

}  // namespace adcs::math

// sin, cos and tan: polynomials up to an eighth of a turn, exchanged and negated by the quarter turns before it.
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

/// Both for the part of x beyond its quarter turns, as sums; the rest counts to first order.
template <class T>
SinCos<DoubleDouble<T>> sincos_of_part(const QuarterTurns<T>& x) {
    const auto y2 = square(x.angle);
    const T &y = x.angle, z = y2.value, half = 0.5 * z;
    const auto [one_less, left] = fast_two_sum(T(1.0), -half);
    return {{y, y * z * polynomial(z, sin_coefficients) + x.rest * (1.0 - half)},
            {one_less, left + (z * z * polynomial(z, cos_coefficients) - (0.5 * y2.rest + y * x.rest))}};
}

/// The quarter turns without whole turns, from -2 to 2, where -2 is 2.
template <class T>
T turn_of(const QuarterTurns<T>& x) {
    return x.quarters - 4.0 * nearest(0.25 * x.quarters);
}

/// sin(x) and cos(x), each to the same digits as alone.
template <class T, IfReal<T> = 0>
SinCos<T> sincos(const T& x) {
    const QuarterTurns<T> parts = quarter_turns(x);
    const auto sums = sincos_of_part(parts);
    const T s = sums.sin.value + sums.sin.rest, c = sums.cos.value + sums.cos.rest;
    const T turn = turn_of(parts);
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

/// tan(x), of the sine and cosine of half of what is left of x: sums lose nothing in them that would be seen here.
template <class T, IfReal<T> = 0>
T tan(const T& x) {
    const QuarterTurns<T> parts = quarter_turns(x);
    const auto sums = sincos_of_part(QuarterTurns<T>{0.5 * parts.angle, 0.5 * parts.rest, parts.quarters});
    const auto s = fast_two_sum(sums.sin.value, sums.sin.rest), c = fast_two_sum(sums.cos.value, sums.cos.rest);
    const auto s2 = times(s, s), c2 = times(c, c), half = times(s, c);
    const auto difference = fast_two_sum(c2.value, -s2.value);
    const DoubleDouble<T> sine{2.0 * half.value, 2.0 * half.rest};
    const DoubleDouble<T> cosine{difference.value, difference.rest + (c2.rest - s2.rest)};
    const auto exchanged = abs(turn_of(parts)) == 1.0;  // tan(y + pi/2) = -cos(y) / sin(y)
    const auto [q, rest] = quotient(
        DoubleDouble<T>{select(exchanged, -cosine.value, sine.value), select(exchanged, -cosine.rest, sine.rest)},
        DoubleDouble<T>{select(exchanged, sine.value, cosine.value), select(exchanged, sine.rest, cosine.rest)});
    return select(abs(x) < 0x1p-27, x, q + rest);  // x: keeps -0 and subnormals
}

}  // namespace adcs::math

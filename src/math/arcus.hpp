// asin, acos, atan and atan2: a polynomial near 0, and elsewhere what is left of eighths of a turn.
#pragma once

#include "math/double_double.hpp"
#include "math/polynomial.hpp"

namespace adcs::math {

/// (atan(t) / t - 1) / t^2 in powers of t^2 up to 0.25, to 3.8e-18;
/// mpmath.chebyfit(lambda z: (atan(sqrt(z)) / sqrt(z) - 1) / z, [0, 0.25], 13).
inline constexpr double atan_coefficients[] = {
    -0x1.5555555555555p-2, 0x1.99999999998e1p-3,  -0x1.2492492488296p-3, 0x1.c71c71c01b24cp-4,  -0x1.745d16026efd7p-4,
    0x1.3b138e6372dcap-4,  -0x1.110ea50256abfp-4, 0x1.e1a7b2562efc5p-5,  -0x1.ad44da04adea3p-5, 0x1.7b20b751c966ap-5,
    -0x1.37d750492dd9bp-5, 0x1.99b4e0c058248p-6,  -0x1.2dfbaab9786efp-7};
/// (asin(s) / s - 1) / s^2 in powers of s^2 up to 0.25, to 9.8e-19;
/// mpmath.chebyfit(lambda z: (asin(sqrt(z)) / sqrt(z) - 1) / z, [0, 0.25], 14).
inline constexpr double asin_coefficients[] = {
    0x1.5555555555555p-3, 0x1.3333333333388p-4, 0x1.6db6db6dac1e0p-5,  0x1.f1c71c7a52ba3p-6, 0x1.6e8ba123e494cp-6,
    0x1.1c4efce23019fp-6, 0x1.c990ad3d8fdcap-7, 0x1.7b027ee1dd585p-7,  0x1.3b49de7121487p-7, 0x1.31622469ce5adp-7,
    0x1.8f193743418ffp-9, 0x1.406192d124629p-6, -0x1.3b416bb7d9257p-6, 0x1.e529c6fce9bb4p-6};

/// pi/4 in two parts; of the first, multiples up to 4 are exact.
inline constexpr double eighth_high = 0x1.921fb54442d18p-1, eighth_low = 0x1.1a62633145c07p-55;

/// n pi/4 + factor angle, for an angle that is at most two thirds of pi/4 times n, and for n = 0.
template <class T>
T from_eighths(const T& n, const T& factor, const DoubleDouble<T>& angle) {
    const auto [sum, left] = fast_two_sum(n * eighth_high, factor * angle.value);
    return sum + (left + (n * eighth_low + factor * angle.rest));
}

/// An angle as eighths of a turn and the rest.
template <class T>
struct Eighths {
    T n;
    DoubleDouble<T> angle;
};

/// atan(y / x), for 0 <= y <= x, and x from 2^-474 to 2^990.
template <class T>
Eighths<T> atan_of_ratio(const T& y, const T& x) {
    const auto far = y > 0.5 * x;  // there, atan(y / x) = pi/4 + atan((y - x) / (y + x)), and y - x is exact
    const auto sum = fast_two_sum(x, y);
    const auto t = quotient(DoubleDouble<T>{select(far, y - x, y), 0.0},
                            DoubleDouble<T>{select(far, sum.value, x), select(far, sum.rest, T(0.0))});
    const T rest = select(y < 0x1p-900, T(0.0), t.rest);  // where it underflows it does not count
    const T z = t.value * t.value;
    return {select(far, T(1.0), T(0.0)), {t.value, t.value * z * polynomial(z, atan_coefficients) + rest * (1.0 - z)}};
}

/// The angle of the vector (x, y) from the first axis, from -pi to pi; that of a zero is 0 or pi, by its signs.
template <class Y, class X, class T = Joint<Y, X>>
T atan2(const Y& y_, const X& x_) {
    const T y = y_, x = x_, infinity = std::numeric_limits<double>::infinity();
    const auto steep = abs(y) > abs(x);
    const T shorter = select(steep, abs(x), abs(y)), longer = select(steep, abs(y), abs(x));
    const T ratio_of_special = select(shorter == infinity, T(1.0), 0.0 * shorter);  // NaN stays
    const auto special = select(longer == infinity, T(0.0), longer) == 0.0;
    const T factor = select(longer > 0x1p990, T(0x1p-100), select(longer < 0x1p-400, T(0x1p600), T(1.0)));
    const auto part =
        atan_of_ratio<T>(select(special, ratio_of_special, shorter * factor), select(special, T(1.0), longer * factor));
    const T n = select(steep, 2.0 - part.n, part.n), sign = select(steep, T(-1.0), T(1.0));
    const auto behind = copysign(T(1.0), x) < 0.0;
    return copysign(from_eighths<T>(select(behind, 4.0 - n, n), select(behind, -sign, sign), part.angle), y);
}

/// The angle from -pi/2 to pi/2 whose tangent is x.
template <class T, IfReal<T> = 0>
T atan(const T& x) {
    return atan2(x, T(1.0));
}

/// asin(a) for 0 <= a <= 1/2; beyond, asin(sqrt((1 - a) / 2)), which is half of what is left to pi/2.
template <class T>
DoubleDouble<T> asin_of_part(const T& a) {
    const auto far = a > 0.5;
    const T z = select(far, 0.5 * (1.0 - a), a * a), s = select(far, sqrt(z), a);
    const auto s2 = square(s);
    const T rest = select(s > 0.0, select(far, ((z - s2.value) - s2.rest) / (s + s), T(0.0)), T(0.0));
    return {s, s * z * polynomial(z, asin_coefficients) + rest * (1.0 + 0.5 * z)};
}

/// The angle from -pi/2 to pi/2 whose sine is x; NaN if there is none.
template <class T, IfReal<T> = 0>
T asin(const T& x) {
    const T a = abs(x);
    const auto far = a > 0.5;
    return copysign(from_eighths<T>(select(far, T(2.0), T(0.0)), select(far, T(-2.0), T(1.0)), asin_of_part(a)), x);
}

/// The angle from 0 to pi whose cosine is x; NaN if there is none.
template <class T, IfReal<T> = 0>
T acos(const T& x) {
    const T a = abs(x), sign = copysign(T(1.0), x);
    const auto far = a > 0.5;
    return from_eighths<T>(select(far, 2.0 - 2.0 * sign, T(2.0)), select(far, 2.0 * sign, -sign), asin_of_part(a));
}

}  // namespace adcs::math

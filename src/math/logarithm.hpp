// log: x = 2^k (1 + f), and log(1 + f) = 2 artanh(s) with s = f / (2 + f), |s| at most 0.172.
#pragma once

#include "math/exponential.hpp"

namespace adcs::math {

/// 2 (artanh(s) - s) / s^3 in powers of s^2 up to 0.02944, to 3.2e-16, of which 1.6e-18 reach the logarithm;
/// mpmath.chebyfit(lambda z: 2 * (atanh(sqrt(z)) / sqrt(z) - 1) / z, [0, 0.02944], 7).
inline constexpr double log_coefficients[] = {0x1.5555555555558p-1, 0x1.99999999952d8p-2, 0x1.2492492df26cep-2,
                                              0x1.c71c62e40b94ep-3, 0x1.7462b5152e8a6p-3, 0x1.39fe52a20dc69p-3,
                                              0x1.2b58f4c8d5f63p-3};

/// The natural logarithm; minus infinity at 0, NaN below.
template <class T, IfReal<T> = 0>
T log(const T& x) {
    const auto subnormal = x < std::numeric_limits<double>::min();
    const auto [m, exponent] = split(select(subnormal, x * 0x1p54, x));
    const T k = exponent - select(subnormal, T(54.0), T(0.0));
    const T f = m - 1.0;
    // 2 s = f - s f, and s f = f^2/2 - s f^2/2: thus s, whose division is rounded, only enters small terms.
    const T s = f / (2.0 + f), s2 = s * s;
    const auto f2 = square(f);
    const T half_square = 0.5 * f2.value;
    const T small = s * (half_square + s2 * polynomial(s2, log_coefficients)) + (k * ln2_low - 0.5 * f2.rest);
    const auto [sum, left] = fast_two_sum(k * ln2_high, f);
    const T log_x = sum + (left - (half_square - small));

    const T infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    const T special = select(x == 0.0, -infinity, select(x < 0.0, nan, x));
    return select(x > 0.0, select(x < infinity, log_x, special), special);
}

}  // namespace adcs::math

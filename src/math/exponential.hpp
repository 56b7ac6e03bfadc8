// exp: x = k ln 2 + r, and e^x = 2^k e^r, with |r| at most half of ln 2.
#pragma once

#include "math/double_double.hpp"
#include "math/polynomial.hpp"

namespace adcs::math {

/// (e^r - 1 - r) / r^2 for |r| <= 0.3466, to 1.4e-18 (relative to e^r: 1.7e-19);
/// mpmath.chebyfit(lambda r: (exp(r) - 1 - r) / r**2, [-0.3466, 0.3467], 11).
inline constexpr double exp_coefficients[] = {0x1.0000000000000p-1,  0x1.5555555555557p-3,  0x1.5555555555556p-5,
                                              0x1.11111111100d7p-7,  0x1.6c16c16c1614fp-10, 0x1.a01a01abea3d7p-13,
                                              0x1.a01a01a77ae89p-16, 0x1.71de022a75ef9p-19, 0x1.27e4d9b176e45p-22,
                                              0x1.af4df84f831acp-26, 0x1.1f7628950c7cfp-29};

/// The logarithm of 2 in two parts; of the first, multiples up to 2^11 are exact.
inline constexpr double ln2_high = 0x1.62e42fefa3800p-1, ln2_low = 0x1.ef35793c76730p-45;

/// x = k ln 2 + part + rest.
template <class T>
struct Doublings {
    T part, rest, k;
};

template <class T>
Doublings<T> doublings(const T& x) {
    const T k = nearest(x * 0x1.71547652b82fep+0);  // 1 / ln 2
    const auto [part, rest] = fast_two_sum(x - k * ln2_high, -k * ln2_low);
    return {part, rest, k};
}

/// e^(r + rest) as a sum, for |r| at most half of ln 2; the rest counts to first order.
template <class T>
DoubleDouble<T> exp_of_part(const T& r, const T& rest) {
    const auto [sum, left] = fast_two_sum(T(1.0), r);
    return {sum, left + (r * r * polynomial(r, exp_coefficients) + rest)};
}

/// x 2^k, also where 2^k itself lies outside the normal numbers and the result does not.
template <class T>
T scaled(const T& x, const T& k) {
    const T half = nearest(0.5 * k);
    return x * power_of_two(half) * power_of_two(k - half);
}

/// e^x, of which the parts are known.
template <class T>
T exp_of(const T& x, const Doublings<T>& parts) {
    const auto [sum, left] = exp_of_part(parts.part, parts.rest);
    return select(x > 710.0, T(std::numeric_limits<double>::infinity()),
                  select(x < -746.0, T(0.0), scaled(sum + left, parts.k)));
}

/// e^x.
template <class T, IfReal<T> = 0>
T exp(const T& x) {
    return exp_of(x, doublings(x));
}

}  // namespace adcs::math

// Polynomials by Estrin's scheme: half the latency of Horner's, and one order of operations for every compiler.
#pragma once

#include <cstddef>

#include "math/scalar.hpp"

namespace adcs::math {

template <int Begin, int Count, class T>
T polynomial_part(const T (&powers)[4], const double* coefficients) {
    if constexpr (Count == 1) {
        return T(coefficients[Begin]);
    } else {
        constexpr int level = Count > 8 ? 3 : Count > 4 ? 2 : Count > 2 ? 1 : 0;
        constexpr int half = 1 << level;
        return polynomial_part<Begin, half>(powers, coefficients) +
               powers[level] * polynomial_part<Begin + half, Count - half>(powers, coefficients);
    }
}

/// c[0] + c[1] x + c[2] x^2 + ...
template <class T, std::size_t N>
T polynomial(const T& x, const double (&c)[N]) {
    static_assert(N <= 16);
    const T x2 = x * x, x4 = x2 * x2;
    const T powers[] = {x, x2, x4, x4 * x4};
    return polynomial_part<0, static_cast<int>(N)>(powers, c);
}

}  // namespace adcs::math

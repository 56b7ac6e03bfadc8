// sinh, cosh and tanh: of exponentials as sums of two numbers where that loses nothing, of polynomials near 0.
#pragma once

#include "math/exponential.hpp"

namespace adcs::math {

/// (sinh(x) / x - 1) / x^2 in powers of x^2 up to 0.25, to 9.2e-20;
/// mpmath.chebyfit(lambda z: (sinh(sqrt(z)) / sqrt(z) - 1) / z, [0, 0.25], 6).
inline constexpr double sinh_coefficients[] = {0x1.5555555555555p-3,  0x1.1111111111120p-7,  0x1.a01a01a00ef0fp-13,
                                               0x1.71de3a84a10c3p-19, 0x1.ae63a07779c78p-26, 0x1.6267cf434f12cp-33};
/// (tanh(x) / x - 1) / x^2 in powers of x^2 up to 0.25, to 1.1e-18;
/// mpmath.chebyfit(lambda z: (tanh(sqrt(z)) / sqrt(z) - 1) / z, [0, 0.25], 11).
inline constexpr double tanh_coefficients[] = {-0x1.5555555555555p-2,  0x1.11111111110ecp-3,  -0x1.ba1ba1ba15daap-5,
                                               0x1.664f487fed22ap-6,   -0x1.226e34a851d2cp-7, 0x1.d6d39b48449bfp-9,
                                               -0x1.7d9e74586c684p-10, 0x1.350ce30757046p-11, -0x1.efab6555ccc22p-13,
                                               0x1.71eb85bee4b4ap-14,  -0x1.8117b15cbb104p-16};

/// 2^-k times e^x and e^-x, each as a sum, for x from 0 on; k = 30 stands for larger ones as to the latter.
template <class T>
struct Exponentials {
    DoubleDouble<T> up, down;
    T k;
};

template <class T>
Exponentials<T> exponentials(const T& x) {
    const auto parts = doublings(x);
    const auto up = exp_of_part(parts.part, parts.rest), down = exp_of_part(-parts.part, -parts.rest);
    const T smaller = power_of_two(-2.0 * select(parts.k < 30.0, parts.k, T(30.0)));
    return {up, {down.value * smaller, down.rest * smaller}, parts.k};
}

inline constexpr double largest_of_cosh = 711.0;  // above it, cosh and sinh are above all numbers

/// (e^x - e^-x) / 2.
template <class T, IfReal<T> = 0>
T sinh(const T& x) {
    const T a = abs(x), z = a * a;
    const T near_zero = a + a * z * polynomial(z, sinh_coefficients);
    const auto [up, down, k] = exponentials(a);
    const auto [sum, left] = fast_two_sum(up.value, -down.value);
    const T elsewhere = scaled(sum + (left + (up.rest - down.rest)), k - 1.0);
    const T infinity = std::numeric_limits<double>::infinity();
    return copysign(select(a < 0.5, near_zero, select(a > largest_of_cosh, infinity, elsewhere)), x);
}

/// (e^x + e^-x) / 2.
template <class T, IfReal<T> = 0>
T cosh(const T& x) {
    const T a = abs(x);
    const auto [up, down, k] = exponentials(a);
    const auto [sum, left] = fast_two_sum(up.value, down.value);
    const T infinity = std::numeric_limits<double>::infinity();
    return select(a > largest_of_cosh, infinity, scaled(sum + (left + (up.rest + down.rest)), k - 1.0));
}

/// sinh(x) / cosh(x) = 1 - 2 / (e^2x + 1).
template <class T, IfReal<T> = 0>
T tanh(const T& x) {
    const T a = abs(x), z = a * a;
    const T near_zero = a + a * z * polynomial(z, tanh_coefficients);
    const auto parts = doublings(select(a > 22.0, T(44.0), a + a));  // from there on it is 1
    const auto e = exp_of_part(parts.part, parts.rest);
    const T factor = power_of_two(parts.k);
    const auto sum_of_large = fast_two_sum(e.value * factor, T(1.0));
    const auto denominator = fast_two_sum(sum_of_large.value, sum_of_large.rest + e.rest * factor);
    const auto q = quotient(DoubleDouble<T>{2.0, 0.0}, denominator);
    const auto [sum, left] = fast_two_sum(T(1.0), -q.value);
    return copysign(select(a < 0.5, near_zero, sum + (left - q.rest)), x);
}

}  // namespace adcs::math

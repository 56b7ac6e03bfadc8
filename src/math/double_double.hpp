// Sums and products as the nearest double and what that leaves out: exact, in plain arithmetic.
#pragma once

#include "math/scalar.hpp"

namespace adcs::math {

/// The number value + rest, |rest| at most half an ulp of the value.
template <class T>
struct DoubleDouble {
    T value, rest;
};

/// a + b, where |a| >= |b|, or a is 0 or a multiple of the ulp of b (Dekker 1971).
template <class T>
DoubleDouble<T> fast_two_sum(const T& a, const T& b) {
    const T sum = a + b;
    return {sum, b - (sum - a)};
}

/// a^2 for |a| < 1.
template <class T>
DoubleDouble<T> square(const T& a) {
    const T upper = (a + 0x1.8p26) - 0x1.8p26;  // 26 bits, the square of which is exact
    const T product = a * a;
    return {product, (upper * upper - product) + (a - upper) * (a + upper)};
}

/// a b for factors below 2^995 (Veltkamp 1968, Dekker 1971).
template <class T>
DoubleDouble<T> two_product(const T& a, const T& b) {
    const auto upper_half = [](const T& x) {
        const T shifted = 0x1.0000002p27 * x;
        return shifted - (shifted - x);
    };
    const T product = a * b, a1 = upper_half(a), b1 = upper_half(b), a2 = a - a1, b2 = b - b1;
    return {product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
}

/// a b, to some 2^-102.
template <class T>
DoubleDouble<T> times(const DoubleDouble<T>& a, const DoubleDouble<T>& b) {
    const auto product = two_product(a.value, b.value);
    return fast_two_sum(product.value, product.rest + (a.value * b.rest + a.rest * b.value));
}

/// a / b, to some 2^-102, where nothing underflows.
template <class T>
DoubleDouble<T> quotient(const DoubleDouble<T>& a, const DoubleDouble<T>& b) {
    const T q = a.value / b.value;
    const auto product = two_product(q, b.value);
    return {q, (((a.value - product.value) - product.rest) + (a.rest - q * b.rest)) / b.value};
}

}  // namespace adcs::math

// Whole numbers below and above, and remainders: all exact.
#pragma once

#include "math/scalar.hpp"

namespace adcs::math {

/// The nearest integer to x, whatever its size; of one that has no fraction, or is no number, x itself.
template <class T>
T nearest_of_any(const T& x) {
    constexpr double whole = 0x1p52;  // from here on there are no fractions
    return select(abs(x) < whole, copysign((abs(x) + whole) - whole, x), x);
}

/// The largest integer that is not above x.
template <class T, IfReal<T> = 0>
T floor(const T& x) {
    const T n = nearest_of_any(x);
    return copysign(n - select(n > x, T(1.0), T(0.0)), x);  // of -0 it is -0
}

/// The smallest integer that is not below x.
template <class T, IfReal<T> = 0>
T ceil(const T& x) {
    const T n = nearest_of_any(x);
    return copysign(n + select(n < x, T(1.0), T(0.0)), x);
}

/// x - n y with the integer n nearest to x / y that is not further from 0; NaN for y = 0 and for an infinite x.
inline double fmod(double x, double y) {
    if (!(abs(x) < std::numeric_limits<double>::infinity()) || !(abs(y) > 0.0)) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    if (abs(x) < abs(y)) return x;
    // |x| = m 2^(e + zeros) and |y| = n 2^e in integers, and the remainder by n of m with ever more zeros behind it
    struct Whole {
        std::uint64_t significand;
        int exponent;
    };
    const auto whole = [](double a) {
        const std::uint64_t hidden_bit = std::uint64_t{1} << significand_bits, bits = bits_of(abs(a));
        const int exponent = static_cast<int>(bits >> significand_bits);
        return exponent == 0 ? Whole{bits, 1} : Whole{(bits & (hidden_bit - 1)) | hidden_bit, exponent};
    };
    const Whole n = whole(y);
    auto [m, exponent] = whole(x);
    m %= n.significand;
    constexpr int room = 11;  // of 64 bits beside 53
    for (int zeros = exponent - n.exponent; zeros > 0 && m != 0; zeros -= room) {
        m = (m << (zeros < room ? zeros : room)) % n.significand;
    }
    const double remainder = static_cast<double>(m), e = n.exponent - 1075, half = nearest(0.5 * e);
    return copysign(remainder * power_of_two(half) * power_of_two(e - half), x);
}

}  // namespace adcs::math

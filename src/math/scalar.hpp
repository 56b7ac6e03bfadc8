// What the elementary functions ask of a number, for double. They are written with arithmetic, comparisons and these
// few operations only, so a type of several numbers side by side needs no more than its own versions of them.
#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "math/compiler.hpp"

namespace adcs::math {

static_assert(std::numeric_limits<double>::is_iec559 && FLT_EVAL_METHOD == 0,
              "doubles must be rounded as IEEE 754 says after each operation");

/// Types that the elementary functions take.
template <class T>
inline constexpr bool is_real = false;
template <>
inline constexpr bool is_real<double> = true;
template <class T>
using IfReal = std::enable_if_t<is_real<T>, int>;

/// What a function of several numbers computes in: constants, also whole ones, mix with the others.
template <class... X>
using Joint = std::enable_if_t<is_real<std::common_type_t<double, X...>>, std::common_type_t<double, X...>>;

/// Where the condition holds a, else b. Both have been computed, so neither may be a matter of life and death.
inline double select(bool condition, double a, double b) { return condition ? a : b; }
/// Whether to take a way that few numbers need.
inline bool any(bool condition) { return condition; }

inline double abs(double x) { return std::fabs(x); }
/// |x| with the sign of y, which zeros have, too.
inline double copysign(double x, double y) { return std::copysign(x, y); }
inline double sqrt(double x) { return std::sqrt(x); }  // IEEE 754 rounds it exactly

inline std::uint64_t bits_of(double x) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}
inline double from_bits(std::uint64_t bits) {
    double x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}

inline constexpr int significand_bits = 52;
inline constexpr double no_fraction = 0x1.8p52;  ///< what is added to this has no place for a fraction

/// The nearest integer, for |x| < 2^51.
template <class T, IfReal<T> = 0>
T nearest(const T& x) {
    return (x + no_fraction) - no_fraction;
}

/// 2^k for an integer k from -1022 to 1023.
inline double power_of_two(double k) { return from_bits(bits_of(k + (no_fraction + 1023.0)) << significand_bits); }

/// x = significand * 2^exponent.
template <class T>
struct Split {
    T significand, exponent;
};

/// The significand from sqrt(1/2) to sqrt(2), for a positive normal x.
inline Split<double> split(double x) {
    const std::uint64_t bits = bits_of(x);
    const std::int64_t k = static_cast<std::int64_t>(bits - bits_of(0x1.6a09e667f3bcdp-1)) >> significand_bits;
    return {from_bits(bits - (static_cast<std::uint64_t>(k) << significand_bits)), static_cast<double>(k)};
}

}  // namespace adcs::math

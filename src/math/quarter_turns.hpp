// An angle as quarter turns and the rest, to more than double precision and for every double, however large.
#pragma once

#include "math/double_double.hpp"

namespace adcs::math {

/// x = quarters pi/2 + angle + rest, with |angle| <= pi/4 (and a rounding error more) and a rest far smaller still.
template <class T>
struct QuarterTurns {
    T angle, rest, quarters;
};

inline constexpr double largest_moderate_angle = 0x1p20;

/// For |x| up to largest_moderate_angle: pi/2 in four parts, of which multiples of the first three are exact (Cody and
/// Waite 1980). The four have 156 bits, and no such x but 0 is nearer than 2^-61 to a multiple of pi/2.
template <class T>
QuarterTurns<T> moderate_quarter_turns(const T& x) {
    const T n = nearest(x * 0x1.45f306dc9c883p-1);  // 2 / pi
    const T coarse = x - n * 0x1.921fb544p+0;       // exact, for both are near each other
    const auto fine = fast_two_sum(n * 0x1.0b4611a6p-34, n * 0x1.3198a2ep-69);
    const auto angle = fast_two_sum(coarse, -fine.value);  // exact: coarse is 0 mod 2^-53, fine at most 2^-13
    return {angle.value, angle.rest - (fine.rest + n * 0x1.b839a252049c1p-104), n};
}

/// For larger x, the method of Payne and Hanek (1983): of the product with 2/pi only the bits between quarter turns and
/// the wanted precision are computed, in integers. NaN for an x that is not finite.
QuarterTurns<double> huge_quarter_turns(double x);

template <class T>
QuarterTurns<T> quarter_turns(const T& x) {
    if (any(!(abs(x) <= largest_moderate_angle))) return huge_quarter_turns(x);
    return moderate_quarter_turns(x);
}

/// 2/pi = 0.a2f9836e... in hexadecimal, as words of 32 bits after two words of 0: as many as the largest double needs.
inline constexpr std::uint32_t two_over_pi[] = {
    0,          0,          0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041,
    0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
    0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b,
    0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
    0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046};

ADCS_RARELY_CALLED inline QuarterTurns<double> huge_quarter_turns(double x) {
    if (!(abs(x) < std::numeric_limits<double>::infinity())) {
        return {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
    }
    // |x| = m 2^e with an integer m of 53 bits
    const std::uint64_t bits = bits_of(abs(x)), hidden_bit = std::uint64_t{1} << significand_bits;
    const std::uint64_t m = (bits & (hidden_bit - 1)) | hidden_bit, m_low = m & 0xffffffffU, m_high = m >> 32;
    const int e = static_cast<int>(bits >> significand_bits) - 1075;

    // Bits of 2/pi that make whole turns are left out. The next 192, times m, modulo 2^192: 2 bits of quarter turns and
    // 190 of a fraction, of which the last 53 are not exact and 61 can be zeros, so that 76 are left.
    constexpr int n = 6;
    const int begin = e - 2 + 64;
    const std::uint32_t* words = two_over_pi + begin / 32;
    const int shift = begin % 32;
    std::uint32_t product[n];
    std::uint64_t carry = 0;
    std::uint32_t window[n];
    for (int i = 0; i < n; ++i) {
        const std::uint64_t two_words = std::uint64_t{words[i]} << 32 | words[i + 1];
        window[i] = static_cast<std::uint32_t>(two_words >> (32 - shift));
    }
    for (int i = n - 1; i >= 0; --i) {
        carry += window[i] * m_low;
        product[i] = static_cast<std::uint32_t>(carry);
        carry >>= 32;
    }
    carry = 0;
    for (int i = n - 2; i >= 0; --i) {
        carry += window[i + 1] * m_high + product[i];
        product[i] = static_cast<std::uint32_t>(carry);
        carry >>= 32;
    }

    // To the nearest quarter turn: the fraction becomes one with a sign, in two's complement, from -1/2 to 1/2.
    const std::uint32_t quarters = ((product[0] >> 29) + 1) >> 1;
    product[0] -= quarters << 30;
    const bool negative = product[0] >> 31 != 0;
    DoubleDouble<double> fraction{0.0, 0.0};
    double weight = 0x1p-30;
    std::uint32_t borrow = 0;
    for (int i = n - 1; negative && i >= 0; --i) {
        const bool zero = product[i] == 0 && borrow == 0;
        product[i] = 0U - product[i] - borrow;
        if (!zero) borrow = 1;
    }
    for (int i = 0; i < n; ++i) {
        const auto sum = fast_two_sum(fraction.value, product[i] * weight);
        fraction = {sum.value, fraction.rest + sum.rest};
        weight *= 0x1p-32;
    }
    const auto product_of_highs = two_product(fraction.value, 0x1.921fb54442d18p+0);
    const auto angle =
        fast_two_sum(product_of_highs.value, product_of_highs.rest + fraction.value * 0x1.1a62633145c07p-54 +
                                                 fraction.rest * 0x1.921fb54442d18p+0);
    const double sign = negative != (x < 0.0) ? -1.0 : 1.0;
    return {sign * angle.value, sign * angle.rest, x < 0.0 ? -static_cast<double>(quarters) : quarters};
}

}  // namespace adcs::math

// pow, cbrt and hypot: powers and roots.
#pragma once

#include "math/logarithm.hpp"
#include "math/rounding.hpp"

namespace adcs::math {

/// (artanh(s) / s - 1 - s^2/3 - s^4/5) / s^6 in powers of s^2 up to 0.02944, to 8.6e-19;
/// mpmath.chebyfit(lambda z: ((atanh(sqrt(z)) / sqrt(z) - 1) / z - mpf(1) / 3 - z / 5) / z**2, [0, 0.02944], 8).
inline constexpr double artanh_coefficients[] = {0x1.2492492492492p-3, 0x1.c71c71c71c822p-4, 0x1.745d1745a3ef7p-4,
                                                 0x1.3b13b16b4b183p-4, 0x1.1110f80573fe8p-4, 0x1.e1effaa94fc23p-5,
                                                 0x1.acf8468c270bap-5, 0x1.b2e0bf1046335p-5};

/// log(x) to some 2^-70, for a positive x that is not infinite.
template <class T>
DoubleDouble<T> log_as_sum(const T& x) {
    const auto subnormal = x < std::numeric_limits<double>::min();
    const auto [m, exponent] = split(select(subnormal, x * 0x1p54, x));
    const T k = exponent - select(subnormal, T(54.0), T(0.0));
    const T f = m - 1.0;
    const auto s = quotient(DoubleDouble<T>{f, 0.0}, fast_two_sum(T(2.0), f));
    // log(x) = k ln 2 + 2 s (1 + z w), with z = s^2 and w = 1/3 + z (1/5 + ...)
    const auto z = times(s, s);
    const auto inner = fast_two_sum(T(0x1.999999999999ap-3), z.value * polynomial(z.value, artanh_coefficients));
    const auto w = times(z, DoubleDouble<T>{inner.value, inner.rest - 0x1.999999999999ap-57});
    const auto outer = fast_two_sum(T(0x1.5555555555555p-2), w.value);
    const auto bent = times(times(s, z), DoubleDouble<T>{outer.value, outer.rest + (w.rest + 0x1.5555555555555p-56)});
    const auto [straight, left] = fast_two_sum(k * ln2_high, 2.0 * s.value);
    const auto [sum, more] = fast_two_sum(straight, 2.0 * bent.value);
    return fast_two_sum(sum, more + (left + (2.0 * (s.rest + bent.rest) + k * ln2_low)));
}

/// x^y. Of a negative x it is NaN unless y is an integer; x^0 and 1^y are 1, whatever the other is.
template <class X, class Y, class T = Joint<X, Y>>
T pow(const X& x_, const Y& y_) {
    const T x = x_, y = y_, a = abs(x);
    const T infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    const T exponent = select(abs(y) > 0x1p70, copysign(T(0x1p70), y), y);  // that of all but 1 is 0 or infinity then
    const auto logarithm = log_as_sum(a);
    const auto [product, rest] = two_product(exponent, logarithm.value);
    const auto parts = doublings(product);
    const auto fraction = fast_two_sum(parts.part, parts.rest + (rest + exponent * logarithm.rest));
    const T finite = exp_of(product, Doublings<T>{fraction.value, fraction.rest, parts.k});

    const T magnitude = select(a == 0.0, select(y < 0.0, infinity, T(0.0)),
                               select(a == infinity, select(y < 0.0, T(0.0), infinity), finite));
    const T no_integer = select(a == 0.0, T(1.0), select(a == infinity, T(1.0), nan));
    const T half = 0.5 * y;
    const T sign = select(floor(y) == y, select(floor(half) == half, T(1.0), T(-1.0)), no_integer);
    const T power = select(copysign(T(1.0), x) < 0.0, sign * magnitude, magnitude);
    const T known = select(x == x, select(y == y, power, y), x);
    return select(y == 0.0, T(1.0), select(x == 1.0, T(1.0), known));
}

/// The number whose third power is x: by logarithm and exponential, and one step of Newton's method.
template <class T, IfReal<T> = 0>
T cbrt(const T& x) {
    const T a = abs(x);
    const auto subnormal = a < std::numeric_limits<double>::min();
    const auto [m, exponent] = split(select(subnormal, a * 0x1p54, a));
    const T third = nearest(exponent * 0x1.5555555555555p-2);
    const T cube = m * power_of_two(exponent - 3.0 * third);
    const T root = exp(log(cube) * 0x1.5555555555555p-2);
    const auto root2 = two_product(root, root), root3 = two_product(root2.value, root);
    const T missing = ((cube - root3.value) - root3.rest) - root2.rest * root;
    const T better = (root + missing / (3.0 * root2.value)) * power_of_two(third - select(subnormal, T(18.0), T(0.0)));
    return select(a > 0.0, select(a < std::numeric_limits<double>::infinity(), copysign(better, x), x), x);
}

/// The length sqrt(x^2 + y^2) of a vector, which is computed without overflow.
template <class X, class Y, class T = Joint<X, Y>>
T hypot(const X& x_, const Y& y_) {
    const T x = abs(T(x_)), y = abs(T(y_)), infinity = std::numeric_limits<double>::infinity();
    const T longer = select(x > y, x, y), shorter = select(x > y, y, x);
    const auto large = longer > 0x1p500, small = longer < 0x1p-400;
    const T factor = select(large, T(0x1p-600), select(small, T(0x1p600), T(1.0)));
    const T back = select(large, T(0x1p600), select(small, T(0x1p-600), T(1.0)));
    const T a = longer * factor, b = shorter * factor;
    const auto a2 = two_product(a, a), b2 = two_product(b, b);
    const auto [sum, left] = fast_two_sum(a2.value, b2.value);
    const T root = sqrt(sum);
    const auto root2 = two_product(root, root);
    const T missing = ((sum - root2.value) - root2.rest) + (left + (a2.rest + b2.rest));
    const T length = (root + select(root > 0.0, missing / (root + root), T(0.0))) * back;
    return select(x == infinity, infinity, select(y == infinity, infinity, length));
}

}  // namespace adcs::math

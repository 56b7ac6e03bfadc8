// A double that carries something along: a derivative (Dual) or the set of variables it came from (Trace).
// A law templated on its scalar type thus gives its own exact directional derivatives and its own dependency
// structure, with no second text of the equations.
#pragma once

#include <cstdint>
#include <type_traits>

#include "attitude/eigen.hpp"
#include "math/functions.hpp"

namespace adcs {

inline double scale(double factor, double tangent) { return factor * tangent; }
/// Told of the tangent of each number that something was decided by, which has none itself.
inline void decided_by(double /*tangent*/) {}
/// The same where the slope can be infinite: what does not change, such as x at a limit, has derivative 0 there, too.
inline double scale_steeply(double slope, double tangent) { return tangent == 0.0 ? 0.0 : slope * tangent; }
/// Of a value that is one of several: the tangent of the one that was chosen. A Trace joins it with the others.
inline double chosen(double tangent, double /*other*/) { return tangent; }
/// What a comparison of two numbers gives: of a Trace, with what it depends on.
inline bool compared(bool holds, double /*a*/, double /*b*/) { return holds; }

/// Value and tangent; `Tangent` needs `a + b` and what is above.
///
/// Where a function has a kink, or a law chooses, the derivative is that of one side; which one is said with it.
template <class Tangent>
struct Lifted {
    double value = 0.0;
    Tangent tangent{};

    constexpr Lifted() = default;
    constexpr Lifted(double v) : value(v) {}  // NOLINT(google-explicit-constructor): constants mix with variables
    constexpr Lifted(double v, const Tangent& t) : value(v), tangent(t) {}

    Lifted& operator+=(const Lifted& b) { return *this = *this + b; }
    Lifted& operator-=(const Lifted& b) { return *this = *this - b; }
    Lifted& operator*=(const Lifted& b) { return *this = *this * b; }
    Lifted& operator/=(const Lifted& b) { return *this = *this / b; }

    friend Lifted operator-(const Lifted& a) { return {-a.value, scale(-1.0, a.tangent)}; }
    friend Lifted operator+(const Lifted& a, const Lifted& b) { return {a.value + b.value, a.tangent + b.tangent}; }
    friend Lifted operator-(const Lifted& a, const Lifted& b) {
        return {a.value - b.value, a.tangent + scale(-1.0, b.tangent)};
    }
    friend Lifted operator*(const Lifted& a, const Lifted& b) {
        return {a.value * b.value, scale(b.value, a.tangent) + scale(a.value, b.tangent)};
    }
    friend Lifted operator/(const Lifted& a, const Lifted& b) {
        const double quotient = a.value / b.value;
        return {quotient, scale(1.0 / b.value, a.tangent) + scale(-quotient / b.value, b.tangent)};
    }

    friend auto operator<(const Lifted& a, const Lifted& b) {
        return compared(a.value < b.value, a.tangent, b.tangent);
    }
    friend auto operator>(const Lifted& a, const Lifted& b) {
        return compared(a.value > b.value, a.tangent, b.tangent);
    }
    friend auto operator<=(const Lifted& a, const Lifted& b) {
        return compared(a.value <= b.value, a.tangent, b.tangent);
    }
    friend auto operator>=(const Lifted& a, const Lifted& b) {
        return compared(a.value >= b.value, a.tangent, b.tangent);
    }
    friend auto operator==(const Lifted& a, const Lifted& b) {
        return compared(a.value == b.value, a.tangent, b.tangent);
    }
    friend auto operator!=(const Lifted& a, const Lifted& b) {
        return compared(a.value != b.value, a.tangent, b.tangent);
    }

    friend Lifted sqrt(const Lifted& a) {
        const double root = math::sqrt(a.value);
        return {root, scale_steeply(0.5 / root, a.tangent)};
    }
    friend Lifted exp(const Lifted& a) {
        const double e = math::exp(a.value);
        return {e, scale(e, a.tangent)};
    }
    friend Lifted log(const Lifted& a) { return {math::log(a.value), scale(1.0 / a.value, a.tangent)}; }
    friend SinCos<Lifted> sincos(const Lifted& a) {
        const auto [s, c] = math::sincos(a.value);
        return {{s, scale(c, a.tangent)}, {c, scale(-s, a.tangent)}};
    }
    friend Lifted sin(const Lifted& a) { return sincos(a).sin; }
    friend Lifted cos(const Lifted& a) { return sincos(a).cos; }
    friend Lifted tan(const Lifted& a) {
        const double t = math::tan(a.value);
        return {t, scale(1.0 + t * t, a.tangent)};
    }
    friend Lifted asin(const Lifted& a) {
        return {math::asin(a.value), scale_steeply(1.0 / math::sqrt((1.0 - a.value) * (1.0 + a.value)), a.tangent)};
    }
    friend Lifted acos(const Lifted& a) {
        return {math::acos(a.value), scale_steeply(-1.0 / math::sqrt((1.0 - a.value) * (1.0 + a.value)), a.tangent)};
    }
    friend Lifted atan(const Lifted& a) {
        return {math::atan(a.value), scale(1.0 / (1.0 + a.value * a.value), a.tangent)};
    }
    /// Has no derivative at the origin.
    friend Lifted atan2(const Lifted& y, const Lifted& x) {
        const double r = math::hypot(x.value, y.value);
        return {math::atan2(y.value, x.value),
                scale_steeply(x.value / r / r, y.tangent) + scale_steeply(-(y.value / r / r), x.tangent)};
    }
    friend Lifted sinh(const Lifted& a) { return {math::sinh(a.value), scale(math::cosh(a.value), a.tangent)}; }
    friend Lifted cosh(const Lifted& a) { return {math::cosh(a.value), scale(math::sinh(a.value), a.tangent)}; }
    friend Lifted tanh(const Lifted& a) {
        const double c = math::cosh(a.value);
        return {math::tanh(a.value), scale(1.0 / c / c, a.tangent)};
    }
    friend Lifted cbrt(const Lifted& a) {
        const double root = math::cbrt(a.value);
        return {root, scale_steeply(1.0 / (3.0 * root * root), a.tangent)};
    }
    /// Where x is not positive there is no derivative by the exponent, which counts as constant.
    friend Lifted pow(const Lifted& x, const Lifted& y) {
        const double power = math::pow(x.value, y.value);
        const double by_x = y.value == 0.0 ? 0.0 : y.value * math::pow(x.value, y.value - 1.0);
        const double by_y = x.value > 0.0 ? power * math::log(x.value) : 0.0;
        return {power, scale_steeply(by_x, x.tangent) + scale(by_y, y.tangent)};
    }
    /// At the origin the derivative is 0, between those of all sides.
    friend Lifted hypot(const Lifted& x, const Lifted& y) {
        const double r = math::hypot(x.value, y.value), divisor = r == 0.0 ? 1.0 : r;
        return {r, scale(x.value / divisor, x.tangent) + scale(y.value / divisor, y.tangent)};
    }
    /// Where it jumps, the derivative is that of the side it belongs to.
    friend Lifted fmod(const Lifted& x, const Lifted& y) {
        const double remainder = math::fmod(x.value, y.value), turns = (x.value - remainder) / y.value;
        return {remainder, x.tangent + scale(-turns, y.tangent)};
    }
    /// The derivative is 0, at the jumps as well; so is that of ceil.
    friend Lifted floor(const Lifted& a) { return {math::floor(a.value), scale(0.0, a.tangent)}; }
    friend Lifted ceil(const Lifted& a) { return {math::ceil(a.value), scale(0.0, a.tangent)}; }

    /// The derivative at 0 is that of the positive side.
    friend Lifted abs(const Lifted& a) {
        return {math::abs(a.value), a.value < 0.0 ? scale(-1.0, a.tangent) : a.tangent};
    }
    /// The derivative by x is 1 or -1, of a zero by its sign; that by the sign is 0.
    friend Lifted copysign(const Lifted& x, const Lifted& sign) {
        const double value = math::copysign(x.value, sign.value);
        const bool same = math::bits_of(value) == math::bits_of(x.value);
        return {value, chosen(scale(same ? 1.0 : -1.0, x.tangent), sign.tangent)};
    }
    /// Where both are equal, the derivative is that of the first; so is that of max.
    friend Lifted min(const Lifted& a, const Lifted& b) {
        return {math::min(a.value, b.value),
                b.value < a.value ? chosen(b.tangent, a.tangent) : chosen(a.tangent, b.tangent)};
    }
    friend Lifted max(const Lifted& a, const Lifted& b) {
        return {math::max(a.value, b.value),
                b.value > a.value ? chosen(b.tangent, a.tangent) : chosen(a.tangent, b.tangent)};
    }
    /// On a limit, the derivative is that of x.
    friend Lifted clamp(const Lifted& x, const Lifted& low, const Lifted& high) { return min(max(x, low), high); }
    /// Where the condition holds a, else b, and the derivative of that one.
    friend Lifted select(bool condition, const Lifted& a, const Lifted& b) {
        return condition ? Lifted(a.value, chosen(a.tangent, b.tangent))
                         : Lifted(b.value, chosen(b.tangent, a.tangent));
    }
};

using Dual = Lifted<double>;

/// The plain number behind any scalar type, for decisions that are not differentiated.
inline double value_of(double x) { return x; }
template <class Tangent>
double value_of(const Lifted<Tangent>& x) {
    decided_by(x.tangent);
    return x.value;
}

}  // namespace adcs

namespace Eigen {
template <class Tangent>
struct NumTraits<adcs::Lifted<Tangent>> : NumTraits<double> {
    using Real = adcs::Lifted<Tangent>;
    using NonInteger = Real;
    using Nested = Real;
    using Literal = double;
    enum {
        IsComplex = 0,
        IsInteger = 0,
        IsSigned = 1,
        RequireInitialization = 1,
        ReadCost = 2,
        AddCost = 2,
        MulCost = 4
    };
};
template <class Tangent, class Op>
struct ScalarBinaryOpTraits<double, adcs::Lifted<Tangent>, Op> {
    using ReturnType = adcs::Lifted<Tangent>;
};
template <class Tangent, class Op>
struct ScalarBinaryOpTraits<adcs::Lifted<Tangent>, double, Op> {
    using ReturnType = adcs::Lifted<Tangent>;
};
}  // namespace Eigen

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

/// Value and tangent; `Tangent` needs `a + b` and `scale(factor, a)`.
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

    friend bool operator<(const Lifted& a, const Lifted& b) { return decisive(a) < decisive(b); }
    friend bool operator>(const Lifted& a, const Lifted& b) { return decisive(a) > decisive(b); }
    friend bool operator<=(const Lifted& a, const Lifted& b) { return decisive(a) <= decisive(b); }
    friend bool operator>=(const Lifted& a, const Lifted& b) { return decisive(a) >= decisive(b); }
    friend bool operator==(const Lifted& a, const Lifted& b) { return decisive(a) == decisive(b); }
    friend bool operator!=(const Lifted& a, const Lifted& b) { return decisive(a) != decisive(b); }
    friend double decisive(const Lifted& a) {
        decided_by(a.tangent);
        return a.value;
    }

    friend Lifted sqrt(const Lifted& a) {
        const double root = math::sqrt(a.value);
        return {root, scale(0.5 / root, a.tangent)};
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
    friend Lifted abs(const Lifted& a) { return a.value < 0.0 ? -a : a; }
};

using Dual = Lifted<double>;

/// The plain number behind any scalar type, for decisions that are not differentiated.
inline double value_of(double x) { return x; }
template <class Tangent>
double value_of(const Lifted<Tangent>& x) {
    return decisive(x);
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

// The smaller and the larger of numbers. What is not a number stays so, for nobody would find what a limit hides; and
// -0 is below 0, so the order of the arguments does not matter.
#pragma once

#include "math/scalar.hpp"

namespace adcs::math {

template <class A, class B, class T = Joint<A, B>>
T min(const A& first, const B& second) {
    const T a = first, b = second;
    return select(a < b, a, select(a > b, b, select(a == b, select(copysign(T(1.0), a) < 0.0, a, b), a + b)));
}

template <class A, class B, class T = Joint<A, B>>
T max(const A& first, const B& second) {
    const T a = first, b = second;
    return select(a > b, a, select(a < b, b, select(a == b, select(copysign(T(1.0), a) < 0.0, b, a), a + b)));
}

/// x, but not below low and not above high, which wins where low is above it.
template <class X, class L, class H, class T = Joint<X, L, H>>
T clamp(const X& x, const L& low, const H& high) {
    return min(max(T(x), T(low)), T(high));
}

}  // namespace adcs::math

// The command filter (C.5): limits a signal and its rate, and gives the rate along with it.
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

/// x, shortened to the length `limit` where it is longer (C.8).
template <class T>
Vec3<T> saturated(const Vec3<T>& x, const T& limit) {
    const T square = x.dot(x);
    return square > limit * limit ? Vec3<T>(limit / sqrt(square) * x) : x;
}

/// One step of length dt (C.5): `x` is the filtered signal of the step before and becomes that of this one; returns its
/// rate. Where neither limit acts, x becomes `raw`.
template <class T>
Vec3<T> command_filter(Vec3<T>& x, const Vec3<T>& raw, const T& limit, const T& rate_limit, const T& dt) {
    const Vec3<T> rate = saturated<T>((saturated(raw, limit) - x) / dt, rate_limit);
    x += dt * rate;
    return rate;
}

}  // namespace adcs

// A vector tilted by a given angle towards a given side: the error of a sensor that errs within a cone.
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

/// v turned by beta towards d = a x v: cos(beta) v + sin(beta) |v| d / |d|, from versine = 1 - cos(beta). With a uniform
/// on the sphere the side is uniform; the tangent plane of v needs no basis. v itself where beta or d is zero.
template <class T>
Vec3<T> tilted(const Vec3<T>& v, const Vec3<T>& a, const T& versine) {
    const Vec3<T> d = a.cross(v);
    if (!(versine > 0.0 && d.dot(d) > 0.0)) return v;
    const T sine = sqrt(versine * (2.0 - versine));
    return (1.0 - versine) * v + (sine * sqrt(v.dot(v) / d.dot(d))) * d;
}

}  // namespace adcs

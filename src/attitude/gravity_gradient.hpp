// Gravity gradient torque on a body in a circular orbit.
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

/// 3 n^2 c_3 x J c_3 of (3.38): c_3, third column of C_BO, is the direction to the Earth; n the orbital rate.
template <class T>
Vec3<T> gravity_gradient(const T& n, const Vec3<T>& c_3, const Mat3<T>& J_B) {
    return 3.0 * n * n * c_3.cross(J_B * c_3);
}

}  // namespace adcs

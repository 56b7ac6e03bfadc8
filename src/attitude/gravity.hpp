// Gravity of a spherical Earth on an extended body, and the shape of the Earth's field: shared by the orbit, the plant
// and the laws that feed it forward. r is the position of the centre of mass relative to the centre of the Earth.
#pragma once

#include <limits>

#include "attitude/eigen.hpp"

namespace adcs {

inline constexpr double earth_mu = 398.6004418e12;  // m3/s2
inline constexpr double earth_equatorial_radius = 6378137.0;

/// Height of r above a sphere. Below its surface not a number, so that the adaptor refuses to go on and names the output.
template <class T>
T height_above(const Vec3<T>& r, const T& radius) {
    const T height = sqrt(r.dot(r)) - radius;
    return height < 0.0 ? T(std::numeric_limits<double>::quiet_NaN()) : height;
}

/// Acceleration of a point mass, -mu r / |r|^3.
template <class T>
Vec3<T> point_mass_gravity(const T& mu, const Vec3<T>& r) {
    const T square = r.dot(r);
    return -mu / (square * sqrt(square)) * r;
}

/// Gravity-gradient torque 3 mu / |r|^5 r x J r; r, J and the torque in B.
template <class T>
Vec3<T> gravity_gradient_torque(const T& mu, const Mat3<T>& J_B, const Vec3<T>& r_B) {
    const T square = r_B.dot(r_B);
    const Vec3<T> moment = r_B.cross(J_B * r_B);
    return 3.0 * mu / (square * square * sqrt(square)) * moment;
}

/// What the extent of the body adds to the force of gravity,
/// -3 mu / (2 |r|^4) [(tr J) I + 2 J - 5 (Z.JZ) I] Z with Z = r/|r|; r, J and the force in B.
template <class T>
Vec3<T> gravity_gradient_force(const T& mu, const Mat3<T>& J_B, const Vec3<T>& r_B) {
    const T square = r_B.dot(r_B);
    const Vec3<T> Z = r_B / sqrt(square);
    const Vec3<T> J_Z = J_B * Z;
    const T stretch = J_B.trace() - 5.0 * Z.dot(J_Z);
    return -1.5 * mu / (square * square) * Vec3<T>(stretch * Z + 2.0 * J_Z);
}

}  // namespace adcs

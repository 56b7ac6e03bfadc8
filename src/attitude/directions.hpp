// Sets of unit vectors: what a direction sensor sees, and what laws make of it without an attitude. A row per vector.
#pragma once

#include "attitude/quaternion.hpp"
#include "fmi/words.hpp"

namespace adcs {

inline constexpr int n_directions = 3;  // of the components; what need not be seen gets the weight 0

template <class T>
using Directions = Eigen::Matrix<T, n_directions, 3, Eigen::RowMajor>;
template <class T>
using Weights = Eigen::Matrix<T, n_directions, 1>;

/// Directions known in N, of any length, as unit vectors in B: row j is C_BN x_j / |x_j|.
template <class T>
Directions<T> seen(const Mat3<T>& C_BN, const Directions<T>& x_N) {
    Directions<T> y_B;
    for (int j = 0; j < n_directions; ++j) {
        const Vec3<T> x = x_N.row(j);
        y_B.row(j) = C_BN * x / sqrt(x.dot(x));
    }
    return y_B;
}

/// sum k_j y_j x_j^T: Wahba's attitude profile; M E of the dissertation where x_j is y_j at the attitude wanted.
template <class T>
Mat3<T> profile(const Weights<T>& k, const Directions<T>& y, const Directions<T>& x) {
    Mat3<T> sum = Mat3<T>::Zero();
    for (int j = 0; j < n_directions; ++j) {
        const Vec3<T> y_j = y.row(j), x_j = x.row(j);
        sum += k[j] * y_j * x_j.transpose();
    }
    return sum;
}

/// sum k_j y_j x x_j.
template <class T>
Vec3<T> cross_sum(const Weights<T>& k, const Directions<T>& y, const Directions<T>& x) {
    Vec3<T> sum = Vec3<T>::Zero();
    for (int j = 0; j < n_directions; ++j) {
        const Vec3<T> y_j = y.row(j), x_j = x.row(j);
        sum += k[j] * y_j.cross(x_j);
    }
    return sum;
}

/// Refuses directions of these weights that tell no attitude.
inline void refuse_blindness(const Directions<double>& x_N, const Weights<double>& k, Words& refuse) {
    constexpr double collinear = 1e-6;  // sin^2 of the angle: 0.06 deg
    int counting = 0;
    bool apart = false;
    for (int j = 0; j < n_directions; ++j) {
        if (!(k[j] > 0.0)) continue;
        ++counting;
        const Vec3<double> x_j = x_N.row(j).normalized();
        for (int i = 0; i < j; ++i) {
            const Vec3<double> x_i = x_N.row(i).normalized();
            apart = apart || (k[i] > 0.0 && x_i.cross(x_j).squaredNorm() > collinear);
        }
    }
    if (counting < 2) {
        refuse("fewer than two weights are positive: two directions at least are needed for an attitude");
    } else if (!apart) {
        refuse(
            "directions_N of positive weight are collinear: turning about their line cannot be seen, give two that "
            "are not");
    }
}

}  // namespace adcs

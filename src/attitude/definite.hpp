// Is a gain matrix symmetric and positive (semi)definite?
#pragma once

#include "attitude/eigen.hpp"

namespace adcs {

template <class T>
bool symmetric(const Mat3<T>& A) {
    const auto differ = [](const T& x, const T& y) {
        const T difference = x - y, size = x * x + y * y;
        return difference * difference > 1e-18 * size;
    };
    return !differ(A(0, 1), A(1, 0)) && !differ(A(0, 2), A(2, 0)) && !differ(A(1, 2), A(2, 1));
}

/// By Sylvester's criterion.
template <class T>
bool positive_definite(const Mat3<T>& A) {
    const T minor = A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0);
    return symmetric(A) && A(0, 0) > 0.0 && minor > 0.0 && A.determinant() > 0.0;
}

/// All principal minors at least 0.
template <class T>
bool positive_semidefinite(const Mat3<T>& A) {
    const auto minor = [&A](int i, int j) { return A(i, i) * A(j, j) - A(i, j) * A(j, i); };
    return symmetric(A) && A(0, 0) >= 0.0 && A(1, 1) >= 0.0 && A(2, 2) >= 0.0 && minor(0, 1) >= 0.0 &&
           minor(0, 2) >= 0.0 && minor(1, 2) >= 0.0 && A.determinant() >= 0.0;
}

}  // namespace adcs

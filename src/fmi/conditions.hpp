// What a variable as a whole has to be, by its kind: the same test and the same tolerance for inputs, parameters and
// start values of all components.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdio>

#include "attitude/definite.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

/// Of the square of a norm that should be 1: further away is a mistake, not round-off.
inline constexpr double norm_tolerance = 0.02;

/// What a page and a model description say about the kind; nullptr for none.
inline const char* condition(Kind kind) {
    switch (kind) {
        case Kind::unit_quaternion:
            return "unit quaternion";
        case Kind::unit_vectors:
            return "unit vectors";
        case Kind::directions:
            return "not zero";
        case Kind::inertia:
            return "inertia matrix";
        case Kind::positive_definite:
            return "positive definite";
        case Kind::positive_semidefinite:
            return "positive semidefinite";
        case Kind::rotation:
            return "rotation matrix";
        case Kind::increasing:
            return "increasing";
        case Kind::any:
            break;
    }
    return nullptr;
}

namespace detail {

/// The vectors in a variable: the rows of a matrix, or the whole of it.
struct Rows {
    explicit Rows(const Variable& v) : length(v.cols != 0 ? v.cols : v.size), count(v.cols != 0 ? v.rows : 1) {}
    std::uint32_t length, count;
};

inline double squared_norm(const double* x, std::uint32_t n) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < n; ++i) sum += x[i] * x[i];
    return sum;
}

/// What is wrong with an inertia matrix, or nullptr. The triangle inequality of the principal moments says that
/// 1/2 tr(J) I - J, the second moment of the mass distribution, has no negative eigenvalue.
inline const char* inertia_fault(const double* J) {
    const double scale = std::fabs(J[0]) + std::fabs(J[4]) + std::fabs(J[8]);
    const double tolerance = 1e-9 * scale;
    if (std::fabs(J[1] - J[3]) > tolerance || std::fabs(J[2] - J[6]) > tolerance ||
        std::fabs(J[5] - J[7]) > tolerance) {
        return "is not symmetric";
    }
    const auto principal_minors_above = [](const double* A, double bound1, double bound2, double bound3) {
        const double minor = A[0] * A[4] - A[1] * A[3];
        const double determinant = A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) +
                                   A[2] * (A[3] * A[7] - A[4] * A[6]);
        return A[0] > bound1 && minor > bound2 && determinant > bound3;
    };
    if (!principal_minors_above(J, 0.0, 0.0, 0.0)) return "is not positive definite";
    const double half_trace = 0.5 * (J[0] + J[4] + J[8]);
    double S[9];
    for (int i = 0; i < 9; ++i) S[i] = (i % 4 == 0 ? half_trace + tolerance : 0.0) - J[i];
    if (!principal_minors_above(S, 0.0, 0.0, 0.0)) {
        return "violates the triangle inequality: no principal moment may exceed the sum of the other two";
    }
    return nullptr;
}

inline const char* matrix_fault(Kind kind, const double* values) {
    if (kind == Kind::inertia) return inertia_fault(values);
    const Mat3<double> A = Eigen::Map<const Mat3<double>>(values);
    if (kind == Kind::rotation) {
        const bool orthonormal =
            ((A * A.transpose()).eval() - Mat3<double>::Identity()).squaredNorm() <= norm_tolerance * norm_tolerance;
        return orthonormal && A.determinant() > 0.0
                   ? nullptr
                   : "is no rotation: rows of length 1 at right angles, and determinant 1, are expected";
    }
    if (kind == Kind::positive_definite) {
        return positive_definite(A)
                   ? nullptr
                   : "is not positive definite: a symmetric matrix of positive eigenvalues is expected";
    }
    return positive_semidefinite(A)
               ? nullptr
               : "is not positive semidefinite: a symmetric matrix without negative eigenvalues is "
                 "expected";
}

}  // namespace detail

/// Whether a variable is of unit vectors, or a unit quaternion: the quick answer for what is set in every step.
inline bool is_unit(const Variable& v) {
    if (v.kind != Kind::unit_quaternion && v.kind != Kind::unit_vectors) return false;
    const detail::Rows rows(v);
    const auto* x = static_cast<const double*>(v.data);
    for (std::uint32_t row = 0; row < rows.count; ++row, x += rows.length) {
        if (!(std::fabs(detail::squared_norm(x, rows.length) - 1.0) <= norm_tolerance)) return false;
    }
    return true;
}

/// Whether the variable meets the condition of its kind; what it says of one that does not goes into `fault`.
inline bool meets_condition(const Variable& v, char* fault, std::size_t size) {
    const auto* x = static_cast<const double*>(v.data);
    switch (v.kind) {
        case Kind::any:
            return true;
        case Kind::unit_quaternion:
        case Kind::unit_vectors:
        case Kind::directions: {
            const detail::Rows rows(v);
            for (std::uint32_t row = 0; row < rows.count; ++row) {
                const double square = detail::squared_norm(x + row * rows.length, rows.length);
                if (v.kind == Kind::directions ? square > 0.0 : std::fabs(square - 1.0) <= norm_tolerance) continue;
                char which[32] = "";
                if (rows.count > 1) std::snprintf(which, sizeof which, "row %u of ", row + 1);
                if (v.kind == Kind::directions) {
                    std::snprintf(fault, size, "%s%s is [0, 0, 0], but a direction is expected", which, v.name);
                } else {
                    std::snprintf(
                        fault, size, "%s%s has norm %g: a unit %s", which, v.name, std::sqrt(square),
                        v.kind == Kind::unit_vectors ? "vector is expected" : "quaternion is expected, scalar first");
                }
                return false;
            }
            return true;
        }
        case Kind::inertia:
        case Kind::positive_definite:
        case Kind::positive_semidefinite:
        case Kind::rotation:
            if (const char* what = detail::matrix_fault(v.kind, x); what != nullptr) {
                std::snprintf(fault, size, "%s = [%g %g %g; %g %g %g; %g %g %g] %s", v.name, x[0], x[1], x[2], x[3],
                              x[4], x[5], x[6], x[7], x[8], what);
                return false;
            }
            return true;
        case Kind::increasing:
            for (std::uint32_t e = 1; e < v.size; ++e) {
                if (x[e] > x[e - 1]) continue;
                std::snprintf(fault, size, "%s is not increasing: element %u = %g is not above element %u = %g", v.name,
                              e + 1, x[e], e, x[e - 1]);
                return false;
            }
            return true;
    }
    return true;
}

/// Whether elements of such a start value influence each other because the whole is normalised.
inline bool is_normalised(Kind kind) { return kind == Kind::unit_quaternion || kind == Kind::unit_vectors; }

/// Scales what should have norm 1, and nearly has, to it.
inline void normalise(const Variable& v) {
    auto* x = static_cast<double*>(v.data);
    const detail::Rows rows(v);
    for (std::uint32_t row = 0; row < rows.count; ++row, x += rows.length) {
        const double length = std::sqrt(detail::squared_norm(x, rows.length));
        if (length == 1.0) continue;
        for (std::uint32_t i = 0; i < rows.length; ++i) x[i] /= length;
    }
}

}  // namespace adcs

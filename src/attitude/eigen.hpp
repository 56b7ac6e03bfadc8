// Eigen, configured once. Results must not depend on the platform: no vector units (Eigen's NEON path fuses
// multiply and add, its SSE path does not), no contraction by the compiler. No allocation, no stream code.
#pragma once

#include "math/functions.hpp"

#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_NO_IO
#define EIGEN_NO_DEBUG

#ifdef ADCS_DESCRIBE
// The program that asks a component what it declares runs its law, and finds there what would be undefined behaviour in
// an FMU, which has no checks: elements that are not there, and variables that nothing was put into.
namespace adcs {
[[noreturn]] void refuse_call(const char* expected, const char* where);
}
#define eigen_assert(x) ((x) ? void() : adcs::refuse_call(#x, __PRETTY_FUNCTION__))
#define EIGEN_INITIALIZE_MATRICES_BY_NAN
#endif

#include <Eigen/Core>
#include <Eigen/LU>
// The cross product, of Eigen/Geometry, which as a whole brings SVD and QR, a fifth of what an FMU would have to carry.
#include <Eigen/src/Geometry/OrthoMethods.h>

namespace adcs {

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3 = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;  // row-major, as FMI lists arrays

/// Where the condition holds a, else b, of vectors and matrices: both are computed, and count as what it depends on.
template <class Condition, class A, class B>
auto select(const Condition& condition, const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
    static_assert(static_cast<int>(A::RowsAtCompileTime) == B::RowsAtCompileTime &&
                      static_cast<int>(A::ColsAtCompileTime) == B::ColsAtCompileTime,
                  "select() chooses between two of one size");
    typename A::PlainObject chosen = a;
    const typename B::PlainObject other = b;
    for (Eigen::Index row = 0; row < chosen.rows(); ++row) {
        for (Eigen::Index col = 0; col < chosen.cols(); ++col) {
            chosen(row, col) = select(condition, chosen(row, col), other(row, col));
        }
    }
    return chosen;
}

}  // namespace adcs

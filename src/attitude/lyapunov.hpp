// The Lyapunov equation of a linear system of order 3, and whether such a system is stable.
#pragma once

#include <utility>

#include "attitude/eigen.hpp"

namespace adcs {

/// x with A x = b, A invertible, by Gaussian elimination with pivoting.
template <class T, int N>
Eigen::Matrix<T, N, 1> eliminate(Eigen::Matrix<T, N, N> A, Eigen::Matrix<T, N, 1> b) {
    for (int k = 0; k < N; ++k) {
        int pivot = k;
        for (int i = k + 1; i < N; ++i) pivot = abs(A(i, k)) > abs(A(pivot, k)) ? i : pivot;
        for (int j = k; j < N; ++j) std::swap(A(k, j), A(pivot, j));
        std::swap(b[k], b[pivot]);
        for (int i = k + 1; i < N; ++i) {
            const T factor = A(i, k) / A(k, k);
            for (int j = k; j < N; ++j) A(i, j) -= factor * A(k, j);
            b[i] -= factor * b[k];
        }
    }
    for (int k = N - 1; k >= 0; --k) {
        for (int j = k + 1; j < N; ++j) b[k] -= A(k, j) * b[j];
        b[k] /= A(k, k);
    }
    return b;
}

/// P with A^T P + P A = -Q. Unique and positive definite if A is Hurwitz and Q positive definite.
template <class T>
Mat3<T> lyapunov(const Mat3<T>& A, const Mat3<T>& Q) {
    Eigen::Matrix<T, 9, 9> L = Eigen::Matrix<T, 9, 9>::Zero();  // of the elements of P, row by row
    Eigen::Matrix<T, 9, 1> q;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            q[3 * i + j] = -Q(i, j);
            for (int k = 0; k < 3; ++k) {
                L(3 * i + j, 3 * k + j) += A(k, i);
                L(3 * i + j, 3 * i + k) += A(k, j);
            }
        }
    }
    const Eigen::Matrix<T, 9, 1> p = eliminate(L, q);
    Mat3<T> P;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) P(i, j) = 0.5 * (p[3 * i + j] + p[3 * j + i]);
    }
    return P;
}

/// Whether all eigenvalues have negative real parts: Routh's conditions on s^3 + a s^2 + b s + c.
inline bool hurwitz(const Mat3<double>& A) {
    const double a = -A.trace();
    const double b = 0.5 * (A.trace() * A.trace() - (A * A).trace());
    const double c = -A.determinant();
    return a > 0.0 && c > 0.0 && a * b > c;
}

}  // namespace adcs

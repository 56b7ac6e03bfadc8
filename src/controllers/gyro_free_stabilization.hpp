/// # Gyro-free attitude stabilisation
///
/// Brings a body to rest at the attitude $C_r$ from unit vectors $y_j$ measured in B alone: no gyro, no attitude
/// estimate, no inertia. With the vectors that would be seen there, $y_{rj} = C_r x_j$, and weights $k_j$, Eqs. (4.7),
/// (4.9), (4.25) and (4.26):
///
/// $$\Omega = \tfrac12\sum k_j\, y_j\times y_{rj}, \qquad ME = \sum k_j\, y_j y_{rj}^T, \qquad
///   \tilde M = -\tfrac12\left[ME - \mathrm{tr}(ME)\,I\right]$$
/// $$\dot z = A_m z + B\,\Omega, \qquad \tau = -k_p\,\Omega - k_z\,\tilde M^T B^T P\,\dot z, \qquad
///   A_m^T P + P A_m = -Q$$
///
/// The filter takes the place of the angular velocity: $\dot\Omega = \tilde M\omega$ for a constant $C_r$. With exact
/// measurements
///
/// $$V = \tfrac12\,\omega^T J\omega + \tfrac12 k_p\sum k_j\left(1 - y_j^T y_{rj}\right) + \tfrac12 k_z\,\dot z^T P\dot z,
///   \qquad \dot V = -\tfrac12 k_z\,\dot z^T Q\,\dot z$$
///
/// **Where it starts from matters.** $V(0) < k_p\sum k_j$, Eq. (4.27), is not enough for convergence, against
/// Theorem 4.2.3: with $e$ an eigenvector of $M_0 = \sum k_j\,y_{rj}y_{rj}^T$ and $\lambda$ its eigenvalue, the body can
/// rest, without torque, turned by 180 degrees about $e$, where $V = k_p(\sum k_j - \lambda)$. Enough is
///
/// $$V(0) < k_p\left(\sum k_j - \lambda_{max}(M_0)\right)$$
///
/// **The filter's start.** With `filter_at_rest` it is $z(0) = -A_m^{-1}B\,\Omega(0)$, so that $\dot z(0) = 0$, taken
/// from the first measurement; without it is `z_0`. To that end the continuous state is $z - z(0)$. $P$ is solved for once,
/// at the start.
#pragma once

#include "attitude/directions.hpp"
#include "attitude/lyapunov.hpp"
#include "fmi/declaration.hpp"

namespace adcs {

template <class T>
struct GyroFreeStabilization {
    static constexpr auto summary = "Attitude stabilisation from unit vector measurements alone, without a gyro";
    static constexpr auto reference =
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Eqs. (4.7), (4.9), "
        "(4.25)-(4.26)";

    Directions<T> directions_B{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {0.6, 0.8, 0.0}};
    Directions<T> directions_N{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
    Weights<T> weights{1.0, 1.0, 1.0};
    Quat<T> q_RN{1.0, 0.0, 0.0, 0.0};
    T k_p = 0.03, k_z = 0.6;
    Mat3<T> A_m{{-3.0, 0.0, 0.0}, {0.0, -10.0, 0.0}, {0.0, 0.0, -5.0}};
    Mat3<T> B{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    Mat3<T> Q{{10.5, 0.0, 0.0}, {0.0, 10.5, 0.0}, {0.0, 0.0, 10.5}};
    bool filter_at_rest = true;
    Vec3<T> z_0{0.0, 0.0, 0.0};
    Mat3<T> P{{1.75, 0.0, 0.0}, {0.0, 0.525, 0.0}, {0.0, 0.0, 1.05}};
    Vec3<T> z_start{0.0, 0.0, 0.0};
    Vec3<T> z_moved{0.0, 0.0, 0.0}, zDot_moved{0.0, 0.0, 0.0};
    Vec3<T> torque_B{0.0, 0.0, 0.0}, Omega_B{0.0, 0.0, 0.0}, z{0.0, 0.0, 0.0}, zDot{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("directions_B", directions_B, unit::one, "y_j, unit vectors measured in B, a row for each")
            .unit_vectors();
        v.parameter("directions_N", directions_N, unit::one, "x_j, the same directions in N").fixed().directions();
        v.parameter("weights", weights, unit::one, "k_j; 0: the vector does not count").at_least(0);
        v.parameter("q_RN", q_RN, unit::one, "attitude to come to rest at, R relative to N").unit_quaternion();
        v.parameter("k_p", k_p, unit::N_m, "attitude gain").above(0);
        v.parameter("k_z", k_z, unit::kg_m2, "damping gain").above(0);
        v.parameter("A_m", A_m, unit::one_per_s, "filter matrix; its eigenvalues have negative real parts").fixed();
        v.parameter("B", B, unit::one_per_s, "filter input matrix, invertible").fixed();
        v.parameter("Q", Q, unit::one_per_s, "how V decreases").fixed().positive_definite();
        v.parameter("filter_at_rest", filter_at_rest, "zDot(0) = 0, from the first measurement; else z(0) = z_0")
            .fixed();
        v.parameter("z_0", z_0, unit::one, "filter state at the start without filter_at_rest").fixed();
        v.sampled(once);
        v.held("P", P, unit::one, "solution of the Lyapunov equation");
        v.held("z_start", z_start, unit::one, "z(0)");
        v.state("z_moved", z_moved, zDot_moved, unit::one, "z - z(0)");
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
        v.output("Omega_B", Omega_B, unit::one, "attitude error that the measurements show, in B");
        v.output("z", z, unit::one, "filter state");
        v.output("zDot", zDot, unit::one_per_s, "time derivative of z, which stands for the angular velocity");
    }

    void sample(const Sample& /*s*/) {
        P = lyapunov(A_m, Q);
        z_start = z_0;
        if (filter_at_rest) z_start = -A_m.inverse() * (B * error(seen(dcm(q_RN), directions_N)));
    }

    void outputs() {
        const Directions<T> y_r = seen(dcm(q_RN), directions_N);
        const Mat3<T> ME = profile(weights, directions_B, y_r);
        const Mat3<T> M_tilde = -0.5 * (ME - ME.trace() * Mat3<T>::Identity());
        Omega_B = error(y_r);
        z = z_start + z_moved;
        zDot = A_m * z + B * Omega_B;
        const Mat3<T> M_tilde_T = M_tilde.transpose(), B_T = B.transpose();
        const Vec3<T> zeta = B_T * (P * zDot);  // (4.26b)
        torque_B = -k_p * Omega_B - k_z * (M_tilde_T * zeta);
    }

    void derivatives() { zDot_moved = zDot; }

    void validate(Words& refuse) const {
        if (!hurwitz(A_m)) refuse("A_m is not Hurwitz: all its eigenvalues must have negative real parts");
        const double size = B.norm();
        if (!(abs(B.determinant()) > 1e-9 * size * size * size))
            refuse("B is singular: it must be invertible, and its determinant is %g", B.determinant());
        refuse_blindness(directions_N, weights, refuse);
    }

private:
    Vec3<T> error(const Directions<T>& y_r) const { return 0.5 * cross_sum(weights, directions_B, y_r); }
};

}  // namespace adcs

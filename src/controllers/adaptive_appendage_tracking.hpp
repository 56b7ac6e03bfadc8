/// # Adaptive attitude tracking with moving appendages
///
/// Two point masses $m_1$, $m_2$, unknown, move on known paths $\rho_1(t)$, $\rho_2(t)$, so that the inertia is
/// $J = J_0 - J_1\Psi$ with, Eq. (3.9),
///
/// $$J_1 = -\left[m_1 I\quad m_2 I\right], \qquad
///   \Psi = \begin{bmatrix} M_1 \\ M_2 \end{bmatrix}, \qquad M_i = \rho_i^T\rho_i\,I - \rho_i\rho_i^T$$
///
/// This law estimates the six elements $\theta$ of $J_0$ and the two masses $\sigma = [m_1\ m_2]^T$, the minimal
/// parametrisation of $J_1$. AdaptiveAppendageTrackingFull estimates all 18 elements of $J_1$. Eqs. (3.20)-(3.22):
///
/// $$\tau = -\beta\,q_{e,v} - k_v\,\omega_e - W_1\hat\theta - (W_2 + W_3)\hat\sigma$$
/// $$W_1\theta = J_0 a - \omega\times J_0\omega, \qquad W_2\sigma = -J_1\Psi a + \omega\times J_1\Psi\omega, \qquad
///   W_3\sigma = J_1\dot\Psi\,\Omega$$
/// $$\dot{\hat\theta} = \gamma_1\,\mathrm{Proj}(\hat\theta,\; W_1^T s), \qquad
///   \dot{\hat\sigma} = \gamma_2\,\mathrm{Proj}(\hat\sigma,\; (W_2 + W_3)^T s)$$
///
/// with $s = \omega_e + q_{e,v}$, $\Omega = \omega - \tfrac12 s$,
/// $a = \tfrac12[q_{e0}I + S(q_{e,v})]\,\omega_e + \phi$ and
/// $\phi = \omega_e\times C(q_e)\omega_r - C(q_e)\dot\omega_r$. The projection, Eqs. (3.26)-(3.31), keeps
/// $\lVert\hat\theta\rVert^2 < \varepsilon_1 + \delta_1$ and $\lVert\hat\sigma\rVert^2 < \varepsilon_2 + \delta_2$; the
/// default bounds are so large that it never acts, as in Sec. 3.4.1. Along the closed loop
///
/// $$V = \tfrac12 s^T J s + (\beta + k_v)\left[q_{e,v}^T q_{e,v} + (q_{e0} - 1)^2\right] +
///   \tfrac{1}{2\gamma_1}\lVert\hat\theta - \theta\rVert^2 + \tfrac{1}{2\gamma_2}\lVert\hat\sigma - \sigma\rVert^2$$
/// $$\dot V = -k_v\,\lVert\omega_e\rVert^2 - \beta\,\lVert q_{e,v}\rVert^2$$
///
/// and with the projection $\dot V$ is at most that.
///
/// **Sign.** What AdaptiveTracking says of $q_e$ and $-q_e$, and of `short_way`, holds here too.
#pragma once

#include "controllers/appendage_compensation.hpp"

namespace adcs {

template <class T>
struct AdaptiveAppendageTracking : AppendageCompensation<T> {
    static constexpr auto summary = "Adaptive attitude tracking with two moving masses, which it estimates";

    Eigen::Matrix<T, 2, 1> mass_est{0.0, 0.0}, mass_estDot{0.0, 0.0};

    template <class V>
    void declare(V& v) {
        this->declare_compensation(v);
        v.state("mass_est", mass_est, mass_estDot, unit::kg, "estimate of the two masses");
    }

    void outputs() { this->command(J_1_est()); }

    void derivatives() {
        const TrackingError<T> e = this->tracking_error();
        this->adapt(e);
        const auto G = this->variable_part(e).gradient();  // by J_1; the masses are in the diagonals of its blocks
        const Eigen::Matrix<T, 2, 1> Gamma{-G.template leftCols<3>().trace(), -G.template rightCols<3>().trace()};
        mass_estDot = this->update(mass_est, Gamma, this->gamma_2, this->sigma_bound, this->sigma_margin);
    }

    void validate(Words& refuse) const { this->refuse_starts(mass_est, this->sigma_bound, this->sigma_margin, refuse); }

private:
    typename AppendageCompensation<T>::Variable::Parameters J_1_est() const {
        typename AppendageCompensation<T>::Variable::Parameters J_1;
        J_1 << -mass_est[0] * Mat3<T>::Identity(), -mass_est[1] * Mat3<T>::Identity();
        return J_1;
    }
};

}  // namespace adcs

"""The gyro-free law with deliberate mistakes. Nearly all of them still converge from the start of the text."""

from dataclasses import replace

import numpy as np

from references.gyro_free import Control, Gains, gyro_free, m_tilde, omega_error
from references.observer_pd import Array


def _with(g: Gains, y: Array, y_r: Array, z: Array, m: Array) -> tuple[Array, Array]:
    """The law with another matrix in place of the transpose of M tilde."""
    _, z_dot = gyro_free(g, y, y_r, z)
    zeta = g.b.T @ g.p @ z_dot
    return -g.k_p * omega_error(g.k, y, y_r) - g.k_z * m @ zeta, z_dot


def not_transposed(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """M tilde for its transpose; the same as y_r y^T for y y_r^T in ME."""
    return _with(g, y, y_r, z, m_tilde(g.k, y, y_r))


def without_trace(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """-ME/2 for M tilde."""
    m = m_tilde(g.k, y, y_r)  # its trace is that of ME
    return _with(g, y, y_r, z, (m - m.trace() / 2 * np.eye(3)).T)


def filter_sign(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """z' = Am z - B Omega."""
    z_dot = g.a_m @ z - g.b @ omega_error(g.k, y, y_r)
    zeta = g.b.T @ g.p @ z_dot
    return -g.k_p * omega_error(g.k, y, y_r) - g.k_z * m_tilde(g.k, y, y_r).T @ zeta, z_dot


def not_differentiated(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """zeta = B^T P z."""
    _, z_dot = gyro_free(g, y, y_r, z)
    zeta = g.b.T @ g.p @ z
    return -g.k_p * omega_error(g.k, y, y_r) - g.k_z * m_tilde(g.k, y, y_r).T @ zeta, z_dot


def damping_sign(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """u = -kp Omega + kz M^T zeta."""
    return gyro_free(replace(g, k_z=-g.k_z), y, y_r, z)


def attitude_sign(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """u = +kp Omega - kz M^T zeta."""
    return gyro_free(replace(g, k_p=-g.k_p), y, y_r, z)


def other_factor(g: Gains, y: Array, y_r: Array, z: Array) -> tuple[Array, Array]:
    """M tilde without its factor 1/2."""
    return _with(g, y, y_r, z, 2 * m_tilde(g.k, y, y_r).T)


MUTANTS: dict[str, Control] = {
    "M for its transpose": not_transposed,
    "M without the trace": without_trace,
    "sign of Omega in the filter": filter_sign,
    "z for its derivative": not_differentiated,
    "sign of the damping": damping_sign,
    "sign of the attitude term": attitude_sign,
    "factor 1/2 of M": other_factor,
}

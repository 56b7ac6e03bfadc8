"""PD attitude tracking, Eq. (5.1), in plain Python: quaternions scalar first, matrices as rows."""


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def times(matrix, vector):
    return [sum(m * v for m, v in zip(row, vector, strict=True)) for row in matrix]


def relative(q, r):
    """q_BR with C(q_BR) = C(q_BN) C(q_RN)^T."""
    turn = cross(q[1:], r[1:])
    return [
        sum(a * b for a, b in zip(q, r, strict=True)),
        *(r[0] * q[i + 1] - q[0] * r[i + 1] + turn[i] for i in range(3)),
    ]


def dcm(q):
    a, x, y, z = q
    return [
        [a * a + x * x - y * y - z * z, 2 * (x * y + a * z), 2 * (x * z - a * y)],
        [2 * (x * y - a * z), a * a - x * x + y * y - z * z, 2 * (y * z + a * x)],
        [2 * (x * z + a * y), 2 * (y * z - a * x), a * a - x * x - y * y + z * z],
    ]


def pd(q_BN, omega_BN_B, q_RN, omega_RN_R, omegaDot_RN_R, J_B, k_p, k_v):
    """Return the torque, q_BR and omega_BR_B."""
    q_BR = relative(q_BN, q_RN)
    C = dcm(q_BR)
    reference = times(C, omega_RN_R)
    omega_BR_B = [a - b for a, b in zip(omega_BN_B, reference, strict=True)]
    feed_forward = times(J_B, times(C, omegaDot_RN_R))
    gyroscopic = cross(reference, times(J_B, reference))
    torque = [-k_p * q_BR[i + 1] - k_v * omega_BR_B[i] + feed_forward[i] + gyroscopic[i] for i in range(3)]
    return torque, q_BR, omega_BR_B

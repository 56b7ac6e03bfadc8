"""What `adcs new` writes to begin with: a small law of each kind, and the same law once more for its test."""

from __future__ import annotations

from dataclasses import dataclass

from fmus.catalog import Kind


@dataclass(frozen=True)
class Beginning:
    """A law of a kind."""

    summary: str
    equation: str
    """As LaTeX."""
    struct: str
    """Variables, declare() and functions, as they stand in the struct."""
    test: str
    """Python that gives it values, runs it for a second, and compares."""


BEGINNINGS: dict[Kind, Beginning] = {
    "guidance": Beginning(
        "Reference attitude that turns about a fixed axis",
        r"q_{RN} = \begin{bmatrix} \cos\tfrac12 r t \\ a \sin\tfrac12 r t \end{bmatrix}, \qquad \omega_{RN} = r\,a",
        """\
    T time = 0.0;
    T rate = 0.01;
    Vec3<T> axis{0.0, 0.0, 1.0};
    Quat<T> q_RN{1.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_RN_R{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.time(time);
        v.parameter("rate", rate, unit::rad_per_s, "r, angular velocity about the axis").fixed();
        v.parameter("axis", axis, unit::one, "a, unit vector, the same in R and in N").fixed().unit_vectors();
        v.output("q_RN", q_RN, unit::one, "attitude of R relative to N").unit_quaternion();
        v.output("omega_RN_R", omega_RN_R, unit::rad_per_s, "angular velocity of R relative to N, in R").nominal(0.1);
    }

    void outputs() {
        const auto [s, c] = sincos(0.5 * rate * time);
        q_RN = Quat<T>{c, s * axis[0], s * axis[1], s * axis[2]};
        omega_RN_R = rate * axis;
    }
""",
        """\
    rate, axis = 0.2, np.array([0.6, 0.0, 0.8])
    result = run({"rate": rate, "axis": axis})
    half = 0.5 * rate * 1.0  # after a second
    np.testing.assert_allclose(result["law.q_RN"][-1], [np.cos(half), *(np.sin(half) * axis)], atol=1e-15)
    np.testing.assert_allclose(result["law.omega_RN_R"][-1], rate * axis, rtol=1e-15)
""",
    ),
    "plant": Beginning(
        "Rotation of a rigid body under a torque",
        r"\dot q_{BN} = \tfrac12 \begin{bmatrix} -q_v^T \\ q_0 I + S(q_v) \end{bmatrix} \omega, \qquad "
        r"J\dot\omega = \tau - \omega\times J\omega",
        """\
    Vec3<T> torque_B{0.0, 0.0, 0.0};
    Mat3<T> J_B{{10.0, 0.0, 0.0}, {0.0, 19.0, 0.0}, {0.0, 0.0, 25.0}};
    Quat<T> q_BN{1.0, 0.0, 0.0, 0.0}, qDot_BN{0.0, 0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0}, omegaDot_BN_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("torque_B", torque_B, unit::N_m, "torque on the body, in B");
        v.parameter("J_B", J_B, unit::kg_m2, "inertia about the centre of mass, in B").inertia();
        v.state("q_BN", q_BN, qDot_BN, unit::one, "attitude of B relative to N").unit_quaternion();
        v.state("omega_BN_B", omega_BN_B, omegaDot_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B")
            .nominal(0.1);
    }

    void derivatives() {
        const Vec3<T> H_B = J_B * omega_BN_B;
        qDot_BN = kinematics(q_BN, omega_BN_B);
        omegaDot_BN_B = J_B.inverse() * (torque_B - omega_BN_B.cross(H_B));
    }
""",
        """\
    torque, inertia = 2.0, 20.0  # about the third axis, from rest
    result = run({"torque_B": [0.0, 0.0, torque], "J_B": np.diag([10.0, 15.0, inertia])})
    half = 0.5 * (0.5 * torque / inertia * 1.0**2)  # of the angle after a second
    np.testing.assert_allclose(result["law.omega_BN_B"][-1], [0.0, 0.0, torque / inertia * 1.0], atol=1e-12)
    np.testing.assert_allclose(result["law.q_BN"][-1], [np.cos(half), 0.0, 0.0, np.sin(half)], atol=1e-9)
""",
    ),
    "environment": Beginning(
        "Torque of a force that acts beside the centre of mass",
        r"\tau = r\times F",
        """\
    Vec3<T> force_B{0.0, 0.0, 0.0};
    Vec3<T> arm_B{0.1, 0.0, 0.0};
    Vec3<T> torque_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("force_B", force_B, unit::N, "F, force on the body, in B").nominal(1e-3);
        v.parameter("arm_B", arm_B, unit::m, "r, from the centre of mass to where the force acts, in B").nominal(0.1);
        v.output("torque_B", torque_B, unit::N_m, "disturbance torque, in B").nominal(1e-4);
    }

    void outputs() { torque_B = arm_B.cross(force_B); }
""",
        """\
    force_B, arm_B = np.array([1e-3, -2e-3, 3e-3]), np.array([0.1, 0.2, -0.3])
    result = run({"force_B": force_B, "arm_B": arm_B})
    np.testing.assert_allclose(result["law.torque_B"][-1], np.cross(arm_B, force_B), atol=1e-18)
""",
    ),
    "sensor": Beginning(
        "Measured angular velocity with a bias",
        r"\omega_{meas} = \omega + b",
        """\
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    Vec3<T> bias{0.0, 0.0, 0.0};
    Vec3<T> omega_BN_B_meas{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.1);
        v.parameter("bias", bias, unit::rad_per_s, "b, constant error, in B").nominal(1e-3);
        v.output("omega_BN_B_meas", omega_BN_B_meas, unit::rad_per_s, "measured angular velocity, in B").nominal(0.1);
    }

    void outputs() { omega_BN_B_meas = omega_BN_B + bias; }
""",
        """\
    omega_BN_B, bias = np.array([0.1, -0.2, 0.3]), np.array([1e-3, 2e-3, -3e-3])
    result = run({"omega_BN_B": omega_BN_B, "bias": bias})
    np.testing.assert_allclose(result["law.omega_BN_B_meas"][-1], omega_BN_B + bias, rtol=1e-15)
""",
    ),
    "observer": Beginning(
        "Low-pass filter of a measured angular velocity",
        r"\dot{\hat\omega} = \frac{1}{t_f}\,(\omega_{meas} - \hat\omega)",
        """\
    Vec3<T> omega_BN_B_meas{0.0, 0.0, 0.0};
    T time_constant = 1.0;
    Vec3<T> omega_BN_B_est{0.0, 0.0, 0.0}, omegaDot_BN_B_est{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("omega_BN_B_meas", omega_BN_B_meas, unit::rad_per_s, "measured angular velocity, in B").nominal(0.1);
        v.parameter("time_constant", time_constant, unit::s, "t_f, time constant of the filter").above(0);
        v.state("omega_BN_B_est", omega_BN_B_est, omegaDot_BN_B_est, unit::rad_per_s, "estimate of omega_BN_B, in B")
            .nominal(0.1);
    }

    void derivatives() { omegaDot_BN_B_est = (omega_BN_B_meas - omega_BN_B_est) / time_constant; }
""",
        """\
    omega_BN_B, time_constant = np.array([0.1, -0.2, 0.3]), 0.5
    result = run({"omega_BN_B_meas": omega_BN_B, "time_constant": time_constant})
    expected = omega_BN_B * (1.0 - np.exp(-1.0 / time_constant))  # a second after a step from 0
    np.testing.assert_allclose(result["law.omega_BN_B_est"][-1], expected, rtol=1e-8)
""",
    ),
    "controller": Beginning(
        "Torque against the angular velocity",
        r"\tau = -k\,\omega",
        """\
    Vec3<T> omega_BN_B{0.0, 0.0, 0.0};
    T k = 1.0;
    Vec3<T> torque_B{0.0, 0.0, 0.0};

    template <class V>
    void declare(V& v) {
        v.input("omega_BN_B", omega_BN_B, unit::rad_per_s, "angular velocity of B relative to N, in B").nominal(0.1);
        v.parameter("k", k, unit::N_m_s, "gain").above(0);
        v.output("torque_B", torque_B, unit::N_m, "commanded torque, in B");
    }

    void outputs() { torque_B = -k * omega_BN_B; }
""",
        """\
    omega_BN_B, k = np.array([0.1, -0.2, 0.3]), 2.0
    result = run({"omega_BN_B": omega_BN_B, "k": k})
    np.testing.assert_allclose(result["law.torque_B"][-1], -k * omega_BN_B, rtol=1e-15)
""",
    ),
}

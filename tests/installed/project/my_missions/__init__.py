"""Systems of somebody else's package."""

from adcs import System


def spinning() -> System:
    """Return a body that spins about the axis of its largest moment of inertia."""
    system = System("spinning", "a body that spins", stop_time="10s", step="10ms")
    still = {"torque_B": [0, 0, 0], "torque_disturbance_B": [0, 0, 0]}
    system.add("plant", "RigidBody", {"omega_BN_B": [0, 0, 0.5], **still})
    return system

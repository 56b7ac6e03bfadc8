"""A system of one's own, with a component of one's own in it."""

from adcs import System


def detumble() -> System:
    """Return a tumbling body and a rate damper, `rate_law.hpp` in the same folder."""
    system = System("detumble", "a tumbling body and a rate damper", stop_time="60s", step="10ms")
    system.add("plant", "RigidBody", {"omega_BN_B": [0.1, -0.2, 0.15], "torque_disturbance_B": [0, 0, 0]})
    system.add("law", "rate_law.hpp", {"k": 2.0})
    system.connect("plant.omega_BN_B", "law.omega_BN_B")
    system.connect("law.torque_B", "plant.torque_B")
    return system

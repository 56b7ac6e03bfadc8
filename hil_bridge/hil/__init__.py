"""Hardware in the loop: an autopilot outside flies the simulated spacecraft, over TCP as PX4 does it."""

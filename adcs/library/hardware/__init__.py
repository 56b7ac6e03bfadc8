"""A spacecraft whose torque comes from outside: from an autopilot, a table or a person."""

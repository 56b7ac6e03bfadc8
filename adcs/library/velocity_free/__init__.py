"""Velocity-free passivity-based attitude tracking under measurement errors, disturbances and inertia mismatch."""

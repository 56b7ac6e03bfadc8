"""de Ruiter, observer-based adaptive attitude control with guaranteed performance bounds."""

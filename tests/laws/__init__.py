"""The control laws recomputed from the published equations, independently of the C++ components."""

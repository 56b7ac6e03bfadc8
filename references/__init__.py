"""The control laws recomputed from the published equations, independently of the C++ components: they import nothing of
this project."""

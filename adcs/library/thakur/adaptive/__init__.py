"""Chapter 3: adaptive tracking while the inertia changes."""

"""Linear state spaces of components and systems."""

"""The lock on a file, by which the builder of FMUs keeps others out, too."""

from fmus.lock import Lock

__all__ = ["Lock"]

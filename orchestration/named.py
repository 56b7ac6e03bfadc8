"""A system, or what it is called: what stands for a name is told by who knows it, as `import adcs` does."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from orchestration.system import System, check_system
from orchestration.times import Seconds

Finder = Callable[[str, Seconds | None], System]
"""Returns the system of this name, or in this file, which is to be run in exchange steps of so much, if given."""

_finders: list[Finder] = []


def find_by(finder: Finder) -> None:
    """Let names of systems be looked up so."""
    _finders[:] = [finder]


def as_system(system: System | str | Path, step: Seconds | None = None) -> System:
    """Return the system itself, or the one of this name; AdcsError if it is neither."""
    if isinstance(system, str | Path):
        for find in _finders:
            return find(str(system), step)
    check_system(system)
    assert isinstance(system, System)
    return system

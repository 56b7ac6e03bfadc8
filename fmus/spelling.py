"""What was perhaps meant by a name that nothing has."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_READ = 200  # characters of a name; longer ones are no slips
_NAMED = 6


def close(name: str, known: Iterable[str], likeness: float = 0.5) -> str:
    """Return the names most like it, best first, as in `a or b or c`; empty if there are none."""
    return " or ".join(alike(name, known, likeness))


def alike(name: str, known: Iterable[str], likeness: float = 0.5) -> list[str]:
    """Return the names most like it, best first, three at most.

    Names that go on after it come before those that are only like it.
    """
    names = list(known)
    longer = [other for other in names if name and other.startswith(name)]
    return list(dict.fromkeys([*longer, *get_close_matches(name[:_READ], names, 3, likeness)]))[:3]


def hint(name: str, known: Iterable[str], there: str = "it has") -> str:
    """Return `did you mean a or b?`, or some of what there is, as in `it has a, b, c and 7 more`."""
    names = list(known)
    if meant := close(name, names):
        return f"did you mean {meant}?"
    return f"{there} {some(names)}"


def some(names: Iterable[object]) -> str:
    """Write the first names, and how many more there are."""
    words = [str(name) for name in names]
    more = len(words) - _NAMED
    return f"{', '.join(words[:_NAMED])} and {more} more" if more > 1 else ", ".join(words) or "none"

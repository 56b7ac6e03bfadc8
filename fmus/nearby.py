"""What was perhaps meant by the path of a file that is not there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from fmus.errors import AdcsError
from fmus.spelling import alike

_LIKE = 0.6  # of two names without their suffixes, which would make all files of a kind alike


def instead(path: str | Path) -> str:
    """Return `: did you mean laws/my_law.hpp?`; empty if the path is there, or nothing is like it."""
    wanted, found = Path(path), []
    with suppress(OSError, ValueError):  # a folder that may not be read, a name that none can have
        found = [] if wanted.exists() else list(_near(wanted))
    return f": did you mean {' or '.join(map(str, found))}?" if found else ""


def not_opened(path: str | Path, error: OSError) -> AdcsError:
    """Return the refusal of a file that cannot be opened, for this reason of the system's."""
    return AdcsError(f"cannot open {path}: {error.strerror or error}{instead(path)}")


def _near(wanted: Path) -> Iterator[Path]:
    """Yield paths that exist, the likest first: of the same kind, then of the same name and another kind."""
    missing = next(part for part in reversed((wanted, *wanted.parents)) if not part.exists())
    rest = wanted.relative_to(missing)  # where a folder is not there
    there = [
        each for each in sorted(missing.parent.iterdir()) if not each.name.startswith(".") and (each / rest).exists()
    ]
    stems = {each.stem: each for each in there if each.suffix.lower() == missing.suffix.lower()}
    likest = [stems[stem] for stem in alike(missing.stem, stems, _LIKE)]
    others = [each for each in there if each.stem.lower() == missing.stem.lower() and each not in likest]
    yield from (each / rest for each in [*likest, *others][:3])

"""Files that are read again by another process say what they are, and in which version: `adcs-checkpoint-1`."""

from __future__ import annotations

import re
from pathlib import Path

from fmus.errors import AdcsError, shown


def refuse_other_version(path: Path, kind: str, said: object, ours: str, way_out: str) -> None:
    """AdcsError if a file is of a kind that this program reads, but of another version than `ours`.

    What is of no such kind passes: the reader knows better what to say of that.
    """
    family = ours.rpartition("-")[0]
    if isinstance(said, str) and said != ours and re.fullmatch(rf"{family}-\d+", said):
        raise AdcsError(f"{path} is {kind} of another version, {shown(said)}: this program reads {ours}; {way_out}")

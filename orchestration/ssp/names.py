"""How an `.ssp` file, or one of several system structures in it, is named; `orchestration.ssp` reads them."""

from __future__ import annotations

from pathlib import Path

from fmus.errors import AdcsError

STRUCTURE = "SystemStructure.ssd"
"""The system structure that every `.ssp` has, read where none is named."""


def named_structure(name: str | Path) -> tuple[Path, str | None]:
    """Split `theirs.ssp#Variant.ssd` into the path and the name of the system structure, None where there is none.

    So SSP itself names one of several system structures of a file.
    """
    text = str(name)
    path, mark, structure = text.rpartition(".ssp#")
    if mark and not text.endswith(".ssp"):
        return Path(f"{path}.ssp"), structure or None
    if Path(name).suffix == ".ssd":
        raise AdcsError(
            f"{name} is a system structure by itself: pack it as {STRUCTURE} into an .ssp (a zip archive), with all "
            "that it names"
        )
    return Path(name), None


def is_ssp(name: str | Path) -> bool:
    """Whether this names an `.ssp` file, or a system structure in one; AdcsError if it is one outside of any."""
    return named_structure(name)[0].suffix == ".ssp"

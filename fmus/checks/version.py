"""Which version of FMI an FMU is of: whether it can be run here."""

from collections.abc import Iterator

from fmus.checks import Note
from fmus.versions import major_version, newer_minor


def check_version(text: str) -> Iterator[str]:
    """A version that is refused, and one that is read as an older one."""
    try:
        major_version(text)
    except ValueError as error:
        yield f"fmiVersion: it {error}"
    if (newer := newer_minor(text)) is not None:
        yield Note(f"fmiVersion: it {newer}")

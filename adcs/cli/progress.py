"""Progress on the standard error, where someone may look at it."""

from __future__ import annotations

from rich.console import Console
from rich.progress import Progress, ProgressColumn


def progress(*columns: ProgressColumn, quiet: bool = False) -> Progress:
    """Return what shows progress in these columns on a terminal; elsewhere not even an empty line is left of it."""
    console = Console(stderr=True)
    return Progress(*columns, console=console, transient=True, disable=quiet or not console.is_terminal)

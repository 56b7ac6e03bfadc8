"""`adcs open`: the report of a run in the browser, where there is a desktop."""

from __future__ import annotations

import os
import sys
import webbrowser
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from adcs.cli.command import command
from fmus.errors import AdcsError
from fmus.nearby import instead

_PAGE = "report.html"

app = command("open", "adcs open", "adcs open results/observer-pd", takes="[FOLDER]")


@app.default
def open_command(
    folder: Annotated[Path | None, Parameter(help="Folder of the results; the newest one if left out.")] = None, /
) -> None:
    """Say which page shows a run, and open it in the browser where there is a desktop."""
    page = _newest() if folder is None else folder / _PAGE
    if not page.is_file():
        raise AdcsError(f"{page} does not exist{instead(page)}: give the folder of a run's results")
    shown = has_desktop(os.environ, sys.platform) and webbrowser.open(page.resolve().as_uri())
    text = f"{page} is opened in the browser" if shown else f"open {page} in a browser"
    Console().print(text, markup=False, highlight=False, soft_wrap=True)


def has_desktop(environment: Mapping[str, str], platform: str) -> bool:
    """Whether someone may look at a window, which nobody does at one of a continuous integration."""
    if environment.get("CI"):
        return False
    return platform in ("darwin", "win32") or any(environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _newest() -> Path:
    pages = list(Path("results").glob(f"*/{_PAGE}"))
    if not pages:
        raise AdcsError(f"there is no results/*/{_PAGE} here: run a system first, as by `adcs run observer-pd`")
    return max(pages, key=lambda page: page.stat().st_mtime)

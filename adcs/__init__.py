"""Spacecraft attitude control as native FMI components, orchestrated by fmpy.

`import adcs` is all that a program needs: it builds and checks components, wires them into systems, runs those. What is
here is listed in `__init__.pyi`, once for type checkers and for the loading of each name when it is first used: so the
import costs nothing.
"""

from __future__ import annotations

import ast
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


@cache
def _homes() -> dict[str, str]:
    """Each name, and the module that has it."""
    listed = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    return {
        alias.name: node.module
        for node in listed
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }


def __getattr__(name: str) -> Any:
    if name not in _homes():
        from fmus.spelling import close

        meant = close(name, _homes(), 0.8)
        raise AttributeError(f"adcs has no {name!r}; {f'did you mean {meant}?' if meant else 'dir(adcs) shows all'}")
    globals()[name] = found = getattr(import_module(_homes()[name]), name)
    return found


def __dir__() -> list[str]:
    return list(_homes())

"""A result in a line, and as a small table for a notebook."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestration.fmu.typed_values import item_name

if TYPE_CHECKING:
    from orchestration.fmu.file import Port
    from orchestration.plan.lowering import Floats
    from orchestration.results.result import Result

_NAMES = 4  # in a line
_ROWS = 50  # of the table
_VALUES = 9  # in a cell
# Colours are those of the notebook, whether it is light or dark.
_CELL = 'style="text-align:left;white-space:nowrap;padding:2px 8px"'


def text(result: Result) -> str:
    """Return what was run, how far, what was recorded and how it ended."""
    names = list(result)
    more = f" and {len(names) - _NAMES} more" if len(names) > _NAMES else ""
    recorded = f"{', '.join(names[:_NAMES])}{more}" if names else "no variables"
    return f"<Result of {_name(result)}: {_rows(result)}; {recorded}; {_outcome(result)}>"


def html(result: Result) -> str:
    """Return a table of the variables, with their last values."""
    names = list(result)
    last = result.block(len(result.time) - 1, len(result.time))[0] if len(result.time) else None
    head = ["variable", "unit", "shape", f"at {result.time[-1]:g} s" if last is not None else "value"]
    lines = [_line("th", head)]
    first = 0
    for name in names[:_ROWS]:
        port = result.ports[name]
        value = "" if last is None else _value(port, last[first : first + port.size])
        lines.append(_line("td", [name, port.unit or "", " x ".join(map(str, port.shape)), value]))
        first += port.size
    if len(names) > _ROWS:
        lines.append(_line("td", [f"and {len(names) - _ROWS} more"]))
    about = f"<b>{escape(_name(result))}</b>: {escape(_rows(result))}; {escape(_outcome(result))}"
    return f'<div style="overflow-x:auto"><p>{about}</p><table>{"".join(lines)}</table></div>'


def _name(result: Result) -> str:
    return str(result.manifest.get("system", {}).get("name", "a system"))


def _rows(result: Result) -> str:
    n = len(result.time)
    return f"{n} row{'s' if n != 1 else ''}" + (f", {result.time[0]:g} to {result.time[-1]:g} s" if n else "")


def _outcome(result: Result) -> str:
    """Return how the run ended, as its manifest has it."""
    outcome: dict[str, Any] = result.manifest.get("outcome", {})
    told = str(outcome.get("status", "outcome unknown"))
    if "met" in outcome:
        told += f", {outcome['met']['condition']} at {outcome['met']['time']:g} s"
    end = outcome.get("ended") or outcome
    if end.get("component"):
        told += f", {'ended by ' if 'ended' in outcome else ''}{end['component']}"
    if end.get("time") is not None:
        told += f" at {end['time']:g} s"
    return told + (f": {end['message']}" if end.get("message") else "")


def _value(port: Port, numbers: Floats) -> str:
    shown = [_number(port, number) for number in numbers[:_VALUES]]
    more = " …" if len(numbers) > _VALUES else ""
    return f"{' '.join(shown)}{more}"


def _number(port: Port, number: float) -> str:
    if port.type == "Boolean":
        return str(bool(number))
    if port.items:
        return item_name(port, number)
    return f"{number:.4g}" if port.type.startswith("Float") or not np.isfinite(number) else f"{number:.0f}"


def _line(kind: str, cells: list[str]) -> str:
    return f"<tr>{''.join(f'<{kind} {_CELL}>{escape(cell)}</{kind}>' for cell in cells)}</tr>"

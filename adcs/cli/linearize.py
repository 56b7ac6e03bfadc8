"""`adcs linearize`: a linear state space of a component or a system, its eigenvalues on the screen."""

from __future__ import annotations

import json as json_
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from adcs.cli.command import Time, command
from adcs.cli.options import StartValues, SystemName
from adcs.cli.words import full_name
from fmus.errors import AdcsError
from orchestration.system import System

if TYPE_CHECKING:
    from orchestration.linear.state_space import Mode, StateSpace

app = command(
    "linearize",
    "adcs linearize PdTracking --set k_v=5",
    "adcs linearize observer-pd --at 1min --minimal --out loop.mat",
    "adcs linearize full-state-pd --open plant.torque_B --inputs plant.torque_B",
)

_Names = Annotated[tuple[str, ...] | None, Parameter(metavar="NAMES")]


@app.default
def linearize(
    system: SystemName,
    /,
    which: StartValues = StartValues(),
    *,
    at: Time = 0.0,
    inputs: _Names = None,
    outputs: _Names = None,
    open_: Annotated[_Names, Parameter(name="--open")] = None,
    minimal: bool = False,
    out: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    force: bool = False,
    json: bool = False,
) -> None:
    """Linearise a component or a closed loop: matrices A, B, C, D, and eigenvalues with frequency and damping.

    Args:
        at: When: the system is run until then, as in 60s.
        inputs: Inputs, separated by commas. [default: all that are not connected]
        outputs: Outputs, separated by commas. [default: all]
        open_: Cut the connections into these inputs, for a loop gain.
        minimal: Count a unit quaternion as the three angles of a small rotation.
        out: Write all of it to a .mat or .json file.
        force: Replace the file if it is there already.
        json: Print all of it as JSON.
    """
    from orchestration.linear.linearization import linearize as linearize_
    from orchestration.process.writing import make_folder

    if out is not None and out.suffix not in (".mat", ".json"):
        raise AdcsError(f"--out {out}: give a name that ends in .mat or .json")
    if out is not None and out.is_dir():
        raise AdcsError(f"--out {out}: it is a folder: give the name of a file in it")
    if out is not None and out.is_file() and not force:
        raise AdcsError(f"--out {out} is there already: give another name, or --force to replace it")
    if out is not None:
        make_folder(out.parent, f"--out {out}")
    _, built = which.built(system)
    found = linearize_(
        built,
        at,
        inputs=_names(built, inputs),
        outputs=_names(built, outputs),
        open_at=_names(built, open_) or [],
        minimal_coordinates=minimal,
        fmi_version=which.fmi_version,
    )
    if out is not None:
        found.write(out)
    if json:
        print(json_.dumps(found.as_dict(), indent=2))
    else:
        _show(found, next(iter(built.components)) if len(built.components) == 1 else None, out)


def _names(system: System, texts: Sequence[str] | None) -> list[str] | None:
    """Split at commas, but not at those of `J_B[1,3]`."""
    if texts is None:
        return None
    words = [word.strip() for text in texts for word in re.split(r",(?![^\[]*\])", text)]
    names = [full_name(system, word) for word in words if word]
    for name in names:
        system.end(name)
    return names


def _show(found: StateSpace, alone: str | None, out: Path | None) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console()
    sizes = f"{len(found.states)} states, {len(found.inputs)} inputs, {len(found.outputs)} outputs"
    console.print(f"[bold]{escape(found.system)}[/bold] at t = {found.time:g} s: {sizes}", highlight=False)
    if found.states:
        rows = [_row(mode, 1e-9 * max(abs(found.eigenvalues)), alone) for mode in found.modes]
        table = Table()
        table.add_column(escape("eigenvalue [1/s]"), no_wrap=True)
        for column in ("frequency [rad/s]", "damping", "time constant [s]", "belongs to"):
            justify: Literal["left", "right"] = "left" if column == "belongs to" else "right"
            if justify == "right" or any(row[-1] for row in rows):
                table.add_column(escape(column), justify=justify)
        for row in rows:
            table.add_row(*row[: len(table.columns)])
        console.print(table)
    else:
        for line in _equations(found, alone):
            console.print(line, highlight=False, markup=False, soft_wrap=True)
    for note in found.notes:
        console.print(f"Note: {note}.", highlight=False, markup=False, soft_wrap=True)
    if out is not None:
        console.print(str(out), highlight=False, markup=False, soft_wrap=True)


def _row(mode: Mode, floor: float, alone: str | None) -> list[str]:
    """Write a mode in words; parts below the floor are rounding, and left out."""
    note = mode.note if alone is None else mode.note.replace(f"{alone}.", "")
    real, imaginary = (0.0 if abs(part) <= floor else part for part in (mode.eigenvalue.real, mode.eigenvalue.imag))
    if not (real or imaginary):
        return ["0", "0", "", "", note]
    value = f"{real:.5g}" + (f" ± {imaginary:.5g}i" if imaginary else "")
    damping = mode.damping if real else 0.0
    return [value, f"{mode.frequency:.5g}", f"{damping:.3g}", f"{mode.time_constant:.4g}" if real else "", note]


def _equations(found: StateSpace, alone: str | None) -> list[str]:
    """Write the rows of D of a system without states as equations between small changes."""
    lines = []
    for name, row in zip(found.outputs, found.D.tolist(), strict=True):
        floor = 1e-13 * max(map(abs, row), default=0.0)
        terms = [(v, u) for v, u in zip(row, found.inputs, strict=True) if abs(v) > floor]
        line = " ".join(f"{'-' if v < 0 else '+'} {abs(v):.5g} {u}" for v, u in terms).removeprefix("+ ") or "0"
        line = f"{name} = -{line[2:]}" if line.startswith("- ") else f"{name} = {line}"
        lines.append(line if alone is None else line.replace(f"{alone}.", ""))
    return lines

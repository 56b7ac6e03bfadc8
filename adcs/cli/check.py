"""`adcs check`: what is wrong with FMUs, and what a run refuses of them."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.markup import escape
from rich.table import Column, Table

from adcs.catalogue import fmus_meant
from adcs.cli.command import command
from adcs.cli.printing import ERR, OUT, Json, print_json
from fmus.built import all_built
from fmus.check import Finding
from orchestration.checking import check

app = command(
    "check",
    "adcs check",
    "adcs check RigidBody",
    "adcs check observer-pd",
    "adcs check path/to/some.fmu",
    "adcs check my_law.hpp laws",
    takes="[FMUS...]",
)


@app.default
def check_command(
    *fmus: Annotated[
        str,
        Parameter(
            help="Components, headers, systems, .fmu or .ssp files, or folders; all built components if left out."
        ),
    ],
    as_json: Json = False,
) -> None:
    """Check FMUs: standard, layout, binaries, what validators miss, and what a run refuses. Exit code 1 for faults.

    Of a system, each component is checked. A note is about what no standard forbids, but what some machine or tool
    cannot do with.
    """
    paths = [path for fmu in fmus for path in fmus_meant(fmu)] if fmus else all_built()
    findings: dict[Path, list[Finding]] = {}
    with ERR.status("checking ...") as status:
        for path in paths:
            status.update(f"checking {path.name}")
            findings[path] = check(path)
    if as_json:
        print_json([{"path": str(p), "findings": [asdict(f) for f in found]} for p, found in findings.items()])
    else:
        table = Table(Column("FMU", overflow="fold"), Column("Check", no_wrap=True), Column("Finding", overflow="fold"))
        for path, found in findings.items():
            if not any(finding.severity == "fault" for finding in found):
                table.add_row(escape(path.name), "", "[green]nothing wrong[/green]")
            for finding in found:
                rule = finding.rule if finding.severity == "fault" else f"{finding.rule} (note)"
                table.add_row(escape(path.name), rule, escape(finding.message))
        OUT.print(table)
    if any(finding.severity == "fault" for found in findings.values() for finding in found):
        sys.exit(1)

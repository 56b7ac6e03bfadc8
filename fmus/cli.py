"""The commands that concern FMUs: build, list, info, check."""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from fmus import catalog
from fmus.build import build, describe
from fmus.catalog import Component
from fmus.check import Finding, check
from fmus.describe import Variable
from fmus.errors import AdcsError
from fmus.freshness import warn_if_outdated
from fmus.pack import FILE_NAMES
from fmus.paths import DIST

app = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", help="Builds, lists and checks FMUs.")

_out = Console()
_err = Console(stderr=True)

Json = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]


@app.command("build")
def build_command(
    names: Annotated[list[str] | None, typer.Argument(help="Components; all if left out.", show_default=False)] = None,
    all_platforms: Annotated[bool, typer.Option(help="For Linux, Windows and macOS, not only this machine.")] = False,
    as_json: Json = False,
) -> None:
    """Build FMUs, for FMI 2.0 and 3.0; what is up to date stays.

    Examples: `adcs build` · `adcs build RigidBody PdTracking` · `adcs build --all-platforms`
    """
    columns = (TextColumn("{task.description:<44}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=_err, transient=True, disable=as_json) as bar:
        task = bar.add_task("compiling", total=None)

        def show(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what)

        built = build(names, all_platforms, show)
    if as_json:
        _print_json([{"path": str(path), "bytes": path.stat().st_size} for path in built])
        return
    table = Table("FMU", "Size", title=f"in {built[0].parent}", title_justify="left")
    for path in built:
        table.add_row(path.name, f"{path.stat().st_size / 1e3:.0f} kB")
    _out.print(table)


@app.command("list")
def list_command(as_json: Json = False) -> None:
    """List the components and the systems made of them.

    Examples: `adcs list` · `adcs list --json`
    """
    from studies.registry import SYSTEMS  # not at the top: only here do FMUs know of systems

    components = catalog.components()
    built = {c.name: {v: str(path) for v, path in _paths(c).items() if path.is_file()} for c in components}
    systems = [{"name": name, "description": system.description} for name, system in SYSTEMS.items()]
    if as_json:
        entries = [
            {"name": c.name, "kind": c.kind, "description": c.summary, "fmus": built[c.name]} for c in components
        ]
        _print_json({"components": entries, "systems": systems})
        return
    table = Table("Component", "Kind", "Description", "Built for FMI")
    for c in components:
        table.add_row(c.name, c.kind, c.summary, ", ".join(built[c.name]) or "[dim]not built[/dim]")
    _out.print(table)
    table = Table("System", "Description")
    for system in systems:
        table.add_row(system["name"], system["description"])
    _out.print(table)


@app.command("info")
def info_command(name: Annotated[str, typer.Argument(help="A component.")], as_json: Json = False) -> None:
    """Show a component's variables with units, start values and bounds, and which parameters can be tuned in a run.

    Examples: `adcs info RigidBody` · `adcs info RigidBody --json`
    """
    show_component(name, as_json)


def show_component(name: str, as_json: bool) -> None:
    """Print what a component declares, which the component itself is asked for; AdcsError if there is none."""
    component = catalog.find(name)
    for path in _paths(component).values():
        warn_if_outdated(name, path)
    with _err.status("asking the component ...") if not as_json else _err.capture():
        description = describe(name)
    if as_json:
        _print_json({"kind": component.kind, **asdict(description)})
        return
    _out.print(f"[bold]{description.name}[/bold] ({component.kind}): {description.description}")
    if description.reference:
        _out.print(f"[dim]{description.reference}[/dim]")
    table = Table()
    table.add_column("Variable", min_width=max(len(v.name) for v in description.variables))  # names are never cut
    for header in ("Causality", "Size", "Unit", "Start", "Bounds", "Description"):
        table.add_column(header)
    for v in description.variables:
        if v.causality != "independent":
            size = " x ".join(map(str, v.shape))
            causality = f"{v.causality}, tunable" if v.variability == "tunable" else v.causality
            table.add_row(v.name, causality, size, v.unit or "", _start(v), v.bounds, v.description)
    _out.print(table)


@app.command("check")
def check_command(
    fmus: Annotated[
        list[str] | None,
        typer.Argument(help="Components or paths of FMUs; all built components if left out.", show_default=False),
    ] = None,
    as_json: Json = False,
) -> None:
    """Check FMUs: standard, layout, binaries, and what validators miss. Exit code 1 if something is wrong.

    A note is about what no standard forbids, but what some machine or tool cannot do with.

    Examples: `adcs check` · `adcs check RigidBody` · `adcs check path/to/some.fmu`
    """
    show_findings(fmus or [], as_json, check)


def show_findings(fmus: Sequence[str], as_json: bool, check: Callable[[Path], list[Finding]]) -> None:
    """Print what `check` finds in components or files, all that are built if none is named; typer.Exit for faults."""
    paths = [path for fmu in fmus for path in _fmu_paths(fmu)] if fmus else _all_built()
    findings: dict[Path, list[Finding]] = {}
    with _err.status("checking ...") as status:
        for path in paths:
            status.update(f"checking {path.name}")
            findings[path] = check(path)
    if as_json:
        _print_json([{"path": str(p), "findings": [asdict(f) for f in found]} for p, found in findings.items()])
    else:
        table = Table(Column("FMU", overflow="fold"), Column("Check", no_wrap=True), Column("Finding", overflow="fold"))
        for path, found in findings.items():
            if not any(finding.severity == "fault" for finding in found):
                table.add_row(escape(path.name), "", "[green]nothing wrong[/green]")
            for finding in found:
                rule = finding.rule if finding.severity == "fault" else f"{finding.rule} (note)"
                table.add_row(escape(path.name), rule, escape(finding.message))
        _out.print(table)
    if any(finding.severity == "fault" for found in findings.values() for finding in found):
        raise typer.Exit(1)


def main() -> None:
    """Runs the commands of this file only; `adcs` has more."""
    try:
        app()
    except AdcsError as error:
        _err.print(f"[red]error:[/red] {error}", highlight=False, markup=True)
        sys.exit(1)


def _fmu_paths(name_or_path: str) -> list[Path]:
    if Path(name_or_path).suffix == ".fmu":
        if not Path(name_or_path).is_file():
            raise AdcsError(f"{name_or_path} is no file")
        return [Path(name_or_path)]
    return _existing(list(_paths(catalog.find(name_or_path)).values()))


def _all_built() -> list[Path]:
    return _existing([path for component in catalog.components() for path in _paths(component).values()])


def _paths(component: Component) -> dict[str, Path]:
    """FMI version -> where the FMU is if it is built."""
    return {version: DIST / pattern.format(component.name) for version, pattern in FILE_NAMES.items()}


def _existing(paths: list[Path]) -> list[Path]:
    existing = [path for path in paths if path.is_file()]
    if not existing:
        raise AdcsError(f"{paths[0].name} is not built: run: adcs build")
    return existing


def _start(v: Variable) -> str:
    return "" if v.start is None else " ".join(f"{x:g}" for x in v.start)


def _print_json(data: Any) -> None:
    print(json.dumps(data, indent=2))

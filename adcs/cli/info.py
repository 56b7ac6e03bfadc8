"""`adcs info`: what a component, an FMU of anyone's, or a system in a file has, as a table or as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

from cyclopts import Parameter

from adcs.catalogue import find_component, find_system, names_system
from adcs.cli.columns import say, show
from adcs.cli.command import at_work, command
from adcs.cli.printing import ERR, Json, print_json
from fmus.build import describe
from fmus.catalog import Component
from fmus.demand import fmu_path, ready_made
from fmus.toolchain import is_installed
from orchestration.fmu.file import Fmu, Port, open_fmu
from orchestration.ssp.names import is_ssp
from orchestration.system import System

app = command(
    "info", "adcs info RigidBody", "adcs info observer-pd", "adcs info path/to/some.fmu", "adcs info system.ssp --json"
)


@app.default
def info(
    name: Annotated[str, Parameter(help="A component, a system, or an .fmu, .ssp or .py file.")],
    /,
    *,
    as_json: Json = False,
) -> None:
    """Show the variables of a component or FMU with units and start values, or the components of a system."""
    path = (None if names_system(name) else ready_made(name)) or Path(name)
    if path.suffix == ".fmu":
        facts = _fmu(open_fmu(path))
    elif is_ssp(name):
        facts = _ssp(name)
    elif names_system(name):
        entry = find_system(name)
        facts = _parts(entry.build(), entry.start_time, entry.stop_time, entry.step)
    else:
        component = find_component(name)
        if is_installed() or not component.outside:
            _show_component(component, as_json)
            return
        facts = _fmu(open_fmu(fmu_path(component.source)))  # it says less, and can be asked without a compiler
    if as_json:
        print_json(facts)
    else:
        _show_facts(facts)


def _show_component(component: Component, as_json: bool) -> None:
    """Print what a component declares, which the component itself is asked for."""
    with at_work(), ERR.status("asking the component ...") if not as_json else ERR.capture():
        description = describe(component.source)
    if as_json:
        print_json({"kind": component.kind, **asdict(description)})
        return
    _head(description.name, description.description, f" ({component.kind})")
    if description.reference:
        say(description.reference, style="dim")
    variables = [v for v in description.variables if v.causality != "independent"]
    show(
        ["Variable", "Kind", "Size", "Unit", "Start"],
        [
            [v.name, _kind(v.causality, v.variability), _size(v.shape), v.unit or "", " ".join(v.start_texts)]
            for v in variables
        ],
        [f"{v.description} ({v.bounds})" if v.bounds else v.description for v in variables],
    )


def _head(name: str, description: str, kind: str = "") -> None:
    say(": ".join(filter(None, (f"{name}{kind}", description))), bold=len(name))


def _kind(causality: str, variability: str | None) -> str:
    return f"{causality}, tunable" if variability == "tunable" else causality


def _size(shape: Iterable[int]) -> str:
    return " x ".join(map(str, shape))


def _fmu(fmu: Fmu) -> dict[str, Any]:
    model = fmu.model
    interfaces = [
        kind
        for kind, there in (
            ("co-simulation", model.coSimulation),
            ("model-exchange", model.modelExchange),
            ("scheduled-execution", model.scheduledExecution),
        )
        if there
    ]
    times = ("startTime", "stopTime", "tolerance", "stepSize")
    experiment = {name: value for name in times if (value := getattr(model.defaultExperiment, name, None))}
    return {
        "name": model.modelName,
        "description": model.description or "",
        "fmi_version": model.fmiVersion,
        "generation_tool": model.generationTool or "",
        "interfaces": interfaces,
        "platforms": list(fmu.platforms),
        "sha256": fmu.sha256,
        "default_experiment": {name: float(value) for name, value in experiment.items()},
        "states": list(fmu.states),
        "variables": [_variable(port) for port in fmu.ports.values()],
    }


def _variable(port: Port) -> dict[str, Any]:
    start = None if port.start is None else [v.hex() if isinstance(v, bytes) else v for v in port.start]
    return {
        "name": port.name,
        "causality": port.causality,
        "variability": port.variability,
        "type": port.type,
        "shape": list(port.shape),
        "unit": port.unit,
        "start": start,
        **({"items": dict(port.items)} if port.items else {}),
        **({"alias_of": port.alias_of} if port.alias_of else {}),
        "description": port.description,
    }


def _ssp(name: str) -> dict[str, Any]:
    from orchestration.ssp import read_ssp

    file = read_ssp(name)
    about = {"ssp_version": file.version, "structure": file.structure, "structures": list(file.structures)}
    return _parts(file.system, file.start_time, file.stop_time, file.step, about)


def _parts(
    system: System,
    start: float | None,
    stop: float | None,
    step: float | None,
    about: Mapping[str, Any] = MappingProxyType({}),
) -> dict[str, Any]:
    return {
        "name": system.name,
        "description": system.description,
        **about,
        "start_time": start,
        "stop_time": stop,
        "step": step,
        "components": [
            {
                "name": c.name,
                "fmu": c.fmu.path.name,
                "fmi_version": c.fmu.model.fmiVersion,
                "description": c.fmu.model.description or "",
            }
            for c in system.components.values()
        ],
        "connections": [[c.source, c.target] for c in system.connections],
    }


def _show_facts(facts: dict[str, Any]) -> None:
    _head(facts["name"], facts["description"])
    if "components" in facts:
        say(
            (f"SSP {facts['ssp_version']}, " if "ssp_version" in facts else "")
            + f"{len(facts['components'])} components, {len(facts['connections'])} connections"
        )
        if len(facts.get("structures", ())) > 1:
            others = ", ".join(name for name in facts["structures"] if name != facts["structure"])
            say(f"of {facts['structure']}; there is also {others}, which FILE.ssp#NAME.ssd chooses")
        times = {"start": facts["start_time"], "stop": facts["stop_time"], "step": facts["step"]}
        if any(time is not None for time in times.values()):
            say(", ".join(f"{name} {time:g} s" for name, time in times.items() if time is not None))
        parts = facts["components"]
        rows = [[c["name"], c["fmu"], c["fmi_version"]] for c in parts]
        show(["Component", "FMU", "FMI"], rows, [c["description"] for c in parts])
        if facts["connections"]:
            show(["From", "To"], facts["connections"])
        return
    say(
        f"FMI {facts['fmi_version']}, {' and '.join(facts['interfaces'])}, "
        f"for {', '.join(facts['platforms']) or 'no platform'}"
        + (f"; made by {facts['generation_tool']}" if facts["generation_tool"] else "")
    )
    variables = [v for v in facts["variables"] if v["causality"] != "independent"]
    show(
        ["Variable", "Kind", "Type", "Size", "Unit", "Start"], [_cells(v) for v in variables], [*map(_note, variables)]
    )


def _cells(v: Mapping[str, Any]) -> list[str]:
    names = {number: name for name, number in v.get("items", {}).items()}
    start = " ".join(f"{x:g}" if isinstance(x, float) else str(names.get(x, x)) for x in v["start"] or ())
    return [v["name"], _kind(v["causality"], v["variability"]), v["type"], _size(v["shape"]), v["unit"] or "", start]


def _note(v: Mapping[str, Any]) -> str:
    also = f"another name of {v['alias_of']}" if "alias_of" in v else ""
    items = ", ".join(f"{number} {name}" for name, number in v.get("items", {}).items())
    return ". ".join(filter(None, (also, v["description"]))) + (f" ({items})" if items else "")

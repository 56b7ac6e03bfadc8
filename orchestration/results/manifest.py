"""What was run: all that is needed to run it again."""

from __future__ import annotations

import platform
from dataclasses import fields
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

import numpy as np

from fmus import paths
from fmus.freshness import outdated
from orchestration.fmu.advice import odd_steps, outside_range
from orchestration.fmu.file import FmiVersion
from orchestration.fmu.seeds import is_seed, shared_seeds
from orchestration.system import Connection, System

_PACKAGES = ("adcs-fmus", "fmpy", "numpy", "scipy", "ziglang")


def make_manifest(system: System, fmi_version: FmiVersion, settings: dict[str, Any]) -> dict[str, Any]:
    """Describe a system and how it is run: components with checksums and start values, connections, seeds, versions."""
    components = {}
    seeds = {}
    warnings = []
    for component in system.components.values():
        fmu = component.open(fmi_version)
        if fmu.path.parent == paths.DIST and (text := outdated(str(component.source), fmu.path)):
            warnings.append(text)
        start = {name: _nested(values, fmu.ports[name].shape) for name, values in component.start.items()}
        components[component.name] = {
            "fmu": str(component.source),
            "file": fmu.path.name,
            "fmi_version": fmu.model.fmiVersion,
            "sha256": fmu.sha256,
            "start": start,
            **({"every": component.every} if component.every > 1 else {}),
        }
        for port in fmu.ports.values():
            if is_seed(port) or port.name == "seed" or port.name.endswith("_seed"):
                default = None if port.start is None else _nested(port.start, port.shape)
                seeds[f"{component.name}.{port.name}"] = start.get(port.name, default)
    warnings += [*shared_seeds(system), *outside_range(system), *odd_steps(system, fmi_version, settings)]
    return {
        "system": {
            "name": system.name,
            "description": system.description,
            "components": components,
            "connections": [_described(c) for c in system.connections],
        },
        "settings": settings,
        "seeds": seeds,
        "warnings": warnings,
        "versions": {
            **{name: _version(name) for name in _PACKAGES},
            "python": platform.python_version(),
            "platform": platform.platform(),
        },
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def completed(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return the outcome of a run that came to its end: its stop time, a condition, or where a component ended it.

    What the manifest says of the last two moves to the outcome.
    """
    ends = {"met": manifest.pop("stopped", None), "ended": manifest.pop("ended", None)}
    return {"status": "complete", **{name: end for name, end in ends.items() if end is not None}}


def _described(connection: Connection) -> list[Any]:
    """Source and target, and what else is not usual about the connection."""
    usual = Connection(connection.source, connection.target)
    unusual = {
        f.name: value
        for f in fields(Connection)
        if f.name != "given" and (value := getattr(connection, f.name)) != getattr(usual, f.name)
    }
    return [connection.source, connection.target, *([unusual] if unusual else [])]


def _nested(values: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    texts = [value.hex() if isinstance(value, bytes) else value for value in values]  # as `System.set` reads them
    return np.asarray(texts).reshape(shape).tolist()


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None

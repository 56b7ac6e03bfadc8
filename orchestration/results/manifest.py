"""What was run: all that is needed to run it again."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import fields
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from orchestration.fmu.advice import odd_steps, outside_range
from orchestration.fmu.file import FmiVersion, is_path
from orchestration.fmu.seeds import is_seed, shared_seeds
from orchestration.plan.lowering import Floats
from orchestration.system import Connection, System

FORMAT = "adcs-manifest-2"
"""What a manifest says of itself under `format`."""

_PACKAGES = ("adcs-fmus", "fmpy", "numpy", "scipy", "ziglang")


def make_manifest(
    system: System,
    fmi_version: FmiVersion,
    settings: dict[str, Any],
    read: Mapping[str, str | Path | None] | None = None,
) -> dict[str, Any]:
    """Describe a system and how it is run: components with checksums and start values, connections, seeds, versions.

    `settings` are what `run` was asked for; `read` are files that it reads, by the name of the setting.
    """
    components = {}
    seeds = {}
    for component in system.components.values():
        fmu = component.open(fmi_version)
        start = {name: _nested(values, fmu.ports[name].shape) for name, values in component.start.items()}
        components[component.name] = {
            "fmu": _from_anywhere(component.source),
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
    warnings = [*shared_seeds(system), *outside_range(system), *odd_steps(system, fmi_version, settings)]
    return {
        "format": FORMAT,
        "system": {
            "name": system.name,
            "description": system.description,
            "components": components,
            "connections": [_described(c) for c in system.connections],
        },
        "settings": settings,
        **(
            {"files": files}
            if (files := {name: _file(Path(path)) for name, path in (read or {}).items() if path})
            else {}
        ),
        "seeds": seeds,
        "warnings": warnings,
        "versions": versions(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def versions() -> dict[str, str | None]:
    """Return the versions of what takes part in a run, components aside."""
    packages = {name: _version(name) for name in _PACKAGES}
    return {**packages, "python": platform.python_version(), "platform": platform.platform()}


def _from_anywhere(source: str | Path) -> str:
    return str(Path(source).absolute()) if is_path(source) else str(source)


def _file(path: Path) -> dict[str, str]:
    return {"path": str(path.absolute()), "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


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
        f.name: value for f in fields(Connection) if (value := getattr(connection, f.name)) != getattr(usual, f.name)
    }
    return [connection.source, connection.target, *([unusual] if unusual else [])]


def _nested(values: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    texts = [value.hex() if isinstance(value, bytes) else value for value in values]  # as `System.set` reads them
    return np.asarray(texts, object).reshape(shape).tolist()  # each of its own type


@cache
def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def row_times(times: Floats, manifest: Mapping[str, Any]) -> Floats:
    """Return the times of rows (s), of which the grid knows all but that of an end between two points."""
    ended = manifest.get("ended") or manifest.get("outcome", {}).get("ended")
    if not ended or not len(times) or not ended["time"] < times[-1]:
        return times
    return np.append(times[:-1], ended["time"])

"""The values of structural parameters, which come before everything else: they say how large the arrays are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from fmus.errors import AdcsError
from orchestration.ssp.parameters import Bindings, fitting
from orchestration.ssp.parts import Part, Place
from orchestration.ssp.structure import SystemElement
from orchestration.ssp.wiring import Route, Wiring
from orchestration.system import System

Parts = Mapping[tuple[str, ...], Part]


def configured(root: SystemElement, parts: Parts, names: Mapping[tuple[str, ...], str]) -> dict[tuple[str, ...], Part]:
    """Return the components with the sizes that the document's values of structural parameters give their arrays.

    Such a value comes from a parameter set, or from a structural parameter of a system or a constant by connections.
    `names` are those of the components in the flat system.
    """
    found = dict(parts)
    if any(_structural(part) for part in parts.values()):
        wiring = Wiring(root, parts, structural=True)
        values = Bindings(parts, wiring.shapes, wiring.relative, structural=True).read(root, refuse_unknown=False)
        starts, _ = settled(wiring.routes(values.units), parts, values.given)
        for path, part in parts.items():
            given = given_to(part, starts)
            if given:
                system = System("sizes")
                try:
                    system.add(names[path], part.path, given)
                except AdcsError as error:
                    text = str(error)
                    own = text.startswith(f"{names[path]}.")
                    raise AdcsError(text if own else f"component {part.element.name}: {text}") from error
                found[path] = replace(part, fmu=system.components[names[path]].fmu, structural=given)
    for part in found.values():
        part.check_sizes()
    return found


def given_to(part: Part, starts: Mapping[Place, Any]) -> dict[str, Any]:
    """Return which of these values are those of the structural parameters of a component."""
    path = part.element.path
    return {name: starts[Place(path, name, 0)] for name in _structural(part) if Place(path, name, 0) in starts}


def settled(routes: Iterable[Route], parts: Parts, given: Mapping[Place, Any]) -> tuple[dict[Place, Any], list[Route]]:
    """Split the routes: what is known beforehand (constants, values given to systems) are start values, the others are
    connections.
    """
    starts = {place: value for place, value in given.items() if place.path in parts}
    links = []
    for route in routes:
        port = parts[route.target.path].fmu.ports[route.target.name]
        if route.source.path not in parts:
            if route.source not in given:
                continue
            value = given[route.source]
        elif port.causality == "input":
            links.append(route)
            continue
        else:
            value = _constant(parts[route.source.path], route.source)
            if value is None:
                raise AdcsError(
                    f"{route.label}: a value that is computed goes into {port.causality} {route.target}, which has to "
                    "be known before the run: bind a parameter to it"
                )
        starts[route.target] = fitting(route.transformation.apply(value), port, f"{route.label}: {route.target}")
    return starts, links


def _constant(part: Part, place: Place) -> Any:
    port = part.fmu.ports[place.name]
    return port.start[place.index] if port.variability == "constant" and port.start is not None else None


def _structural(part: Part) -> list[str]:
    return [port.name for port in part.ports if port.causality == "structuralParameter"]

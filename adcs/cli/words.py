"""Words of a command line that several commands take: values of variables, and times."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isfinite
from typing import Any

from fmus.errors import AdcsError, shown
from orchestration.fmu.values import parse_value
from orchestration.system import System


def assigned(system: System, assignment: str, option: str = "--set", alone: str | None = None) -> tuple[str, Any]:
    """Read COMPONENT.VARIABLE=VALUE: the name, and the value in the variable's unit.

    Of a system of one component, which `alone` names, VARIABLE=VALUE is enough.
    """
    name, equals, text = assignment.partition("=")
    if not equals:
        raise AdcsError(f"{option} {shown(assignment)}: expected COMPONENT.VARIABLE=VALUE")
    name = full_name(name.strip(), alone)
    component, port = system.port(name)
    if system.end(name).shape != port.shape:
        whole = f"{component}.{port.name}"
        raise AdcsError(
            f"{option} {shown(assignment)}: {name} is one of the {port.size} elements of {whole}: give all of them, "
            f"as {whole}=VALUE"
        )
    return name, parse_value(system.components[component].fmu, port, text)


def assign(system: System, assignments: Sequence[str], alone: str | None = None) -> None:
    """Set the start values that `--set` gives: structural parameters first, which say what size others have.

    Of two for the same name the later one counts; two for two names of one variable are refused.
    """
    given: dict[Any, str] = {}
    for assignment in _sizes_first(system, assignments, alone):
        name, value = assigned(system, assignment, alone=alone)
        for other in (given[place] for place in system.places(name) if given.get(place, name) != name):
            raise AdcsError(f"--set {name} and --set {other} are for two names of one variable: give one of them")
        given.update(dict.fromkeys(system.places(name), name))
        system.set(name, value)


def _sizes_first(system: System, assignments: Sequence[str], alone: str | None) -> list[str]:
    def later(assignment: str) -> bool:
        name = full_name(assignment.partition("=")[0].strip(), alone)
        try:
            return not system.port(name)[1].structural
        except AdcsError:  # which is refused when its turn comes
            return True

    return sorted(assignments, key=later)


def full_name(name: str, alone: str | None) -> str:
    """`component.variable`, where the component may have been left out."""
    return name if alone is None or name.startswith(f"{alone}.") else f"{alone}.{name}"


def seconds(text: str, what: str) -> float:
    """Read a time [s] with or without a unit; `what` is the option, for the error."""
    match = re.fullmatch(r"\s*(?P<number>[-+.\deE]+)\s*(?P<unit>ms|s|min|h)?\s*", text)
    try:
        time = float(match["number"]) * {"ms": 1e-3, "min": 60.0, "h": 3600.0}.get(match["unit"], 1.0)  # type: ignore[index]
        if not isfinite(time):
            raise ValueError
        return time
    except (TypeError, ValueError):
        raise AdcsError(f"{what}: {shown(repr(text))} is not a time, write 120s, 0.1s, 5ms, 2min or 1h") from None


def whole(text: str) -> int | None:
    """Return a whole number from 0 that is written in digits, None if it is not so or has more than nine."""
    return int(text) if text.isdecimal() and len(text) <= 9 else None

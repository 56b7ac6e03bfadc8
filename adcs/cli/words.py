"""Words of a command line that several commands take: values of variables, times, and what is done to a system."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from math import isfinite, nan
from typing import Any

from fmus.errors import AdcsError, shown
from fmus.spelling import hint
from orchestration.fmu.values import parse_value
from orchestration.system import System


def assigned(system: System, assignment: str, option: str = "--set") -> tuple[str, Any]:
    """Read COMPONENT.VARIABLE=VALUE: the name, and the value in the variable's unit.

    Of a system of one component VARIABLE=VALUE is enough.
    """
    name, equals, text = assignment.partition("=")
    if not equals:
        raise AdcsError(f"{option} {shown(assignment)}: expected COMPONENT.VARIABLE=VALUE")
    name = full_name(system, name.strip())
    component, port = system.port(name)
    if system.end(name).shape != port.shape:
        whole = f"{component}.{port.name}"
        raise AdcsError(
            f"{option} {shown(assignment)}: {name} is one of the {port.size} elements of {whole}: give all of them, "
            f"as {whole}=VALUE"
        )
    return name, parse_value(system.components[component].fmu, port, text)


def assign(system: System, assignments: Sequence[str]) -> None:
    """Set the start values that `--set` gives: structural parameters first, which say what size others have.

    Of two for the same name the later one counts; two for two names of one variable are refused.
    """
    given: dict[Any, str] = {}
    for assignment in _sizes_first(system, assignments):
        name, value = assigned(system, assignment)
        for other in (given[place] for place in system.places(name) if given.get(place, name) != name):
            raise AdcsError(f"--set {name} and --set {other} are for two names of one variable: give one of them")
        given.update(dict.fromkeys(system.places(name), name))
        system.set(name, value)


def _sizes_first(system: System, assignments: Sequence[str]) -> list[str]:
    def later(assignment: str) -> bool:
        name = full_name(system, assignment.partition("=")[0].strip())
        try:
            return not system.port(name)[1].structural
        except AdcsError:  # which is refused when its turn comes
            return True

    return sorted(assignments, key=later)


def full_name(system: System, name: str) -> str:
    """`component.variable`, where the component may have been left out if there is only one."""
    if len(system.components) != 1:
        return name
    (alone,) = system.components
    return name if name.startswith(f"{alone}.") else f"{alone}.{name}"


def change(system: System, text: str) -> tuple[float, str, Any]:
    """Read what `--at` gives: TIME COMPONENT.VARIABLE=VALUE."""
    when, blank, assignment = text.strip().partition(" ")
    if not blank:
        raise AdcsError(f"--at {shown(text)}: expected TIME COMPONENT.VARIABLE=VALUE, as in --at 120s controller.k_p=2")
    return seconds(when, "--at"), *assigned(system, assignment.strip(), "--at")


def every(system: System, assignment: str) -> None:
    """Do what `--every` says: COMPONENT=N."""
    name, _, text = assignment.partition("=")
    number = whole(text)
    if name not in system.components or not number:
        known = "" if name in system.components else f"; {hint(name, system.components, 'there is')}"
        raise AdcsError(f"--every {shown(assignment)}: expected COMPONENT=N, N from 1{known}")
    system.components[name].every = number


def delay(system: System, assignment: str) -> None:
    """Do what `--delay` says: INPUT=N, or INPUT=TIME."""
    name, _, text = assignment.partition("=")
    if (number := whole(text)) is not None:
        system.delay(name, steps=number)
    elif re.fullmatch(r"[-+.\deE\s]+", text):
        raise AdcsError(f"--delay {shown(assignment)}: give a whole number of steps, or a time as in 0.1s")
    else:
        system.delay(name, seconds=seconds(text, f"--delay {shown(name)}"))


_UNITS = {"": 1.0, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}  # s
_TIME = re.compile(r"\s*(?P<number>[-+]?[.\d]+(?:[eE][-+]?\d+)?)\s*(?P<unit>[^\s\d.]*)\s*", re.ASCII)


def time(text: str) -> float:
    """Read a time [s] with or without a unit; ValueError if it is none."""
    match = _TIME.fullmatch(text)
    found = nan
    if match is not None:
        with suppress(ValueError):
            found = float(match["number"]) * _UNITS.get(match["unit"], 1.0)
    if match is None or not isfinite(found):
        raise ValueError(f"{shown(repr(text))} is not a time, write 120s, 0.1s, 5ms, 2min or 1h")
    if match["unit"] not in _UNITS:
        known = " or ".join(filter(None, _UNITS))
        raise ValueError(f"{shown(repr(text))} is not a time: {shown(repr(match['unit']), 40)} is no unit, use {known}")
    return found


def seconds(text: str, what: str) -> float:
    """Read a time [s] that is part of an option; `what` is the option, for the error."""
    try:
        return time(text)
    except ValueError as error:
        raise AdcsError(f"{what}: {error}") from None


def whole(text: str) -> int | None:
    """Return a whole number from 0 that is written in digits, None if it is not so or has more than nine."""
    return int(text) if text.isdecimal() and len(text) <= 9 else None

"""Words of a command line that several commands take: values of variables, times, and what is done to a system."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from fmus.errors import AdcsError, shown
from fmus.spelling import hint
from orchestration import times
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
    if name in system.components and number is None and text.isdecimal():
        raise AdcsError(f"--every {shown(assignment)}: expected at most {_MOST_STEPS} steps")
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


def seconds(text: str, what: str) -> float:
    """Read a time [s] that is part of an option; `what` is the option, for the error."""
    try:
        return times.seconds(text)
    except ValueError as error:
        raise AdcsError(f"{what}: {error}") from None


def whole(text: str) -> int | None:
    """Return a whole number from 0 that is written in digits, None if it is not so or has more than nine."""
    return int(text) if text.isdecimal() and len(text) <= len(str(_MOST_STEPS)) else None


_MOST_STEPS = 999_999_999

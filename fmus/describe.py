"""What a component declares, asked from the component itself by a small program built for this machine."""

import json
import math
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmus.errors import AdcsError, shown
from fmus.process_end import how


@dataclass(frozen=True)
class DisplayUnit:
    """`display = factor * value`."""

    name: str
    factor: float


@dataclass(frozen=True)
class Unit:
    """`base = factor * value + offset`, with the base unit as exponents of kg, m, s, A, K, mol, cd, rad."""

    name: str
    exponents: dict[str, int]
    factor: float
    offset: float
    display: tuple[DisplayUnit, ...]


@dataclass(frozen=True)
class LogCategory:
    """A kind of log message that can be switched."""

    name: str
    description: str


@dataclass(frozen=True)
class Variable:
    """A scalar, vector or matrix variable; element i (row-major) has the value reference `vr + i` in FMI 2.0."""

    name: str
    vr: int
    shape: tuple[int, ...]
    type: str
    causality: str
    variability: str
    initial: str | None
    unit: str | None
    display_unit: str | None
    start: tuple[float, ...] | None
    min: float | None
    max: float | None
    nominal: float | None
    description: str
    derivative_of: int | None
    """Value reference of the state whose time derivative this is."""
    dependencies: tuple[tuple[int, ...], ...] | None
    """For each element the scalar value references it depends on during the run."""
    initial_dependencies: tuple[tuple[int, ...], ...] | None
    """The same during initialisation."""
    items: tuple[str, ...] = ()
    """Of an enumeration: the names of 0, 1, 2 and so on."""
    is_event: bool = False
    """Whether it is an event function, by whose sign things happen."""
    is_seed: bool = False
    """Whether it is the seed of random draws."""
    condition: str | None = None
    """What the variable as a whole has to be: `unit quaternion`, `inertia matrix`; which no XML attribute can say."""
    min_excluded: bool = False
    """Whether `min` itself is refused, which the XML of neither standard can say."""

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)

    @property
    def bounds(self) -> str:
        """The range of values in a few characters: `> 0`, `≤ 1.57`, `0 … 1`, `0 off, 1 on`, or the condition.

        Empty if any will do.
        """
        if self.condition is not None:
            return self.condition
        if self.items:
            return ", ".join(f"{number} {name}" for number, name in enumerate(self.items))
        match (self.min, self.max):
            case (None, None):
                return ""
            case (low, None):
                return f"{'>' if self.min_excluded else '≥'} {low:g}"
            case (None, high):
                return f"≤ {high:g}"
            case (low, high):
                return f"{low:g} … {high:g}"

    @property
    def start_texts(self) -> list[str]:
        """The start values as people write them: `0.5`, `true`, the name of an item; none if it has none."""
        if self.type == "Boolean":
            return [str(bool(x)).lower() for x in self.start or ()]
        if self.items:
            return [self.items[int(x)] for x in self.start or ()]
        return [f"{x:g}" for x in self.start or ()]

    @property
    def element_names(self) -> list[str]:
        """Names of the scalars that FMI 2.0 has instead of an array: `q_BN[1]`, `J_B[1,1]`, `der(q_BN[1])`."""
        if not self.shape:
            return [self.name]
        derived = self.name.startswith("der(")
        name = self.name[4:-1] if derived else self.name
        names = [f"{name}[{','.join(map(str, index))}]" for index in _indices(self.shape)]
        return [f"der({name})" for name in names] if derived else names


@dataclass(frozen=True)
class Description:
    """A component's declaration, free of FMI versions."""

    name: str
    description: str
    reference: str
    token: str
    differentiable: bool
    sampled: bool
    states: int
    log_categories: tuple[LogCategory, ...]
    units: tuple[Unit, ...]
    variables: tuple[Variable, ...]

    def at(self, scalar_vr: int) -> Variable:
        """The variable that owns a scalar value reference."""
        return next(v for v in self.variables if v.vr <= scalar_vr < v.vr + v.size)


REFUSED = 2
"""The exit code of a describe program for a mistake in the declaration, as in `src/fmi/describe.hpp`."""


SECONDS = 60
"""How long a describe program may take, which needs some milliseconds."""
NOT_PRINTED = "laws print nothing (what is to be seen of a law is an output: v.output(...) in declare())"


class Misdeclared(AdcsError):
    """What a describe program refuses: a text by which the line is found, a tab, and words."""


def described(program: Path) -> dict[str, Any]:
    """What a component's describe program prints, as JSON."""
    try:
        result = subprocess.run([program], capture_output=True, text=True, errors="replace", timeout=SECONDS)
    except subprocess.TimeoutExpired:
        raise Misdeclared(f"\tits law does not end within {SECONDS} s (a loop without an end?)") from None
    if result.returncode == REFUSED:
        raise Misdeclared(result.stderr)
    if result.returncode != 0:
        said = shown(result.stderr.strip())
        why = f": {said}" if said else " (a whole number divided by 0, or an element that an array does not have?)"
        raise Misdeclared(f"\tits law ends the process: {how(result.returncode)}{why}")
    if not result.stdout.startswith("{"):
        raise Misdeclared("\t" + NOT_PRINTED)
    try:
        content: dict[str, Any] = json.loads(result.stdout)
        parse(content)
    except (ValueError, KeyError, TypeError) as error:
        raise AdcsError(f"{program.name} printed no valid description: {error!r}") from error
    return content


def parse(data: dict[str, Any]) -> Description:
    """The description in parsed JSON; unknown keys are errors."""
    return Description(
        **{
            **data,
            "log_categories": tuple(LogCategory(**item) for item in data["log_categories"]),
            "units": tuple(
                Unit(**{**item, "display": tuple(DisplayUnit(**unit) for unit in item["display"])})
                for item in data["units"]
            ),
            "variables": tuple(_variable(item) for item in data["variables"]),
        }
    )


def _variable(item: dict[str, Any]) -> Variable:
    def nested(key: str) -> Any:
        return None if item[key] is None else tuple(map(tuple, item[key]))

    return Variable(
        **{
            **item,
            "shape": tuple(item["shape"]),
            "items": tuple(item.get("items", ())),
            "start": None if item["start"] is None else tuple(item["start"]),
            "dependencies": nested("dependencies"),
            "initial_dependencies": nested("initial_dependencies"),
        }
    )


def _indices(shape: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """One-based indices, last index fastest."""
    if not shape:
        yield ()
        return
    for first in range(1, shape[0] + 1):
        for rest in _indices(shape[1:]):
            yield (first, *rest)

"""Clocks as connectors have them in SSP 2.0, and whether that is what the FMU says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from math import isclose

from lxml import etree

from fmus.errors import AdcsError
from orchestration.fmu.description import TIME_BASED, Clock

_STEADY = ("constant", "fixed")
_SAME = 1e-6  # relative: a decimal stands where the FMU may have a fraction, and few write all digits of one


@dataclass(frozen=True)
class ClockType:
    """What a connector says of its clock; None where it says nothing. Interval and shift in seconds.

    `kind` is intervalVariability. Which times are represented how (supportsFraction), and which clock comes first where
    tasks are scheduled (priority), has no effect here.
    """

    kind: str | None
    interval: Fraction | float | None
    shift: Fraction | float | None

    def __str__(self) -> str:
        """`constant, each 0.25 s`."""
        each = "" if self.interval is None else f", each {float(self.interval):g} s"
        return f"{self.kind}{each}" + (f" from {float(self.shift):g} s on" if self.shift else "")

    @property
    def timed(self) -> bool:
        """Whether it ticks at times of its own, rather than when it is triggered."""
        return self.kind in TIME_BASED

    def holds_with(self, other: ClockType) -> bool:
        """Whether two clocks that tick by themselves are known to tick together."""
        if self.interval is None or other.interval is None or self.kind != other.kind or self.kind not in _STEADY:
            return False
        return _same(self.interval, other.interval) and _same(self.shift or 0.0, other.shift or 0.0)


def clock_type(element: etree._Element, where: str) -> ClockType:
    """Read the type of a connector that is a clock."""
    resolution = element.get("resolution")
    if resolution is not None and int(resolution) == 0:
        raise AdcsError(f"{where} is a clock with a resolution of 0: expected a number of parts of a second from 1")

    def time(counter: str, decimal: str) -> Fraction | float | None:
        if resolution is not None and element.get(counter) is not None:
            return Fraction(int(element.get(counter)), int(resolution))
        return None if element.get(decimal) is None else float(element.get(decimal))

    return ClockType(
        element.get("intervalVariability"),
        time("intervalCounter", "intervalDecimal"),
        time("shiftCounter", "shiftDecimal"),
    )


def of_fmu(clock: Clock) -> ClockType:
    """Return what an FMU says of its clock."""
    return ClockType(clock.kind, clock.interval, clock.shift)


def check_clock(said: ClockType, clock: Clock, where: str) -> None:
    """Refuse what a connector says of a clock where the FMU says something else."""
    own = of_fmu(clock)
    if said.kind is not None and said.kind != own.kind:
        raise AdcsError(f"{where} is a clock of kind {said.kind!r}, the FMU's is {own.kind!r}: correct it")
    if not own.timed:
        return
    if said.interval is not None and own.interval is None and own.kind not in _STEADY:
        raise AdcsError(
            f"{where} is a clock whose interval is {float(said.interval):g} s, and the FMU's is {own.kind}, which it "
            "says only while it runs: leave the interval out"
        )
    for what, here, there in (("interval", said.interval, own.interval), ("shift", said.shift, own.shift)):
        if here is not None and there is not None and own.interval is not None and not _same(here, there):
            raise AdcsError(
                f"{where} is a clock whose {what} is {float(here):g} s, that of the FMU's {float(there):g} s: "
                "correct it"
            )


def connection_holds(ends: Sequence[ClockType | None], names: Sequence[str], label: str) -> bool:
    """Whether two clocks are connected that tick by themselves, at the same times; False if neither does so.

    SSP leaves it to tools what becomes of such connections. Here each clock keeps its own interval; what would ask for
    more than that is refused.
    """
    for (one, name), (other, _) in permutations(zip(ends, names, strict=True)):
        if one is None or not one.timed:
            continue
        if other is None or not other.timed:
            raise AdcsError(
                f"{label}: {name} is a clock that ticks by its own interval, it triggers nothing and nothing triggers "
                "it: drop the connection, or connect an output clock to one that waits for a trigger"
            )
        if not one.holds_with(other):
            raise AdcsError(
                f"{label}: both clocks tick by their own intervals, which are not known to be the same "
                f"({one}; {other}): drop the connection"
            )
        return True
    return False


def _same(a: Fraction | float, b: Fraction | float) -> bool:
    return isclose(float(a), float(b), rel_tol=_SAME, abs_tol=0.0)

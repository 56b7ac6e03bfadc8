"""What the compiled loop does at a communication point, call by call from Python; how its failures read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import takewhile
from math import inf, isfinite

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import Fmu
from orchestration.fmu.number_types import BEYOND, EXACT, first_beyond, first_misfit
from orchestration.instances.instance import CallFailed, Instance
from orchestration.plan.lowering import Call, Delay, Floats, Plan

_MOST = 2.0**70
"""Of a factor or offset between integers; larger ones let nothing arrive that fits. The compiled loop has it, too."""


@dataclass(frozen=True)
class Ring:
    """What is on its way in a delay: `values` (steps, n), those that left at point k at k modulo steps."""

    delay: Delay
    values: Floats

    @classmethod
    def filled(cls, delay: Delay, signals: Floats) -> Ring:
        """Return the ring as it is when nothing has arrived yet."""
        try:
            return cls(delay, np.tile(signals[delay.target], (delay.steps, 1)))
        except (MemoryError, OverflowError, ValueError):  # of what can be addressed
            raise AdcsError(f"a delay by {delay.steps} steps does not fit into memory: use a shorter one") from None

    def arrive(self, k: int, signals: Floats) -> None:
        """Hand on what left `steps` points before k."""
        signals[self.delay.target] = self.values[k % self.delay.steps]

    def leave(self, k: int, signals: Floats) -> None:
        """Take what leaves at k."""
        self.values[k % self.delay.steps] = signals[self.delay.source]


def execute(call: Call, signals: Floats, instances: Mapping[str, Instance]) -> None:
    """Execute a get or set call through fmpy's own methods."""
    instance = instances[call.component]
    if call.kind == "set":
        values = gather(call, signals)
        misfit = first_misfit(call.type, values)
        if misfit is not None:
            raise not_handed_on(call, misfit[0], signals)
        instance.set(call.references, values.tolist(), action_of(call), call.type)
        return
    read = instance.read(call.references, len(call.where), action_of(call), call.type)
    if not call.type.startswith("Float") and (beyond := first_beyond(read)) is not None:
        raise not_doubled(call, beyond, read[beyond])
    values = np.array(read, float)
    for i in np.flatnonzero(~np.isfinite(values)):
        raise not_finite(call.component, call.elements[i])
    signals[call.where] = values


def gather(call: Call, signals: Floats) -> Floats:
    """Return what a set call hands on, (n,)."""
    values = signals[call.where]
    if call.factor is None or call.offset is None:
        return values
    plain = (call.factor == 1.0) & (call.offset == 0.0)
    with np.errstate(over="ignore"):  # infinity is no value of any type
        scaled: Floats = np.where(plain, values, call.factor * values + call.offset)
    if "Int" in call.type:
        for element in np.flatnonzero(~plain & np.isfinite(values)).tolist():
            exact = _scaled(call, element, signals)
            scaled[element] = (
                float(exact)
                if abs(exact) <= EXACT and max(abs(call.factor[element]), abs(call.offset[element])) <= _MOST
                else inf
            )
    for i, pairs in enumerate(call.mappings):
        if pairs:
            scaled[i] = next((there for here, there in pairs if here == values[i]), np.nan)
    return scaled


def gets_of(plan: Plan) -> list[Call]:
    """Return all get calls of a propagation, those inside algebraic loops too."""
    return [*(c for c in plan.calls if c.kind == "get"), *(c for loop in plan.loops for c in loop.gets)]


def depends_on(fmu: Fmu, get: Call, nodes: Iterable[str]) -> list[str]:
    """Return which nodes (`Fmu.nodes`) that a get call fetches depend directly on some inputs of the same component."""
    inputs = set(nodes)
    return [node for node in _nodes(fmu, get) if not inputs.isdisjoint(fmu.feedthrough(node))]


def _nodes(fmu: Fmu, call: Call) -> list[str]:
    return [fmu.nodes.called(call.type, reference) for reference in call.references]


def read_after_set(failed: CallFailed, plan: Plan, get: Call, instance: Instance, k: int) -> CallFailed:
    """Add to the failure of a get call at point k what the component was given there before, and why.

    In step mode FMI forbids a get after a set without a step between. Most FMUs take it; one that does not refuses.
    """
    before = takewhile(lambda call: call is not get, plan.calls)
    sets = [call for call in before if call.kind == "set" and call.component == get.component]
    given = [node for call in sets for node in _nodes(instance.fmu, call)]
    changed = instance.changed_at(k)
    given += [node for name in changed for node in instance.fmu.nodes.of(instance.fmu.ports[name])]
    if failed.status is None or not instance.in_step_mode or not given:
        return failed
    names = ", ".join(dict.fromkeys(node.partition("[")[0] for node in given))
    failed.text += (
        f"; before that, {names} had been set at this point, after which FMI allows no get before the next step"
    )
    needing = ", ".join(dict.fromkeys(node.partition("[")[0] for node in depends_on(instance.fmu, get, given)))
    if needing:
        handed_on = {int(place) for call in plan.calls if call.kind == "set" for place in call.where}
        fed = not handed_on.isdisjoint(get.where.tolist())
        way = "connect others" if fed else "leave it out of what is recorded (--record)"
        failed.text += f", but by its ModelStructure {needing} depends on them: {way}, or use an FMU that takes it"
    return failed


def action_of(call: Call) -> str:
    """Name a get or set call by its variables."""
    variables = dict.fromkeys(e.partition("[")[0] for e in call.elements)
    return f"{call.kind}ting {', '.join(variables)}"


def not_finite(component: str, element: str) -> CallFailed:
    """Put into words that an FMU returned NaN or infinity."""
    return CallFailed(component, f"{element} is not finite")


def not_doubled(call: Call, element: int, value: int) -> CallFailed:
    """Put into words that an integer that an FMU returned cannot be had as a double."""
    return CallFailed(call.component, f"{call.elements[element]} = {value}{BEYOND}")


def not_handed_on(call: Call, element: int, signals: Floats) -> CallFailed:
    """Put into words that what a set call hands on is no value of the variable's type."""
    name, came = call.elements[element], float(signals[call.where[element]])
    source = _source(call, element)
    pairs = call.mappings[element] if call.mappings else ()
    if pairs and all(here != came for here, _ in pairs):
        return CallFailed(call.component, f"{name} gets a value for which its connection has no mapping{source}")
    value: float | int
    if pairs:
        value = next(there for here, there in pairs if here == came)
    elif isfinite(came) and "Int" in call.type and (exact := _scaled(call, element, signals)).denominator == 1:
        value = int(exact)
        if abs(value) > EXACT:
            return CallFailed(call.component, f"{name} = {value}{BEYOND}{source}")
    else:
        value = float(gather(call, signals)[element])
    return CallFailed(call.component, f"{name} = {value!r} does not fit type {call.type}{source}")


def _scaled(call: Call, element: int, signals: Floats) -> Fraction:
    """Return what one element gets of its finite signal by factor and offset, without a rounding."""
    value = Fraction(float(signals[call.where[element]]))
    if call.factor is None or call.offset is None:
        return value
    return Fraction(float(call.factor[element])) * value + Fraction(float(call.offset[element]))


def _source(call: Call, element: int) -> str:
    """Say where the value that a set call hands on comes from."""
    link = call.links[element] if call.links else None
    if link is None or not link.source:
        return ""
    _, bracket, index = call.elements[element].partition("[")
    whole = not link.target.endswith("]")
    return f", it comes from {link.source}{bracket + index if whole else ''}"

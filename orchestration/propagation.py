"""What the compiled loop does at a communication point, call by call from Python; how its failures read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orchestration.instance import CallFailed, Instance
from orchestration.plan import Call, Delay, Floats

_EXACT = 2.0**53  # above, a double does not hold every integer
_FLOATS = ("Float64", "Float32")


@dataclass(frozen=True)
class Ring:
    """What is on its way in a delay: `values` (steps, n), those that left at point k at k modulo steps."""

    delay: Delay
    values: Floats

    @classmethod
    def filled(cls, delay: Delay, signals: Floats) -> Ring:
        """Return the ring as it is when nothing has arrived yet."""
        return cls(delay, np.tile(signals[delay.target], (delay.steps, 1)))

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
        for i in np.flatnonzero(~np.isfinite(values)):
            raise (not_mapped if np.isnan(values[i]) else not_held)(call, int(i), values[i])
        instance.set(call.references, values.tolist(), action_of(call), call.type)
        return
    values = np.array(instance.get(call.references, len(call.where), action_of(call), call.type))
    if call.type not in _FLOATS:
        for i in np.flatnonzero(np.abs(values) > _EXACT):
            raise not_held(call, int(i), values[i])
    for i in np.flatnonzero(~np.isfinite(values)):
        raise not_finite(call.component, call.elements[i])
    signals[call.where] = values


def gather(call: Call, signals: Floats) -> Floats:
    """Return what a set call hands on, (n,)."""
    values = signals[call.where]
    if call.factor is None or call.offset is None:
        return values
    plain = (call.factor == 1.0) & (call.offset == 0.0)
    scaled: Floats = np.where(plain, values, call.factor * values + call.offset)
    for i, pairs in enumerate(call.mappings):
        if pairs:
            scaled[i] = next((there for here, there in pairs if here == values[i]), np.nan)
    return scaled


def action_of(call: Call) -> str:
    """Name a get or set call by its variables."""
    variables = dict.fromkeys(e.partition("[")[0] for e in call.elements)
    return f"{call.kind}ting {', '.join(variables)}"


def not_finite(component: str, element: str) -> CallFailed:
    """Put into words that an FMU returned NaN or infinity."""
    return CallFailed(component, f"{element} is not finite")


def not_held(call: Call, element: int, value: float) -> CallFailed:
    """Put into words that a value cannot be had or given in the type of its variable."""
    where = f"{call.elements[element]} = {value:.17g}"
    if call.kind == "get":
        return CallFailed(call.component, f"{where} is beyond 2^53, and cannot be handed on or recorded exactly")
    return CallFailed(call.component, f"{where} does not fit type {call.type}{_source(call, element)}")


def not_mapped(call: Call, element: int, value: float) -> CallFailed:
    """Put into words that a connection's mapping has no pair for the value that came."""
    text = f"{call.elements[element]} gets a value for which its connection has no mapping"
    return CallFailed(call.component, f"{text}{_source(call, element)}")


def _source(call: Call, element: int) -> str:
    """Say where the value that a set call hands on comes from."""
    link = call.links[element] if call.links else None
    if link is None or not link.source:
        return ""
    _, bracket, index = call.elements[element].partition("[")
    whole = not link.target.endswith("]")
    return f", it comes from {link.source}{bracket + index if whole else ''}"

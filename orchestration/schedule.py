"""From connections and direct feedthrough to the order in which values are fetched and handed on."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Literal

from fmus.errors import AdcsError
from orchestration.system import Connection

Name = tuple[str, str]
"""A component and one of its variables."""


@dataclass(frozen=True)
class Operation:
    """One call: get these outputs of a component, or set these inputs of it."""

    kind: Literal["get", "set"]
    component: str
    variables: tuple[str, ...]


def schedule(
    connections: Collection[Connection],
    depends: Callable[[Name], Collection[str]],
    record: Collection[Name] = (),
) -> list[Operation]:
    """Order the calls that propagate all values, so that no value is fetched before what it depends on was set.

    `depends` gives the inputs on which an output of the same component directly depends; `record` names the outputs
    that are wanted besides the connected ones. Each component gets as few calls as the dependencies allow. An algebraic
    loop is refused with its variables.
    """
    source = {split(c.target): split(c.source) for c in connections}
    connected = dict.fromkeys(source.values())
    needs = {}
    for out in (*connected, *record):
        needs[out] = [(out[0], i) for i in depends(out) if (out[0], i) in source]
    pending = list(connected)
    wanted = [out for out in needs if out not in connected]
    fetched: set[Name] = set()
    unset = list(source)
    operations: list[Operation] = []

    def ready(out: Name) -> bool:
        return all(source[i] in fetched for i in needs[out])

    def set_(component: str) -> None:
        now = [i for i in unset if i[0] == component and source[i] in fetched]
        if now:
            operations.append(Operation("set", component, tuple(v for _, v in now)))
            unset[:] = [i for i in unset if i not in now]

    def get(component: str) -> None:
        now = [o for o in (*pending, *wanted) if o[0] == component and not any(i in unset for i in needs[o])]
        if now:
            operations.append(Operation("get", component, tuple(v for _, v in now)))
            fetched.update(now)
            pending[:] = [out for out in pending if out not in fetched]
            wanted[:] = [out for out in wanted if out not in fetched]

    while pending:
        possible = dict.fromkeys(out[0] for out in pending if ready(out))
        if not possible:
            raise AdcsError(f"algebraic loop: {_loop(pending, source, needs)}; put a state or a delay into it")
        # A component of which all is ready needs only one call; one that is served in parts can wait.
        component = min(possible, key=lambda c: sum(out[0] == c and not ready(out) for out in pending))
        if any(needs[out] for out in pending if out[0] == component and ready(out)):
            set_(component)
        get(component)
    for component in dict.fromkeys(i[0] for i in unset):
        set_(component)
    for component in dict.fromkeys(out[0] for out in wanted):
        get(component)
    return operations


def split(name: str) -> Name:
    """`component.variable` -> (component, variable)."""
    component, _, variable = name.partition(".")
    return component, variable


def _loop(pending: Collection[Name], source: Mapping[Name, Name], needs: Mapping[Name, Collection[Name]]) -> str:
    """Walk upstream from an output that cannot be had until one comes up again; return the path downstream."""
    walk = [next(iter(pending))]
    while True:
        input_ = next(i for i in needs[walk[-1]] if source[i] in pending)
        output = source[input_]
        walk.append(input_)
        if output in walk:
            return " -> ".join(".".join(name) for name in [output, *reversed(walk[walk.index(output) :])])
        walk.append(output)

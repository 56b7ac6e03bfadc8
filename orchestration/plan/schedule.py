"""From connections and direct feedthrough to the order in which values are fetched and handed on."""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import Literal

import numpy as np

from fmus.errors import AdcsError

Name = tuple[str, str]
"""A component and one of its variables: an element of an array in FMI 2, a whole array in FMI 3."""


@dataclass(frozen=True)
class Operation:
    """Get these outputs of a component, set these inputs of it; or solve a loop by repeating what is `inside`."""

    kind: Literal["get", "set", "solve"]
    component: str
    variables: tuple[str, ...]
    inside: tuple[Operation, ...] = ()


def schedule(
    sources: Mapping[Name, Collection[Name]],
    depends: Callable[[Name], Iterable[str]],
    record: Collection[Name] = (),
    wanted: Collection[Name] = (),
    solve_loops: bool = False,
) -> list[Operation]:
    """Order the calls that propagate all values, so that no value is fetched before what it depends on was set.

    `sources` gives for each input that is set the outputs from which its value comes now; none, if the value is there
    already. `depends` gives the inputs on which an output of the same component directly depends. `wanted` names
    outputs that are fetched though they feed no input now, `record` those that are fetched last. Each component gets
    as few calls as the dependencies allow, and those that get before those that set, where that takes none more. An
    algebraic loop is refused with its variables, unless it is to be solved.
    """
    outputs = dict.fromkeys([*(out for all_of in sources.values() for out in all_of), *wanted])
    extra = [out for out in dict.fromkeys(record) if out not in outputs]
    needs = _needs((*outputs, *extra), sources, depends)
    loop_of = _loops(list(outputs), sources, needs)
    if loop_of and not solve_loops:
        raise AdcsError(
            f"algebraic loop: {_path(next(iter(loop_of)), sources, needs, loop_of)}; solve it (--solve-loops), or put "
            "a state or a delay into it"
        )
    return _Sequence(sources, needs, list(outputs), extra, loop_of).operations


def _needs(
    outputs: Iterable[Name], sources: Collection[Name], depends: Callable[[Name], Iterable[str]]
) -> dict[Name, list[Name]]:
    """Give for each output the inputs among `sources` on which it depends.

    Outputs of which an FMU says nothing depend on all inputs, by one list: it is gone through once, not for each.
    """
    seen: dict[tuple[str, int], tuple[Iterable[str], list[Name]]] = {}
    needs = {}
    for out in outputs:
        on = depends(out)
        key = (out[0], id(on))
        if key not in seen:
            seen[key] = on, [i for v in on if (i := (out[0], v)) in sources]  # `on` is kept, and so is its id
        needs[out] = seen[key][1]
    return needs


class _Sequence:
    """Works off all outputs, each when all that it needs is there."""

    def __init__(
        self,
        sources: Mapping[Name, Collection[Name]],
        needs: Mapping[Name, Sequence[Name]],
        outputs: Sequence[Name],
        extra: Sequence[Name],
        loop_of: Mapping[Name, int],
    ) -> None:
        self.operations: list[Operation] = []
        self._sources, self._needs, self._loop_of = sources, needs, loop_of
        self._fetched: set[Name] = set()
        self._unset: dict[str, dict[Name, None]] = defaultdict(dict)
        for input_ in sources:
            self._unset[input_[0]][input_] = None
        self._extra: dict[str, list[Name]] = defaultdict(list)
        for out in extra:
            self._extra[out[0]].append(out)
        self._missing: dict[Name, int] = {}  # outputs or loops that an output waits for
        self._waiting: dict[Name, list[Name]] = defaultdict(list)
        self._pending: Counter[str] = Counter(out[0] for out in outputs)
        self._ready: dict[str, list[Name]] = defaultdict(list)
        self._complete: deque[str] = deque()  # components of which all is ready need only one call
        self._members: dict[int, list[Name]] = defaultdict(list)
        for out, loop in loop_of.items():
            self._members[loop].append(out)
        self._missing_of_loop: Counter[int] = Counter()
        ready = [out for out in outputs if not self._wait(out)]
        for loop in self._members:
            if not self._missing_of_loop[loop]:
                self._solve(loop)
        for out in ready:
            self._make_ready(out)
        self._work()

    def _wait(self, out: Name) -> bool:
        """Note what an output waits for; an output in a loop makes the whole loop wait."""
        loop = self._loop_of.get(out)
        before = {s for i in self._needs[out] for s in self._sources[i] if loop is None or self._loop_of.get(s) != loop}
        for source in before:
            self._waiting[source].append(out)
        if loop is not None:
            self._missing_of_loop[loop] += len(before)
            return True
        self._missing[out] = len(before)
        return bool(before)

    def _work(self) -> None:
        while True:
            while self._complete and not self._ready[self._complete[0]]:
                self._complete.popleft()
            if self._complete:
                component = self._complete.popleft()
            else:
                partly = [c for c, outs in self._ready.items() if outs]
                if not partly:
                    break
                component = min(partly, key=lambda c: self._pending[c] - len(self._ready[c]))
            if any(self._needs[out] for out in self._ready[component]):
                self._set(component)
            self._get(component)
        for component, extra in list(self._extra.items()):
            if not any(self._needs[out] for out in extra):  # in step mode FMI wants a component read before it is set
                self._get(component)
        for component in list(self._unset):
            self._set(component)
        for component in list(self._extra):
            self._get(component)

    def _set(self, component: str) -> None:
        now = [i for i in self._unset[component] if all(s in self._fetched for s in self._sources[i])]
        if now:
            self.operations.append(Operation("set", component, tuple(v for _, v in now)))
            for input_ in now:
                del self._unset[component][input_]

    def _get(self, component: str) -> None:
        ready = self._ready.pop(component, [])
        unset = self._unset[component]
        needed = {id(self._needs[out]): self._needs[out] for out in self._extra[component]}
        waits = {key for key, needs in needed.items() if any(i in unset for i in needs)}
        extra = [out for out in self._extra[component] if id(self._needs[out]) not in waits]
        self._extra[component] = [out for out in self._extra[component] if id(self._needs[out]) in waits]
        if ready or extra:
            self.operations.append(Operation("get", component, tuple(v for _, v in (*ready, *extra))))
        self._arrived(ready)

    def _solve(self, loop: int) -> None:
        members = self._members[loop]
        components = list(dict.fromkeys(out[0] for out in members))
        unknown = dict.fromkeys(
            i
            for out in members
            for i in self._needs[out]
            if any(self._loop_of.get(s) == loop for s in self._sources[i])
        )
        for component in components:
            self._set(component)
        inside = [Operation("set", *part) for part in _by_component(unknown)]
        inside += [Operation("get", *part) for part in _by_component(members)]
        for input_ in unknown:
            self._unset[input_[0]].pop(input_, None)
        self.operations.append(Operation("solve", "", (), tuple(inside)))
        self._arrived(members)

    def _arrived(self, outs: Sequence[Name]) -> None:
        self._fetched.update(outs)
        self._pending.subtract(out[0] for out in outs)
        for out in outs:
            for waiting in self._waiting.pop(out, ()):
                loop = self._loop_of.get(waiting)
                if loop is not None:
                    self._missing_of_loop[loop] -= 1
                    if not self._missing_of_loop[loop]:
                        self._solve(loop)
                else:
                    self._missing[waiting] -= 1
                    if not self._missing[waiting]:
                        self._make_ready(waiting)

    def _make_ready(self, out: Name) -> None:
        self._ready[out[0]].append(out)
        if len(self._ready[out[0]]) == self._pending[out[0]]:
            self._complete.append(out[0])


def _by_component(names: Iterable[Name]) -> list[tuple[str, tuple[str, ...]]]:
    groups: dict[str, list[str]] = {}
    for component, variable in names:
        groups.setdefault(component, []).append(variable)
    return [(component, tuple(variables)) for component, variables in groups.items()]


def _loops(
    outputs: Sequence[Name], sources: Mapping[Name, Collection[Name]], needs: Mapping[Name, Sequence[Name]]
) -> dict[Name, int]:
    """Return the outputs that depend on themselves, in groups that depend on each other."""
    with suppress(CycleError):
        TopologicalSorter({out: {s for i in needs[out] for s in sources[i]} for out in outputs}).prepare()
        return {}
    from scipy.sparse import csr_array  # where there is a loop: it takes longer to load than most runs
    from scipy.sparse.csgraph import connected_components

    number = {out: i for i, out in enumerate(outputs)}
    edges = [(number[out], number[s]) for out in outputs for i in needs[out] for s in sources[i]]
    here, there = np.array(edges).T
    graph = csr_array((np.ones(len(edges), np.int8), (here, there)), shape=(len(outputs), len(outputs)))
    _, group = connected_components(graph, connection="strong")
    looped = set(np.flatnonzero(np.bincount(group) > 1)) | set(group[here[here == there]])
    return {out: int(group[i]) for out, i in number.items() if group[i] in looped}


def _path(
    first: Name,
    sources: Mapping[Name, Collection[Name]],
    needs: Mapping[Name, Sequence[Name]],
    loop_of: Mapping[Name, int],
) -> str:
    """Walk upstream within the loop until an output comes up again; return the path downstream."""
    walk = [first]
    while True:
        steps = ((i, s) for i in needs[walk[-1]] for s in sources[i])
        input_, output = next((i, s) for i, s in steps if loop_of.get(s) == loop_of[first])
        walk.append(input_)
        if output in walk:
            return " -> ".join(".".join(name) for name in [output, *reversed(walk[walk.index(output) :])])
        walk.append(output)


def split(name: str) -> Name:
    """`component.variable` -> (component, variable)."""
    component, _, variable = name.partition(".")
    return component, variable

"""On which inputs of its own an FMU's variables depend directly, as its ModelStructure says."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestration.fmu.file import Fmu


class Feedthrough:
    """Gives for each node of an FMU the input nodes on which it depends, while running or in initialisation mode.

    A variable of which the FMU says nothing depends on every input; so does one whose `dependencies` are left out.
    """

    def __init__(self, fmu: Fmu, initial: bool) -> None:
        self._fmu, self._initial = fmu, initial
        self._inputs = [node for node, (port, _) in fmu.nodes.items() if port.causality == "input"]
        self._running = self._listed(fmu.model.outputs)
        self._initially = self._listed(fmu.model.initialUnknowns) if initial else {}

    def __call__(self, node: str) -> Iterable[str]:
        """Return the input nodes on which a node depends."""
        port, _ = self._fmu.nodes[node]
        if port.causality == "input":
            return [node]
        if port.causality in ("parameter", "independent") or port.variability == "constant":
            return []
        running = self._running.get(node, self._inputs)
        if not self._initial:
            return running
        return [] if port.initial == "exact" else self._initially.get(node, running)

    def _listed(self, unknowns: Iterable[Any]) -> Mapping[str, list[str]]:
        node_of, inputs = self._fmu.node_of, set(self._inputs)
        return {
            node_of(u.variable): self._inputs
            if u.dependencies is None
            else [node for v in u.dependencies if (node := node_of(v)) in inputs]
            for u in unknowns
        }

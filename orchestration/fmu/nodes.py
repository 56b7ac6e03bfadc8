"""What has a value of its own in an FMU: a value reference, however many names it has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestration.fmu.file import Port

Place = tuple[str, int]
"""A node and the number of a value in it, counted from 0."""


class Nodes(Mapping[str, "tuple[Port, list[int]]"]):
    """Of each node of an FMU, the variable to which it belongs and the elements of it that it has.

    A node is what has a value reference: in FMI 2.0 an element of an array, in FMI 3.0 a whole array. Variables that
    share a reference are one node under several names. It is called as the one that leads: an input, else one that can
    be set, else the first in the file.
    """

    def __init__(self, ports: Iterable[Port]) -> None:
        self._nodes: dict[str, tuple[Port, list[int]]] = {}
        self._of: dict[tuple[str, int], str] = {}  # by type, since references of FMI 2.0 count for each anew
        self._main: dict[tuple[str, tuple[int, ...]], Port] = {}
        self._mains: dict[str, list[str]] = {}
        for port in sorted(ports, key=_rank):
            main = self._main.setdefault((port.type, port.references), port)
            for i, reference in enumerate(port.references):
                if (port.type, reference) not in self._of:
                    each = len(port.references) > 1
                    name = port.elements[i] if each else port.name
                    self._of[port.type, reference] = name
                    self._nodes[name] = (port, [i] if each else list(range(port.size)))
                if main is port:
                    self._mains.setdefault(self._of[port.type, reference], []).append(port.name)

    def __getitem__(self, node: str) -> tuple[Port, list[int]]:
        return self._nodes[node]

    def __iter__(self) -> Iterator[str]:
        return iter(self._nodes)

    def __len__(self) -> int:
        return len(self._nodes)

    def called(self, type: str, reference: int) -> str:
        """Return the node of a value reference of a type (`Port.type`)."""
        return self._of[type, reference]

    def of(self, port: Port) -> list[str]:
        """Return the nodes of a variable."""
        return [self.called(port.type, reference) for reference in port.references]

    def place(self, port: Port, element: int) -> Place:
        """Return where an element of a variable is: the same for all its names."""
        if len(port.references) > 1:
            return self.called(port.type, port.references[element]), 0
        return self.called(port.type, port.references[0]), element

    def main(self, port: Port) -> Port:
        """Return the variable that leads where several have the very same references: it keeps their start value."""
        return self._main[port.type, port.references]

    def mains(self, node: str) -> list[str]:
        """Return the leading variables that have a node: arrays of FMI 2.0 may have it at different places."""
        return self._mains[node]

    def spread(self, port: Port, flat: Sequence[Any]) -> dict[str, Any]:
        """Return what each node of a variable gets of its values: one of them, or all."""
        each = len(port.references) == len(flat)
        return dict(zip(self.of(port), flat if each else [flat], strict=True))


def _rank(port: Port) -> int:
    return 0 if port.causality == "input" else 1 if port.settable else 2

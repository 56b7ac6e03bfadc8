"""What is driven through the points of a run: a co-simulation, with steps of one size or not, or Model Exchange."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from numpy.typing import NDArray

from fmus.errors import AdcsError
from orchestration.fmu.file import Port
from orchestration.grid import Grid
from orchestration.instances.instance import EndRequested, Instance
from orchestration.plan.lowering import Floats
from orchestration.system import System, Value


class Simulation(Protocol):
    """A system that is under way, at point `k` of `last`."""

    grid: Grid
    system: System
    k: int
    last: int
    notes: list[str]
    """What there is to be told of the run, besides what its components say."""

    @property
    def states(self) -> Floats:
        """The continuous states of each row, where they are known: (rows or more, number of `state_names`)."""
        ...

    @property
    def state_names(self) -> list[str]:
        """Their names."""
        ...

    @property
    def instances(self) -> Mapping[str, Instance]:
        """The components by name."""
        ...

    @property
    def ports(self) -> Mapping[str, Port]:
        """The variables of a row, by name."""
        ...

    @property
    def warnings(self) -> list[str]:
        """What the FMUs warned of, and what else there is to be told."""
        ...

    def __enter__(self) -> Simulation: ...

    def __exit__(self, *error: Any) -> None: ...

    @property
    def ended(self) -> EndRequested | None:
        """The wish of a component to end the simulation, once it has come about: nothing comes after that."""
        ...

    @property
    def time(self) -> float:
        """The time of the present point [s]."""
        ...

    @property
    def row(self) -> Floats:
        """The recorded variables as they were last seen, side by side."""
        ...

    @property
    def shorter_due(self) -> bool:
        """Whether the point that comes next is reached by `shorter_step`, which has not been taken."""
        ...

    def check(self) -> None:
        """Look at what components may have changed of the process."""
        ...

    def check_change(self, name: str, value: Value) -> object:
        """Refuse a variable that may not be set during a run, or to that value."""
        ...

    def shows(self, name: str) -> bool:
        """Whether what is set in a variable may show in the row of the same point."""
        ...

    def set(self, name: str, value: Value) -> None:
        """Set an input that nothing feeds, or a tunable parameter, at the present point."""
        ...

    def advance(self, count: int, rows: Floats, *, stay: bool = False) -> tuple[int, int, AdcsError | None]:
        """Take `count` points from the present one on, recorded in `rows`.

        Returns the point that comes next, the number of rows, and what failed; EndRequested, if a component ends the
        simulation. With `stay` no component is stepped on from the last of them; `leave` does that.
        """
        ...

    def leave(self) -> None:
        """Go on to the next point, after `advance` with `stay`."""
        ...

    def shorter_step(self) -> None:
        """Take a last step that is shorter than the others."""
        ...

    def end_row(self) -> Floats | None:
        """Return the row of the time at which a component ended the simulation, if it has one of its own."""
        ...

    def stop(self, at_once: bool = False) -> None:
        """Let `advance` return before its next point, or before its next call; to be called from another thread."""
        ...

    @property
    def external(self) -> Sequence[str]:
        """The inputs whose values come from outside."""
        ...

    def memory(self) -> Mapping[str, NDArray[Any]]:
        """Return what has to be kept to go on from here, besides the components' states."""
        ...

    def remember(self, k: int, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on at point k with what `memory` gave; the components are there already."""
        ...

    def report(self) -> Mapping[str, Any]:
        """Return what the manifest is to have of it."""
        ...

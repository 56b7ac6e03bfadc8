"""What takes part in a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from orchestration.plan.lowering import Floats
from orchestration.running.change import Change
from orchestration.running.simulation import Simulation
from orchestration.system import Value

if TYPE_CHECKING:
    from orchestration.running.outline import Outline

MOST = 1_000_000
"""Points that are taken at once, where nothing asks for less."""


class Watched(Protocol):
    """Does a piece of work in the thread in which the components live, and watches it."""

    def __call__(self, work: Callable[[], Any]) -> Any:
        """Do it, and return what comes of it."""
        ...


class Hook:
    """Takes part in a run, and does nothing in it but what it overrides.

    A run asks, in this order: `prepare`, `begin`; then over and over `changes`, `ahead`, `met` and `after`; at last
    `end`, unless a component failed or ended the run, and `report` in any case.
    """

    def __repr__(self) -> str:
        known = "".join(f" {name} = {value!r}" for name, value in self.for_manifest().items())
        return f"<{type(self).__name__}{known}>"

    exchanges: ClassVar[str] = ""
    """Why a run in which it takes part is a co-simulation, if no method is asked for: "it keeps to the clock"."""

    @property
    def repeatable(self) -> bool:
        """Whether the manifest knows all of it: then it takes part in isolated runs, and when a run is repeated.

        That is said of its very class: one that is made of that may do more.
        """
        return bool(vars(type(self)).get("_repeatable", False))

    def for_manifest(self) -> Mapping[str, Any]:
        """Return what the manifest has to know to repeat it; of several hooks with the same it has a list."""
        return {}

    def prepare(self, outline: Outline) -> None:
        """See what is to be run, before any component is there; AdcsError if it cannot take part in it.

        It may append to the outline's `sources` what gives inputs their values, and to its `warnings`.
        """

    def begin(self, simulation: Simulation, hooks: Sequence[Hook], watched: Watched) -> None:
        """See the run when its components are initialised; AdcsError if it cannot take part in it."""

    def changes(self, k: int) -> Sequence[Change | tuple[str, Value]]:
        """Return what is to be set at point k, which comes next: names `component.variable` and values."""
        return ()

    def ahead(self, k: int) -> int:
        """Return how many points may be taken at once, from point k on; it may wait for the time to go on.

        One by one, if it sees points or sets something at them and does not say otherwise.
        """
        return 1 if overrides(self, "after") or overrides(self, "changes") else MOST

    def met(self, times: Floats, rows: Floats) -> int | None:
        """Return the index of the first of these rows, at their times (s), with which the run is to end."""
        return None

    def after(self, point: int, time: float) -> None:
        """See the points that were taken, up to `point` at `time` (s), of which `simulation.row` is; `simulation.k`
        comes next, unless a component has ended the simulation."""

    def end(self) -> None:
        """Do what is to be done where the run ends."""

    def notes(self) -> Sequence[str]:
        """Return warnings of what it could not do."""
        return ()

    def report(self) -> Mapping[str, Any]:
        """Return what the manifest is to have of it."""
        return {}


def overrides(hook: Hook, method: str) -> bool:
    """Whether a hook has a method of its own."""
    return getattr(type(hook), method) is not getattr(Hook, method)


def listed(given: Any) -> list[Any]:
    """Return what a manifest has of the hooks of a kind as a list, also of a single one."""
    return list(given) if isinstance(given, list) else [given]


def together(*parts: Mapping[str, Any]) -> dict[str, Any]:
    """Join what a manifest is to have of several; what more than one of them has becomes a list."""
    joined: dict[str, Any] = {}
    for part in parts:
        for name, value in part.items():
            joined[name] = [*listed(joined[name]), *listed(value)] if name in joined else value
    return joined

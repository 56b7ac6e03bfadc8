"""The compiled stepping loop's twin in Python: the same calls one by one, for the same result to the last bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf

from orchestration.instances.instance import CallFailed, EndRequested, Instance, failing_at
from orchestration.plan.lowering import Call, Floats, Plan
from orchestration.plan.propagation import Ring, execute, read_after_set
from orchestration.process.where import Doing, Where


class PythonLoop:
    """A plan with its instances, used as `Engine` is."""

    def __init__(
        self,
        plan: Plan,
        instances: Mapping[str, Instance],
        *,
        rings: tuple[Ring, ...] = (),
        record_every: int = 1,
        solve: Callable[[int], None] | None = None,
        where: Where | None = None,
    ) -> None:
        self._plan, self._instances, self._rings = plan, instances, rings
        self._record_every, self._solve = record_every, solve
        self._stopped = 0
        self._where = where or Where()
        self.forget_end()

    def forget_end(self) -> None:
        """Nobody has asked yet to end the simulation, unless it was in initialisation."""
        asking = next((i for i in self._instances.values() if i.wants_end), None)
        self._ending: tuple[float, Instance | None] = (inf if asking is None else -inf, asking)

    def ending(self, k: int) -> EndRequested | None:
        """Return the wish of a component to end the simulation at point k, or before."""
        at, instance = self._ending
        return instance.ended() if instance is not None and k >= at else None

    @property
    def doing(self) -> Doing:
        """Point, component and call that are going on; to be read from another thread."""
        return self._where.now

    def stop(self, at_once: bool = False) -> None:
        """Let `steps` return before its next point, or before its next call; to be called from another thread."""
        self._stopped = 2 if at_once else 1

    def propagate(self, k: int = 0, time: float = 0.0) -> None:
        """Execute the get and set calls of point k once."""
        self._where.place.k = k
        for ring in self._rings:
            ring.arrive(k, self._plan.signals)
        with failing_at(time):
            for call in self._plan.calls:
                if k % call.every:
                    continue
                self._go_on(call.component)
                if call.kind == "solve":
                    assert self._solve is not None
                    self._solve(call.loop)
                else:
                    self._execute(call, k)

    def _execute(self, call: Call, k: int) -> None:
        try:
            execute(call, self._plan.signals, self._instances)
        except CallFailed as failed:
            if call.kind == "get":
                read_after_set(failed, self._plan, call, self._instances[call.component], k)
            raise

    def move_on(self, k: int, last: int, time: float, step: float) -> None:
        """Step all components on from point k; none beyond point `last`."""
        self._where.place.k = k
        for ring in self._rings:
            ring.leave(k, self._plan.signals)
        with failing_at(time):
            for name, instance in self._instances.items():
                every = self._plan.every.get(name, 1)
                if k % every == 0 and k + every <= last:
                    self._go_on(name)
                    instance.do_step(time, every * step)
                    if instance.wants_end and k + every < self._ending[0]:
                        self._ending = (k + every, instance)

    def _go_on(self, component: str) -> None:
        if self._stopped > 1:
            raise CallFailed(component, "it was given up")

    def steps(
        self, start: float, step: float, first: int, count: int, last: int, external: Floats | None, rows: Floats
    ) -> tuple[int, int, CallFailed | None]:
        """Co-simulate from point `first` to before point `first + count`; do not step on from point `last`."""
        written = 0
        for k in range(first, first + count):
            if self._stopped:
                return k, written, None
            time = start + k * step
            if external is not None:
                self._plan.signals[: self._plan.n_external] = external[k - first]
            try:
                self.propagate(k, time)
                if k % self._record_every == 0:
                    rows[written] = self._plan.signals[self._plan.row]
                    written += 1
                    self._where.place.rows += 1
                if (end := self.ending(k)) is not None:
                    end.time = time
                    raise end
                if k < last:
                    self.move_on(k, last, time, step)
            except CallFailed as failed:
                return k, written, failed
        return first + count, written, None

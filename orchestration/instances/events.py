"""Event mode of FMI 3.0 Co-Simulation, with clocks: ticked when due, clocked variables held in between.

A communication point at which a clock ticks is one super-dense instant: the clock is activated before values are
propagated and the FMU updates its discrete states when it is stepped on, so that what a clocked component computes from
the values of this point is handed on at this point.
"""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any

from fmpy import fmi3

from orchestration.instances.clocks import Intervals, Timer

if TYPE_CHECKING:
    from orchestration.instances.instance import Instance

_MAX_ITERATIONS = 100
_ERROR = 3


@dataclass
class Snapshot:
    """What belongs to a saved state of the FMU and is not in it."""

    timers: list[Timer]
    next_event: float
    in_event_mode: bool
    active: set[int]
    ticked: set[int]
    held: dict[int, list[Any]]
    pending: set[int]


class Events:
    """The event mode of one instance, which was instantiated with eventModeUsed."""

    def __init__(self, instance: Instance) -> None:
        self._instance = instance
        fmu = instance.fmu
        self._clocks = {c.reference: c for c in fmu.clocks}
        self._outputs = [c.reference for c in fmu.clocks if c.causality == "output"]
        self._clocked = fmu.clocked
        self._ports = {p.references[0]: p for p in fmu.ports.values()}
        self._intervals = Intervals(instance.call, instance.wrong)
        # inputs that only event mode may take, at any communication point
        self._stays = any(
            p.causality == "input" and p.variability == "discrete" and p.references[0] not in self._clocked
            for p in fmu.ports.values()
        )
        self.timers: list[Timer] = []
        self.next_event = inf
        self.in_event_mode = False
        self._initialising = False
        self._active: set[int] = set()  # clocks, in the present instant
        self._ticked: set[int] = set()  # since the communication point before
        self._held: dict[int, list[Any]] = {}  # values of clocked variables
        self._pending: set[int] = set()  # clocked inputs whose held value the FMU has not got yet
        self._wanted = {r for r in self._clocked if r in self._ports and self._ports[r].causality == "output"}
        kinds = {self._ports[r].type for r in (*self._clocked, *self._clocks) if r in self._ports}
        for kind in kinds - {"String", "Binary"}:
            self._interpose(kind)

    # From initialisation on

    def initialise(self) -> None:
        """In initialisation mode: set what could not be set before, clocked inputs."""
        self._initialising = True
        self._set_pending()

    def prepare(self, time: float) -> None:
        """At the end of initialisation mode: learn the intervals and the first values of clocked variables."""
        self.timers = [self._intervals.begin(c, time) for c in self._clocks.values() if c.time_based]
        self._hold(self._wanted)
        self._initialising = False

    def begin(self, time: float, resolution: float = 0.0) -> None:
        """After initialisation mode, which ends in event mode."""
        self.in_event_mode = True
        self._settle(time, resolution, tick=False)
        if not self._instance.wants_end:
            self._wait(time, resolution)

    # At a communication point

    def next_time(self) -> float:
        """Return the time of the next tick or time event."""
        return min((self.next_event, *(t.next for t in self.timers)))

    def next_name(self) -> str:
        """Name what comes next."""
        timer = min(self.timers, key=lambda t: t.next, default=None)
        return "its next event" if timer is None or self.next_event < timer.next else f"clock {timer.clock.name}"

    def inside(self, time: float, resolution: float, *, needed: bool) -> None:
        """Handle what happens at a time inside a communication step, if anything does."""
        self._handle(time, resolution, needed=needed)
        due = self._due(time, resolution)
        if due and not self._instance.wants_end:
            self._enter()
            self._activate(due)
            self._settle(time, resolution, tick=True)
        if self._instance.wants_end:
            raise self._instance.ended(time)
        self._leave()

    def arrive(self, time: float, resolution: float, *, needed: bool) -> None:
        """At the end of a communication step: handle events, and activate the clocks that tick here."""
        self._handle(time, resolution, needed=needed)
        if not self._instance.wants_end:
            self._wait(time, resolution)

    def depart(self, time: float, resolution: float) -> None:
        """After values were propagated: let the FMU update its discrete states, and return to step mode."""
        if self.in_event_mode:
            self._settle(time, resolution, tick=True)
            if self._instance.wants_end:
                raise self._instance.ended(time)
            self._leave()
        self._ticked.clear()

    def snapshot(self) -> Snapshot:
        """Return a copy of all that changes."""
        return Snapshot(
            [copy(t) for t in self.timers],
            self.next_event,
            self.in_event_mode,
            set(self._active),
            set(self._ticked),
            {r: list(v) for r, v in self._held.items()},
            set(self._pending),
        )

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot."""
        self.timers = [copy(t) for t in snapshot.timers]
        self.next_event, self.in_event_mode = snapshot.next_event, snapshot.in_event_mode
        self._active, self._ticked = set(snapshot.active), set(snapshot.ticked)
        self._held = {r: list(v) for r, v in snapshot.held.items()}
        self._pending = set(snapshot.pending)

    def to_bytes(self, snapshot: Snapshot) -> bytes:
        """Return a snapshot as text; numbers come back to the last bit."""
        timers = [
            [t.clock.reference, t.origin.hex(), _pack(t.shift), _pack(t.interval), t.count, t.waiting]
            for t in snapshot.timers
        ]
        held = {r: [_pack(v) for v in values] for r, values in snapshot.held.items()}
        sets = [sorted(s) for s in (snapshot.active, snapshot.ticked, snapshot.pending)]
        return json.dumps([timers, snapshot.next_event.hex(), snapshot.in_event_mode, sets, held]).encode()

    def from_bytes(self, content: bytes) -> Snapshot:
        """Return the snapshot that the text holds."""
        timers, next_event, in_event_mode, sets, held = json.loads(content)
        active, ticked, pending = map(set, sets)
        return Snapshot(
            [
                Timer(self._clocks[r], float.fromhex(origin), _unpack(shift), _unpack(interval), count, waiting)
                for r, origin, shift, interval, count, waiting in timers
            ],
            float.fromhex(next_event),
            in_event_mode,
            active,
            ticked,
            {int(r): [_unpack(v) for v in values] for r, values in held.items()},
            pending,
        )

    def _handle(self, time: float, resolution: float, *, needed: bool) -> None:
        """Let the FMU handle the event that it asked for, or that it announced for now."""
        if needed or self.next_event <= time:
            self._enter()
            self._settle(time, resolution, tick=False)

    def _due(self, time: float, resolution: float) -> list[Timer]:
        return [t for t in self.timers if t.next <= time + resolution]

    def _wait(self, time: float, resolution: float) -> None:
        due = self._due(time, resolution)
        if due or self._stays:
            self._enter()
            self._activate(due)
        else:
            self._leave()

    def _enter(self) -> None:
        if not self.in_event_mode:
            self._instance.call("entering event mode", "enterEventMode")
            self.in_event_mode = True

    def _leave(self) -> None:
        if self.in_event_mode:
            self._instance.call("entering step mode", "enterStepMode")
            self.in_event_mode = False

    def _settle(self, time: float, resolution: float, *, tick: bool) -> None:
        """Update discrete states until nothing is left to do, or the FMU wants to end the simulation.

        `tick` says whether clocks that become due tick, too.
        """
        for _ in range(_MAX_ITERATIONS):
            self._harvest()
            result = self._instance.call("updating discrete states", "updateDiscreteStates")
            needed, terminate, _, _, defined, next_event = result
            if terminate:
                self._instance.wants_end = True
                return
            self.next_event = next_event if defined else inf
            ticked, self._active = self._active, set()
            for timer in self.timers:
                self._intervals.update(timer, time, ticked=timer.clock.reference in ticked)
            due = self._due(time, resolution) if tick else []
            if not needed and not due:
                break
            self._activate(due)
        else:
            again = ", ".join(timer.clock.name for timer in due)
            why = f": clock {again} ticks again and again at this time, its interval is too short" if due else ""
            raise self._instance.wrong(
                f"the event at t = {time:.9g} s does not settle in {_MAX_ITERATIONS} iterations{why}"
            )
        if not self.next_event > time:
            raise self._instance.wrong(f"its next event, at t = {self.next_event!r} s, does not lie ahead of this one")

    def _activate(self, timers: list[Timer]) -> None:
        references = [timer.clock.reference for timer in timers]
        for timer in timers:
            timer.tick(timer.next)
        self._set_clocks(references)

    def _set_clocks(self, references: list[int]) -> None:
        if not references:
            return
        names = ", ".join(self._clocks[r].name for r in references)
        self._instance.call(f"activating {names}", "setClock", references, [True] * len(references))
        self._active.update(references)
        self._ticked.update(references)
        self._set_pending()

    def _set_pending(self) -> None:
        for r in sorted(self._pending):
            if self._accessible(r):
                port = self._ports[r]
                self._instance.call(f"setting {port.name}", f"set{port.type}", [r], self._held[r])

    def _harvest(self) -> None:
        """Before clocks become inactive: see which output clocks tick, and keep the values of clocked variables."""
        self._look()
        if self._active:
            self._hold(r for r in self._wanted if self._accessible(r))

    def _look(self) -> None:
        """Ask which output clocks tick."""
        if self._outputs and self.in_event_mode:
            asked = [r for r in self._outputs if r not in self._active]
            if asked:
                states = self._instance.call("asking for clocks", "getClock", asked)
                ticking = {r for r, on in zip(asked, states, strict=True) if on}
                self._active |= ticking
                self._ticked |= ticking

    def _hold(self, references: Iterable[int]) -> None:
        for r in references:
            port = self._ports[r]
            if r not in self._clocks and port.type not in ("String", "Binary"):
                self._held[r] = list(self._instance.call(f"getting {port.name}", f"get{port.type}", [r], port.size))

    def _accessible(self, reference: int) -> bool:
        return self._initialising or (self.in_event_mode and not self._active.isdisjoint(self._clocked[reference]))

    # Clocked variables and clocks as the propagation sees them

    def _interpose(self, kind: str) -> None:
        """Put functions between the FMU and whoever gets and sets values of a type, compiled or from Python."""
        functions = getattr(self._instance.handle, "_functions")  # noqa: B009 - what fmpy loaded
        value: Any = getattr(fmi3, f"fmi3{kind}")
        prototype = ctypes.CFUNCTYPE(
            ctypes.c_int,
            ctypes.c_void_p,
            ctypes.POINTER(ctypes.c_uint),
            ctypes.c_size_t,
            ctypes.POINTER(value),
            ctypes.c_size_t,
        )
        for verb, element in (("Get", self._get), ("Set", self._set)):
            name = f"fmi3{verb}{kind}"
            functions[name] = prototype(self._guarded(element, functions[name], value))

    def _guarded(self, element: Callable[..., int], real: Any, kind: Any) -> Callable[..., int]:
        size = ctypes.sizeof(kind)

        def access(instance: int, references: Any, n: int, values: Any, _: int) -> int:
            if n == 0:
                return 0
            try:
                start, done, worst = ctypes.addressof(values.contents), 0, 0
                for r in references[:n]:
                    length = self._ports[r].size if r in self._ports else 1
                    part = (kind * length).from_address(start + done * size)
                    reference = (ctypes.c_uint * 1)(r)
                    worst = max(worst, element(r, part, partial(real, instance, reference, 1, part, length)))
                    done += length
                return worst
            except Exception as error:  # cannot pass through C
                self._instance.note(_ERROR, str(error))
                return _ERROR

        return access

    def _get(self, reference: int, part: Any, direct: Callable[[], int]) -> int:
        if reference in self._clocks:
            self._look()
            part[0] = reference in self._ticked
            return 0
        if reference not in self._clocked:
            return direct()
        if any(r in self._outputs for r in self._clocked[reference]):
            self._look()
        if self._accessible(reference):
            return direct()
        self._wanted.add(reference)
        part[:] = self._held.get(reference) or self._ports[reference].start or [0] * len(part)
        return 0

    def _set(self, reference: int, part: Any, direct: Callable[[], int]) -> int:
        if reference in self._clocks:
            if part[0] and self.in_event_mode and reference not in self._active:
                self._set_clocks([reference])
            return 0
        if reference in self._clocked:
            if not self._accessible(reference):
                self._held[reference] = list(part)
                self._pending.add(reference)
                return 0
            self._pending.discard(reference)
        return direct()


def _pack(value: Any) -> Any:
    """Return a number as JSON has it, without loss: fractions as pairs, floats in hexadecimal."""
    if isinstance(value, Fraction):
        return [value.numerator, value.denominator]
    return value.hex() if isinstance(value, float) else value


def _unpack(value: Any) -> Any:
    if isinstance(value, list):
        return Fraction(*value)
    return float.fromhex(value) if isinstance(value, str) else value

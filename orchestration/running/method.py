"""The methods by which a system is solved, each with its options, which check themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.coupled import CoupledModel, CoupledSimulation, SolverName
from orchestration.coupled.model import refuse
from orchestration.fmu.file import FmiVersion, Kind
from orchestration.plan.loops import LoopMethod, LoopSolver, loop_solver
from orchestration.process.guard import Guard
from orchestration.running import adaptive
from orchestration.running.adaptive import AdaptiveSession
from orchestration.running.session import Session, Stepping, rigid
from orchestration.running.simulation import Simulation
from orchestration.system import System
from orchestration.times import Seconds

if TYPE_CHECKING:
    from orchestration.running.outline import Outline


@dataclass(frozen=True, kw_only=True)
class Method:
    """What all methods have; the text below each field is the help of the option of `adcs run`, too."""

    kind: ClassVar[Kind]

    loops: LoopSolver | LoopMethod | None = None
    """Solve algebraic loops by this method; they are refused without."""
    timeout: Seconds = inf
    """Give up when one call of a component takes longer."""

    def __post_init__(self) -> None:
        _positive("timeout", self.patience, endless=True)
        loop_solver(self.loops)

    @property
    def patience(self) -> float:
        """The timeout [s]."""
        return expected.seconds("timeout", self.timeout)

    def refuse(self, system: System, fmi_version: FmiVersion) -> None:
        """Refuse by name what this method cannot solve, before any component is there."""

    def rigid(self, system: System, fmi_version: FmiVersion) -> str | None:
        """Say why the last step may not be shorter than the others; None if it may."""
        raise NotImplementedError

    @property
    def unsaved(self) -> str | None:
        """Say what of it no checkpoint holds; None if it can go on from one."""
        raise NotImplementedError

    def simulation(self, outline: Outline, guard: Guard | None = None) -> Simulation:
        """Make the components, and what solves them."""
        raise NotImplementedError

    def for_manifest(self) -> dict[str, Any]:
        """Return what the manifest has to know to repeat it: all that is not None, but how long to wait."""
        given = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("loops", "timeout")}
        solver = loop_solver(self.loops)
        loops = {} if solver is None else {"solve_loops": asdict(solver)}
        plain = {name: str(value) if isinstance(value, Path) else value for name, value in given.items()}
        return {"method": self.kind, **{name: value for name, value in plain.items() if value is not None}, **loops}

    @classmethod
    def of_manifest(cls, settings: dict[str, Any]) -> Method:
        """Take what `for_manifest` gave out of the settings of a manifest, and return the method."""
        kind = settings.pop("method")
        made = next((each for each in METHODS if each.kind == kind), None)
        if made is None:
            raise AdcsError(f"method {kind!r} is unknown: use {' or '.join(repr(each.kind) for each in METHODS)}")
        return made.taken(settings)

    @classmethod
    def taken(cls, settings: dict[str, Any]) -> Self:
        """Take the fields of this method out of settings, and return it."""
        loops = settings.pop("solve_loops", None)
        given = {f.name: settings.pop(f.name) for f in fields(cls) if f.name in settings}
        return cls(**given, loops=LoopSolver(**loops) if isinstance(loops, Mapping) else loops)


@dataclass(frozen=True)
class CoSimulation(Method):
    """The components step by themselves and exchange values every `step`."""

    kind: ClassVar[Kind] = "co-simulation"

    adaptive: float | None = field(default=None, kw_only=True)
    """Take 2^j exchange steps between two rows, so that halving them changes no output by more than this tolerance
    times (1 + its size)."""
    stepping: Stepping = field(default="compiled", kw_only=True)
    """The loop, for tests and debuggers: "python" makes the same calls one by one, for the same result to the bit."""

    def __post_init__(self) -> None:
        super().__post_init__()
        expected.choice("stepping", self.stepping, Stepping)
        if self.adaptive is not None:
            object.__setattr__(self, "adaptive", expected.number("adaptive", self.adaptive))
            if not (isfinite(self.adaptive) and self.adaptive > 0):
                raise AdcsError(f"adaptive = {self.adaptive}: expected a positive tolerance")

    def refuse(self, system: System, fmi_version: FmiVersion) -> None:
        """Refuse with adaptive steps what counts steps."""
        if self.adaptive is not None:
            adaptive.refuse(system)

    def rigid(self, system: System, fmi_version: FmiVersion) -> str | None:
        """Say which component takes steps of one length only."""
        return rigid(system, fmi_version)

    @property
    def unsaved(self) -> str | None:
        """Say what of it no checkpoint holds."""
        return None if self.adaptive is None else "adaptive exchange steps, whose choice it does not hold"

    def simulation(self, outline: Outline, guard: Guard | None = None) -> Simulation:
        """Make a session."""
        grid, source = outline.grid, outline.source
        session: dict[str, Any] = {
            "step": grid.step,
            "start_time": grid.start,
            "steps": grid.steps,
            "stop_time": grid.stop,
            "fmi_version": outline.fmi_version,
            "stepping": self.stepping,
            "record": list(outline.recording.ports),
            "record_every": outline.save.every,
            "external": () if source is None else source.names,
            "may_go_on": outline.may_go_on,
            "loops": self.loops,
            "where": outline.recording.where,
            "guard": guard,
        }
        made = (
            Session(outline.system, **session)
            if self.adaptive is None
            else AdaptiveSession(outline.system, self.adaptive, **session)
        )
        made.source = source
        return made


@dataclass(frozen=True)
class ModelExchange(Method):
    """All components are integrated as one ordinary differential equation."""

    kind: ClassVar[Kind] = "model-exchange"

    solver: SolverName = "DOP853"
    """The integrator."""
    rtol: float | None = field(default=None, kw_only=True)
    """Its relative tolerance: 1e-12 for DOP853, 1e-10 for CVode."""
    atol: float | None = field(default=None, kw_only=True)
    """Its absolute tolerance, of the nominal value of a state: a hundredth of the relative one."""
    max_step: Seconds | None = field(default=None, kw_only=True)
    """Its longest step: 100 rows, so that nothing that begins of itself is stepped over."""

    def __post_init__(self) -> None:
        super().__post_init__()
        expected.choice("solver", self.solver, SolverName)
        for name in ("rtol", "atol"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _positive(name, expected.number(name, getattr(self, name))))
        if self.max_step is not None:
            object.__setattr__(self, "max_step", _positive("max_step", expected.seconds("max_step", self.max_step)))
        if self.rtol is not None and self.rtol < _MIN_RTOL:
            raise AdcsError(f"rtol = {self.rtol} is below what double precision can hold: use {_MIN_RTOL:.1e} or more")

    def for_manifest(self) -> dict[str, Any]:
        """Return what the manifest has to know to repeat it."""
        _, rtol, atol = self.integrator
        return {**super().for_manifest(), "rtol": rtol, "atol": atol}

    def refuse(self, system: System, fmi_version: FmiVersion) -> None:
        """Refuse what no differential equation can hold."""
        refuse(system, fmi_version)

    @property
    def unsaved(self) -> str | None:
        """Say what of it no checkpoint holds."""
        return "CVode, whose memory of its steps it does not hold" if self.solver == "CVode" else None

    def rigid(self, system: System, fmi_version: FmiVersion) -> str | None:
        """Steps are as long as the integrator likes."""
        return None

    def simulation(self, outline: Outline, guard: Guard | None = None) -> Simulation:
        """Make the coupled model, and what takes it from point to point."""
        grid, recording = outline.grid, outline.recording
        model = CoupledModel(
            outline.system,
            grid.start,
            inf if outline.may_go_on else grid.bound,
            outline.fmi_version,
            list(recording.ports),
            loops=self.loops,
            source=outline.source,
            where=recording.where,
            guard=guard,
        )
        return CoupledSimulation(
            model,
            grid,
            *self.integrator,
            longest=None if self.max_step is None else expected.seconds("max_step", self.max_step),
            record_every=outline.save.every,
            where=recording.where,
        )

    @property
    def integrator(self) -> tuple[SolverName, float, float]:
        """Name, relative and absolute tolerance."""
        rtol = _RTOL[self.solver] if self.rtol is None else self.rtol
        return self.solver, rtol, rtol / 100 if self.atol is None else self.atol


METHODS: tuple[type[Method], ...] = (CoSimulation, ModelExchange)

_RTOL: dict[SolverName, float] = {"DOP853": 1e-12, "CVode": 1e-10}
_MIN_RTOL = 100 * float(np.finfo(float).eps)  # below, the error of a step is all rounding


def _positive(name: str, value: float, *, endless: bool = False) -> float:
    if not (value > 0 and (endless or isfinite(value))):
        raise AdcsError(f"{name} = {value}: expected a positive number")
    return value


def method_of(kind: Kind) -> Method:
    """Return the method of this kind, with nothing but defaults."""
    return next(each() for each in METHODS if each.kind == kind)

"""The options of the commands, each written once: in groups, which a command that takes one takes as a whole."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from adcs.catalogue import find_system
from adcs.cli import words
from adcs.cli.command import Epoch, Speed, Time, Whole, given, group
from adcs.cli.showing import Format
from fmus.errors import AdcsError, Failed
from hil_bridge.frames import FrameName
from orchestration.entry import SystemEntry
from orchestration.fmu.file import FmiVersion, Kind
from orchestration.isolation.folder import ResultsFolder, new_results
from orchestration.plan.loops import LoopMethod
from orchestration.process.writing import make_folder
from orchestration.results.plots import can_draw
from orchestration.running.fitting import Fitting
from orchestration.running.hook import Hook
from orchestration.running.hooks.changes import Changes
from orchestration.running.hooks.inputs import Inputs
from orchestration.running.hooks.pace import Pace
from orchestration.running.hooks.saves import Saves
from orchestration.running.hooks.until import Until
from orchestration.running.method import METHODS, CoSimulation, Method, ModelExchange
from orchestration.running.session import Stepping
from orchestration.system import System

SystemName = Annotated[
    str,
    Parameter(
        help="Name of a system or of a built component (`adcs list`), or an .ssp, .fmu or .py file; of several systems "
        "in that FILE.py:NAME."
    ),
]


@group("System")
class StartValues:
    """What is done to the system that is named, before anything happens with it, where time is continuous."""

    set: Annotated[tuple[str, ...], Parameter(metavar="NAME=VALUE")] = ()
    """Start value of a COMPONENT.VARIABLE; may be repeated. VALUE is 1.5, 0.05deg, 1,2,3 or [[1,2],[3,4]]."""
    fmi: Literal["2", "3"] | None = None
    """FMI version of the components that are known by name. [default: 2]"""

    @property
    def fmi_version(self) -> FmiVersion:
        """The version as FMUs write it."""
        return "3.0" if self.fmi == "3" else "2.0"

    def built(self, name: str) -> tuple[SystemEntry, System]:
        """Find a system, build it and do to it what the options say."""
        entry = find_system(name)
        system = entry.build()
        words.assign(system, self.set)
        return entry, system


@group("System")
class Which(StartValues):
    """The same where there are steps."""

    every: Annotated[tuple[str, ...], Parameter(metavar="COMPONENT=N")] = ()
    """Let a component communicate at every N-th step only; may be repeated."""
    delay: Annotated[tuple[str, ...], Parameter(metavar="INPUT=N|TIME")] = ()
    """Delay what arrives at a connected input by N steps, or by a time as in 0.1s; may be repeated."""

    def built(self, name: str) -> tuple[SystemEntry, System]:
        """Find a system, build it and do to it what the options say."""
        entry, system = super().built(name)
        for text in self.every:
            words.every(system, text)
        for text in self.delay:
            words.delay(system, text)
        return entry, system


@group("Time")
class Steps:
    """How far, and in which steps."""

    step: Time | None = None
    """Time between two exchanges, and two rows. [default: that of the system]"""
    stop: Time | None = None
    """Stop time; the last step of a run is shorter, if need be. [default: that of the system; of a bridge, none]"""

    def step_of(self, entry: SystemEntry) -> float:
        """Return the exchange step [s], which the system does not refuse."""
        step = entry.step if self.step is None else self.step
        if step > 0:
            entry.check_step(step)
        return step

    def stop_of(self, entry: SystemEntry) -> float:
        """Return the stop time [s]."""
        return entry.stop_time if self.stop is None else self.stop


@group("Time")
class Times(Steps):
    """From when, how far, and in which steps."""

    start: Time | None = None
    """Start time. [default: that of the system]"""

    def start_of(self, entry: SystemEntry) -> float:
        """Return the start time [s]."""
        return entry.start_time if self.start is None else self.start


@dataclass(frozen=True, kw_only=True)
class _Choice:
    method: Kind | None = None
    """Exchange values every step, or integrate all components as one differential equation. [default: the latter, if
    nothing is sampled, delayed, from elsewhere or watched from outside, and no --step is asked for]"""


_COMMON = {f.name for f in fields(Method)}


@group("How it is solved")
class Solving(ModelExchange, CoSimulation, _Choice):
    """The method: its options are declared in its class, and here only where words of a command line differ."""

    loops: Annotated[LoopMethod | None, Parameter(name="--solve-loops")] = None
    """Solve algebraic loops by this method."""
    timeout: Time = 120.0
    """Give up when one call of a component takes longer."""
    stepping: Annotated[Stepping, Parameter(parse=False)] = "compiled"
    estimate_error: bool = False
    """Say what the exchange step costs in accuracy, output by output."""

    def made(self) -> Method:
        """Return the method; AdcsError where options of two are given."""
        owner = {f.name: kind for kind in METHODS for f in fields(kind) if f.name not in _COMMON} | {
            "estimate_error": CoSimulation
        }
        asked = [(option, field) for option, field in given(self).items() if field in owner]
        kinds = {owner[field] for _, field in asked}
        if self.method is not None:
            kind: type[Method] = next(each for each in METHODS if each.kind == self.method)
            for option, field in asked:
                if owner[field] is not kind:
                    value = "" if field == "estimate_error" else f" {getattr(self, field)}"
                    other = owner[field].kind
                    raise AdcsError(f"{option}{value}: an option of {other}, leave out --method {self.method}")
        elif len(kinds) > 1:
            each = " and ".join(f"{option} ({owner[field].kind})" for option, field in asked)
            raise AdcsError(f"{each} are options of two methods: leave one out")
        else:
            kind = kinds.pop() if kinds else Fitting
        return kind(**{f.name: getattr(self, f.name) for f in fields(kind)})


@group("What happens during the run")
class During:
    """What happens on the way."""

    at: Annotated[tuple[str, ...], Parameter(metavar="TIME NAME=VALUE", allow_leading_hyphen=True)] = ()
    """Set an unconnected input or a tunable parameter at a time, as in 120s; may be repeated."""
    input_table: Annotated[tuple[Path, ...], Parameter(metavar="PATH")] = ()
    """CSV table of unconnected inputs: columns `time` and COMPONENT.VARIABLE; may be repeated."""
    until: Annotated[tuple[str, ...], Parameter(metavar="CONDITION")] = ()
    """End at the first row where "norm(NAME) < 1e-4 and time > 20" holds; also max(), min(), abs(), or, not, <=, >, >=,
    + - * /."""
    real_time: Speed | None = None
    """Keep pace with the clock, SPEED times as fast."""
    checkpoint: Path | None = None
    """Save the state at the end to this file."""
    checkpoint_every: Time | None = None
    """Save it every so much simulated time, too."""
    resume: Path | None = None
    """Go on from a saved state."""
    in_process: bool = False
    """Do without a process of its own for the run, as for a debugger."""

    def hooks(self, system: System) -> list[Hook]:
        """Return what takes part in a run of the system."""
        hooks: list[Hook] = [Changes([words.change(system, text) for text in self.at])] if self.at else []
        hooks += [Inputs(path) for path in self.input_table]
        hooks += [Until(condition) for condition in self.until]
        if self.real_time is not None:
            hooks.append(Pace(self.real_time))
        if self.checkpoint is not None:
            make_folder(self.checkpoint.parent, f"--checkpoint {self.checkpoint}")
            hooks.append(Saves(self.checkpoint.absolute(), self.checkpoint_every))
        elif self.checkpoint_every is not None:
            raise AdcsError("--checkpoint-every: there is no checkpoint to be written, add --checkpoint FILE")
        return hooks


@group("Ground tools")
class Endpoints:
    """Where messages are sent to, and who may be there."""

    to: Annotated[tuple[str, ...], Parameter(metavar="KIND:HOST:PORT")] = ()
    """Where ground tools are: udpout:, udpin: or tcpin:; may be repeated. [default: udpout:127.0.0.1:14550 and
    :14540]"""
    remote: bool = False
    """Let that be beyond this machine; read `docs/mavlink.md` first."""
    peer: Annotated[tuple[str, ...], Parameter(metavar="ADDRESS")] = ()
    """Hear this address only (udpin, tcpin); may be repeated."""


@group("Ground tools")
class GroundTools(Endpoints):
    """What ground tools see and may do, besides."""

    allow: Annotated[str, Parameter(metavar="WHAT,...")] = ""
    """Let them: arm, param, attitude."""
    key: Path | None = None
    """Sign messages, and take signed ones only, with the key in this file."""
    frame: FrameName = "ned"
    """Frame of the attitude."""
    epoch: Epoch = datetime(2026, 1, 1)
    """UTC at t = 0, for the turning Earth."""
    position: Annotated[str, Parameter(metavar="LAT,LON,HEIGHT", allow_leading_hyphen=True)] = "0,0,500km"
    """Where a system without orbit is shown [deg, m]."""
    map: Annotated[tuple[str, ...], Parameter(metavar="ROLE=NAME")] = ()
    """Variable of a role, as attitude or rate, or a TOML file; may be repeated."""
    show: Annotated[tuple[str, ...], Parameter(metavar="NAME")] = ()
    """Show this output besides; may be repeated."""
    rate: Annotated[tuple[str, ...], Parameter(metavar="MESSAGE=HZ")] = ()
    """Rate of a message; may be repeated."""
    wheel_limit: float | None = None
    """Speed at which a wheel is saturated [rad/s]."""
    tlog: Path | None = None
    """Write a telemetry log."""


@group("Ground tools")
class Streaming(GroundTools):
    """Whether there are any, for a run that may do without."""

    mavlink: bool = False
    """Stream the run by MAVLink, in real time unless --real-time says otherwise."""


@group("Results")
class Report:
    """Where the results go, and how they are told."""

    out: Path | None = None
    """Folder of the results; one that holds some already gets the next number, as in NAME-2. [default:
    results/SYSTEM]"""
    force: bool = False
    """Replace the results that the folder holds."""
    no_report: bool = False
    """Write no report.html."""
    png: bool = False
    """Draw the plots of the report as report.png, too, which takes a second."""
    json: bool = False
    """Print key numbers, outcome and files as JSON."""

    def folder(self, entry: SystemEntry) -> AbstractContextManager[ResultsFolder]:
        """Take the folder, for as long as it is written to."""
        if self.png and self.no_report:
            raise AdcsError("--png draws the plots of the report: leave out --no-report")
        if self.png and not can_draw():
            raise Failed("--png: matplotlib is not installed: pip install 'adcs-fmus[plot]'")
        return new_results(self.out or Path("results") / entry.name, self.force)


@group("Results")
class Results(Report):
    """Which results there are besides."""

    record: Annotated[tuple[str, ...], Parameter(metavar="NAME")] = ()
    """Write this variable only; may be repeated. [default: all outputs]"""
    rows: Time | None = None
    """Time between two rows. [default: the step]"""
    record_every: Whole = 1
    """Write every N-th row only."""
    format: tuple[Format, ...] = ()
    """Kind of result file; may be repeated. With hdf5 alone a run may be larger than memory. [default: csv, mat]"""

"""The exchange with an autopilot at each communication point: sensors out, controls in, one step of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from math import isfinite
from time import monotonic
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from fmus.errors import AdcsError
from hil_bridge.frames import Earth, Floats, FrameName, Place
from hil_bridge.hil.actuators import Actuators
from hil_bridge.hil.field import MagneticField
from hil_bridge.hil.link import Link
from hil_bridge.hil.messages import Messages, Moment, frame
from hil_bridge.hil.wiring import Wiring
from orchestration.running.session import Session
from orchestration.system import System

BOOT_USEC = 1_000_000
"""What the autopilot's clock shows at t = 0: to many receivers a time of 0 means that there is none."""

_HEARTBEAT_PERIOD = 1.0  # s, all of simulated time
_GPS_PERIOD = 0.2
_FIELD_PERIOD = 0.1  # in which the field along a low orbit changes by some 0.01 microtesla
_MOST_REPLIES = 100  # to requests between two points; more are not answered
_PATIENCE = 1.0  # s of real time for the first answer, before an autopilot that is still booting is not waited for


@dataclass(frozen=True)
class Terms:
    """How simulation and autopilot go together.

    With `lockstep` every point waits up to `timeout` s for the answer to its sensors; without, points are taken at
    `speed` times real time, with the controls that came last, which may be `timeout` s old. An autopilot that does not
    answer at once is booting: it has `warm_up` s of simulated time to do so, at `speed` times real time, and nobody
    waits for it meanwhile.
    `truth` and `star_tracker` say whether HIL_STATE_QUATERNION and ODOMETRY are sent.
    """

    lockstep: bool = True
    timeout: float = 5.0
    warm_up: float = 60.0
    speed: float = 1.0
    frame: FrameName = "ned"
    epoch: datetime = field(default_factory=lambda: datetime(2026, 1, 1))
    truth: bool = True
    star_tracker: bool = True

    def __post_init__(self) -> None:
        for name, value, least in (
            ("timeout", self.timeout, None),
            ("warm-up", self.warm_up, 0.0),
            ("speed", self.speed, None),
        ):
            if not (isfinite(value) and (value > 0 or value == least)):
                raise AdcsError(
                    f"{name} = {value}: expected a {'positive number' if least is None else 'number from 0'}"
                )


@dataclass
class Account:
    """What happened on the line; messages that are late belong to an earlier point and are dropped."""

    answered: int = 0
    not_waited_for: int = 0
    late: int = 0
    ahead: int = 0
    round_trips: list[float] = field(default_factory=list)  # s
    locked_at: float | None = None  # s of simulated time


class Flight:
    """Flies a system: to be called at each communication point, before it is propagated, recorded and stepped on from.

    What the sensors show at point k is answered by controls that act from point k to k+1: no delay is added.
    """

    def __init__(self, system: System, link: Link, wiring: Wiring, actuators: Actuators, terms: Terms) -> None:
        self.account = Account()
        self.actuators = actuators
        self._link, self._wiring, self._terms = link, wiring, terms
        self._messages = Messages(wiring)
        self._earth = Earth(terms.epoch)
        orbits = wiring.position is not None
        self._field = MagneticField(self._earth) if wiring.magnetic_field is not None and orbits else None
        if terms.frame == "lvlh" and not orbits:
            raise AdcsError(f"frame lvlh: {system.name} has no orbit (outputs r_ON_N, v_ON_N)")
        self._truth_period = 0.0 if terms.truth else None
        self._first: int | None = None
        self._origin = self._controls_at = 0.0  # of time.monotonic
        self._replies: list[bytes] = []
        self._columns: dict[str, slice] = {}

    def __call__(self, simulation: Session) -> None:
        """Tell the autopilot of point k, take its answer, set the torque."""
        first = self._first is None
        if first:
            self._first = simulation.k
        moment = self._moment(simulation)
        self._link.send(self._told(simulation, moment))
        sent = monotonic()
        if first:
            self._origin = self._controls_at = sent
        answer = self._answer(simulation, moment.time_usec)
        if answer is not None:
            self.account.answered += 1
            self.account.round_trips.append(monotonic() - sent)
            self._controls_at = monotonic()
            simulation.set(self._wiring.torque, self.actuators.torque(answer))

    def report(self) -> dict[str, Any]:
        """All that was counted, and how long answers took [s]."""
        account, frames = self.account, self._link.frames
        trips = np.array(account.round_trips or [0.0])
        return {
            "autopilot": self._link.peer,
            "locked_at_s": account.locked_at,
            "points_answered": account.answered,
            "points_not_waited_for": account.not_waited_for,
            "answers_late": account.late,
            "answers_ahead": account.ahead,
            "controls_clipped": self.actuators.clipped,
            "controls_not_numbers": self.actuators.not_numbers,
            "answers_not_armed": self.actuators.disarmed,
            "messages_received": frames.messages,
            "garbage_bytes": frames.garbage,
            "answer_median_s": float(np.median(trips)),
            "answer_99_percent_s": float(np.percentile(trips, 99)),
        }

    def _moment(self, simulation: Session) -> Moment:
        simulation.propagate()
        values = self._finite(simulation)
        t = simulation.time
        r_N, v_N = (values[name] if name else None for name in (self._wiring.position, self._wiring.velocity))
        place: Place | None = None
        if r_N is not None and v_N is not None:
            place = self._earth.place(t, r_N, v_N)
            if self._field is not None and self._due(simulation, _FIELD_PERIOD):
                assert self._wiring.magnetic_field is not None
                simulation.set(self._wiring.magnetic_field, self._field.at(t, place))
                simulation.propagate()  # the magnetometer measures the field of now
                values = self._finite(simulation)
        q_FN = frame(self._terms.frame, place, r_N, v_N)
        return Moment(BOOT_USEC + round(1e6 * t), values, place, q_FN)

    def _finite(self, simulation: Session) -> dict[str, Floats]:
        """The values of the point; an autopilot is told no numbers that are none."""
        if not self._columns:
            self._columns = _columns(simulation, self._wiring.outputs)
        row = simulation.row
        values = {name: row[columns] for name, columns in self._columns.items()}
        if not np.isfinite(row).all():
            for name, value in values.items():
                if not np.isfinite(value).all():
                    raise AdcsError(f"{name} is {value} at t = {simulation.time:g} s: nothing to tell an autopilot")
        return values

    def _due(self, simulation: Session, period: float) -> bool:
        """Whether something that is done every so often is to be done at this point, and at the first in any case."""
        return (simulation.k - (self._first or 0)) % max(1, round(period / simulation.step)) == 0

    def _told(self, simulation: Session, now: Moment) -> bytes:
        """All messages of a point; HIL_SENSOR is the last, for it lets the autopilot's time go on."""
        parts, self._replies = self._replies, []
        if self._due(simulation, _HEARTBEAT_PERIOD):
            parts.append(self._messages.heartbeat())
        if now.place is not None and self._due(simulation, _GPS_PERIOD):
            parts.append(self._messages.gps(now))
        if self._truth_period is not None and self._due(simulation, self._truth_period):
            parts.append(self._messages.truth(now))
        if self._terms.star_tracker and self._wiring.star_tracker is not None:
            parts.append(self._messages.star_tracker(now))
        return b"".join([*parts, self._messages.sensors(now)])

    def _answer(self, simulation: Session, time_usec: int) -> Any:
        """The controls for this point; None if there are none and nobody waits for them."""
        terms, account = self._terms, self.account
        if not terms.lockstep:
            answer = self._latest(simulation)
        elif account.locked_at is None and terms.warm_up > 0:
            answer = self._first_answer(simulation, time_usec)
        else:
            answer = self._exact(simulation, time_usec)
        if answer is None:
            account.not_waited_for += 1
        elif account.locked_at is None:
            account.locked_at = simulation.time
        return answer

    def _exact(self, simulation: Session, time_usec: int) -> Any:
        """Wait for the answer to the sensors of this very point."""
        deadline = monotonic() + self._terms.timeout
        while True:
            messages = self._link.receive(deadline)
            if (answer := self._matching(self._controls(messages), time_usec)) is not None:
                return answer
            if not messages or monotonic() >= deadline:
                break
        late, ahead = self.account.late, self.account.ahead
        wrong = f" ({late} answers were late, {ahead} ahead of time)" if late or ahead else ""
        raise AdcsError(
            f"the autopilot at {self._link.peer} did not answer the sensors of t = {simulation.time:g} s within "
            f"{self._terms.timeout:g} s{wrong}"
        )

    def _matching(self, controls: list[Any], time_usec: int) -> Any:
        """The one that belongs to this point, by its time."""
        answer = None
        for message in controls:
            if message.time_usec == time_usec:
                answer = answer or message
            elif message.time_usec < time_usec:
                self.account.late += 1
            else:
                self.account.ahead += 1
        return answer

    def _first_answer(self, simulation: Session, time_usec: int) -> Any:
        """Wait a little at the first point, then as long as time takes; the first answer of all ends this."""
        assert self._first is not None
        steps = simulation.k - self._first
        if steps * simulation.step >= self._terms.warm_up:
            raise AdcsError(
                f"the autopilot at {self._link.peer} did not answer within the {self._terms.warm_up:g} s of its warm-up"
            )
        deadline = self._origin + (steps * simulation.step / self._terms.speed if steps else _PATIENCE)
        while True:
            if controls := self._controls(self._link.receive(deadline)):
                answer = self._matching(controls, time_usec)
                return answer if answer is not None else self._exact(simulation, time_usec)
            if monotonic() >= deadline:
                if not steps:
                    self._origin = monotonic()  # what was waited is not to be caught up with
                return None

    def _latest(self, simulation: Session) -> Any:
        """Take what comes until the next point is due; the last word counts."""
        assert self._first is not None
        deadline = self._origin + (simulation.k - self._first + 1) * simulation.step / self._terms.speed
        answer = None
        while True:
            messages = self._link.receive(deadline)
            for message in self._controls(messages):
                answer = message
            now = monotonic()
            if now >= deadline and (not messages or now >= deadline + self._terms.timeout):
                break
        silent = now - self._controls_at
        allowed = (
            self._terms.timeout if self.account.locked_at is not None else self._terms.timeout + self._terms.warm_up
        )
        if answer is None and silent > allowed:
            raise AdcsError(
                f"the autopilot at {self._link.peer} has sent no controls for {silent:.3g} s, at "
                f"t = {simulation.time:g} s"
            )
        return answer

    def _controls(self, messages: list[Any]) -> list[Any]:
        """Those that are controls; requests among the others are answered with the next sensors."""
        controls = []
        for message in messages:
            kind = message.get_type()
            if kind == "HIL_ACTUATOR_CONTROLS":
                controls.append(message)
            elif kind == "COMMAND_LONG" and len(self._replies) < _MOST_REPLIES:
                self._replies.append(self._messages.acknowledgement(message.command, self._requested(message)))
        return controls

    def _requested(self, message: Any) -> bool:
        """Serve SET_MESSAGE_INTERVAL of HIL_STATE_QUATERNION, the one that PX4 asks for."""
        if (
            message.command != mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
            or message.param1 != mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION
            or not (isfinite(message.param2) and self._terms.truth)
        ):
            return False
        self._truth_period = None if message.param2 < 0 else 1e-6 * message.param2
        return True


def _columns(simulation: Session, names: Sequence[str]) -> dict[str, slice]:
    """Where these variables are in a row."""
    first, found = 0, {}
    for name, port in simulation.recording.ports.items():
        found[name] = slice(first, first + port.size)
        first += port.size
    return {name: found[name] for name in names}

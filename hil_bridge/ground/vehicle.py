"""The vehicle that ground stations talk to: answers requests, and passes on the commands that are allowed."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import isfinite
from time import time_ns
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from fmus.errors import AdcsError
from hil_bridge import frames
from hil_bridge.frames import Floats
from hil_bridge.ground.endpoints import Peer
from hil_bridge.ground.parameters import Parameter
from hil_bridge.ground.settings import COMPONENT_ID, SYSTEM_ID, Settings
from hil_bridge.ground.state import Scene, State
from hil_bridge.ground.streams import Streams
from hil_bridge.ground.telemetry import MESSAGES, Message, Report, heartbeat_of
from hil_bridge.wire import clamped, float32, texts

Changes = list[tuple[str, Any]]

_ACCEPTED: int = mavlink.MAV_RESULT_ACCEPTED
_DENIED: int = mavlink.MAV_RESULT_DENIED
_UNSUPPORTED: int = mavlink.MAV_RESULT_UNSUPPORTED
_LATER: int = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
_FORGOTTEN = 10.0  # s of silence, after which a ground station is greeted anew
_BATCH = 10  # queued messages that go out at once
_MOST_QUEUED = 500
_MOST_ID = 65535
_MOST_PENDING, _MOST_WARNINGS = 100, 64
_LOST = 30.0  # s, after which the simulation's answer to a change is not waited for any more

_CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
)
_FTP_NAK, _FTP_OPEN, _FTP_NOT_FOUND, _FTP_UNKNOWN = 129, (4, 6, 7), 10, 7
_OFFBOARD = 6  # PX4's number of the mode
_UNDECIDED = 0.05  # cosine of half the angle to the target: within 6 deg of half a revolution


@dataclass
class _Pending:
    """A parameter that waits for the simulation, and who asked."""

    peer: Peer
    parameters: Sequence[Parameter]
    values: Sequence[float]
    since: float  # s


class Vehicle:
    """State of the vehicle besides the simulation's: parameters, mode, what is on its way.

    `request` passes changes of FMU variables on, with their source and the number under which the answer comes.
    """

    def __init__(self, settings: Settings, request: Callable[[int, str, Changes, str], None]) -> None:
        self.settings, self.scene = settings, Scene(settings)
        self._rates = message_rates(settings)
        self.armed, self.pointing = True, False
        self.over: int | None = None
        self.state: State | None = None
        self.report: Report | None = None
        self._request = request
        self._pending: dict[int, _Pending] = {}
        self._number = 0
        self._text_id = 0
        self._setpoint_at = -1e9
        self._commanded: Floats | None = None
        self._commanded_by = 0
        self._now = 0.0
        self._last_warning: dict[str, float] = {}
        self._parameters = list(settings.parameters)
        self._by_id = {p.id: i for i, p in enumerate(self._parameters)}
        self._by_element = {p.element: p for p in self._parameters}
        self._by_variable: dict[str, list[Parameter]] = {}
        for parameter in self._parameters:
            self._by_variable.setdefault(parameter.variable, []).append(parameter)
        self._handlers: dict[str, Callable[[Peer, Any, float], None]] = {
            "HEARTBEAT": lambda peer, message, now: None,
            "PARAM_REQUEST_LIST": self._list_parameters,
            "PARAM_REQUEST_READ": self._read_parameter,
            "PARAM_SET": self._set_parameter,
            "COMMAND_LONG": self._command,
            "COMMAND_INT": self._command,
            "SET_MODE": lambda peer, message, now: self._mode(peer, message.base_mode, message.custom_mode >> 16, now),
            "REQUEST_DATA_STREAM": self._data_stream,
            "SET_ATTITUDE_TARGET": self._attitude_target,
            "PING": self._ping,
            "TIMESYNC": self._timesync,
            "FILE_TRANSFER_PROTOCOL": self._file,
            "MISSION_REQUEST_LIST": self._mission_count,
            "MISSION_COUNT": self._no_mission,
            "MISSION_CLEAR_ALL": self._no_mission,
            "MISSION_WRITE_PARTIAL_LIST": self._no_mission,
            "SYSTEM_TIME": lambda peer, message, now: None,
        }

    # What it says -----------------------------------------------------------------------------------------------------

    def show(self, state: State, load: float = 0.0) -> None:
        """Take the state of a new point."""
        self.state = state
        self.report = Report(state, self.armed, self.pointing, load)

    def heartbeat(self) -> Message:
        """Return a heartbeat, state or none."""
        return heartbeat_of(self.armed, self.pointing, self.over)

    def beat(self, peer: Peer, now: float) -> None:
        """Send a partner a heartbeat when it is due on the clock, whether the simulation goes on or not."""
        interval = peer.stream.interval(mavlink.MAVLINK_MSG_ID_HEARTBEAT)
        if interval and now - peer.beat >= interval:
            late = now - peer.beat - interval
            peer.beat = now if late > interval else now - late  # does not drift, and makes up for nothing
            peer.send(self.heartbeat())

    def end(self, text: str, failed: bool) -> list[Message]:
        """Say that the run is over: why, and by a last heartbeat that the vehicle is off, or in trouble."""
        self.over = mavlink.MAV_STATE_EMERGENCY if failed else mavlink.MAV_STATE_POWEROFF
        severity = mavlink.MAV_SEVERITY_CRITICAL if failed else mavlink.MAV_SEVERITY_INFO
        return [*self.text(text, severity), self.heartbeat()]

    def text(self, text: str, severity: int = mavlink.MAV_SEVERITY_INFO) -> list[Message]:
        """Return a text as messages, several if it is long."""
        pieces = texts(text)
        if len(pieces) == 1:
            return [mavlink.MAVLink_statustext_message(severity, pieces[0])]
        self._text_id = self._text_id % 65535 + 1
        return [mavlink.MAVLink_statustext_message(severity, p, self._text_id, i) for i, p in enumerate(pieces)]

    def banner(self) -> list[Message]:
        """What each new ground station is told."""
        allowed = ", ".join(self.settings.allow) or "nothing: read-only"
        lines = [f"adcs: {self.settings.system}", self.scene.announcement, f"Allowed: {allowed}", *self.settings.notes]
        return [message for line in lines for message in self.text(line)]

    def all_parameters(self) -> list[Message]:
        """Return all parameters with their present values."""
        return [self._parameter_value(p) for p in self._parameters]

    def stream(self, peer: Peer, now: float) -> None:
        """Send a partner what is due for it; `now` is the time of its streams [s]."""
        if self.report is None:
            return
        for id_ in peer.stream.due(now):
            if id_ == mavlink.MAVLINK_MSG_ID_HEARTBEAT:  # goes by the clock: `beat`
                continue
            for message in self.report.messages(id_):
                peer.send(message)

    def flush(self, peer: Peer) -> None:
        """Send some of what is queued for a partner."""
        for _ in range(min(_BATCH, len(peer.queue))):
            peer.send(peer.queue.popleft())

    # What it hears ----------------------------------------------------------------------------------------------------

    def greet(self, peer: Peer) -> None:
        """Give a partner its streams."""
        peer.stream = Streams(self._rates)

    def handle(self, peer: Peer, message: Any, now: float) -> None:
        """Answer a message; what is meant for another vehicle, and what is not known, is left alone."""
        if peer.spoke is None or now - peer.spoke > _FORGOTTEN:
            self._queue(peer, self.banner())
        peer.spoke = now
        if getattr(message, "target_system", 0) not in (0, SYSTEM_ID):
            return
        if getattr(message, "target_component", 0) not in (0, COMPONENT_ID):
            return
        handler = self._handlers.get(message.get_type())
        if handler is not None:
            handler(peer, message, now)

    def tick(self, now: float) -> list[Message]:
        """Let a commanded attitude end when nobody repeats it; return what is to be said."""
        self._now = now
        for number in [n for n, pending in self._pending.items() if now - pending.since > _LOST]:
            pending = self._pending.pop(number)  # its answer got lost on the way
            self._queue(pending.peer, [self._parameter_value(p) for p in pending.parameters])
        if not self.pointing or now - self._setpoint_at <= self.settings.setpoint_timeout:
            return []
        self._release("attitude target timed out")
        return self.text("Attitude target timed out: back to guidance", mavlink.MAV_SEVERITY_WARNING)

    def answered(self, number: int, refused: str | None) -> list[Message]:
        """Take the simulation's answer to a request; return what is to be said to all."""
        pending = self._pending.pop(number, None)
        if pending is None:
            if refused is None:
                return []
            if number == self._commanded_by:
                self.pointing, self._setpoint_at, self._commanded = False, -1e9, None
            return self.text(refused, mavlink.MAV_SEVERITY_ERROR) if self._is_news(refused, self._now) else []
        if refused is None:
            for parameter, value in zip(pending.parameters, pending.values, strict=True):
                parameter.value = value
        self._queue(pending.peer, [self._parameter_value(p) for p in pending.parameters])
        if refused is not None:
            return self.text(refused, mavlink.MAV_SEVERITY_ERROR)
        first = pending.parameters[0]
        return self.text(f"{first.element} = {first.value:g} {first.unit}".rstrip())

    def _queue(self, peer: Peer, messages: Iterable[Message]) -> None:
        for message in messages:
            if len(peer.queue) < _MOST_QUEUED:
                peer.queue.append(message)

    def _warn(self, peer: Peer, text: str, now: float) -> None:
        """Say something to one partner, not more than once a second."""
        if self._is_news(text, now):
            self._queue(peer, self.text(text, mavlink.MAV_SEVERITY_WARNING))

    def _is_news(self, text: str, now: float) -> bool:
        """Whether it was not said in the last second."""
        if abs(now - self._last_warning.get(text, -1e9)) <= 1.0:
            return False
        if len(self._last_warning) >= _MOST_WARNINGS:  # the words are a stranger's, and he has many
            self._last_warning.clear()
        self._last_warning[text] = now
        return True

    def _allowed(self, what: str, peer: Peer, now: float) -> bool:
        if what in self.settings.allow:
            return True
        self._warn(peer, f"Read-only: start with --allow {what}", now)
        return False

    def _ask(self, kind: str, changes: Changes, source: str) -> int:
        self._number += 1
        self._request(self._number, kind, changes, source)
        return self._number

    # Parameters -------------------------------------------------------------------------------------------------------

    def _parameter_value(self, parameter: Parameter) -> Message:
        return mavlink.MAVLink_param_value_message(
            parameter.id.encode(),
            float32(parameter.value),
            mavlink.MAV_PARAM_TYPE_REAL32,
            len(self._parameters),
            self._by_id[parameter.id],
        )

    def _list_parameters(self, peer: Peer, message: Any, now: float) -> None:
        self._queue(peer, self.all_parameters())

    def _read_parameter(self, peer: Peer, message: Any, now: float) -> None:
        index = message.param_index if message.param_index >= 0 else self._by_id.get(message.param_id, -1)
        if 0 <= index < len(self._parameters):
            peer.send(self._parameter_value(self._parameters[index]))

    def _set_parameter(self, peer: Peer, message: Any, now: float) -> None:
        index = self._by_id.get(message.param_id)
        if index is None:
            self._warn(peer, f"No parameter {message.param_id}", now)
            return
        parameter = self._parameters[index]
        try:
            if message.param_type != mavlink.MAV_PARAM_TYPE_REAL32:  # others encode integers as bytes of a float
                raise AdcsError(f"{parameter.id}: all parameters are of type REAL32")
            value = parameter.checked(message.param_value)
        except AdcsError as error:
            self._warn(peer, str(error), now)
            self._queue(peer, [self._parameter_value(parameter)])
            return
        if not self._allowed("param", peer, now):
            self._queue(peer, [self._parameter_value(parameter)])
            return
        if len(self._pending) >= _MOST_PENDING:
            self._warn(peer, "Too many changes at once: wait for the answers", now)
            self._queue(peer, [self._parameter_value(parameter)])
            return
        touched = self._symmetric(parameter)
        whole = [value if p in touched else self._coming(p) for p in self._by_variable[parameter.variable]]
        number = self._ask("param", [(parameter.variable, whole)], peer.name)
        self._pending[number] = _Pending(peer, touched, [value] * len(touched), now)

    def _coming(self, parameter: Parameter) -> float:
        """The value that was asked for last, if that is on its way: the next change must not take it back."""
        for pending in reversed(self._pending.values()):
            for other, value in zip(pending.parameters, pending.values, strict=True):
                if other is parameter:
                    return value
        return parameter.value

    def _symmetric(self, parameter: Parameter) -> list[Parameter]:
        """The element, and in a symmetric matrix the one across the diagonal: half of a pair makes no inertia."""
        name, bracket, index = parameter.element.rpartition("[")
        row, comma, column = index.rstrip("]").partition(",")
        mirror = self._by_element.get(f"{name}[{column},{row}]") if bracket and comma and row != column else None
        values = np.array([p.value for p in self._by_variable[parameter.variable]])
        n = round(len(values) ** 0.5)
        if mirror is None or n * n != len(values) or not np.array_equal(values.reshape(n, n), values.reshape(n, n).T):
            return [parameter]
        return [parameter, mirror]

    # Commands ---------------------------------------------------------------------------------------------------------

    def _command(self, peer: Peer, message: Any, now: float) -> None:
        p1, p2 = message.param1, message.param2
        result = _UNSUPPORTED
        extra: list[Message] = []
        if not (isfinite(p1) or message.command == mavlink.MAV_CMD_DO_SET_MODE):
            result = _DENIED
        elif message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            result = self._arm(peer, p1 >= 0.5, now)
        elif message.command == mavlink.MAV_CMD_DO_SET_MODE:
            result = self._set_mode(peer, round(p2) if isfinite(p2) else 0, now)
        elif message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            result = self._set_interval(peer, round(p1), p2)
        elif message.command == mavlink.MAV_CMD_GET_MESSAGE_INTERVAL:
            extra = self._interval(peer, round(p1))
            result = _ACCEPTED if extra else _DENIED
        elif message.command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            found = self._requested(peer, round(p1), p2)
            result, extra = (_ACCEPTED, found) if found else (_UNSUPPORTED, [])
        elif message.command == mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
            result, extra = _ACCEPTED, [_autopilot_version()]
        sender, component = message.get_srcSystem(), message.get_srcComponent()
        peer.send(mavlink.MAVLink_command_ack_message(message.command, result, 0, 0, sender, component))
        for each in extra:
            peer.send(each)

    def _arm(self, peer: Peer, arm: bool, now: float) -> int:
        if not self._allowed("arm", peer, now):
            return _DENIED
        if self.settings.arm is None:
            return _UNSUPPORTED
        self._ask("arm", [(self.settings.arm, int(arm))], peer.name)
        if arm != self.armed:
            self.armed = arm
            self._queue(peer, self.text("Armed: control loop closed" if arm else "Disarmed: control torque is zero"))
        return _ACCEPTED

    def _set_mode(self, peer: Peer, main_mode: int, now: float) -> int:
        if not self._allowed("attitude", peer, now):
            return _DENIED
        if self.settings.point is None:
            return _UNSUPPORTED
        if main_mode == _OFFBOARD:
            return _ACCEPTED if now - self._setpoint_at <= self.settings.setpoint_timeout else _LATER
        if self.pointing:
            self._release(peer.name)
        return _ACCEPTED

    def _mode(self, peer: Peer, base_mode: int, main_mode: int, now: float) -> None:
        self._set_mode(peer, main_mode, now)

    def _attitude_target(self, peer: Peer, message: Any, now: float) -> None:
        point, state = self.settings.point, self.state
        if not self._allowed("attitude", peer, now) or state is None or state.q_FN is None:
            return
        if point is None:
            self._warn(peer, "This system takes no attitude target", now)
            return
        q = np.array(message.q, float)
        length = float(np.linalg.norm(q)) if np.isfinite(q).all() else 0.0
        if message.type_mask & mavlink.ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE or abs(length - 1) > 0.01:
            self._warn(peer, "Attitude target without a unit quaternion ignored", now)
            return
        rates = [message.body_roll_rate, message.body_pitch_rate, message.body_yaw_rate]
        rates = [0.0 if message.type_mask >> i & 1 or not isfinite(r) else r for i, r in enumerate(rates)]
        q_CN = self._short_way(frames.unit(frames.multiply(q / length, state.q_FN)), state)
        changes: Changes = [(point.attitude, q_CN.tolist())]
        if point.rate is not None:
            changes.append((point.rate, rates))
        if point.engaged is not None:
            changes.append((point.engaged, 1))
        self._setpoint_at = now
        self._commanded_by = self._ask("attitude", changes, peer.name)
        if not self.pointing:
            self.pointing = True
            self._queue(peer, self.text("Attitude target taken"))

    def _short_way(self, q_CN: Floats, state: State) -> Floats:
        """The sign of a commanded quaternion from which the body has the short way to turn.

        It is that nearest to the attitude which the control law sees. Near half a revolution, where measurement noise
        would toss the sign, a command that is repeated keeps the one it had.
        """
        q_BN = state.inertial("attitude")
        if q_BN is None:
            q_BN = state.inertial("true_attitude")
        if q_BN is None:
            return q_CN
        if self._commanded is not None and abs(float(q_CN @ q_BN)) < _UNDECIDED:
            q_BN = self._commanded
        self._commanded = frames.nearest(q_CN, q_BN)
        return self._commanded

    def _release(self, source: str) -> None:
        self.pointing = False
        self._commanded = None
        self._setpoint_at = -1e9
        if self.settings.point is not None and self.settings.point.engaged is not None:
            self._ask("attitude", [(self.settings.point.engaged, 0)], source)

    # Rates and requests -----------------------------------------------------------------------------------------------

    def _set_interval(self, peer: Peer, id_: int, microseconds: float) -> int:
        if id_ not in MESSAGES:
            return _UNSUPPORTED
        if not isfinite(microseconds):
            return _DENIED
        if microseconds == 0:
            peer.stream.reset(id_)
        else:
            peer.stream.set(id_, microseconds * 1e-6 if microseconds > 0 else 0.0)
        return _ACCEPTED

    def _interval(self, peer: Peer, id_: int) -> list[Message]:
        """What MESSAGE_INTERVAL says: microseconds, -1 never, 0 not known; nothing of a number it cannot hold."""
        if not 0 <= id_ <= _MOST_ID:
            return []
        interval = peer.stream.interval(id_)
        us = clamped(interval * 1e6, 32) if interval else (-1 if id_ in MESSAGES else 0)
        return [mavlink.MAVLink_message_interval_message(id_, us)]

    def _requested(self, peer: Peer, id_: int, parameter: float) -> list[Message]:
        if id_ == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            return [_autopilot_version()]
        if id_ == mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL:
            return self._interval(peer, round(parameter)) if isfinite(parameter) else []
        return [] if self.report is None else self.report.messages(id_)

    def _data_stream(self, peer: Peer, message: Any, now: float) -> None:
        peer.stream.group(message.req_stream_id, message.req_message_rate if message.start_stop else 0)

    def _ping(self, peer: Peer, message: Any, now: float) -> None:
        if message.target_system == 0:
            sender = (message.get_srcSystem(), message.get_srcComponent())
            peer.send(mavlink.MAVLink_ping_message(message.time_usec, message.seq, *sender))

    def _timesync(self, peer: Peer, message: Any, now: float) -> None:
        if message.tc1 == 0:
            peer.send(mavlink.MAVLink_timesync_message(time_ns(), message.ts1))

    def _file(self, peer: Peer, message: Any, now: float) -> None:
        """There are no files; a ground station that gets no answer would wait."""
        payload = bytes(message.payload)
        sequence, session, opcode = struct.unpack_from("<HBB", payload)
        error = _FTP_NOT_FOUND if opcode in _FTP_OPEN else _FTP_UNKNOWN
        reply = struct.pack("<HBBBBBBIB", (sequence + 1) % 65536, session, _FTP_NAK, 1, opcode, 0, 0, 0, error)
        padded = list(reply.ljust(251, b"\0"))
        sender = (message.get_srcSystem(), message.get_srcComponent())
        peer.send(mavlink.MAVLink_file_transfer_protocol_message(0, *sender, padded))

    def _mission_count(self, peer: Peer, message: Any, now: float) -> None:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        peer.send(mavlink.MAVLink_mission_count_message(*sender, 0, message.mission_type))

    def _no_mission(self, peer: Peer, message: Any, now: float) -> None:
        empty = message.get_type() == "MISSION_CLEAR_ALL"
        result = mavlink.MAV_MISSION_ACCEPTED if empty else mavlink.MAV_MISSION_UNSUPPORTED
        sender = (message.get_srcSystem(), message.get_srcComponent())
        peer.send(mavlink.MAVLink_mission_ack_message(*sender, result, getattr(message, "mission_type", 0)))


def message_rates(settings: Settings) -> dict[int, float]:
    """Return the rates that were asked for, by number of the message [1/s]."""
    ids = {str(kind.msgname): id_ for id_, kind in mavlink.mavlink_map.items()}
    found = {}
    for name, rate in settings.rates.items():
        if ids.get(name.upper()) not in MESSAGES:
            raise AdcsError(f"rate of {name}: the bridge has no such message")
        if not (isfinite(rate) and rate >= 0):
            raise AdcsError(f"rate of {name} = {rate} Hz: expected a number from 0")
        found[ids[name.upper()]] = rate
    return found


def _autopilot_version() -> Message:
    return mavlink.MAVLink_autopilot_version_message(
        _CAPABILITIES, 0x00010000, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0
    )

"""MAVLink messages of a state, one function for each message."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import atan2, degrees, hypot, pi
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from hil_bridge import frames
from hil_bridge.frames import Place
from hil_bridge.ground.state import State
from hil_bridge.wire import U16_UNKNOWN, clamped, float32, floats, microseconds, milliseconds, name10

Message = Any  # pymavlink.MAVLink_message
Maker = Callable[["Report"], Iterator[Message]]

_NAN = float("nan")
_OFFBOARD = 6 << 16  # custom mode of PX4's numbering, which clients assume for a generic autopilot too
_HOLD = (4 << 16) | (3 << 24)
_SENSORS = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
    | mavlink.MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_GEOFENCE  # not healthy reads as a breach
    | mavlink.MAV_SYS_STATUS_PREARM_CHECK
    | mavlink.MAV_SYS_STATUS_AHRS
)


class Report:
    """A state and what is known of the vehicle besides, made into messages. Messages are made once and kept."""

    def __init__(self, state: State, armed: bool, pointing: bool, load: float = 0.0) -> None:
        """`load` is the part of the time that the bridge is busy."""
        self.state, self.armed, self.pointing, self.load = state, armed, pointing, load
        self.ms = milliseconds(state.since_start)
        self.us = microseconds(state.since_start)
        self._made: dict[int, list[Message]] = {}

    def messages(self, id_: int) -> list[Message]:
        """Return the messages of a number; none if the vehicle has nothing to say under it."""
        if id_ not in self._made:
            make = MESSAGES.get(id_)
            self._made[id_] = [] if make is None else list(make(self))
        return self._made[id_]


def heartbeat(report: Report) -> Iterator[Message]:
    """An orbiter with an autopilot of no known make."""
    yield heartbeat_of(report.armed, report.pointing)


def heartbeat_of(armed: bool, pointing: bool, over: int | None = None) -> Message:
    """Return a heartbeat; armed is a closed control loop, pointing an attitude that a ground station commands.

    `over` is the MAV_STATE of a run that is over: it is not armed any more.
    """
    armed, pointing = armed and over is None, pointing and over is None
    mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    if armed:
        mode |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
        mode |= mavlink.MAV_MODE_FLAG_GUIDED_ENABLED if pointing else mavlink.MAV_MODE_FLAG_AUTO_ENABLED
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_SPACECRAFT_ORBITER,
        mavlink.MAV_AUTOPILOT_GENERIC,
        mode,
        _OFFBOARD if pointing else _HOLD,
        over if over is not None else mavlink.MAV_STATE_ACTIVE if armed else mavlink.MAV_STATE_STANDBY,
        3,
    )


def sys_status(report: Report) -> Iterator[Message]:
    """Health; there is no battery."""
    yield mavlink.MAVLink_sys_status_message(
        _SENSORS, _SENSORS, _SENSORS, clamped(1e3 * min(report.load, 1.0), 16), U16_UNKNOWN, -1, -1, 0, 0, 0, 0, 0, 0
    )


def extended_sys_state(report: Report) -> Iterator[Message]:
    """In flight."""
    yield mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, mavlink.MAV_LANDED_STATE_IN_AIR)


def system_time(report: Report) -> Iterator[Message]:
    """Simulated time."""
    yield mavlink.MAVLink_system_time_message(_unix_us(report), report.ms)


def attitude(report: Report) -> Iterator[Message]:
    """Roll, pitch, yaw of what the vehicle takes for its attitude; its inertial rates, as a gyro has them."""
    q, rate = report.state.attitude, _rate(report)
    if q is not None and rate is not None:
        yield mavlink.MAVLink_attitude_message(report.ms, *frames.euler(q), *floats(rate))


def attitude_quaternion(report: Report) -> Iterator[Message]:
    """The same as a quaternion."""
    q, rate = report.state.attitude, _rate(report)
    if q is not None and rate is not None:
        yield mavlink.MAVLink_attitude_quaternion_message(report.ms, *q.tolist(), *floats(rate))


def attitude_target(report: Report) -> Iterator[Message]:
    """The commanded attitude."""
    q, rate = report.state.shown("reference"), report.state.vector("reference_rate")
    if q is not None:
        mask = 0 if rate is not None else 7  # rates are to be ignored
        mask |= mavlink.ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE
        yield mavlink.MAVLink_attitude_target_message(report.ms, mask, q.tolist(), *floats(rate or [0.0] * 3), 0.0)


def hil_state_quaternion(report: Report) -> Iterator[Message]:
    """The truth. Velocities and heights beyond the fields are at their limits."""
    q, rate = report.state.shown("true_attitude"), report.state.vector("true_rate")
    place = report.state.place
    if q is not None and rate is not None and place is not None:
        velocity = [clamped(1e2 * v, 16) for v in place.velocity_ned]
        yield mavlink.MAVLink_hil_state_quaternion_message(
            _unix_us(report), q.tolist(), *floats(rate), *_coordinates(place), *velocity, 0, 0, 0, 0, 0
        )


def global_position_int(report: Report) -> Iterator[Message]:
    """Place over the Earth; velocities are at the limit of +-327 m/s in any orbit, the true ones are in others."""
    place = report.state.place
    if place is None:
        return
    *coordinates, height = _coordinates(place)
    velocity = [clamped(1e2 * v, 16) for v in place.velocity_ned]
    q = report.state.attitude
    heading = U16_UNKNOWN if q is None else round(degrees(frames.euler(q)[2] % (2 * pi)) * 100) % 36000
    yield mavlink.MAVLink_global_position_int_message(report.ms, *coordinates, height, height, *velocity, heading)


def gps_raw_int(report: Report) -> Iterator[Message]:
    """Place with the course over ground; the speed is unknown, since the field ends at 655 m/s."""
    place = report.state.place
    if place is None:
        return
    north, east, _ = place.velocity_ned.tolist()
    moves = hypot(north, east) > 1e-3
    course = round(degrees(atan2(east, north) % (2 * pi)) * 100) % 36000 if moves else U16_UNKNOWN
    *coordinates, height = _coordinates(place)
    yield mavlink.MAVLink_gps_raw_int_message(
        _unix_us(report),
        mavlink.GPS_FIX_TYPE_3D_FIX,
        *coordinates,
        height,
        U16_UNKNOWN,
        U16_UNKNOWN,
        U16_UNKNOWN,
        course,
        255,
        height,
    )


def local_position_ned(report: Report) -> Iterator[Message]:
    """Height over, and true velocity relative to the point of the ellipsoid under the spacecraft."""
    place = report.state.place
    if place is None:
        return
    yield mavlink.MAVLink_local_position_ned_message(
        report.ms, 0.0, 0.0, float32(-place.geodetic.height), *floats(place.velocity_ned.tolist())
    )


def vfr_hud(report: Report) -> Iterator[Message]:
    """Speed over ground, height and climb rate, in floats."""
    place, q = report.state.place, report.state.attitude
    if place is None:
        return
    north, east, down = place.velocity_ned.tolist()
    heading = 0 if q is None else round(degrees(frames.euler(q)[2] % (2 * pi))) % 360
    speed = float32(hypot(north, east))
    yield mavlink.MAVLink_vfr_hud_message(speed, speed, heading, 0, float32(place.geodetic.height), float32(-down))


def debug_vect(report: Report) -> Iterator[Message]:
    """Control torque, rate error, and the estimated disturbance."""
    for name, role in (("torque", "torque"), ("rate_err", "rate_error"), ("disturb", "disturbance")):
        values = report.state.vector(role)
        if values is not None:
            yield mavlink.MAVLink_debug_vect_message(name10(name), report.us, *floats(values))


def named_value_float(report: Report) -> Iterator[Message]:
    """Errors of control and estimation, and scalars that were asked for."""
    state = report.state
    torque = state.vector("torque")
    values = {
        "att_error": state.attitude_error,
        "est_error": state.estimation_error,
        "rate_est_e": state.rate_estimation_error,
        "torque": None if torque is None else hypot(*torque),
    }
    for key in state.scene.columns:
        if key.startswith("shown:") and len(state.values[key]) == 1:
            values[key.removeprefix("shown:")] = float(state.values[key][0])
    for name, value in values.items():
        if value is not None:
            yield mavlink.MAVLink_named_value_float_message(report.ms, name10(name), float32(value))


def actuator_output_status(report: Report) -> Iterator[Message]:
    """Torques about the body axes [N.m], then momentum or speeds of wheels."""
    values = report.state.vector("torque")
    if values is not None:
        values += report.state.vector("wheel_momentum") or report.state.vector("wheel_speed") or []
        padded = [*floats(values[:32]), *[0.0] * (32 - len(values))]
        yield mavlink.MAVLink_actuator_output_status_message(report.us, min(len(values), 32), padded)


def raw_rpm(report: Report) -> Iterator[Message]:
    """Speeds of wheels in revolutions per minute."""
    for i, speed in enumerate(report.state.vector("wheel_speed") or []):
        yield mavlink.MAVLink_raw_rpm_message(i, float32(speed * 30 / pi))


def debug_float_array(report: Report) -> Iterator[Message]:
    """The quaternions relative to N, for which MAVLink has no frame, and arrays that were asked for."""
    state = report.state
    arrays: list[tuple[str, list[float]]] = [
        (name, q.tolist())
        for name, role in (("q_BN", "attitude"), ("q_BN_true", "true_attitude"), ("q_RN", "reference"))
        if (q := state.inertial(role)) is not None
    ]
    arrays += [
        (key.removeprefix("shown:"), state.values[key].tolist())
        for key in state.scene.columns
        if key.startswith("shown:") and len(state.values[key]) > 1
    ]
    for number, (name, values) in enumerate(arrays):
        padded = [*floats(values[:58]), *[0.0] * (58 - len(values))]
        yield mavlink.MAVLink_debug_float_array_message(report.us, name10(name), number, padded)


def _rate(report: Report) -> list[float] | None:
    return report.state.vector("rate") if "rate" in report.state.values else [_NAN] * 3


def _coordinates(seen: Place) -> tuple[int, int, int]:
    """Latitude and longitude in 1e-7 deg, height in mm, which ends at 2147 km."""
    place = seen.geodetic
    return (
        clamped(1e7 * degrees(place.latitude), 32),
        clamped(1e7 * degrees(place.longitude), 32),
        clamped(1e3 * place.height, 32),
    )


def _unix_us(report: Report) -> int:
    return microseconds(report.state.scene.earth.unix_time(report.state.t))


MESSAGES: dict[int, Maker] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: heartbeat,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: sys_status,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: extended_sys_state,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: system_time,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: attitude,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: attitude_quaternion,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: attitude_target,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: global_position_int,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: gps_raw_int,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: local_position_ned,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: vfr_hud,
    mavlink.MAVLINK_MSG_ID_DEBUG_VECT: debug_vect,
    mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: named_value_float,
    mavlink.MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS: actuator_output_status,
    mavlink.MAVLINK_MSG_ID_RAW_RPM: raw_rpm,
    mavlink.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY: debug_float_array,
    mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION: hil_state_quaternion,
}
"""What makes the messages of each number."""

RATES: dict[int, float] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 1,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 1,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 50,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 10,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 5,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 2,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 5,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: 2,
    mavlink.MAVLINK_MSG_ID_DEBUG_VECT: 5,
    mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: 5,
    mavlink.MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS: 5,
    mavlink.MAVLINK_MSG_ID_RAW_RPM: 5,
    mavlink.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY: 2,
    mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION: 0,
}
"""Messages per second, unless an endpoint asks for others; 0: only on request."""

"""What a simulator tells an autopilot, as MAVLink messages: sensors, GPS and the truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, degrees, hypot, pi
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from hil_bridge import frames
from hil_bridge.frames import Floats, FrameName, Place
from hil_bridge.hil.wiring import Wiring
from hil_bridge.wire import U16_UNKNOWN, clamped, floats

STANDARD_GRAVITY = 9.80665
_ACCELEROMETER, _GYRO, _MAGNETOMETER = 0b111, 0b111_000, 0b111_000_000
_GAUSS = 1e-4  # T
_SYSTEM, _COMPONENT = 1, mavlink.MAV_COMP_ID_SYSTEM_CONTROL


@dataclass(frozen=True)
class Moment:
    """A communication point: microseconds on the autopilot's clock, what was measured, and where it was.

    `place` is None without an orbit. `q_FN` (4,) is the frame that attitudes are told in, relative to N.
    """

    time_usec: int
    values: Mapping[str, Floats]
    place: Place | None
    q_FN: Floats


class Messages:
    """Packs messages as MAVLink 2, from one sender."""

    def __init__(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self._codec = mavlink.MAVLink(None, srcSystem=_SYSTEM, srcComponent=_COMPONENT)
        self._told: dict[str, Floats] = {}

    def packed(self, message: Any) -> bytes:
        """Return the bytes of a message; each has the next sequence number."""
        data = message.pack(self._codec)
        self._codec.seq = (self._codec.seq + 1) % 256
        return bytes(data)

    def heartbeat(self) -> bytes:
        """Say that a simulator is here, and no vehicle."""
        return self.packed(
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_GENERIC, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
            )
        )

    def sensors(self, now: Moment) -> bytes:
        """HIL_SENSOR: gyro [rad/s], accelerometer [m/s2], magnetometer [gauss], whichever there are; no barometer."""
        wiring, fields = self._wiring, _GYRO
        force = field = np.zeros(3)
        if wiring.accelerometer is not None:
            force, fields = now.values[wiring.accelerometer], fields | _ACCELEROMETER
        if wiring.magnetometer is not None:
            field, fields = now.values[wiring.magnetometer] / _GAUSS, fields | _MAGNETOMETER
        rate = now.values[wiring.gyro]
        numbers = floats([*force.tolist(), *rate.tolist(), *field.tolist(), 0.0, 0.0, 0.0, 0.0])
        return self.packed(mavlink.MAVLink_hil_sensor_message(now.time_usec, *numbers, fields, 0))

    def gps(self, now: Moment) -> bytes:
        """HIL_GPS: exact, with speeds clamped to what 16 bits of cm/s hold and the ground speed unknown."""
        assert now.place is not None
        north, east, down = now.place.velocity_ned.tolist()
        course = degrees(atan2(east, north)) % 360.0 if hypot(north, east) > 0.01 else None
        return self.packed(
            mavlink.MAVLink_hil_gps_message(
                now.time_usec,
                mavlink.GPS_FIX_TYPE_3D_FIX,
                *_position(now.place),
                100,  # horizontal and vertical dilution of precision, times 100
                100,
                _ground_speed(hypot(north, east)),
                *(clamped(100 * v, 16) for v in (north, east, down)),
                U16_UNKNOWN if course is None else round(100 * course) % 36000,
                12,  # satellites
            )
        )

    def truth(self, now: Moment) -> bytes:
        """HIL_STATE_QUATERNION: true attitude in the frame F, inertial rate and specific force in B, place."""
        wiring = self._wiring
        attitude = self._steady("truth", frames.multiply(now.values[wiring.attitude], frames.conjugate(now.q_FN)))
        place = (0, 0, 0) if now.place is None else _position(now.place)
        speed = (0.0, 0.0, 0.0) if now.place is None else now.place.velocity_ned.tolist()
        force = wiring.constant_force if wiring.specific_force is None else now.values[wiring.specific_force]
        return self.packed(
            mavlink.MAVLink_hil_state_quaternion_message(
                now.time_usec,
                attitude.tolist(),
                *floats(now.values[wiring.rate].tolist()),
                *place,
                *(clamped(100 * v, 16) for v in speed),
                0,
                0,
                *(clamped(1000 * a / STANDARD_GRAVITY, 16) for a in np.asarray(force).tolist()),
            )
        )

    def star_tracker(self, now: Moment) -> bytes:
        """ODOMETRY of which the attitude alone is known: the star tracker's, in the frame F."""
        assert self._wiring.star_tracker is not None
        measured = frames.multiply(now.values[self._wiring.star_tracker], frames.conjugate(now.q_FN))
        measured = self._steady("star tracker", measured)
        nothing, unknown = [float("nan")] * 3, [float("nan")] * 21
        return self.packed(
            mavlink.MAVLink_odometry_message(
                now.time_usec,
                mavlink.MAV_FRAME_LOCAL_NED,
                mavlink.MAV_FRAME_BODY_FRD,
                *nothing,
                measured.tolist(),
                *nothing,
                *nothing,
                unknown,
                unknown,
                0,
                mavlink.MAV_ESTIMATOR_TYPE_VISION,
                100,
            )
        )

    def _steady(self, what: str, q: Floats) -> Floats:
        """The one of q and -q that is nearest to what was told before, so that no sign jumps where the body does not.

        The first has a scalar part that is not negative.
        """
        before = self._told.get(what)
        self._told[what] = frames.canonical(q) if before is None else frames.nearest(q, before)
        return self._told[what]

    def acknowledgement(self, command: int, accepted: bool) -> bytes:
        """COMMAND_ACK."""
        result = mavlink.MAV_RESULT_ACCEPTED if accepted else mavlink.MAV_RESULT_UNSUPPORTED
        return self.packed(mavlink.MAVLink_command_ack_message(command, result))


def frame(name: FrameName, place: Place | None, r_N: Floats | None, v_N: Floats | None) -> Floats:
    """Return q_FN (4,) of the frame that attitudes are told in; without an orbit that is N."""
    if name == "eci" or place is None or r_N is None or v_N is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return frames.quaternion(place.C_FN if name == "ned" else frames.lvlh(r_N, v_N))


def _position(place: Place) -> tuple[int, int, int]:
    """Latitude and longitude [1e-7 deg], height [mm], clamped to 32 bits: heights end at 2147 km."""
    where = place.geodetic
    scale = 1e7 * 180.0 / pi
    return round(scale * where.latitude), round(scale * where.longitude), clamped(1000 * where.height, 32)


def _ground_speed(speed: float) -> int:
    """In cm/s; unknown where 16 bits do not hold it, and those of orbits they do not."""
    return U16_UNKNOWN if speed > 655 else round(100 * speed)

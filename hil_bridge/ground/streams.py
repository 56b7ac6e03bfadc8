"""When which message is due: rates belong to a partner, since one must not throttle another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pymavlink.dialects.v20 import common as mavlink

from hil_bridge.ground.telemetry import RATES

_FASTEST = 1e-3  # s

GROUPS: dict[int, tuple[int, ...]] = {
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
    ),
    mavlink.MAV_DATA_STREAM_POSITION: (
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    ),
    mavlink.MAV_DATA_STREAM_RAW_CONTROLLER: (
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET,
        mavlink.MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS,
        mavlink.MAVLINK_MSG_ID_RAW_RPM,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (
        mavlink.MAVLINK_MSG_ID_ATTITUDE,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA2: (mavlink.MAVLINK_MSG_ID_VFR_HUD,),
    mavlink.MAV_DATA_STREAM_EXTRA3: (
        mavlink.MAVLINK_MSG_ID_DEBUG_VECT,
        mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT,
        mavlink.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY,
    ),
}
"""The messages of REQUEST_DATA_STREAM's streams; MAV_DATA_STREAM_ALL is all of them."""


class Streams:
    """Intervals of one partner's messages. Time is that of the clock on the wall, as a run keeps pace with it."""

    def __init__(self, rates: Mapping[int, float] = RATES) -> None:
        """`rates` are in messages per second, 0 for never."""
        self._defaults = {id_: 1 / rate if rate > 0 else 0.0 for id_, rate in {**RATES, **rates}.items()}
        self._intervals = dict(self._defaults)
        self._due: dict[int, float] = {}

    def interval(self, id_: int) -> float:
        """Return the time between two messages [s]; 0 for never."""
        return self._intervals.get(id_, 0.0)

    def set(self, id_: int, interval: float) -> None:
        """Set the time between two messages [s]; 0 for never."""
        self._intervals[id_] = max(interval, _FASTEST) if interval > 0 else 0.0
        self._due.pop(id_, None)

    def reset(self, id_: int) -> None:
        """Go back to the rate of the beginning."""
        self.set(id_, self._defaults.get(id_, 0.0))

    def group(self, stream: int, rate: float) -> None:
        """Do as REQUEST_DATA_STREAM says; 0 for never. Streams that are not known are left as they are."""
        wanted = [id_ for ids in GROUPS.values() for id_ in ids] if stream == 0 else GROUPS.get(stream, ())
        for id_ in wanted:
            self.set(id_, 1 / rate if rate > 0 else 0.0)

    def due(self, now: float) -> Iterator[int]:
        """Yield the messages whose time has come; what was missed is not made up for."""
        for id_, interval in self._intervals.items():
            if not interval:
                continue
            due = self._due.get(id_, now)
            if due - now > 2 * interval:  # time went back
                due = now
            if now >= due - 1e-6:
                missed = max(0, int((now - due) / interval))
                self._due[id_] = due + (missed + 1) * interval
                yield id_

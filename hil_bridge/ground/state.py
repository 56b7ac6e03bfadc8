"""What a snapshot of the simulation means: attitude in the frame asked for, place over the Earth, errors."""

from __future__ import annotations

from functools import cached_property
from math import dist, radians

import numpy as np

from fmus.errors import AdcsError
from hil_bridge import frames
from hil_bridge.frames import Floats, Geodetic, Place
from hil_bridge.ground.settings import Settings, Snapshot

_NEAREST, _FARTHEST = 1e5, 1e12  # m
_FASTEST = 3e8  # m/s
_LARGEST = 1e6  # element of a quaternion or of Rodrigues parameters


class Scene:
    """The frames in which the vehicle is shown. Without an orbit, N itself stands still at a declared place."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.columns = {key: slice(first, last) for key, first, last in settings.columns}
        self.orbits = "position" in self.columns
        if settings.frame == "lvlh" and not self.orbits:
            raise AdcsError("frame lvlh: this system has no orbit; --map position=... velocity=..., or --frame ned")
        try:
            self.earth = frames.Earth(settings.start_of_time)
        except ValueError as error:
            raise AdcsError(f"epoch {settings.epoch!r}: {error}") from None
        latitude, longitude, height = settings.position
        self._pseudo = Place(Geodetic(radians(latitude), radians(longitude), height), np.zeros(3), np.eye(3))

    @property
    def announcement(self) -> str:
        """The frame in words, for people at the ground station."""
        if not self.orbits:
            latitude, longitude, height = self.settings.position
            place = f"{latitude:g}, {longitude:g} deg, {height / 1e3:g} km"
            return f"No orbit: {self.settings.base} is shown as NED at {place}"
        return {
            "ned": "Attitude in true NED (WGS 84) under the spacecraft",
            "lvlh": "Attitude in LVLH: along track, -orbit normal, nadir",
            "eci": "Attitude in the inertial frame (GCRS)",
        }[self.settings.frame]

    def at(self, snapshot: Snapshot) -> State:
        """Return the state of a snapshot."""
        return State(self, snapshot)

    def place(self, state: State) -> Place | None:
        """Where the spacecraft is; None if it is nowhere near the Earth, or its position is not a number."""
        if not self.orbits:
            return self._pseudo
        r, v = state.values["position"], state.values["velocity"]
        if not (_NEAREST < np.abs(r).max() < _FARTHEST and np.abs(v).max() < _FASTEST):
            return None
        return self.earth.place(state.t, r, v)


class _Values:
    def __init__(self, scene: Scene, snapshot: Snapshot) -> None:
        self._columns, self._all = scene.columns, np.asarray(snapshot.values, float)

    def __contains__(self, key: str) -> bool:
        return key in self._columns

    def __getitem__(self, key: str) -> Floats:
        return self._all[self._columns[key]]


class State:
    """What a snapshot means; everything is worked out when it is asked for, once."""

    def __init__(self, scene: Scene, snapshot: Snapshot) -> None:
        self.scene, self.k, self.t = scene, snapshot.k, snapshot.t
        self.values = _Values(scene, snapshot)

    @property
    def since_start(self) -> float:
        """Time since the run started [s]."""
        return self.t - self.scene.settings.start

    @cached_property
    def place(self) -> Place | None:
        """Where the spacecraft is over the Earth, if it is anywhere."""
        return self.scene.place(self)

    @cached_property
    def q_FN(self) -> Floats | None:
        """Attitude (4,) of the frame that is shown, relative to N; None where there is no place to have it."""
        if not self.scene.orbits or self.scene.settings.frame == "eci":
            return np.array([1.0, 0.0, 0.0, 0.0])
        if self.place is None:
            return None
        if self.scene.settings.frame == "lvlh":
            return frames.quaternion(frames.lvlh(self.values["position"], self.values["velocity"]))
        return frames.quaternion(self.place.C_FN)

    def inertial(self, role: str) -> Floats | None:
        """Return a role's quaternion (4,) relative to N, from quaternion or MRP; None if there is none or no number."""
        if role not in self.values:
            return None
        value = self.values[role]
        if not np.abs(value).max() < _LARGEST:
            return None
        return frames.unit(value) if len(value) == 4 else frames.from_mrp(value)

    def shown(self, role: str) -> Floats | None:
        """Return a role's quaternion (4,) relative to the frame that is shown."""
        q = self.inertial(role)
        return (
            None
            if q is None or self.q_FN is None
            else frames.canonical(frames.multiply(q, frames.conjugate(self.q_FN)))
        )

    @cached_property
    def attitude(self) -> Floats | None:
        """What the vehicle takes for its attitude, relative to the frame that is shown (4,)."""
        return self.shown("attitude")

    def vector(self, role: str) -> list[float] | None:
        """Return the values of a role; None if there is none, or one is not a number."""
        if role not in self.values:
            return None
        value = self.values[role]
        return value.tolist() if np.isfinite(value).all() else None

    @cached_property
    def attitude_error(self) -> float | None:
        """Angle from commanded to true attitude [rad]."""
        error = self.vector("attitude_error")
        if error is not None:
            return frames.rotation_angle(error)
        return self._angle("reference", "true_attitude")

    @cached_property
    def estimation_error(self) -> float | None:
        """Angle from true to estimated attitude [rad]."""
        settings = self.scene.columns
        if settings.get("attitude") == settings.get("true_attitude"):
            return None
        return self._angle("true_attitude", "attitude")

    @cached_property
    def rate_estimation_error(self) -> float | None:
        """Distance from true to estimated angular velocity [rad/s]."""
        columns = self.scene.columns
        estimate, truth = self.vector("rate"), self.vector("true_rate")
        if estimate is None or truth is None or columns["rate"] == columns["true_rate"]:
            return None
        return dist(estimate, truth)

    def _angle(self, a: str, b: str) -> float | None:
        q, p = self.inertial(a), self.inertial(b)
        return None if q is None or p is None else frames.rotation_angle(frames.multiply(p, frames.conjugate(q)))

"""From the controls of an autopilot to a torque."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from fmus.errors import AdcsError
from hil_bridge.frames import Floats
from orchestration.running.hooks.tables import read_table

CHANNELS = 16


@dataclass
class Actuators:
    """The torque on the body is `effect` (3, n) times the first n of 16 controls [N.m].

    A control outside -1 to 1 is clipped, one that is not a number (MAVLink's "not used") counts as 0, and while the
    autopilot is not armed there is no torque.
    """

    effect: Floats
    clipped: int = 0
    not_numbers: int = 0
    disarmed: int = 0

    @classmethod
    def by_axis(cls, most: tuple[float, ...]) -> Actuators:
        """Let controls 1 to 3 be the torques about x, y, z in parts of `most` [N.m], one number or three."""
        if len(most) not in (1, 3) or not all(isfinite(x) and x > 0 for x in most):
            raise AdcsError(f"largest torque {most}: expected one positive number or three [N.m]")
        return cls(np.diag(np.broadcast_to(np.array(most, float), 3)))

    @classmethod
    def from_csv(cls, path: Path) -> Actuators:
        """Read three lines for x, y, z with the torque [N.m] of each control at 1: a column for a thruster or wheel."""
        _, effect = read_table(path, header=False)
        if len(effect) != 3 or effect.shape[1] > CHANNELS or not np.isfinite(effect).all():
            raise AdcsError(
                f"{path}: expected 3 lines of 1 to {CHANNELS} finite numbers, torque in N.m of each control"
            )
        return cls(effect)

    def torque(self, message: Any) -> Floats:
        """Return the torque (3,) of a HIL_ACTUATOR_CONTROLS [N.m]."""
        if not message.mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED:
            self.disarmed += 1
            return np.zeros(3)
        controls = np.array(message.controls[: self.effect.shape[1]], float)
        finite = np.isfinite(controls)
        if not finite.all():
            self.not_numbers += 1
            controls[~finite] = 0.0
        if np.abs(controls).max() > 1.0:
            self.clipped += 1
            controls = np.clip(controls, -1.0, 1.0)
        torque: Floats = self.effect @ controls
        return torque

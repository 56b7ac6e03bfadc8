"""Which variables of a system an autopilot sees and moves, found by their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmus.errors import AdcsError
from orchestration.system import System


@dataclass(frozen=True)
class Wiring:
    """Variables as `component.variable`; None where the system has no such sensor, or no orbit."""

    attitude: str
    rate: str
    gyro: str
    torque: str
    accelerometer: str | None = None
    magnetometer: str | None = None
    magnetic_field: str | None = None
    position: str | None = None
    velocity: str | None = None
    star_tracker: str | None = None
    specific_force: str | None = None
    """What the accelerometer measures, where an output feeds it."""
    constant_force: tuple[float, ...] = (0.0, 0.0, 0.0)
    """What it measures where nothing does: the start value of its input, in B [m/s2]; free fall feels none."""

    @classmethod
    def find(cls, system: System, torque: str | None = None) -> Wiring:
        """Find all of them; `torque` names the input if there is more than one that nothing feeds."""
        free = _free_inputs(system)
        if torque is not None and torque not in free:
            raise AdcsError(f"--torque {torque}: expected an input of 3 values that nothing feeds; {_choice(free)}")
        outputs = list(system.outputs())
        position, velocity = _one(outputs, "r_ON_N"), _one(outputs, "v_ON_N")
        accelerometer = _one(outputs, "specific_force_B_meas")
        specific_force, constant_force = _felt(system, accelerometer)
        return cls(
            attitude=_needed(system, outputs, "q_BN", "the attitude, from a plant"),
            rate=_needed(system, outputs, "omega_BN_B", "the angular velocity, from a plant"),
            gyro=_needed(system, outputs, "omega_BN_B_meas", "the rate of a gyro, from an InertialMeasurementUnit"),
            torque=torque or _torque(system, free),
            accelerometer=accelerometer,
            magnetometer=_one(outputs, "magnetic_field_B_meas"),
            magnetic_field=_one(free, "magnetic_field_N"),
            position=position if velocity else None,
            velocity=velocity if position else None,
            star_tracker=_one(outputs, "q_BN_meas"),
            specific_force=specific_force,
            constant_force=constant_force,
        )

    @property
    def outputs(self) -> list[str]:
        """Those that are read at every point."""
        read = (
            self.attitude,
            self.rate,
            self.gyro,
            self.accelerometer,
            self.magnetometer,
            self.position,
            self.velocity,
            self.star_tracker,
            self.specific_force,
        )
        return list(dict.fromkeys(name for name in read if name is not None))


def _felt(system: System, accelerometer: str | None) -> tuple[str | None, tuple[float, ...]]:
    """The true specific force at an accelerometer: the output that feeds it as it is, or a constant [m/s2]."""
    none = (0.0, 0.0, 0.0)
    if accelerometer is None:
        return None, none
    component = system.components[accelerometer.partition(".")[0]]
    port = component.fmu.ports.get("specific_force_B")
    if port is None or port.causality != "input" or port.size != 3:
        return None, none
    name = f"{component.name}.{port.name}"
    feeding = [c for c in system.connections if c.target.partition("[")[0] == name]
    if not feeding:
        start = component.start.get(port.name, none if port.start is None else port.start)
        return None, tuple(float(x) for x in np.ravel(start))
    whole = len(feeding) == 1 and feeding[0].target == name and feeding[0].plain and not feeding[0].delayed
    return (feeding[0].source, none) if whole and system.port(feeding[0].source)[1].size == 3 else (None, none)


def _free_inputs(system: System) -> list[str]:
    """Inputs of three values that nothing feeds."""
    fed = {connection.target.partition("[")[0] for connection in system.connections}
    names = [
        f"{c.name}.{p.name}" for c in system.components.values() for p in c.fmu.ports.values() if p.causality == "input"
    ]
    return [name for name in names if name not in fed and system.port(name)[1].size == 3]


def _one(names: Sequence[str], variable: str) -> str | None:
    """Return the name that ends in the variable; None if there is none, or no telling which."""
    found = [name for name in names if name.partition(".")[2] == variable]
    return found[0] if len(found) == 1 else None


def _needed(system: System, names: Sequence[str], variable: str, what: str) -> str:
    found = _one(names, variable)
    if found is None:
        several = [name for name in names if name.partition(".")[2] == variable]
        how = f"{len(several)} outputs are called" if several else "no output is called"
        raise AdcsError(f"{system.name} cannot be flown: {how} {variable} ({what}); hil-spacecraft can")
    return found


def _torque(system: System, free: Sequence[str]) -> str:
    found = [name for variable in ("torque_command_B", "torque_B") if (name := _one(free, variable))]
    if len(found) != 1:
        raise AdcsError(
            f"{system.name} cannot be flown: "
            + ("there is no free input torque_command_B or torque_B" if not found else "name the input with --torque")
            + f"; {_choice(free)}"
        )
    return found[0]


def _choice(free: Sequence[str]) -> str:
    return f"nothing feeds {', '.join(free)}" if free else "all inputs of 3 values are fed"

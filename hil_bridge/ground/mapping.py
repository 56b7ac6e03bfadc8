"""Which variable of a system feeds which field: found by name, and changed by declaration."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fmus.errors import AdcsError
from fmus.nearby import instead
from orchestration.system import System


@dataclass(frozen=True)
class Role:
    """What a variable may be to a vehicle: its shapes (None: any), its unit, and names it usually has, best first."""

    meaning: str
    shapes: tuple[tuple[int, ...], ...] | None
    unit: str | None
    names: tuple[str, ...]


_Q, _V3 = ((4,),), ((3,),)
_Q_OR_MRP = ((4,), (3,))

ROLES: dict[str, Role] = {
    "attitude": Role(
        "what the vehicle takes for its attitude: quaternion or MRP",
        _Q_OR_MRP,
        "1",
        ("q_BN_est", "q_BN_meas", "q_EN", "plant.q_BN", "q_BN", "sigma_BO_meas", "plant.q_BO", "q_BO"),
    ),
    "rate": Role(
        "what it takes for its angular velocity, in B",
        _V3,
        "rad/s",
        ("omega_BN_B_est", "omega_BN_B_meas", "plant.omega_BN_B", "omega_BN_B"),
    ),
    "true_attitude": Role("the attitude that it has", _Q_OR_MRP, "1", ("plant.q_BN", "plant.q_BO")),
    "true_rate": Role("the angular velocity that it has, in B", _V3, "rad/s", ("plant.omega_BN_B",)),
    "reference": Role(
        "commanded attitude: quaternion or MRP",
        _Q_OR_MRP,
        "1",
        ("q_SN", "guidance.q_RN", "q_RN", "guidance.sigma_RO", "sigma_RO"),
    ),
    "reference_rate": Role(
        "commanded angular velocity, in R", _V3, "rad/s", ("omega_SN_S", "guidance.omega_RN_R", "omega_RN_R")
    ),
    "torque": Role(
        "control torque, in B", _V3, "N.m", ("torque_applied_B", "controller.torque_B", "law.torque_B", "torque_B")
    ),
    "position": Role("position from the Earth's centre, in N", _V3, "m", ("plant.r_BN_N", "r_BN_N", "r_ON_N")),
    "velocity": Role("its velocity, in N", _V3, "m/s", ("plant.v_BN_N", "v_BN_N", "v_ON_N")),
    "attitude_error": Role("attitude error, quaternion", _Q, "1", ("controller.q_BR", "q_BR")),
    "rate_error": Role("rate error, in B", _V3, "rad/s", ("controller.omega_BR_B", "omega_BR_B")),
    "wheel_speed": Role("speeds of reaction wheels", None, "rad/s", ("wheel_speed", "wheel_rate", "omega_W")),
    "wheel_momentum": Role("momentum of wheels, in B", _V3, "N.m.s", ("wheel.H_B",)),
    "disturbance": Role("estimate of the disturbance torque", _V3, "N.m", ("torque_disturbance_B_est",)),
}


@dataclass(frozen=True)
class Signals:
    """The variables that feed the bridge: `roles` by role, and `shown` by the name of ten characters they go under."""

    roles: Mapping[str, str]
    shown: Mapping[str, str] = field(default_factory=dict)

    @property
    def base(self) -> str:
        """The frame to which the attitude is relative, as its name says: `O` of `sigma_BO_meas`, else `N`."""
        match = re.search(r"_[A-Z]([A-Z])(_|$)", self.roles.get("attitude", ""))
        return match[1] if match else "N"

    @property
    def variables(self) -> list[str]:
        """All of them, once."""
        return list(dict.fromkeys([*self.roles.values(), *self.shown.values()]))


def find(system: System, wanted: Sequence[str] = (), show: Sequence[str] = ()) -> Signals:
    """Return the signals of a system.

    `wanted` are `ROLE=COMPONENT.VARIABLE`, `ROLE=` for none, or the path of a TOML file of such lines under `[roles]`
    and, under `[shown]`, of `name = "component.variable"`; `show` names scalars and arrays to be shown besides.
    """
    outputs = system.outputs()
    given: dict[str, str] = {}
    shown: dict[str, str] = {}
    for text in wanted:
        role, equals, name = text.partition("=")
        if equals:
            given[role.strip()] = name.strip()
        else:
            _read(Path(text), given, shown)
    for name in show:
        shown[name.partition(".")[2]] = name
    roles = {role: found for role in ROLES if role not in given and (found := _default(system, role, outputs))}
    for role, name in given.items():
        if role not in ROLES:
            raise AdcsError(f"--map {role}={name}: there is no {role!r}, choose one of {', '.join(ROLES)}")
        if not name:
            continue
        if not _fits(system, name, role):
            shapes, unit = ROLES[role].shapes, ROLES[role].unit
            sizes = " or ".join(str(shape[0]) for shape in shapes or ()) or "any number of"
            raise AdcsError(f"--map {role}={name}: expected an output with {sizes} elements in {unit}")
        roles[role] = name
    for name in shown.values():
        if name not in outputs:
            system.port(name)  # says which there are
            raise AdcsError(f"{name} is not an output: only outputs can be shown")
    signals = Signals({role: roles[role] for role in ROLES if role in roles}, shown)
    if signals.base != "N" and "position" in roles:
        raise AdcsError(
            f"{roles['attitude']} is relative to {signals.base}, but position {roles['position']} wants one "
            "relative to N: --map attitude=..., or --map position="
        )
    if "position" in roles and "velocity" not in roles:
        raise AdcsError(f"position {roles['position']} has no velocity: --map velocity=..., or --map position=")
    return signals


def _read(path: Path, roles: dict[str, str], shown: dict[str, str]) -> None:
    try:
        with path.open("rb") as file:
            content = tomllib.load(file)
    except OSError as error:
        why = f"{error.strerror}{instead(path)}"
        raise AdcsError(f"--map {path}: expected ROLE=COMPONENT.VARIABLE or a TOML file ({why})") from None
    except (ValueError, RecursionError) as error:  # no TOML, no UTF-8, a path with NUL, brackets without end
        raise AdcsError(f"{' '.join(str(path).split())}: {' '.join(str(error).split())}") from None
    for table, into in (("roles", roles), ("shown", shown)):
        lines = content.pop(table, {})
        if not isinstance(lines, dict) or not all(isinstance(value, str) for value in lines.values()):
            raise AdcsError(f'{path}: expected lines like attitude = "plant.q_BN" under [{table}]')
        into.update(lines)
    if content:
        raise AdcsError(f"{path}: {', '.join(map(repr, content))} is unknown, there are [roles] and [shown]")


def _default(system: System, role: str, outputs: Sequence[str]) -> str | None:
    for name in ROLES[role].names:
        for output in outputs:
            if (output == name or output.partition(".")[2] == name) and _fits(system, output, role):
                return output
    return None


def _fits(system: System, name: str, role: str) -> bool:
    port = system.port(name)[1]
    shapes = ROLES[role].shapes
    right_shape = len(port.shape) <= 1 if shapes is None else port.shape in shapes
    return port.causality == "output" and right_shape and port.unit in (ROLES[role].unit, None)

"""Makes a system take commands: between guidance and law, and law and body, stand components that an operator moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from fmus.errors import AdcsError
from hil_bridge.ground.mapping import Signals
from hil_bridge.ground.settings import Pointing
from orchestration.system import Connection, System

SWITCH, COMMAND = "torque_switch", "commanded_reference"
_PARTS = (("q_RN", "q_SN"), ("omega_RN_R", "omega_SN_S"), ("omegaDot_RN_R", "omegaDot_SN_S"))


@dataclass(frozen=True)
class Commandable:
    """The variables by which a system is commanded; `own_variables` are not for others to set."""

    arm: str | None = None
    point: Pointing | None = None
    own_variables: tuple[str, ...] = ()


def make_commandable(system: System, signals: Signals, allow: list[str]) -> tuple[Commandable, Signals]:
    """Rewire a system for what is allowed; return how it is commanded, and its signals then.

    Undisturbed, the system does the same as before, to the last bit. What a system has no place for is left out.
    """
    made = Commandable()
    roles = dict(signals.roles)
    if "arm" in allow and "torque" in roles:
        made, roles["torque"] = _with_switch(system, made, roles["torque"])
    if "attitude" in allow:
        made = _with_command(system, made, roles)
        if made.point is not None and made.point.engaged is not None:
            roles |= {"reference": f"{COMMAND}.q_SN", "reference_rate": f"{COMMAND}.omega_SN_S"}
    return made, replace(signals, roles=roles)


def _with_switch(system: System, made: Commandable, torque: str) -> tuple[Commandable, str]:
    taken = [c for c in system.connections if c.source == torque]
    if not taken:
        return made, torque
    system.add(SWITCH, "TorqueSwitch")
    _redirect(system, taken, f"{SWITCH}.torque_applied_B")
    system.connect(torque, f"{SWITCH}.torque_B")
    enabled = f"{SWITCH}.enabled"
    return replace(made, arm=enabled, own_variables=(*made.own_variables, enabled)), f"{SWITCH}.torque_applied_B"


def _with_command(system: System, made: Commandable, roles: Mapping[str, str]) -> Commandable:
    """Between guidance and all that follow it; or directly, where a law has the target as a parameter.

    Of a commanded quaternion and its negative the one nearer to the attitude counts that the law itself is given.
    """
    sources = {
        part: {c.source for c in system.connections if c.target.endswith(f".{part}") and c.plain and not c.delayed}
        for part, _ in _PARTS
    }
    if all(len(found) == 1 for found in sources.values()):
        taken = {part: [c for c in system.connections if c.source == next(iter(sources[part]))] for part, _ in _PARTS}
        system.add(COMMAND, "CommandedReference")
        for part, selected in _PARTS:
            _redirect(system, taken[part], f"{COMMAND}.{selected}")
            system.connect(next(iter(sources[part])), f"{COMMAND}.{part}")
        _tell_attitude(system, [c.target.partition(".")[0] for c in taken["q_RN"]], roles)
        system.set(f"{COMMAND}.q_CN", [1.0, 0.0, 0.0, 0.0])
        system.set(f"{COMMAND}.omega_CN_C", [0.0, 0.0, 0.0])
        point = Pointing(f"{COMMAND}.q_CN", f"{COMMAND}.omega_CN_C", f"{COMMAND}.engaged")
        own = (*made.own_variables, point.attitude, f"{COMMAND}.omega_CN_C", f"{COMMAND}.engaged")
        return replace(made, point=point, own_variables=own)
    for component in system.components.values():
        port = component.fmu.ports.get("q_RN")
        if port is not None and port.causality == "parameter" and port.variability == "tunable" and port.shape == (4,):
            return replace(made, point=Pointing(f"{component.name}.q_RN"))
    return made


def _tell_attitude(system: System, laws: Sequence[str], roles: Mapping[str, str]) -> None:
    """Feed the attitude by which the component chooses the sign of a command: that which the laws see."""
    seen = [c.source for c in system.connections if c.target in {f"{law}.q_BN" for law in laws} and c.plain]
    shown = [roles[role] for role in ("attitude", "true_attitude") if role in roles]
    found = next((name for name in [*seen, *shown] if system.port(name)[1].shape == (4,)), None)
    if found is None:
        system.set(f"{COMMAND}.q_BN", [1.0, 0.0, 0.0, 0.0])
    else:
        system.connect(found, f"{COMMAND}.q_BN")


def _redirect(system: System, taken: list[Connection], source: str) -> None:
    """Let inputs have another source, scaled and delayed as before."""
    for old in taken:
        if old.delay_steps or old.delay or old.given:
            raise AdcsError(
                f"the connection from {old.source} to {old.target} is delayed or scaled: it cannot be commanded"
            )
        system.disconnect(old.target)
        system.connect(source, old.target)

"""What this folder adds to the catalogue: light, as it is read for every list of names; `entries` has the rest."""

from __future__ import annotations

from typing import Literal

Controller = Literal["bs", "rbs", "tf", "neso", "ii"]
Scenario = Literal["nominal", "mismatch", "wheel", "mirror"]

LONG_NAMES: dict[Controller, str] = {
    "bs": "standard backstepping",
    "rbs": "robust backstepping",
    "tf": "backstepping with tuning functions",
    "neso": "backstepping with a nonlinear extended state observer",
    "ii": "immersion and invariance adaptive backstepping",
}
SCENARIOS: dict[Scenario, str] = {
    "nominal": "undisturbed",
    "mismatch": "inertia known with its axes 10 deg off",
    "wheel": "a reaction wheel saturated",
    "mirror": "a mirror swinging in the payload",
}


def system_name(controller: Controller, scenario: Scenario) -> str:
    """`trigo-bs` for the undisturbed case, `trigo-bs-wheel` and so on for the others."""
    return f"trigo-{controller}" + ("" if scenario == "nominal" else f"-{scenario}")


SYSTEMS = {
    system_name(controller, scenario): f"{name[0].upper()}{name[1:]}, {disturbance}"
    for scenario, disturbance in SCENARIOS.items()
    for controller, name in LONG_NAMES.items()
}
"""What each system is in a line."""
STUDIES = ("trigo",)

"""The model structure says exactly what depends on what: no dependency is missing, and none is made up."""

import numpy as np
import pytest

from tests.one_fmu import Raw, unpacked

NAMES = (
    "FixedAxisReference",
    "RigidBody",
    "StarTracker",
    "SmoothRateObserver",
    "PdTracking",
    "BoundedAdaptiveTracking",
    "BoundedEstimationError",
    "SinusoidalRateReference",
    "SinusoidalTorque",
)
POINTS = 12


def random_start(rng: np.random.Generator, raw: Raw) -> dict[str, np.ndarray]:
    """Values for inputs and states away from the points where terms vanish by symmetry."""
    names = {
        v.name.split("[")[0] for v in unpacked(raw.fmu.modelIdentifier, 2)[1].modelVariables if v.start is not None
    }
    values: dict[str, np.ndarray] = {}
    for name in sorted(names - raw.integers - {"J_B", "max_internal_step", "redraw_period", "eta_p"}):
        value = rng.uniform(0.1, 0.9, raw.sizes[name])
        values[name] = value / np.linalg.norm(value) if name.startswith("q_") else value
    return values


@pytest.mark.parametrize("name", NAMES)
def test_declared_dependencies_are_those_of_the_directional_derivatives(name: str) -> None:
    description = unpacked(name, 2)[1]
    knowns = [v for v in description.modelVariables if v.causality == "input"]
    knowns += [d.variable.derivative for d in description.derivatives]
    seen: dict[tuple[str, str], float] = {}
    unknowns = [*description.outputs, *description.derivatives]
    rng = np.random.default_rng(11)
    for _ in range(POINTS):
        with Raw(name, 2, cosim=False) as raw:
            raw.initialize(**random_start(rng, raw))
            for u in unknowns:
                for k in knowns:
                    slope = raw.fmu.getDirectionalDerivative([u.variable.valueReference], [k.valueReference], [1.0])[0]
                    pair = (u.variable.name, k.name)
                    seen[pair] = max(seen.get(pair, 0.0), abs(slope))
    declared = {(u.variable.name, d.name) for u in unknowns for d in u.dependencies if d.causality != "independent"}
    assert {pair for pair, slope in seen.items() if slope > 1e-12} == declared
    assert description.outputs


def test_parameters_are_listed_where_the_standard_counts_them_among_the_knowns() -> None:
    """During a run FMI 3.0 does, and what is not listed has no influence by its text; FMI 2.0 does not."""

    def knowns(version: int) -> dict[str, set[str]]:
        outputs = unpacked("PdTracking", version)[1].outputs
        return {u.variable.name: {d.name for d in u.dependencies} for u in outputs}

    assert {"k_p", "k_v", "J_B", "short_way"} <= knowns(3)["torque_B"]
    assert knowns(3)["omega_BR_B"] & {"k_p", "k_v", "J_B"} == set()
    assert not {name for names in knowns(2).values() for name in names if name.startswith(("k_", "J_", "short"))}

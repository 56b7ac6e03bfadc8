"""Components whose inputs must be plausible (positions outside the Earth): what they declare to depend on, they do."""

import numpy as np
import pytest

from . import test_six_dof, test_velocity_free
from .at_points import draw, opened
from .fmu_access import array_name

LAWS = {**test_six_dof.LAWS, **test_velocity_free.LAWS}


@pytest.mark.parametrize("name", LAWS)
def test_declared_dependencies_are_those_of_the_directional_derivatives(name: str) -> None:
    """Element by element at eight random points: none missing, none made up."""
    seen: dict[tuple[str, str], float] = {}
    for point in draw(name, LAWS[name], 8):
        with opened(name, 2, point) as component:
            description = component.description
            unknowns = [*description.outputs, *description.derivatives]
            names = [u.variable.name for u in unknowns]
            references = [u.variable.valueReference for u in unknowns]
            knowns = [v for v in description.modelVariables if v.causality == "input"]
            knowns += [d.variable.derivative for d in description.derivatives]
            for known in knowns:
                base, _ = array_name(known.name)
                size = 100.0 if base.startswith("r_") else 1.0
                slopes = component.fmu.getDirectionalDerivative(references, [known.valueReference], [size])
                for unknown, slope in zip(names, slopes, strict=True):
                    seen[unknown, known.name] = max(seen.get((unknown, known.name), 0.0), abs(slope))
    declared = {(u.variable.name, d.name) for u in unknowns for d in u.dependencies if d.causality != "independent"}
    assert {pair for pair, slope in seen.items() if slope > 0} == declared
    assert np.isfinite(list(seen.values())).all()

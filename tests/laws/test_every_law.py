"""Every component against its independent answer. One that has none fails here."""

import numpy as np
import pytest

from fmus import catalog
from references.answers import LAWS, SAMPLED
from tests.one_fmu import VERSIONS

from . import at_points as at

both = pytest.mark.parametrize("version", VERSIONS)
at_points = pytest.mark.parametrize("name", LAWS)
by_instants = pytest.mark.parametrize("name", SAMPLED)
everything = pytest.mark.parametrize("name", dict.fromkeys([*LAWS, *SAMPLED]))
integrated = pytest.mark.parametrize("name", [n for n, law in LAWS.items() if law.rates(at.draw(n, 1)[0])])


def test_every_component_has_an_answer_and_every_answer_a_component() -> None:
    assert {component.name for component in catalog.components()} == set(LAWS) | set(SAMPLED)


@both
@at_points
def test_outputs_and_derivatives(name: str, version: int) -> None:
    at.check_points(name, version)


@both
@by_instants
def test_outputs_from_instant_to_instant(name: str, version: int) -> None:
    at.check_instants(name, version)


@at_points
def test_both_fmi_versions_give_the_same_bits(name: str) -> None:
    for point in at.draw(name, 3):
        with at.opened(name, 2, point) as two, at.opened(name, 3, point) as three:
            for variable in two.names("output", "local"):
                np.testing.assert_array_equal(two.get(variable), three.get(variable), err_msg=variable)


@both
@at_points
def test_directional_derivatives(name: str, version: int) -> None:
    """Against central differences of sixth order, for every input, state and tunable parameter."""
    at.check_slopes(name, version)


@both
@by_instants
def test_directional_derivatives_of_an_instant(name: str, version: int) -> None:
    at.check_slopes_of_an_instant(name, version)


@everything
def test_declared_dependencies_are_those_of_the_directional_derivatives(name: str) -> None:
    at.check_dependencies(name)


@both
@integrated
def test_co_simulation_integrates_with_fourth_order(name: str, version: int) -> None:
    at.check_order(name, version)

"""What a number in the unit of one FMU is in that of another."""

from types import SimpleNamespace

import pytest
from fmpy.model_description import BaseUnit, Unit

from adcs import AdcsError
from orchestration.fmu.units import Scale, conversion


def fmu(**units):
    """An FMU that defines these units; None: by name only."""
    definitions = [Unit(name, None if base is None else BaseUnit(**base)) for name, base in units.items()]
    return SimpleNamespace(model=SimpleNamespace(unitDefinitions=definitions))


OURS = fmu(rad={"rad": 1}, deg={"rad": 1, "factor": 0.5}, K={"K": 1}, m={"m": 1}, odd=None)
THEIRS = fmu(rad={"rad": 1}, deg={"rad": 1, "factor": 0.25}, C={"K": 1, "offset": 273.15}, ft={"m": 1, "factor": 0.3})


@pytest.mark.parametrize(
    ("unit", "wanted", "scale"),
    [
        ("rad", "rad", Scale()),
        ("deg", "rad", Scale(0.5)),
        ("rad", "deg", Scale(4.0)),
        ("deg", "deg", Scale(2.0)),  # one name, two definitions
        ("K", "C", Scale(1.0, -273.15)),
        ("odd", "odd", Scale()),
        (None, "C", Scale()),
        ("K", None, Scale()),
    ],
)
def test_conversions(unit, wanted, scale):
    assert conversion(OURS, unit, THEIRS, wanted) == scale


@pytest.mark.parametrize(
    ("unit", "wanted", "message"),
    [
        ("m", "rad", "units differ, 'm' and 'rad', and do not measure the same: connect something else"),
        ("odd", "rad", "units differ, 'odd' and 'rad', and 'odd' is not defined: give a factor"),
        ("rad", "none", "units differ, 'rad' and 'none', and 'none' is not defined: give a factor"),
    ],
)
def test_refused_conversions(unit, wanted, message):
    with pytest.raises(AdcsError) as error:
        conversion(OURS, unit, THEIRS, wanted)
    assert str(error.value) == message


def test_a_factor_of_zero_is_refused():
    with pytest.raises(AdcsError, match=r"^units 'm' and 'nothing': a factor is zero or not finite: correct it$"):
        conversion(OURS, "m", fmu(nothing={"m": 1, "factor": 0.0}), "nothing")

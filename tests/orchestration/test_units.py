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


@pytest.mark.parametrize("factor", [0.0, float("inf"), float("-inf"), float("nan")])
def test_a_factor_that_is_none_is_refused(factor):
    """Both ways: what is divided by infinity would arrive as 0."""
    bad = fmu(bad={"m": 1, "factor": factor}, worse={"m": 1, "factor": factor})
    for here, unit, there, wanted in ((OURS, "m", bad, "bad"), (bad, "bad", OURS, "m"), (bad, "bad", bad, "worse")):
        with pytest.raises(AdcsError) as error:
            conversion(here, unit, there, wanted)
        assert str(error.value) == f"units {unit!r} and {wanted!r}: a factor is zero or not finite: correct it"
    if factor == factor:
        assert conversion(bad, "bad", bad, "bad") == Scale()  # nothing is converted


def test_factors_so_far_apart_that_0_would_arrive_are_refused():
    with pytest.raises(AdcsError, match=r"^units 'tiny' and 'huge': a factor is zero or not finite: correct it$"):
        conversion(fmu(tiny={"m": 1, "factor": 1e-200}), "tiny", fmu(huge={"m": 1, "factor": 1e200}), "huge")


@pytest.mark.parametrize("offset", [float("inf"), float("nan")])
def test_an_offset_that_is_none_is_refused(offset):
    bad = fmu(bad={"K": 1, "offset": offset})
    for here, unit, there, wanted in ((OURS, "K", bad, "bad"), (bad, "bad", OURS, "K")):
        with pytest.raises(AdcsError) as error:
            conversion(here, unit, there, wanted)
        assert str(error.value) == f"units {unit!r} and {wanted!r}: an offset is not finite: correct it"

"""The components that an operator moves: the commanded reference and the torque switch."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from .at_points import draw, opened

POINTS = 20


@pytest.mark.parametrize(("name", "parameter"), [("CommandedReference", "engaged"), ("TorqueSwitch", "enabled")])
def test_a_switch_is_on_or_off(name: str, parameter: str) -> None:
    point = draw(name, 1)[0] | {parameter: np.array(2)}
    with pytest.raises(FMICallException, match=r"SetBoolean failed"):
        opened(name, 2, point)  # in FMI 3 nothing else can be said

"""What controls do to the body."""

from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from adcs import AdcsError
from adcs.cli.hil import _numbers
from hil_bridge.hil.actuators import Actuators

NAN = float("nan")


def controls(*values: float, armed: bool = True) -> mavlink.MAVLink_message:
    padded = [*values, *[NAN] * (16 - len(values))]
    mode = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0
    return mavlink.MAVLink_hil_actuator_controls_message(0, padded, mode, 1)


def test_controls_are_parts_of_the_largest_torque() -> None:
    np.testing.assert_array_equal(Actuators.by_axis((0.2,)).torque(controls(1.0, -0.5, 0.0)), [0.2, -0.1, 0.0])
    np.testing.assert_array_equal(Actuators.by_axis((1.0, 2.0, 4.0)).torque(controls(0.5, 0.5, -0.5)), [0.5, 1.0, -2.0])


def test_what_is_beyond_is_clipped_and_what_is_no_number_is_nothing() -> None:
    actuators = Actuators.by_axis((2.0,))
    np.testing.assert_array_equal(actuators.torque(controls(7.0, -1e30, float("inf"))), [2.0, -2.0, 0.0])
    np.testing.assert_array_equal(actuators.torque(controls(NAN, 0.5, 0.5)), [0.0, 1.0, 1.0])
    assert (actuators.clipped, actuators.not_numbers, actuators.disarmed) == (1, 2, 0)


def test_only_an_armed_autopilot_moves_anything() -> None:
    actuators = Actuators.by_axis((2.0,))
    assert not actuators.torque(controls(1.0, 1.0, 1.0, armed=False)).any()
    assert actuators.disarmed == 1


def test_four_wheels_from_a_table(tmp_path: Path) -> None:
    """A pyramid of four wheels: equal controls give no torque about x and y."""
    table = tmp_path / "wheels.csv"
    table.write_text("0.1,0,-0.1,0\n0,0.1,0,-0.1\n0.05,0.05,0.05,0.05\n\n")
    actuators = Actuators.from_csv(table)
    np.testing.assert_allclose(actuators.torque(controls(1, 1, 1, 1)), [0, 0, 0.2], atol=1e-17)
    np.testing.assert_allclose(actuators.torque(controls(1, 0.5, -1, -0.5)), [0.2, 0.1, 0.0], atol=1e-17)


@pytest.mark.parametrize(
    "text", ["1,2\n3,4\n", "1,2\n3\n4,5\n", "1,a\n1,2\n1,2\n", "nan\n1\n1\n", ",".join("1" * 17) + "\n"]
)
def test_other_tables_are_refused(tmp_path: Path, text: str) -> None:
    table = tmp_path / "wheels.csv"
    table.write_text(text)
    with pytest.raises(AdcsError, match=r"wheels\.csv(:|, line [12]:) ") as refused:
        Actuators.from_csv(table)
    assert "\n" not in str(refused.value)


def test_a_table_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(AdcsError, match="cannot open"):
        Actuators.from_csv(tmp_path / "none.csv")


@pytest.mark.parametrize("most", [(0.0,), (-1.0,), (1.0, 2.0), (NAN,), (float("inf"), 1.0, 1.0)])
def test_other_largest_torques_are_refused(most: tuple[float, ...]) -> None:
    with pytest.raises(AdcsError, match="expected one positive number or three"):
        Actuators.by_axis(most)


def test_words_on_the_command_line() -> None:
    assert _numbers("0.2,0.2,0.1") == (0.2, 0.2, 0.1)
    with pytest.raises(AdcsError, match="--max-torque much: expected one number or three"):
        _numbers("much")

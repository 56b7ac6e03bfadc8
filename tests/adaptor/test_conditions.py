"""What a variable as a whole may be required to be, and what a law says of its parameters."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fmus.build import build
from tests.one_fmu import Raw

HEADER = """\
/// # What is required
#pragma once

#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct Required {
    static constexpr auto kind = "sensor";
    static constexpr auto summary = "conditions";
    static constexpr auto reference = "";

    Mat3<T> C_BN = Mat3<T>::Identity(), C_SB = Mat3<T>::Identity();
    Eigen::Matrix<T, 4, 1> times{0.0, 1.0, 2.0, 3.0};
    T mass = 2.0, y = 0.0;

    template <class V>
    void declare(V& v) {
        v.input("C_BN", C_BN, unit::one, "attitude").rotation();
        v.parameter("C_SB", C_SB, unit::one, "mounting").rotation();
        v.parameter("times", times, unit::s, "of a table").increasing();
        v.parameter("mass", mass, unit::kg, "of it");
        v.output("y", y, unit::one, "an element");
    }

    void outputs() { y = (C_SB * C_BN)(0, 0) + times[1]; }

    void validate(Words& refuse) const {
        if (mass > times[3]) refuse("mass = %g kg is above the last time, %g", mass, times[3]);
        if (mass > 50.0) refuse("said second");
    }
};

}  // namespace adcs
"""
TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("conditions") / "required.hpp"
    path.write_text(HEADER)
    build([str(path)])
    return path


@pytest.fixture(params=[2, 3])
def raw(request: pytest.FixtureRequest, header: Path) -> Iterator[Raw]:
    with Raw(str(header), request.param) as instance:
        yield instance


@pytest.mark.parametrize(
    ("start", "says"),
    [
        (
            {"C_SB": -np.eye(3)},
            "C_SB = [-1 -0 -0; -0 -1 -0; -0 -0 -1] is no rotation: rows of length 1 at right angles",
        ),
        ({"C_SB": np.diag([1.0, 1.0, 1.5])}, "C_SB = [1 0 0; 0 1 0; 0 0 1.5] is no rotation"),
        ({"times": [0.0, 1.0, 1.0, 3.0]}, "times is not increasing: element 3 = 1 is not above element 2 = 1"),
        ({"mass": 60.0}, "mass = 60 kg is above the last time, 3"),
    ],
)
def test_parameters_are_refused_with_their_values(raw: Raw, start: dict[str, object], says: str) -> None:
    for name, value in start.items():
        raw.set({name: value})
    with pytest.raises(FMICallException):
        raw.initialize()
    assert says in raw.messages[-1][2]


def test_an_input_has_to_be_a_rotation_at_all_times(raw: Raw) -> None:
    raw.initialize()
    raw.set({"C_BN": TURN})
    assert raw.get("y") == 1.0
    raw.set({"C_BN": 0.9 * TURN})
    with pytest.raises(FMICallException):
        raw.get("y")
    assert "at t = 0: input C_BN = [0 0.9 0; -0.9 0 0; 0 0 0.9] is no rotation" in raw.messages[-1][2]
    raw.set({"C_BN": np.eye(3)})
    assert raw.get("y") == 2.0

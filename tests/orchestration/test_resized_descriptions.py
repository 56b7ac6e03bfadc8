"""What follows from a size that a structural parameter gives, in Model Exchange: states, events, derivatives."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest

from adcs import CoupledModel, ModelExchange, linearize, run
from orchestration.single import single

SIZE = (
    '<UInt64 name="n" valueReference="900" causality="structuralParameter" variability="fixed" start="2"/>'
    '<Float64 name="time"'
)
CHANGES = {
    '<Float64 name="time"': SIZE,
    '<Dimension start="3"/>': '<Dimension valueReference="900"/>',
    'start="1.0 1.0 1.0"': 'start="1.0"',
    'start="0.0 0.0 0.0"': 'start="0.0"',
    "<ModelExchange ": '<ModelExchange providesDirectionalDerivatives="true" ',
    "</ModelStructure>": '<EventIndicator valueReference="12"/></ModelStructure>',
}


@pytest.fixture
def resizable(mock, tmp_path):
    """Two elements as it is described, three after n = 3; its binary has three."""
    changed = tmp_path / "resizable.fmu"
    with zipfile.ZipFile(mock("resizable", "3.0")) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                text = content.decode()
                for here, there in CHANGES.items():
                    assert here in text
                    text = text.replace(here, there)
                content = text.encode()
            new.writestr(name, content)
    return changed


def test_linearised(resizable):
    found = linearize(single(resizable, {"n": 3}), fmi_version="3.0")
    assert found.states == ("resizable.x[1]", "resizable.x[2]", "resizable.x[3]")
    assert found.A.tolist() == [[-1, 0, 0], [0, -2, 0], [0, 0, -3]]
    assert found.B.tolist() == found.C.tolist() == np.eye(3).tolist()
    assert found.D.tolist() == np.zeros((3, 3)).tolist()
    assert not [note for note in found.notes if "differences" in note]


def test_event_indicators(resizable):
    system = single(resizable, {"n": 3, "x": [1.0, 1.0, 1.0]})
    with CoupledModel(system, 0.0, fmi_version="3.0") as model:
        assert model.indicators(0.0, np.array([1.0, 2.0, 3.0])).tolist() == [0.5, 1.5, 2.5]
    result = run(system, stop_time=1.0, step=0.25, method=ModelExchange(rtol=1e-10, atol=1e-12), fmi_version="3.0")
    expected = np.exp(-np.outer([0.0, 0.25, 0.5, 0.75, 1.0], [1, 2, 3]))
    np.testing.assert_allclose(result["resizable.y"], expected, rtol=1e-8)

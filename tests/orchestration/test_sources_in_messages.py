"""An input that goes bad is named with the output that it comes from."""

from __future__ import annotations

import pytest

from adcs import CoSimulation, RunFailed, Save, System, run

STEPPINGS = ("compiled", "python")


def grown(mock, version, source, target):
    """Offset + t in metres, which is beyond what a double holds after 0.5 s, ten times as large."""
    system = System("large")
    system.add("source", mock("source", version), {"offset": [0.0, 1.7e307, 1.7e307], "slope": 1e307})
    system.add("gain", mock("gain", version), {"u": [0.0, 0.0, 0.0]} if target.endswith("]") else None)
    system.connect(source, target, factor=10.0)
    return system


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize(
    ("source", "target", "named"), [("source.y", "gain.u", "source.y[2]"), ("source.y[3]", "gain.u[2]", "source.y[3]")]
)
def test_a_value_that_becomes_infinite_on_the_way(mock, version, stepping, source, target, named):
    """From an array to an array, or from one element to another."""
    with pytest.raises(RunFailed) as error:
        run(
            grown(mock, version, source, target),
            stop_time=1.0,
            step=0.25,
            method=CoSimulation(stepping=stepping),
            save=Save(["gain.y"]),
        )
    text = str(error.value)
    assert text.startswith(f"gain failed at t = 0.25 s: u[2] = inf does not fit type Float64, it comes from {named};")


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_message_of_the_component_that_names_an_input(mock, version, stepping):
    """The component says which of its inputs it refuses, and knows nothing of where that comes from."""
    system = System("fussy")
    system.add("source", mock("source", version), {"offset": [1.0, 2.0, 3.0]})
    system.add("gain", mock("gain", version), {"k": 1e9})
    system.connect("source.y", "gain.u")
    with pytest.raises(RunFailed) as error:
        run(system, stop_time=4.0, step=0.5, method=CoSimulation(stepping=stepping))
    assert "u is too large for this gain (u comes from source.y); " in str(error.value)

"""What is done with a system is done with its name, or its file, at its own times."""

from __future__ import annotations

import numpy as np
import pytest

from adcs import AdcsError, System, linearize, run, steps, systems, write_ssp


def test_a_name_is_a_system_with_its_times():
    plain = run(systems()["hil-spacecraft"].build(), stop_time=60.0, step=0.004)
    named = run("hil-spacecraft")
    assert np.array_equal(named.data, plain.data)
    assert np.array_equal(named.time, plain.time)
    assert [t for t, _ in steps("observer-pd", stop_time=0.03)] == [0.0, 0.01, 0.02, 0.03]
    assert linearize("full-state-pd").system == "full-state-pd"


def test_a_file_is_a_system_with_its_times(tmp_path):
    write_ssp(systems()["observer-pd"].build(), tmp_path / "x.ssp", start_time=1.0, stop_time=2.0, step=0.25)
    assert run(tmp_path / "x.ssp").time.tolist() == [1.0, 1.25, 1.5, 1.75, 2.0]
    assert run(str(tmp_path / "x.ssp"), start_time=0.0, stop_time=1.0, step=0.5).time.tolist() == [0.0, 0.5, 1.0]


@pytest.mark.parametrize(
    ("system", "settings", "message"),
    [
        ("observer-dp", {}, "no system 'observer-dp': did you mean observer-pd"),
        (System("mine"), {}, "stop_time: mine has none of its own, give it"),
        (System("mine"), {"stop_time": 1.0}, "step: mine has none of its own, give it"),
        ("trigo-bs", {"step": 0.3}, "step"),
    ],
)
def test_refused(system, settings, message):
    with pytest.raises(AdcsError) as error:
        run(system, **settings)
    assert message in str(error.value)


def test_a_system_of_ones_own_may_have_times():
    from orchestration.system import Times

    system = systems()["observer-pd"].build()
    system.times = Times(0.0, 0.5, 0.25)
    assert run(system).time.tolist() == [0.0, 0.25, 0.5]
    assert run(system, stop_time=0.25).time.tolist() == [0.0, 0.25]

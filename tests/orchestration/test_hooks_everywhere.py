"""What happens during a run happens by every method: changes, tables, conditions, rows left out, one's own hooks."""

from __future__ import annotations

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, Hook, ModelExchange, Save, System, run
from orchestration.running.hooks.changes import Changes
from orchestration.running.hooks.inputs import Table

METHODS = {
    "adaptive": {"method": CoSimulation(adaptive=1e-9)},
    "DOP853": {"method": ModelExchange()},
    "CVode": {"method": ModelExchange("CVode")},
}


@pytest.fixture(params=METHODS)
def method(request):
    return METHODS[request.param]


def body(torque=(0.0, 0.0, 0.0)):
    """A sphere of 2 kg.m2 at rest: its rate is half the integral of the torque, which None leaves to a table."""
    system = System("body")
    system.add("plant", "RigidBody", {"J_B": 2 * np.eye(3), "torque_disturbance_B": [0.0, 0.0, 0.0]})
    if torque is not None:
        system.set("plant.torque_B", torque)
    return system


PUSHED = (1.0, 0.0, 0.0)


def rate(result):
    return result["plant.omega_BN_B"][:, 0]


def test_a_change_acts_from_its_time_on(method, version):
    changes = [(1.0, "plant.torque_B", [1.0, 0.0, 0.0]), (1.5, "plant.torque_B", [0.0, 0.0, 0.0])]
    result = run(body(), stop_time=2.0, step=0.25, hooks=[Changes(changes)], fmi_version=version, **method)
    t = result.time
    assert rate(result) == pytest.approx(np.clip(t - 1.0, 0.0, 0.5) / 2, abs=1e-12)
    assert result.manifest["settings"]["changes"][0] == [1.0, "plant.torque_B", [1.0, 0.0, 0.0]]


def test_a_tunable_parameter_is_changed(method):
    start = [(0.0, "plant.torque_B", [1.0, 0.0, 0.0]), (1.0, "plant.J_B", 4 * np.eye(3))]
    result = run(body(), stop_time=2.0, step=0.25, hooks=[Changes(start)], **method)
    t = result.time
    assert rate(result) == pytest.approx(np.minimum(t, 1) / 2 + np.maximum(t - 1, 0) / 4, abs=1e-12)


def test_a_table_bends_between_two_rows(tmp_path, version):
    """Up to 0.6 s the torque rises, then it stays: coupled Model Exchange sees the bend, which is at no row."""
    table = tmp_path / "u.csv"
    table.write_text("time,plant.torque_B[1],plant.torque_B[2],plant.torque_B[3]\n0,0,0,0\n0.6,1.2,0,0\n9,1.2,0,0\n")
    for settings in (METHODS["DOP853"], METHODS["CVode"]):
        result = run(body(None), stop_time=2.0, step=0.5, hooks=[adcs.inputs(table)], fmi_version=version, **settings)
        t = result.time
        exact = np.where(t < 0.6, t**2, 0.36 + 1.2 * (t - 0.6)) / 2
        assert rate(result) == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("solver", ["DOP853", "CVode"])
def test_a_table_gives_the_bits_of_one_that_is_asked(tmp_path, monkeypatch, solver):
    """What is compiled asks it at the times of events only; before, between, at and after its times, and for -0.0."""
    times = np.cumsum(np.random.default_rng(5).uniform(0.01, 0.3, 12)) + 0.2
    rows = np.column_stack([times, np.random.default_rng(6).normal(size=(12, 6))])
    rows[3] = [rows[3, 0], *(-0.0,) * 6]
    names = [f"plant.{torque}[{i}]" for torque in ("torque_B", "torque_disturbance_B") for i in (1, 2, 3)]
    table = tmp_path / "u.csv"
    np.savetxt(table, rows, "%.17g", ",", header=",".join(["time", *names]), comments="")
    open_ended = System("body")
    open_ended.add("plant", "RigidBody", {"J_B": np.diag([1.0, 2.0, 2.5])})
    asked = []
    monkeypatch.setattr(Table, "at", lambda self, t, at=Table.at: asked.append(float(t[0])) or at(self, t))
    settings = {"stop_time": 3.0, "step": 0.01, "method": ModelExchange(solver)}
    followed = run(open_ended, **settings, hooks=[adcs.inputs(table)])
    assert len(asked) < 20
    monkeypatch.setattr("orchestration.coupled.model.lines_of", lambda source: None)
    again = run(open_ended, **settings, hooks=[adcs.inputs(table)])
    assert len(asked) > 300
    assert np.array_equal(followed.data, again.data)
    assert np.array_equal(np.signbit(followed.data), np.signbit(again.data))
    assert followed.manifest["integrator"] == again.manifest["integrator"]


def test_a_table_beside_a_source_that_has_to_be_asked(tmp_path):
    class Ramp:
        names = ("plant.torque_B[2]",)

        def at(self, times):
            return times[:, None]

        def jump(self, after):
            return np.inf

    class Ramped(Hook):
        def prepare(self, outline):
            outline.sources.append(Ramp())

    table = tmp_path / "u.csv"
    table.write_text("time,plant.torque_B[1],plant.torque_B[3]\n0,1,0\n2,1,4\n")
    result = run(body(None), stop_time=2.0, step=0.5, hooks=[Ramped(), adcs.inputs(table)], method=ModelExchange())
    t = result.time
    assert result["plant.omega_BN_B"] == pytest.approx(np.column_stack([t / 2, t**2 / 4, t**2 / 2]), abs=1e-9)


def test_a_table_is_followed_by_the_steps_between_two_rows(tmp_path):
    """Held over a step, a ramp is late by half of it; 2^j steps are late by 2^-j of that."""
    table = tmp_path / "u.csv"
    table.write_text("time,plant.torque_B[1],plant.torque_B[2],plant.torque_B[3]\n0,0,0,0\n2,2,0,0\n")
    rough = run(body(None), stop_time=2.0, step=0.5, hooks=[adcs.inputs(table)])
    result = run(body(None), stop_time=2.0, step=0.5, hooks=[adcs.inputs(table)], method=CoSimulation(adaptive=1e-3))
    exact = result.time**2 / 4
    assert np.abs(rate(rough) - exact).max() == pytest.approx(0.25)
    assert np.abs(rate(result) - exact).max() < 0.01
    assert result.manifest["adaptive"]["rejected"] > 0


def test_a_condition_ends_the_run(method):
    pushed = body(PUSHED)
    result = run(pushed, stop_time=10.0, step=0.25, hooks=[adcs.until("plant.omega_BN_B[1] > 0.6")], **method)
    assert result.time[-1] == 1.25
    assert result.manifest["outcome"]["met"] == {"condition": "plant.omega_BN_B[1] > 0.6", "time": 1.25}


def test_rows_are_left_out_and_go_to_a_file(method, tmp_path):
    pushed = body(PUSHED)
    whole = run(pushed, stop_time=2.3, step=0.1, **method)
    some = run(pushed, stop_time=2.3, step=0.1, save=Save(every=5), **method)
    assert np.array_equal(some.data, whole.data[::5])
    assert np.array_equal(some.time, whole.time[::5])
    filed = run(pushed, stop_time=2.3, step=0.1, save=Save(every=5, to=tmp_path / "x.h5"), **method)
    assert np.array_equal(filed["plant.omega_BN_B"], some["plant.omega_BN_B"])
    if "method" in method:
        assert some.states.shape == (5, len(whole.state_names))
        assert np.array_equal(some.states, whole.states[::5])


def test_it_keeps_to_the_clock(method):
    result = run(body(), stop_time=0.2, step=0.05, hooks=[adcs.pace(1.0)], **method)
    assert result.manifest["real_time"]["points"] == 5
    assert result.manifest["timing"]["wall_s"] >= 0.2


def test_a_hook_of_ones_own(method):
    class Brake(Hook):
        """Takes the torque away at the first point at which the rate is above 0.3 rad/s; a part of the caller."""

        def begin(self, simulation, hooks, watched):
            self.simulation, self.place, self.braked = simulation, None, None
            names = list(simulation.ports)
            sizes = [simulation.ports[name].size for name in names]
            self.place = sum(sizes[: names.index("plant.omega_BN_B")])

        def ahead(self, k):
            return 1

        def after(self, point, time):
            if self.braked is None and self.simulation.row[self.place] > 0.3:
                self.braked = point + 1

        def changes(self, k):
            return [("plant.torque_B", [0.0, 0.0, 0.0])] if k == self.braked else []

        def report(self):
            return {"braked_at": self.braked}

    pushed = body(PUSHED)
    result = run(pushed, stop_time=2.0, step=0.25, hooks=[Brake()], **method)
    # above 0.3 rad/s at 0.75 s; what is seen there is answered at the next point
    assert result.manifest["braked_at"] == 4
    assert rate(result) == pytest.approx(np.minimum(result.time, 1.0) / 2, abs=1e-12)


def test_a_hook_that_goes_nowhere_is_named():
    class Stuck(Hook):
        def ahead(self, k):
            return 0

    with pytest.raises(AdcsError, match=r"Stuck\.ahead returned 0: expected a number of points from 1"):
        run(body(), stop_time=1.0, step=0.5, hooks=[Stuck()])


def test_a_report_does_not_replace_what_the_manifest_says():
    class Loud(Hook):
        def report(self):
            return {"settings": {"x": 1}, "loud": True}

    manifest = run(body(), stop_time=1.0, step=0.5, hooks=[Loud()]).manifest
    assert manifest["settings"]["stop_time"] == 1.0
    assert manifest["loud"] is True
    assert "settings of a report is left out: the manifest has it" in manifest["warnings"]

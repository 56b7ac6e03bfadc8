"""A stop time that is no whole number of steps after the start: the last step is shorter, where that can be."""

from __future__ import annotations

import json
import sys

import mocks
import numpy as np
import pytest

from adcs import (
    AdcsError,
    CoSimulation,
    ModelExchange,
    Save,
    Session,
    System,
    at,
    checkpoint,
    estimate_error,
    inputs,
    run,
    steps,
    until,
)
from adcs.cli import app as cli
from adcs.library.thakur.observer.systems import observer_pd
from hil_bridge.hil.flying import check

STEPPINGS = ("compiled", "python")
ME = ModelExchange()


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_integrals_end_where_they_should(chain, version, stepping):
    """y = 2 (offset + t), held over each step and integrated: the last part is 0.05 s long."""
    result = run(chain(version), stop_time=0.35, step=0.1, method=CoSimulation(stepping=stepping), fmi_version=version)
    assert result.time.tolist() == [0.0, 0.1, 0.2, 0.1 * 3, 0.35]
    held = [2 * (1 + t) for t in (0.0, 0.1, 0.2, 0.3)]
    expected = np.cumsum([0.0, *np.multiply(held, [0.1, 0.1, 0.1, 0.05])])
    assert result["integrator.y"][:, 0] == pytest.approx(expected, abs=1e-15)
    assert result["source.y"][:, 0] == pytest.approx([1.0, 1.1, 1.2, 1.3, 1.35])
    assert result.manifest["outcome"] == {"status": "complete", "rows": 5}


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_its_length_and_where_it_starts(foreign, version, stepping):
    system = System("alone")
    system.add("c", foreign("punctual", version))
    result = run(system, start_time=0.7, stop_time=1.56, step=0.1, method=CoSimulation(stepping=stepping))
    assert result.time[-2:] == pytest.approx([1.5, 1.56])
    assert result["c.step_seen"][-3:] == pytest.approx([0.1, 0.1, 0.06])
    assert result["c.off"][-1] <= 3


def test_a_run_of_less_than_a_step(chain):
    result = run(chain(), stop_time=0.25, step=1.0)
    assert result.time.tolist() == [0.0, 0.25]
    assert result["integrator.y"][:, 0].tolist() == [0.0, 0.5]


def test_the_same_bits_before_it(chain):
    whole, more = (run(chain(), stop_time=stop, step=0.1) for stop in (0.3, 0.35))
    assert more["integrator.y"][:-1].tolist() == whole["integrator.y"].tolist()


def test_where_it_may_not_be_the_component_is_named(foreign):
    system = System("alone")
    system.add("c", foreign("rigid_clock", name="rigid", canHandleVariableCommunicationStepSize=None))
    with pytest.raises(AdcsError) as error:
        run(system, stop_time=1.3, step=0.25)
    assert str(error.value) == (
        "stop_time = 1.3 s is not a whole number of steps of 0.25 s after start_time = 0.0 s, and c "
        "(rigid.fmi3.fmu) takes no shorter last one (canHandleVariableCommunicationStepSize is not true): use "
        "1.25 or 1.5 s"
    )


def test_in_lockstep_with_an_autopilot_it_is_refused(chain):
    with pytest.raises(AdcsError, match=r"is not a whole number of steps of 0.1 s after start_time = 0.0 s: use 0.3"):
        check(chain(), stop_time=0.35, step=0.1)


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("every", [2, 3])
def test_slow_components_hold(mock, version, stepping, every):
    """The source communicates at 0, every*h ... only; its values hold at the end, as they do at the end of any run."""
    system = System("slow")
    system.add("source", mock("source", version), every=every)
    system.add("gain", mock("gain", version))
    system.connect("source.y", "gain.u")
    result = run(system, stop_time=0.55, step=0.1, method=CoSimulation(stepping=stepping), fmi_version=version)
    times = every * 0.1 * (np.arange(6) // every)
    assert result["source.y"][:, 0] == pytest.approx([*times, times[-1]])
    assert result["gain.doubled"][:, 0] == pytest.approx(2 * np.array([*times, times[-1]]))


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize("delay", [{"delay_steps": 1}, {"delay_steps": 3}, {"delay": 0.2}])
def test_what_is_delayed_arrives_at_points_of_the_grid(mock, version, stepping, delay):
    """At 0.45 s what has arrived last is what left at 0.4 s less the delay."""
    system = System("late")
    system.add("source", mock("source", version), {"offset": [1.0, 1.0, 1.0]})
    system.add("gain", mock("gain", version), {"u": [0.0, 0.0, 0.0]})
    system.connect("source.y", "gain.u", **delay)
    result = run(system, stop_time=0.45, step=0.1, method=CoSimulation(stepping=stepping), fmi_version=version)
    late = round(delay.get("delay", 0.0) / 0.1) or delay["delay_steps"]
    left = [1.0 + 0.1 * (k - late) if k >= late else 0.0 for k in range(5)]
    assert result["gain.doubled"][:, 0] == pytest.approx([2 * v for v in (*left, left[-1])])


def test_changes_inputs_and_conditions_at_the_end(mock, tmp_path):
    system = System("driven")
    system.add("integrator", mock("integrator"), {"u": [1.0, 1.0, 1.0]})
    result = run(
        system, stop_time=0.25, step=0.1, hooks=[at(0.25, {"integrator.u": [5, 5, 5]})], save=Save(["integrator.u"])
    )
    assert result["integrator.u"][:, 0].tolist() == [1.0, 1.0, 1.0, 5.0]
    with pytest.raises(AdcsError, match=r"at 0.22 s lies between two communication points: use 0.2 or 0.25 s$"):
        run(system, stop_time=0.25, step=0.1, hooks=[at(0.22, {"integrator.u": [5, 5, 5]})])
    with pytest.raises(AdcsError, match=r"at 0.3 s lies outside the run, 0 to 0.25 s$"):
        run(system, stop_time=0.25, step=0.1, hooks=[at(0.3, {"integrator.u": [5, 5, 5]})])
    open_ = System("open")
    open_.add("integrator", mock("integrator"))
    (tmp_path / "u.csv").write_text("time,integrator.u[1],integrator.u[2],integrator.u[3]\n0,0,0,0\n1,1,1,1\n")
    result = run(open_, stop_time=0.25, step=0.1, hooks=[inputs(tmp_path / "u.csv")], save=Save(["integrator.u"]))
    assert result["integrator.u"][:, 0] == pytest.approx([0.0, 0.1, 0.2, 0.25])
    result = run(system, stop_time=0.25, step=0.1, hooks=[until("integrator.y[1] > 0.24")])
    assert result.manifest["outcome"]["met"]["time"] == 0.25


@pytest.mark.parametrize("every", [2, 3, 100])
def test_its_row_is_written_whatever_rows_are_left_out(chain, every):
    result = run(chain(), stop_time=0.95, step=0.1, save=Save(every=every))
    assert result.time == pytest.approx([*(np.arange(0, 10, every) * 0.1), 0.95])


def test_the_checkpoint_is_that_before_it(foreign, version, tmp_path):
    system = System("alone")
    system.add("c", foreign("picky", version), {"u": 1.0, "longest": 1.0})
    whole = run(system, stop_time=1.0, step=0.1)
    run(system, stop_time=0.55, step=0.1, hooks=[checkpoint(tmp_path / "state.npz", every=0.3)])
    rest = run(system, stop_time=1.0, step=0.1, resume=tmp_path / "state.npz")
    assert rest.time[0] == 0.5
    assert rest["c.x"].tolist() == whole["c.x"][5:].tolist()
    again = run(system, stop_time=0.77, step=0.1, resume=tmp_path / "state.npz")
    assert again.time == pytest.approx([0.5, 0.6, 0.7, 0.77])


def test_steps_and_sessions(chain):
    times = [t for t, _ in steps(chain(), stop_time=0.35, step=0.1)]
    assert times == [0.0, 0.1, 0.2, 0.1 * 3, 0.35]
    with Session(chain(), step=0.1, steps=4, stop_time=0.35) as simulation:
        *_, (_, values) = simulation
        assert values["source.y"][0] == pytest.approx(1.35)


def test_adaptive_steps_too(foreign, version):
    system = System("alone")
    system.add("c", foreign("picky", version), {"u": 1.0, "longest": 1.0})
    result = run(system, stop_time=0.35, step=0.1, method=CoSimulation(adaptive=1e-3), save=Save(["c.x"]))
    assert result["c.x"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.35])


def test_one_differential_equation_ends_anywhere(mock):
    system = System("swing")
    system.add("oscillator", mocks.build("oscillator", mock("oscillator").parent), {"u": 0.0})
    result = run(system, stop_time=1.2345, step=0.5, method=ME)
    assert result.time.tolist() == [0.0, 0.5, 1.0, 1.2345]
    assert result["oscillator.position"] == pytest.approx(np.cos(result.time), abs=1e-9)


def test_estimates_of_the_error_see_it():
    result = run(observer_pd(), stop_time=0.25, step=0.02)
    estimate = estimate_error(result, run)
    assert max(d.most for d in estimate.deviations) < 0.05
    slow = observer_pd()
    slow.components["controller"].every = 2
    assert estimate_error(run(slow, stop_time=0.25, step=0.02), run).method == "step halving"


def adcs(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["adcs", *map(str, arguments)])
    try:
        cli.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def test_start_on_the_command_line(tmp_path, monkeypatch):
    """The draws of a star tracker are functions of time: a later start sees later ones."""
    common = ("--step", 0.05, "--no-report", "--format", "csv")
    assert adcs(monkeypatch, "run", "observer-pd", "--start", 2, "--stop", 2.12, *common, "--out", tmp_path) == 0
    rows = (tmp_path / "result.csv").read_text().splitlines()
    assert [float(row.partition(",")[0]) for row in rows[1:]] == pytest.approx([2.0, 2.05, 2.1, 2.12])
    assert json.loads((tmp_path / "manifest.json").read_text())["settings"]["start_time"] == 2.0


def test_a_start_after_the_end(tmp_path, monkeypatch, capsys):
    assert adcs(monkeypatch, "run", "observer-pd", "--start", 200, "--out", tmp_path) == 2
    assert capsys.readouterr().err == "adcs: stop_time = 100.0 s lies before start_time = 200.0 s\n"


def test_sizes_on_the_command_line(foreign, tmp_path, monkeypatch):
    """In any order: what says how long arrays are comes first."""
    values = ("--set", "sizes.u=1,2,3,4,5", "--set", "sizes.n=5")
    arguments = ("--stop", 1, "--step", 0.5, "--out", tmp_path, "--no-report", "--fmi", 3)
    assert adcs(monkeypatch, "run", foreign("sizes"), *values, *arguments) == 0
    header, *rows = (tmp_path / "result.csv").read_text().splitlines()
    assert header == "time[s],sizes.y[1][-],sizes.y[2][-],sizes.y[3][-],sizes.y[4][-],sizes.y[5][-],sizes.total[-]"
    assert rows[-1] == "1.0,2.0,4.0,6.0,8.0,10.0,15.0"

"""Co-simulation of mocks whose values are known exactly; compiled and from Python."""

import threading

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, RunFailed, RunInterrupted, Save, System, run, steps

STEPPINGS = ("compiled", "python")


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_chain_has_no_hidden_delay(chain, version, stepping):
    result = run(chain(version), stop_time=1.0, step=0.25, method=CoSimulation(stepping=stepping))
    k = np.arange(5)
    t = 0.25 * k
    assert result.time.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    for i, offset in enumerate((1.0, 2.0, 3.0)):
        assert result["source.y"][:, i].tolist() == (offset + t).tolist()
        assert result["gain.y"][:, i].tolist() == (2 * (offset + t)).tolist()
        assert result["gain.doubled"][:, i].tolist() == (2 * (offset + t)).tolist()
        # Euler with the value propagated at the beginning of each step: 2 h sum(offset + j h) over j < k
        exact = 0.5 * (offset * k + 0.25 * k * (k - 1) / 2) + (10.0 if i == 2 else 0.0)
        assert result["integrator.y"][:, i].tolist() == exact.tolist()


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_the_first_row_holds_propagated_initial_values(chain, version, stepping):
    result = run(chain(version), start_time=2.0, stop_time=2.0, step=0.25, method=CoSimulation(stepping=stepping))
    assert result.time.tolist() == [2.0]
    assert result["gain.y"].tolist() == [[6.0, 8.0, 10.0]]
    assert result["integrator.y"].tolist() == [[0.0, 0.0, 10.0]]


def test_time_is_an_index(mock):
    system = System("clock")
    system.add("source", mock("source"))
    result = run(system, start_time=0.3, stop_time=1000.3, step=0.1)
    assert len(result.time) == 10001
    assert result.time.tolist() == [0.3 + k * 0.1 for k in range(10001)]
    assert result.time[-1] == 1000.3
    # what the components are told: t_k + step, not a sum of steps
    assert result["source.y"][1:, 0].tolist() == [(0.3 + k * 0.1) + 0.1 for k in range(10000)]


def test_compiled_and_python_agree_to_the_last_bit(mock, version):
    system = System("ring")
    system.add("a", mock("oscillator", version), {"a": 0.7})
    system.add("b", mock("oscillator", version), {"b": 0.3})
    system.connect("a.position", "b.u")
    system.connect("b.position", "a.u")
    one, other = (run(system, stop_time=3, step=0.01, method=CoSimulation(stepping=s)) for s in STEPPINGS)
    assert np.array_equal(one.data, other.data)
    assert np.ptp(one["a.position"]) > 0.5
    live = list(steps(system, stop_time=3, step=0.01))
    assert [t for t, _ in live] == one.time.tolist()
    assert [float(v["a.position"]) for _, v in live] == one["a.position"].tolist()


def test_both_versions_agree_to_the_last_bit(chain):
    two, three = (run(chain(v), stop_time=2, step=0.01) for v in ("2.0", "3.0"))
    assert np.array_equal(two.data, three.data)


def test_versions_can_be_mixed(mock):
    system = System("mixed")
    system.add("source", mock("source", "3.0"))
    system.add("gain", mock("gain", "2.0"), {"k": 3.0})
    system.connect("source.y", "gain.u")
    assert run(system, stop_time=1, step=1)["gain.y"][:, 0].tolist() == [0.0, 3.0]


def test_several_instances_of_one_fmu(mock):
    system = System("twins")
    system.add("one", mock("source"), {"slope": 1.0})
    system.add("two", mock("source"), {"slope": -2.0})
    result = run(system, stop_time=1, step=0.5)
    assert result["one.y"][:, 0].tolist() == [0.0, 0.5, 1.0]
    assert result["two.y"][:, 0].tolist() == [0.0, -1.0, -2.0]


def test_runs_in_several_threads(chain):
    expected = run(chain(), stop_time=5, step=0.01).data
    found: list[np.ndarray] = []
    threads = [
        threading.Thread(target=lambda: found.append(run(chain(), stop_time=5, step=0.01).data)) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert all(np.array_equal(data, expected) for data in found)


def test_an_algebraic_loop_is_refused_by_name(mock):
    system = System("loop")
    system.add("gain", mock("gain"))
    system.connect("gain.doubled", "gain.u")
    with pytest.raises(AdcsError, match=r"algebraic loop: gain\.doubled\[1\] -> gain\.u\[1\] -> gain\.doubled\[1\]"):
        run(system, stop_time=1, step=1)


@pytest.mark.parametrize("stepping", STEPPINGS)
@pytest.mark.parametrize(
    ("mode", "rows", "time", "message"),
    [
        (1, 3, 0.5, "doStep returned error: the wheel is stuck"),
        (2, 2, 0.5, "y is nan|y is not finite"),
        (3, 3, 0.5, "doStep returned the unknown status 99: the FMU gave no message"),
        (4, 3, 0.5, "doStep returned discard: the FMU gave no message"),
        (5, 2, 0.5, "getting y returned error: nothing to get"),
    ],
)
def test_a_failing_component_stops_the_run(faulty, version, stepping, mode, rows, time, message):
    if version == "3.0":  # which takes a step that is discarded in smaller ones
        message = message.replace("discard", "discard, even in steps of 6.1e-05 s")
    with pytest.raises(RunFailed, match=f"^wheel failed at t = {time} s: ({message}); {rows} rows are kept$") as error:
        run(faulty(version, mode), stop_time=1, step=0.25, method=CoSimulation(stepping=stepping))
    result = error.value.result
    assert result.time.tolist() == [0.25 * k for k in range(rows)]
    assert result["wheel.y"].tolist() == [1.0] * rows
    assert result["source.y"][:, 0].tolist() == [0.25 * k for k in range(rows)]
    outcome = result.manifest["outcome"]
    assert (outcome["status"], outcome["component"], outcome["time"]) == ("failed", "wheel", time)
    assert outcome["rows"] == rows
    assert outcome["message"] in str(error.value)


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_component_may_ask_to_end(faulty, stepping):
    result = run(faulty("3.0", 6), stop_time=1, step=0.25, method=CoSimulation(stepping=stepping))
    assert result.time.tolist() == [0.0, 0.25, 0.5, 0.75]  # it took the step in which it asked
    ended = {"component": "wheel", "time": 0.75, "message": "it gave no reason"}
    assert result.manifest["outcome"] == {"status": "complete", "ended": ended, "rows": 4}


def test_failures_in_initialisation_name_the_component(faulty, version):
    with pytest.raises(
        AdcsError, match=r"^wheel: initialisation returned error: mode 7 is no good to start with$"
    ) as error:
        run(faulty(version, 7, at=0.0), stop_time=1, step=0.25)
    assert not isinstance(error.value, RunFailed)


def test_warnings_are_kept(faulty, version):
    result = run(faulty(version, 8), stop_time=1, step=0.25)
    assert result.manifest["warnings"] == ["wheel: the wheel squeaks"] * 2
    assert result.manifest["outcome"] == {"status": "complete", "rows": 5}


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_progress_and_interruption(chain, stepping):
    seen: list[float] = []

    def interrupt(fraction: float) -> None:
        seen.append(fraction)
        if fraction > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(RunInterrupted) as error:
        run(
            chain(),
            stop_time=10_000,
            step=0.01 if stepping == "compiled" else 0.1,
            method=CoSimulation(stepping=stepping),
            progress=interrupt,
        )
    result = error.value.result
    rows = len(result.time)
    assert 0.1 < seen[-1] < 1.0
    assert result.manifest["outcome"] == {"status": "interrupted", "rows": rows}
    assert np.abs(result["source.y"][:, 0] - 1 - result.time).max() < 1e-9


def test_progress_ends_at_one(chain):
    seen: list[float] = []
    run(chain(), stop_time=100, step=0.001, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_what_is_recorded(chain):
    system = chain()
    names = ["integrator.x", "gain.u", "gain.k", "integrator.der(x)"]
    result = run(system, stop_time=1, step=0.5, save=Save(names))
    assert result.names == names
    assert result["gain.u"][:, 0].tolist() == [1.0, 1.5, 2.0]
    assert result["gain.k"].tolist() == [2.0, 2.0, 2.0]
    assert result["integrator.der(x)"][:, 0].tolist() == [2.0, 3.0, 4.0]
    assert result["integrator.x"][:, 2].tolist() == [10.0, 13.0, 16.5]
    with pytest.raises(AdcsError, match=r"component 'gain' \(gain\.fmu\) has no variable 'z'"):
        run(system, stop_time=1, step=0.5, save=Save(["gain.z"]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"step": 0.0}, "step = 0.0 s: expected a positive time"),
        ({"step": -0.1}, "step = -0.1 s: expected a positive time"),
        ({"step": float("nan")}, "step = nan s is not finite"),
        ({"stop_time": float("inf")}, "stop_time = inf s is not finite"),
        ({"stop_time": -1.0}, "stop_time = -1.0 s lies before start_time = 0.0 s"),
        (
            {"start_time": 1e17, "stop_time": 1e17, "step": 1.0},
            "step = 1.0 s is below the resolution of time at 1e+17 s",
        ),
        ({"fmi_version": "1.0"}, "fmi_version = '1.0' is unknown: use '2.0' or '3.0'"),
        (
            {"hooks": [adcs.until("typed.y")]},
            "condition 'typed.y': 'typed.y' at character 1 is no comparison; write it as in norm(plant.omega_BN_B) < "
            "1e-3 and time > 20s",
        ),
        ({"hooks": [adcs.pace(0.0)]}, "speed = 0.0: expected a positive number, 1 for real time"),
    ],
)
def test_refused_arguments(mock, arguments, message):
    system = System("typed")
    system.add("typed", mock("typed"))
    with pytest.raises(AdcsError) as error:
        run(system, **{"stop_time": 1.0, "step": 0.1, **arguments})
    assert str(error.value) == message

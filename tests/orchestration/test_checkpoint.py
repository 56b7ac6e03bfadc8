"""Saved and gone on with: the rest of a run is that of a run without a break, to the last bit."""

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, LoopSolver, RunInterrupted, Save, System, run
from adcs.catalogue import SYSTEMS
from orchestration.running.parts import parts

STEPPINGS = ["compiled", "python"]


def t5(**noise):
    system = SYSTEMS["observer-pd"].build()
    system.set("tracker.half_angle", 0.01)
    system.set("tracker.redraw_period", 0.03)
    system.delay("observer.torque_B", steps=3)
    return system


@pytest.mark.parametrize("stepping", STEPPINGS)
def test_a_resumed_run_goes_on_to_the_last_bit(tmp_path, version, stepping):
    common = {"step": 0.01, "fmi_version": version, "method": CoSimulation(stepping=stepping)}
    whole = run(t5(), stop_time=1.0, **common)
    first = run(t5(), stop_time=0.37, hooks=[adcs.checkpoint(tmp_path / "state")], **common)
    rest = run(t5(), stop_time=1.0, resume=tmp_path / "state", **common)
    assert np.array_equal(first.data, whole.data[:38])
    assert np.array_equal(rest.data, whole.data[37:])
    assert np.array_equal(rest.time, whole.time[37:])
    again = run(t5(), **parts(rest.manifest["settings"])[0])
    assert np.array_equal(again.data, rest.data)


def test_a_run_that_is_interrupted_can_be_resumed(tmp_path):
    def interrupt(fraction):
        if fraction > 0.3:
            raise KeyboardInterrupt

    whole = run(t5(), stop_time=200, step=0.01)
    state = tmp_path / "state"
    with pytest.raises(RunInterrupted) as error:
        run(t5(), stop_time=200, step=0.01, hooks=[adcs.checkpoint(state, every=0.5)], progress=interrupt)
    reached = len(error.value.result.time)
    rest = run(t5(), stop_time=200, step=0.01, resume=state)
    assert np.array_equal(error.value.result.data, whole.data[:reached])
    assert rest.time[0] <= error.value.result.time[-1]
    assert np.array_equal(rest.data, whole.data[-len(rest.time) :])


def test_a_run_that_met_its_condition_is_resumed_after_it(tmp_path):
    state = tmp_path / "state"
    ended = run(
        t5(), stop_time=5.0, step=0.01, hooks=[adcs.until("plant.kinetic_energy > 0.1"), adcs.checkpoint(state)]
    )
    whole = run(t5(), stop_time=5.0, step=0.01)
    rest = run(t5(), stop_time=5.0, step=0.01, resume=state)
    assert 0 < ended.time[-1] < 5.0
    assert np.array_equal(np.vstack([ended.data, rest.data]), whole.data)


def test_slow_components_are_saved_where_they_communicate(tmp_path):
    def build():
        system = t5()
        system.components["tracker"].every = 4
        return system

    state = tmp_path / "state"
    whole = run(build(), stop_time=1.0, step=0.01)
    run(build(), stop_time=0.36, step=0.01, hooks=[adcs.checkpoint(state)])
    assert np.array_equal(run(build(), stop_time=1.0, step=0.01, resume=state).data, whole.data[36:])


def test_decimation_keeps_its_rows(tmp_path):
    whole = run(t5(), stop_time=1.0, step=0.01, save=Save(every=7))
    run(t5(), stop_time=0.3, step=0.01, hooks=[adcs.checkpoint(tmp_path / "state")])
    rest = run(t5(), stop_time=1.0, step=0.01, save=Save(every=7), resume=tmp_path / "state")
    assert np.array_equal(rest.data, whole.data[5:])  # 0.35 s is the first after 0.3 s
    assert np.array_equal(rest.time, whole.time[5:])


def test_a_solved_loop_is_resumed_alike(tmp_path):
    def build():
        system = System("loop")
        system.add("plant", "RigidBody", {"torque_disturbance_B": [0.1, 0.0, 0.0]})
        start = {"q_RN": [1.0, 0, 0, 0], "omega_RN_R": [0.0, 0, 0], "omegaDot_RN_R": [0.0, 0, 0]}
        system.add("controller", "PdTracking", start)
        system.connect("plant.q_BN", "controller.q_BN")
        system.connect("controller.torque_B", "controller.omega_BN_B", factor=0.3, offset=0.0)
        system.connect("controller.torque_B", "plant.torque_B")
        return system

    common = {"step": 0.1, "method": CoSimulation(loops=LoopSolver())}
    whole = run(build(), stop_time=4, **common)
    run(build(), stop_time=2, hooks=[adcs.checkpoint(tmp_path / "state")], **common)
    assert np.array_equal(run(build(), stop_time=4, resume=tmp_path / "state", **common).data, whole.data[20:])


def test_refused(tmp_path, chain):
    state = tmp_path / "state"
    run(t5(), stop_time=1.0, step=0.01, hooks=[adcs.checkpoint(state)])

    def refused(system, message, **settings):
        with pytest.raises(AdcsError) as error:
            run(system, **{"stop_time": 2.0, "step": 0.01, **settings})
        assert message in str(error.value)

    refused(t5(), f"{state} is of another run: step is 0.01 there, 0.02 here", step=0.02, resume=state)
    refused(
        t5(),
        "the recorded variables are not the same, guidance.angle there is plant.q_BN here",
        save=Save(["plant.q_BN"]),
        resume=state,
    )
    refused(t5(), "the FMUs are not the same, guidance is the first that differs", fmi_version="3.0", resume=state)
    refused(
        SYSTEMS["full-state-pd"].build(), "the FMUs are not the same, observer is the first that differs", resume=state
    )
    refused(t5(), f"{state} is at t = 1 s, after stop_time = 0.5 s", stop_time=0.5, resume=state)
    refused(t5(), "cannot open", resume=tmp_path / "nothing")
    other = t5()
    other.set("controller.k_p", 9.0)
    refused(other, "the start values of controller are not the same, k_p is the first that differs", resume=state)
    refused(t5(), "the change of controller.k_p at 0.5 s lies before the checkpoint, 1 s", resume=state,
            hooks=[adcs.at(0.5, {"controller.k_p": 2.0})])  # fmt: skip
    refused(t5(), "checkpoint: every = 0 s: expected a positive time", hooks=[adcs.checkpoint(state, every=0)])
    (tmp_path / "text").write_text("no checkpoint")
    refused(t5(), "is not a checkpoint of this program", resume=tmp_path / "text")
    state.write_bytes(state.read_bytes()[:1000])
    refused(t5(), "is not a checkpoint of this program", resume=state)
    refused(t5(), "state: a file that is no checkpoint is there: give another name", hooks=[adcs.checkpoint(state)])
    state = tmp_path / "another"
    refused(chain(), "cannot save its state to a file", hooks=[adcs.checkpoint(state)])
    slow = t5()
    slow.components["tracker"].every = 3
    message = "no checkpoint at t = 2 s: tracker communicates at every 3 steps, and not then"
    refused(slow, message, hooks=[adcs.checkpoint(state)])
    both = [adcs.checkpoint(state), adcs.until("plant.kinetic_energy > 0.1")]
    refused(slow, "checkpoint: not together with until", hooks=both)
    wrong = " s, is not a whole number of exchange steps of 0.01 s: use "
    refused(t5(), f"checkpoint: every, 0.015{wrong}0.01 or 0.02 s", hooks=[adcs.checkpoint(state, every=0.015)])
    refused(t5(), f"checkpoint: every, 0.005{wrong}0.01 s", hooks=[adcs.checkpoint(state, every=0.005)])

"""Which method is taken where none is asked for, and that Model Exchange can do what co-simulation can."""

import numpy as np
import pytest

import adcs
from adcs import AdcsError, CoSimulation, Hook, ModelExchange, Save, System, run, systems
from adcs.cli import words

ONE = ("model-exchange", "all components are continuous")


def chosen(system, **asked):
    return tuple(run(system, stop_time=0.1, **asked).manifest["chosen"].values())


def observer_pd(**start) -> System:
    system = systems()["observer-pd"].build()
    for name, value in start.items():
        system.set(name.replace("__", "."), value)
    return system


def test_a_continuous_system_is_one_differential_equation():
    assert chosen("observer-pd") == chosen(observer_pd()) == ONE
    assert chosen("observer-pd", save=Save(rows="20ms")) == ONE
    assert chosen("observer-pd", hooks=[adcs.until("time > 0.05")]) == ONE


@pytest.mark.parametrize(
    ("how", "because"),
    [
        (lambda: {"system": "observer-pd", "step": "10ms"}, "an exchange step is asked for"),
        (lambda: {"system": "observer-pd", "hooks": [adcs.pace(1000)]}, "it keeps to the clock"),
        (lambda: {"system": observer_pd(tracker__half_angle=0.01)}, "tracker is sampled"),
        (lambda: {"system": "trigo-bs"}, "guidance is sampled"),
        (lambda: {"system": delayed()}, "the connection to controller.torque_B is delayed"),
        (lambda: {"system": slower()}, "controller communicates at every 2 steps"),
    ],
)
def test_what_makes_it_a_co_simulation(how, because):
    if "delayed" in because:
        because = "the connection to plant.torque_B is delayed"
    assert chosen(**how()) == ("co-simulation", because)


def delayed() -> System:
    system = systems()["observer-pd"].make()
    system.times = systems()["observer-pd"].build().times
    system.delay("plant.torque_B", steps=1)
    return system


def slower() -> System:
    system = observer_pd()
    words.every(system, "controller=2")
    return system


def test_what_is_from_elsewhere_is_co_simulated(mock):
    system = System("alone", stop_time=1, step=0.5)
    system.add("c", mock("oscillator"), {"u": 0.0})
    assert chosen(system) == ("co-simulation", "c is of another tool")


def test_nothing_is_chosen_where_a_method_is_given():
    for method in (CoSimulation(), ModelExchange()):
        manifest = run("observer-pd", stop_time=0.1, method=method).manifest
        assert "chosen" not in manifest
        assert manifest["settings"]["method"] == method.kind


def test_rows_are_as_far_apart_as_asked_for():
    exact = run("observer-pd", stop_time=1, save=Save(rows="50ms"))
    exchanged = run("observer-pd", stop_time=1, step="10ms", save=Save(rows="50ms"))
    assert exact.time == pytest.approx(np.arange(21) * 0.05)
    assert np.array_equal(exchanged.time, run("observer-pd", stop_time=1, step="10ms").time[::5])
    assert exact.manifest["settings"]["step"] == 0.05
    assert exchanged.manifest["settings"]["record_every"] == 5
    with pytest.raises(AdcsError, match=r"^Save: every and rows say both how far rows are apart: leave one out$"):
        Save(every=2, rows=1)


@pytest.mark.parametrize("way", ["whole", "in pieces", "isolated", "fmi 3"])
def test_the_bits_do_not_depend_on_how_it_is_run(way):
    class Pieces(Hook):
        def ahead(self, k):
            return 1 + k % 3

    how = {
        "whole": {},
        "in pieces": {"hooks": [Pieces()]},
        "isolated": {"isolated": True},
        "fmi 3": {"fmi_version": "3.0"},
    }
    assert np.array_equal(run("observer-pd", stop_time=3, **how[way]).data, run("observer-pd", stop_time=3).data)


@pytest.mark.parametrize("name", ["observer-pd", "six-dof-saturated", "velocity-free-tracking-uncertain"])
@pytest.mark.parametrize("at", [0.05, 0.4, 0.73])
def test_saved_and_gone_on_with_to_the_last_bit(name, at, tmp_path):
    step = systems()[name].step
    end = round(at / step) * step
    method = {} if name != "velocity-free-tracking-uncertain" else {"method": ModelExchange()}
    whole = run(name, stop_time=1, **method)
    part = run(name, stop_time=end, hooks=[adcs.checkpoint(tmp_path / "state")], **method)
    rest = run(name, stop_time=1, resume=tmp_path / "state", **method)
    assert rest.manifest["settings"]["method"] == "model-exchange"
    k = len(part.time) - 1
    assert part.data == pytest.approx(whole.data[: k + 1], rel=1e-8, abs=1e-8)  # its last step is shorter
    assert np.array_equal(rest.data, whole.data[k:])


def test_a_checkpoint_knows_its_method(tmp_path):
    state = tmp_path / "state"
    run("observer-pd", stop_time=0.1, method=ModelExchange(rtol=1e-9), hooks=[adcs.checkpoint(state)])
    again = run("observer-pd", stop_time=0.2, resume=state)
    assert again.manifest["chosen"] == {"method": "model-exchange", "because": "the checkpoint is of it"}
    assert again.manifest["settings"]["rtol"] == 1e-9
    with pytest.raises(
        AdcsError, match=r"state is of another run: method is \{'method': 'model-exchange', .* None here"
    ):
        run("observer-pd", stop_time=0.2, resume=state, method=CoSimulation())
    with pytest.raises(AdcsError, match=r"^checkpoint: not together with CVode, whose memory of its steps it does not"):
        run("observer-pd", stop_time=0.1, method=ModelExchange("CVode"), hooks=[adcs.checkpoint(state)])


def test_changes_are_made_at_their_time_whatever_the_steps():
    """Up to there the run is the one without; and the one from there on, in a run of its own."""
    plain = run("observer-pd", stop_time=2)
    changed = run("observer-pd", stop_time=2, hooks=[adcs.at("1s", {"controller.k_p": 7.0})])
    k = int(np.searchsorted(plain.time, 1.0))
    assert plain.manifest["integrator"]["longest [s]"] > 5 * 0.01
    assert changed.data[:k] == pytest.approx(plain.data[:k], rel=1e-11, abs=1e-11)
    assert changed["plant.q_BN"][k] == pytest.approx(plain["plant.q_BN"][k], rel=1e-11)
    assert changed["controller.torque_B"][k] != pytest.approx(plain["controller.torque_B"][k], rel=1e-3)
    by_steps = run(
        "observer-pd", stop_time=2, method=ModelExchange(max_step="10ms"), hooks=[adcs.at(1, {"controller.k_p": 7.0})]
    )
    assert changed.data == pytest.approx(by_steps.data, rel=1e-9, abs=1e-9)

"""Changes that would end a run are refused, the run is only looked at, and trials have a share of its time."""

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

import adcs
from adcs import AdcsError, RunFailed, Session, run
from adcs.catalogue import SYSTEMS
from hil_bridge.ground import attach
from hil_bridge.ground.forecast import Forecast
from hil_bridge.ground.security import Bucket

from .test_run import flown

ENTRY = SYSTEMS["observer-pd"]


@pytest.fixture
def simulation():
    with Session(ENTRY.build(), step=0.01, steps=3000) as found:
        for _ in range(100):
            found.propagate()
            found.move_on()
        yield found


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_gain_that_would_end_the_run_is_refused_and_the_run_is_not_touched(version):
    with Session(ENTRY.build(), step=0.01, steps=3000, fmi_version=version) as simulation:
        for _ in range(100):
            simulation.propagate()
            simulation.move_on()
        forecast = Forecast(simulation)
        assert forecast.possible
        for _ in range(2):  # the copy is of no use after a failure, and made anew
            refused = forecast.refused([("controller.k_v", 5000.0)])
            assert refused is not None and "at t = 1.0" in refused, refused
        assert forecast.refused([("controller.k_v", 6.5)]) is None
        forecast.close()
        for _ in range(400):
            simulation.propagate()
            simulation.move_on()
        simulation.propagate()
        row = simulation.row.copy()
    plain = run(ENTRY.build(), stop_time=30.0, step=0.01, fmi_version=version)
    assert np.array_equal(row, plain.data[500])


def test_the_forecast_is_what_happens():
    """The time at which the run is said to end is the time at which it does."""
    with Session(ENTRY.build(), step=0.01, steps=3000) as simulation:
        for _ in range(100):
            simulation.propagate()
            simulation.move_on()
        refused = Forecast(simulation).refused([("controller.k_v", 5000.0)])
    with pytest.raises(RunFailed) as failed:
        run(ENTRY.build(), stop_time=30.0, step=0.01, hooks=[adcs.at(1.0, {"controller.k_v": 5000.0})])
    assert str(failed.value).startswith(str(refused))


def test_what_grows_beyond_float32_is_an_end(simulation):
    refused = Forecast(simulation).refused([("controller.k_v", 2000.0)])
    assert refused is not None and "grows beyond 3.4e+38 by t = " in refused


def test_nothing_is_foreseen_where_states_cannot_be_told(simulation, monkeypatch):
    monkeypatch.setattr(type(simulation.instances["plant"]), "can_serialize", False)
    forecast = Forecast(simulation)
    assert not forecast.possible
    assert forecast.refused([("controller.k_v", 5000.0)]) is None


def test_no_ground_station_ends_the_run_by_a_gain_that_diverges():
    said = {}

    def work(pilot):
        said["wild"] = pilot.parameter("CTRL_K_V", 5000.0)
        said["tame"] = pilot.parameter("CTRL_K_V", 6.5)
        for rate in (1e38, 1e30, 1e6, float("inf"), float("nan")):
            message = mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 0, [1, 0, 0, 0], rate, rate, rate, 0)
            for _ in range(5):
                pilot.send(message)

    result, pilot, _ = flown(work, stop_time=20.0, speed=4.0, entry=ENTRY)
    assert result.manifest["outcome"]["status"] == "complete"
    assert said == {"wild": ENTRY.build().components["controller"].start["k_v"][0], "tame": 6.5}
    assert ["controller.k_v", 6.5] in [c[1:3] for c in result.manifest["commands"]]
    texts = "".join(m.text for m in pilot.station.heard if m.get_type() == "STATUSTEXT")
    assert "controller.k_v = 5000.0 refused: the run would end with it: " in texts


def test_trials_take_a_share_of_the_time_and_all_else_goes_on():
    bucket = Bucket(attach._SHARE, attach._SHARE)
    spent = sum(0.1 for t in np.arange(0, 60, 0.01) if bucket.take(t, 0.0) and (bucket.spend(0.1) or True))
    assert 12.0 <= spent <= 12.4  # of 60 s, and one trial more


def test_a_run_that_fails_names_the_change_before(monkeypatch):
    """What cannot be foreseen ends the run, and the last words say what came before."""
    monkeypatch.setattr(Forecast, "refused", lambda self, changes: None)
    heard = []

    def work(pilot):
        pilot.parameter("CTRL_K_V", 5000.0)
        heard.append(pilot)

    with pytest.raises((RunFailed, AdcsError)):
        flown(work, stop_time=20.0, speed=10.0, entry=ENTRY)
    texts = "".join(m.text for m in heard[0].station.listen() if m.get_type() == "STATUSTEXT")
    assert "Run failed: " in texts and " failed at t = " in texts and "nan" in texts
    assert "the last change was controller.k_v = 5000.0 at t = " in texts
    last = [m for m in heard[0].station.heard if m.get_type() == "HEARTBEAT"][-1]
    assert last.system_status == mavlink.MAV_STATE_EMERGENCY
    assert not last.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED

"""Every call from Python is noted before it is made, and looked after when it has returned."""

import foreign_fmus
import pytest

from orchestration.fmu.file import extracted, open_fmu
from orchestration.instances.instance import CallFailed, Instance
from orchestration.process.guard import Guard
from orchestration.process.where import ACTIONS, Action, Place, Where


class Log(Where):
    """Writes down what begins and ends."""

    def __init__(self):
        self.lines = []
        log = self

        class Noting(Place):
            """Sees the last thing that is written when a call begins or ends."""

            def __setattr__(self, name, value):
                super().__setattr__(name, value)
                if name == "doing":
                    log.lines.append(log.now[2] or "idle")

        super().__init__(Noting())


class Looking(Guard):
    def __init__(self, log):
        super().__init__()
        self.log = log

    def thread(self, component):
        self.log.lines.append(f"looked at {component}")


@pytest.mark.parametrize(
    ("model", "version", "changes", "calls"),
    [
        ("picky", "2.0", {}, ["saving the state", "doStep"]),  # through Stepper
        ("picky", "2.0", {"canGetAndSetFMUstate": None}, ["doStep"]),
        ("picky", "3.0", {}, ["doStep"]),
        ("short", "3.0", {}, ["doStep", "doStep", "doStep"]),  # of 0.04 s at most
    ],
)
def test_a_step(tmp_path, model, version, changes, calls):
    log = Log()
    guard = Looking(log)
    fmu = open_fmu(foreign_fmus.build(model, tmp_path, version, **changes))
    with extracted(fmu, "co-simulation") as places:
        instance = Instance("c", fmu, "co-simulation", *places, log, guard)
        instance.enter_initialization(0.0, 10.0)
        instance.exit_initialization()
        log.lines.clear()
        instance.do_step(0.0, 0.03 if model == "picky" else 0.09)
        lines = list(log.lines)
        log.lines.clear()
        instance.close(healthy=True)
    guard.close()
    assert lines == [line for action in calls for line in (action, "idle", "looked at c")]
    assert [line for line in log.lines if line != "idle" and "looked" not in line][-2:] == ["terminating", "freeing"]
    assert log.lines.count("idle") == log.lines.count("looked at c") - 1  # the process is looked at once more


def test_a_call_that_fails_has_ended(tmp_path):
    log = Log()
    fmu = open_fmu(foreign_fmus.build("counter", tmp_path, "3.0"))
    with extracted(fmu, "co-simulation") as places:
        instance = Instance("c", fmu, "co-simulation", *places, log)
        with pytest.raises(CallFailed, match="fmi3EnterEventMode"):
            instance.call("entering event mode", "enterEventMode")
        assert log.lines[-2:] == ["entering event mode", "idle"]
        assert log.now == (0, "", "")
        instance.close(healthy=False)


def test_the_names_of_the_calls_of_the_engine_stand_in_one_list():
    assert [action.text for action in ACTIONS[:4]] == ["get", "set", "solving an algebraic loop", "doStep"]
    assert [int(action) for action in ACTIONS] == list(range(len(ACTIONS)))
    for action in ACTIONS:
        where = Where(Place(doing=action, component=1, k=7), ["a", "b"])
        assert where.now == (7, "" if action is Action.SOLVE else "b", action.text)
    assert Where(Place(doing=len(ACTIONS))).now == (0, "", "")

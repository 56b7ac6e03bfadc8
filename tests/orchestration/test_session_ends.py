"""A session after its end, and after its `with`: refused, where components that are gone would be called."""

import pytest

from adcs import AdcsError, Save, Session, run, systems

CLOSED = r"^the session is closed, and its components with it: use it within its `with`$"


def test_a_closed_session_does_nothing_more():
    with Session("observer-pd", step=0.01) as session:
        session.propagate()
        session.move_on()
        before = session.save()
    for work in (
        session.move_on,
        session.propagate,
        session.save,
        lambda: session.set("controller.k_p", 3.0),
        lambda: session.restore(before),
        lambda: next(iter(session)),
    ):
        with pytest.raises(AdcsError, match=CLOSED):
            work()


def test_there_is_no_step_beyond_the_last_point():
    with Session("observer-pd", step=0.01, steps=1) as session:
        session.move_on()
        with pytest.raises(AdcsError, match=r"^the session is at its last point, t = 0\.01 s: there is no step from"):
            session.move_on()


@pytest.mark.parametrize("stop", [1.0, "1s", 0.995])
def test_a_stop_time_alone_says_how_many_steps(stop):
    with Session("observer-pd", step="10ms", stop_time=stop, record=["plant.q_BN"]) as session:
        values = [values["plant.q_BN"].copy() for _, values in session]
    expected = run("observer-pd", step=0.01, stop_time=stop)["plant.q_BN"]
    assert [v.tolist() for v in values] == expected.tolist()


def test_numbers_beyond_what_is_counted_are_refused():
    system = systems()["observer-pd"].build()
    for every in (2**53 + 1, 2**64 + 2):
        with pytest.raises(AdcsError, match=r"expected a whole number of steps from 1 to 2\^53$"):
            Save(every=every)
        system.components["controller"].every = every
        with pytest.raises(AdcsError, match=r"^component .controller.: every = \d+: expected a whole number of"):
            run(system, stop_time=1, step=0.1)
    system = systems()["observer-pd"].build()
    system.delay("plant.torque_B", steps=2**63)
    with pytest.raises(AdcsError, match=r"^a delay by 9223372036854775808 steps does not fit into memory"):
        run(system, stop_time=1, step=0.1)


def test_a_result_in_a_file_does_not_show_the_values_of_another_run(tmp_path):
    file = tmp_path / "rows.h5"
    first = run("observer-pd", stop_time=1, step=0.1, save=Save(to=file))
    assert first["plant.q_BN"].shape == (11, 4)
    second = run("full-state-pd", stop_time=1, step=0.1, save=Save(to=file))
    assert second["plant.q_BN"].shape == (11, 4)
    with pytest.raises(AdcsError, match=r"rows\.h5 is not the file any more that this result is in: give each run its"):
        first["plant.q_BN"]


def test_no_file_of_another_kind_is_replaced(tmp_path):
    from adcs import checkpoint

    program = tmp_path / "program.py"
    program.write_text("mine")
    with pytest.raises(AdcsError, match=r"program\.py: a file that is not HDF5 is there: give another name$"):
        run("observer-pd", stop_time=1, save=Save(to=program))
    with pytest.raises(AdcsError, match=r"program\.py: a file that is no checkpoint is there: give another name$"):
        run("observer-pd", stop_time=1, hooks=[checkpoint(program)])
    assert program.read_text() == "mine"
    for _ in range(2):  # its own kind it does
        run("observer-pd", stop_time=1, save=Save(to=tmp_path / "r.h5"), hooks=[checkpoint(tmp_path / "c.npz")])

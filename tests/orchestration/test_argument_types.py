"""Arguments of a wrong type: one line that names the argument and the way out, by every door."""

import numpy as np
import pytest

from adcs import (
    AdcsError,
    CoupledModel,
    LoopSolver,
    Session,
    System,
    build,
    check,
    estimate_error,
    linearize,
    read_ssp,
    run,
    steps,
    write_ssp,
)

TIMES = {"stop_time": 1.0, "step": 0.1}
WRONG = [
    ({"record": "gain.y"}, "record = 'gain.y': expected a list, ['gain.y']"),
    ({"record": [1]}, "record: 1 is no text: expected a list of texts"),
    ({"record": iter(["gain.y"])}, "expected a list"),
    ({"step": "0.1"}, "step = '0.1': expected a number, 0.1 without quotes"),
    ({"step": [0.1]}, "step = [0.1]: expected a number"),
    ({"step": True}, "step = True: expected a number"),
    ({"start_time": 1j}, "start_time = 1j: expected a number"),
    ({"stop_time": "ten"}, "stop_time = 'ten': expected a number"),
    ({"stop_time": 10**400}, "stop_time is beyond the range of numbers: expected one below 1e308"),
]
OF_RUN = [
    ({"step": None}, "step: chain has none of its own, give it"),
    ({"stop_time": None}, "stop_time: chain has none of its own, give it"),
    (
        {"solve_loops": "newton"},
        "solve_loops = 'newton': expected a LoopSolver, as adcs.LoopSolver(\"newton\")",
    ),
    ({"solve_loops": {"methd": "newton"}}, "solve_loops: 'methd' is unknown: use method, tolerance, max_iterations"),
    ({"rtol": "1e-8"}, "rtol = '1e-8': expected a number, 1e-8 without quotes"),
    ({"timeout": "1"}, "timeout = '1': expected a number, 1 without quotes"),
    ({"until": 3.0}, "until = 3.0: expected a text"),
    ({"hdf5": 3}, "hdf5 = 3: expected the name of a file"),
    ({"inputs": {"gain.u": 1}}, "inputs = {'gain.u': 1}: expected the name of a file"),
    ({"changes": (0.5, "gain.k", 2.0)}, "changes: 0.5 is no change: expected (time, name, value)"),
    ({"changes": {"gain.k": 2.0}}, "changes = {'gain.k': 2.0}: expected a list"),
    ({"changes": [("0.5", "gain.k", 2.0)]}, "changes: time = '0.5': expected a number, 0.5 without quotes"),
    ({"changes": [("gain.k", 0.5, 2.0)]}, "changes: name = 0.5: expected a text"),
    ({"watchers": print}, "expected a list"),
    ({"watchers": [1]}, "watchers = 1: expected hooks, as adcs.Hook describes them"),
    ({"progress": "bar"}, "progress = 'bar': expected what can be called"),
    ({"real_time": "1"}, "real_time = '1': expected a number, 1 without quotes"),
    ({"adaptive": "1e-6"}, "adaptive = '1e-6': expected a number, 1e-6 without quotes"),
]
OF_SESSION = [
    ({"step": None}, "step: chain has none of its own, give it"),
    ({"solver": "newton"}, "solver = 'newton': expected a LoopSolver, as adcs.LoopSolver(\"newton\")"),
    ({"solver": {"method": "newton"}}, 'expected a LoopSolver, as adcs.LoopSolver("newton")'),
    ({"external": "gain.u"}, "external = 'gain.u': expected a list, ['gain.u']"),
    ({"steps": 2.5}, "steps = 2.5: expected a whole number of steps from 0"),
    ({"record_every": "2"}, "record_every = '2': expected a whole number of steps from 1"),
    ({"stepping": "fast"}, "stepping = 'fast' is unknown: use 'compiled' or 'python'"),
    ({"fmi_version": 2.0}, "fmi_version = 2.0 is unknown: use '2.0' or '3.0'"),
]


def refusal(action) -> str:
    with pytest.raises(AdcsError) as error:
        action()
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(("wrong", "said"), WRONG + OF_RUN, ids=lambda value: str(value)[:40])
@pytest.mark.parametrize("method", ["co-simulation", "model-exchange"])
def test_run(chain, method, wrong, said):
    assert refusal(lambda: run(chain(), **TIMES | wrong, method=method)).endswith(said)


@pytest.mark.parametrize(("wrong", "said"), WRONG, ids=lambda value: str(value)[:40])
def test_steps(chain, wrong, said):
    assert refusal(lambda: next(steps(chain(), **TIMES | wrong))).endswith(said)


@pytest.mark.parametrize(("wrong", "said"), WRONG + OF_SESSION, ids=lambda value: str(value)[:40])
def test_session(chain, wrong, said):
    assert refusal(lambda: Session(chain(), **{"step": 0.1} | wrong)).endswith(said)


def test_what_is_no_system():
    said = 'system = 3: expected a System, as adcs.System("name") or adcs.systems()[name].build() gives it'
    assert refusal(lambda: Session(3, step=0.1)) == said
    assert refusal(lambda: run(3, **TIMES)) == said
    assert refusal(lambda: next(steps(3, **TIMES))) == said


def test_numbers_of_numpy_are_numbers(chain):
    expected = run(chain(), stop_time=1.0, step=0.5)
    assert run(chain(), stop_time=np.int64(1), step=np.float32(0.5), start_time=np.array(0.0)) == expected
    assert run(chain(), stop_time=1, step=0.5, record=("source.y",)) == expected.select(["source.y"])
    assert run(chain(), stop_time=1, step=0.5, solve_loops={"method": "newton"}) == expected


@pytest.mark.parametrize("name", ["inputs", "outputs", "open_at"])
def test_linearize(chain, name):
    assert refusal(lambda: linearize(chain(), **{name: "gain.u"})) == f"{name} = 'gain.u': expected a list, ['gain.u']"
    assert refusal(lambda: linearize(chain(), "1")) == "time = '1': expected a number, 1 without quotes"


def test_a_loop_solver():
    assert refusal(lambda: LoopSolver(tolerance="1e-8")).startswith("loop tolerance = '1e-8': expected a number")
    assert refusal(lambda: LoopSolver(max_iterations=2.5)) == (
        "loop max_iterations = 2.5: expected a whole number from 1"
    )
    assert refusal(lambda: LoopSolver(max_iterations=0)).endswith("expected a whole number from 1")


def test_a_system(chain, mock):
    system = chain()
    assert refusal(lambda: System(3)) == "name = 3: expected a text"
    assert refusal(lambda: system.add(3, mock("gain"))) == "name = 3: expected a text"
    assert refusal(lambda: system.add("g", 3)) == "component 'g': fmu = 3: expected the name of a file"
    assert refusal(lambda: system.add("g", mock("gain"), [("k", 2.0)])) == (
        "component 'g': start = [('k', 2.0)]: expected a dict, {name: value}"
    )
    assert refusal(lambda: system.add("g", mock("gain"), {1: 2.0})) == (
        "component 'g': start: 1 is no text: expected a list of texts"
    )
    for action in (
        lambda: system.connect(1, "gain.u"),
        lambda: system.connect("source.y", 1),
        lambda: system.disconnect(1),
        lambda: system.set(1, 2.0),
        lambda: system.port(1),
    ):
        assert refusal(action) == "1 names no variable: give a text as 'component.variable'"


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"factor": "2"}, "factor = '2': expected a number, 2 without quotes"),
        ({"offset": [1.0]}, "offset = [1.0]: expected a number"),
        ({"delay": "0.1"}, "delay = '0.1': expected a number, 0.1 without quotes"),
        ({"delay": None}, "delay = None: expected a number"),
        ({"delay_steps": "1"}, "delay_steps = 1, delay = 0.0 s: expected a whole number, a time"),
        ({"mapping": 3}, "mapping = 3: expected pairs of numbers, (from, to)"),
        ({"mapping": {0: 1}}, "mapping = {0: 1}: expected pairs of numbers, (from, to)"),
    ],
    ids=str,
)
def test_a_connection(chain, wrong, said):
    system = chain()
    system.disconnect("gain.u")
    assert refusal(lambda: system.connect("source.y", "gain.u", **wrong)) == (
        f"cannot connect source.y to gain.u: {said}"
    )


def test_a_mapping_may_be_an_array(mock):
    system = System("mapped")
    system.add("typed", mock("typed"))
    system.add("oscillator", mock("oscillator"))
    system.connect("typed.whole", "oscillator.u", mapping=np.array([[0, 2.5], [4, -1.0]]))
    assert system.connections[0].mapping == ((0.0, 2.5), (4.0, -1.0))


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: write_ssp(7, "x.ssp"), "system = 7: expected a System"),
        (lambda: write_ssp(System("x"), 3), "path = 3: expected the name of a file"),
        (lambda: read_ssp(3), "path = 3: expected the name of a file"),
        (lambda: check(["x.fmu"]), "path = ['x.fmu']: expected the name of a file"),
        (lambda: build("RigidBody"), "names = 'RigidBody': expected a list, ['RigidBody']"),
        (lambda: CoupledModel(["observer-pd"]), "system = ['observer-pd']: expected a System"),
        (lambda: Session(None, step=0.1), "system = None: expected a System"),
        (lambda: estimate_error(3, run), "result = 3: expected a Result"),
    ],
)
def test_what_else_is_called(call, said):
    assert refusal(call).startswith(said)

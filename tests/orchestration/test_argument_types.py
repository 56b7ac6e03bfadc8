"""Arguments of a wrong type: one line that names the argument and the way out, by every door."""

import numpy as np
import pytest

import adcs
from adcs import (
    AdcsError,
    CoSimulation,
    CoupledModel,
    LoopSolver,
    ModelExchange,
    Save,
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
    ({"step": "0.1"}, "step = '0.1': expected a number, 0.1 without quotes"),
    ({"step": [0.1]}, "step = [0.1]: expected a number"),
    ({"step": True}, "step = True: expected a number"),
    ({"start_time": 1j}, "start_time = 1j: expected a number"),
    ({"stop_time": "ten"}, "stop_time: 'ten' is not a time, write 120s, 0.1s, 5ms, 2min or 1h"),
    ({"stop_time": 10**400}, "stop_time is beyond the range of numbers: expected one below 1e308"),
]
RECORD = [
    ({"record": "gain.y"}, "record = 'gain.y': expected a list, ['gain.y']"),
    ({"record": [1]}, "record: 1 is no text: expected a list of texts"),
    ({"record": iter(["gain.y"])}, "expected a list"),
]
METHODS = 'expected adcs.CoSimulation() or adcs.ModelExchange("DOP853")'
OF_RUN = [
    ({"step": None}, "step: chain has none of its own, give it"),
    ({"stop_time": None}, "stop_time: chain has none of its own, give it"),
    ({"method": ModelExchange}, METHODS),
    ({"method": None}, f"method = None: {METHODS}"),
    ({"save": ["gain.y"]}, "save = ['gain.y']: expected adcs.Save([\"plant.q_BN\"])"),
    ({"hooks": print}, "expected a list"),
    ({"hooks": [1]}, "hooks = 1: expected hooks, as adcs.until(...), or what adcs.Hook describes"),
    ({"hooks": adcs.until("time > 1")}, "expected a list"),
    ({"progress": "bar"}, "progress = 'bar': expected what can be called"),
]
PARTS = [
    (lambda: Save("gain.y"), "Save: names = 'gain.y': expected a list, ['gain.y']"),
    (lambda: Save([1]), "Save: names: 1 is no text: expected a list of texts"),
    (lambda: Save(iter(["gain.y"])), "expected a list"),
    (lambda: Save(every="2"), "Save: every = '2': expected a whole number of steps from 1"),
    (lambda: Save(every=0), "Save: every = 0: expected a whole number of steps from 1"),
    (lambda: Save(to=3), "Save: to = 3: expected the name of a file"),
    (lambda: CoSimulation(loops="euler"), "loop method 'euler' is unknown: use 'newton' or 'fixed-point'"),
    (lambda: CoSimulation(loops=3), "loops = 3: expected 'newton' or 'fixed-point', or adcs.LoopSolver(...)"),
    (lambda: CoSimulation(stepping="fast"), "stepping = 'fast' is unknown: use 'compiled' or 'python'"),
    (lambda: CoSimulation(timeout="1"), "timeout = '1': expected a number, 1 without quotes"),
    (lambda: CoSimulation(timeout=0), "timeout = 0.0: expected a positive number"),
    (lambda: CoSimulation(adaptive="1e-6"), "adaptive = '1e-6': expected a number, 1e-6 without quotes"),
    (lambda: ModelExchange("Euler"), "solver = 'Euler' is unknown: use 'DOP853' or 'CVode'"),
    (lambda: ModelExchange(rtol="1e-8"), "rtol = '1e-8': expected a number, 1e-8 without quotes"),
    (lambda: adcs.until(3.0), "until = 3.0: expected a text"),
    (lambda: adcs.inputs({"gain.u": 1}), "inputs = {'gain.u': 1}: expected the name of a file"),
    (
        lambda: adcs.at("0.5", {"gain.k": 2.0}),
        "at: time = '0.5': expected a number, 0.5 without quotes",
    ),
    (lambda: adcs.at(0.5, ("gain.k", 2.0)), "at: values = ('gain.k', 2.0): expected a dict, {name: value}"),
    (lambda: adcs.at(0.5, {1: 2.0}), "at: values: 1 is no text: expected a list of texts"),
    (lambda: adcs.pace("1"), "pace: speed = '1': expected a number, 1 without quotes"),
    (lambda: adcs.checkpoint(3), "checkpoint = 3: expected the name of a file"),
    (lambda: adcs.checkpoint("a", every="1"), "checkpoint: every = '1': expected a number, 1 without quotes"),
]
OF_SESSION = [
    ({"step": None}, "step: chain has none of its own, give it"),
    ({"loops": "euler"}, "loop method 'euler' is unknown: use 'newton' or 'fixed-point'"),
    ({"loops": {"method": "newton"}}, "expected 'newton' or 'fixed-point', or adcs.LoopSolver(...)"),
    ({"external": "gain.u"}, "external = 'gain.u': expected a list, ['gain.u']"),
    ({"steps": 2.5}, "steps = 2.5: expected a whole number of steps from 0"),
    ({"record_every": "2"}, "record_every = '2': expected a whole number of steps from 1"),
    ({"stepping": "fast"}, "stepping = 'fast' is unknown: use 'compiled' or 'python'"),
    ({"fmi_version": 2.0}, "fmi_version = 2.0 is unknown: use '2.0' or '3.0'"),
]
UNKNOWN = [
    ({"until": "time > 1"}, "until: run() has no such argument: write hooks=[adcs.until('time > 1')]"),
    ({"record": ["gain.y"]}, "record: run() has no such argument: write save=adcs.Save(['gain.y'])"),
    ({"timeout": 5.0}, "write method=adcs.CoSimulation(timeout=5.0)"),
    ({"changes": [(1, "gain.k", 2)]}, "write hooks=[adcs.at(time, {name: value})]"),
    ({"watchers": []}, "watchers: run() has no such argument: write hooks=[...]"),
    (
        {"rtol": 1e-6, "solver": "CVODE", "record": ["gain.y"], "record_every": 2, "real_time": 1, "until": "time > 1"},
        "rtol, solver, record, record_every, real_time, until: run() has no such arguments: write "
        "method=adcs.ModelExchange('CVODE', rtol=1e-06), save=adcs.Save(['gain.y'], every=2), "
        "hooks=[adcs.pace(1), adcs.until('time > 1')]",
    ),
    ({"method": "model-exchange"}, "method: run() takes no text for a method: write method=adcs.ModelExchange()"),
    (
        {"method": "co-simulation", "timeout": 5},
        "method, timeout: run() takes no text for a method: write method=adcs.CoSimulation(timeout=5)",
    ),
    ({"stop": 1}, "stop: run() has no such argument: did you mean stop_time?"),
    ({"stoptime": 1}, "stoptime: run() has no such argument: did you mean stop_time?"),
    ({"start": 1}, "start: run() has no such argument: did you mean start_time?"),
    ({"fmi": "3"}, "fmi: run() has no such argument: did you mean fmi_version?"),
    ({"loops": "newton"}, "loops: run() has no such argument: write method=adcs.CoSimulation(loops='newton')"),
    ({"to": "x.h5"}, "to: run() has no such argument: write save=adcs.Save(to='x.h5')"),
    ({"set": {}}, "set: run() has no such argument: write system.set(name, value) before"),
    ({"delay": 1}, "delay: run() has no such argument: write system.delay(target, seconds=...) before"),
    (
        {"out": "x"},
        "out: run() has no such argument: write result.write_csv(path) of what it returns, or save=adcs.Save(to=path) "
        "for HDF5",
    ),
    (
        {"xyzzy": 1},
        "xyzzy: run() has no such argument: it has system, stop_time, step, start_time, method, save and 5 more",
    ),
]


def refusal(action) -> str:
    with pytest.raises(AdcsError) as error:
        action()
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(("wrong", "said"), WRONG + OF_RUN, ids=lambda value: str(value)[:40])
def test_run(chain, wrong, said):
    assert refusal(lambda: run(chain(), **TIMES | wrong)).endswith(said)


@pytest.mark.parametrize(("made", "said"), PARTS, ids=[said[:40] for _, said in PARTS])
def test_parts_of_a_run(made, said):
    assert refusal(made).endswith(said)


@pytest.mark.parametrize(("unknown", "said"), UNKNOWN, ids=lambda value: str(value)[:40])
def test_arguments_that_run_does_not_have_are_told_what_stands_for_them(chain, unknown, said):
    assert refusal(lambda: run(chain(), **TIMES | unknown)).endswith(said)


@pytest.mark.parametrize(
    ("unknown", "said"),
    [
        ({"rtol": 1e-8}, "rtol: linearize() has no such argument: write method=adcs.ModelExchange(rtol=1e-08)"),
        ({"loops": "newton"}, "write method=adcs.ModelExchange(loops='newton')"),
        ({"at": 5}, "at: linearize() has no such argument: write time=5"),
        ({"minimal": True}, "minimal: linearize() has no such argument: did you mean minimal_coordinates?"),
    ],
)
def test_linearize_is_told_as_well(chain, unknown, said):
    assert refusal(lambda: linearize(chain(), **unknown)).endswith(said)


def test_steps_are_told_as_well(chain):
    said = refusal(lambda: steps(chain(), stop=1))  # type: ignore[call-arg]
    assert said == "stop: steps() has no such argument: did you mean stop_time?"
    said = refusal(lambda: steps(chain(), save=["gain.y"]))  # type: ignore[call-arg]
    assert said == "save: steps() has no such argument: write record=['gain.y']"


@pytest.mark.parametrize(("wrong", "said"), WRONG + RECORD, ids=lambda value: str(value)[:30])
def test_steps(chain, wrong, said):
    assert refusal(lambda: next(steps(chain(), **TIMES | wrong))).endswith(said)


@pytest.mark.parametrize(("wrong", "said"), WRONG + RECORD + OF_SESSION, ids=lambda value: str(value)[:30])
def test_session(chain, wrong, said):
    assert refusal(lambda: Session(chain(), **{"step": 0.1} | wrong)).endswith(said)


def test_times_with_units(chain):
    expected = run(chain(), start_time=0.5, stop_time=1.0, step=0.05)
    assert run(chain(), start_time="500ms", stop_time="1s", step="50ms") == expected
    times, values = zip(*steps(chain(), start_time="500ms", stop_time="1 s", step="5e4us"), strict=True)
    assert list(times) == expected.time.tolist()
    assert np.array_equal([v["gain.y"] for v in values], expected["gain.y"])
    with Session(chain(), step="50ms", start_time="500ms") as session:
        assert (session.step, session.time) == (0.05, 0.5)
    later, same = (
        adcs.run("observer-pd", **TIMES, hooks=[adcs.at(time, {"controller.k_p": 7.0})]) for time in ("500ms", 0.5)
    )
    assert later == same != adcs.run("observer-pd", **TIMES)


def test_what_is_no_system():
    said = 'system = 3: expected a System, as adcs.System("name") or adcs.systems()[name].build() gives it'
    assert refusal(lambda: Session(3, step=0.1)) == said
    assert refusal(lambda: run(3, **TIMES)) == said
    assert refusal(lambda: next(steps(3, **TIMES))) == said


def test_numbers_of_numpy_are_numbers(chain):
    expected = run(chain(), stop_time=1.0, step=0.5)
    assert run(chain(), stop_time=np.int64(1), step=np.float32(0.5), start_time=np.array(0.0)) == expected
    assert run(chain(), stop_time=1, step=0.5, save=Save(("source.y",))) == expected.select(["source.y"])
    assert run(chain(), stop_time=1, step=0.5, method=CoSimulation(loops="newton")) == expected


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
        ({"delay": "10 days"}, "delay: '10 days' is not a time: 'days' is no unit, use us or ms or s or min or h"),
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


def test_a_delay_is_a_time_with_or_without_its_unit(chain):
    delays = []
    for delay in (0.01, "10ms", "0.01s"):
        system = chain()
        system.disconnect("gain.u")
        system.connect("source.y", "gain.u", delay=delay)
        delays.append(system.connections[-1].delay)
        system.delay("gain.u", seconds=delay if isinstance(delay, str) else 0.01)
        delays.append(system.connections[-1].delay)
    assert delays == [0.01] * 6


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("plant.q_BN", "1,0,0,0", "plant.q_BN = '1,0,0,0': expected a list, [1, 0, 0, 0]"),
        ("plant.q_BN", "[1,0,0,0]", "plant.q_BN = '[1,0,0,0]': expected a list, [1, 0, 0, 0]"),
        ("plant.omega_BN_B", "0.05deg", "plant.omega_BN_B = '0.05deg': expected a number, in rad/s"),
        ("tracker.half_angle", "0.05deg", "tracker.half_angle = '0.05deg': expected a number, in rad"),
        ("tracker.half_angle", "0.05", "tracker.half_angle = '0.05': expected a number, in rad, 0.05 without quotes"),
    ],
)
def test_a_start_value_as_a_command_line_has_it(name, value, said):
    system = adcs.systems()["observer-pd"].build()
    assert refusal(lambda: system.set(name, value)) == said


def test_results_and_manifests(chain):
    result = run(chain(), **TIMES)
    assert refusal(lambda: result["time"]) == "'time' is no variable: it is result.time"
    assert refusal(lambda: result.select("gain.y")) == "names = 'gain.y': expected a list, ['gain.y']"
    assert refusal(lambda: adcs.rerun({})) == (
        "manifest: this dict is not that of a run: give result.manifest, or the manifest.json of one"
    )
    assert refusal(lambda: adcs.rerun(result)) == (
        "manifest: give result.manifest of this result, or the manifest.json of a run"
    )


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("simulate", "adcs has no 'simulate'; dir(adcs) shows all"),
        ("Change", "adcs has no 'Change'; dir(adcs) shows all"),
        ("linearise", "adcs has no 'linearise'; did you mean linearize?"),
        ("Sesion", "adcs has no 'Sesion'; did you mean Session?"),
    ],
)
def test_what_adcs_does_not_have(name, said):
    with pytest.raises(AttributeError) as error:
        getattr(adcs, name)
    assert str(error.value) == said


def test_the_beginning_of_a_name(chain):
    said = refusal(lambda: run("observer-pd", stop_time=1, save=adcs.Save(["plant.q"])))
    assert said == "component 'plant' (RigidBody.fmu) has no variable 'q': did you mean q_BN?"

"""Hooks that answer what they should not, or raise: told by their name, with all rows that were recorded."""

import numpy as np
import pytest

from adcs import AdcsError, CoSimulation, Hook, LoopSolver, ModelExchange, RunFailed, Save, at, rerun, run, until

TIMES = {"stop_time": 1, "step": 0.1}
PAIRS = "expected a list of names and values, [(name, value)]"
ROWS = "expected None, or the index of one of 11 rows"
POINTS = "expected a number of points from 1"
ENTRIES = "expected a dict, {name: value}"


def fails(*_):
    raise ZeroDivisionError("division by zero")


def mine(method, answer):
    """A hook with one method of its own, which returns this, or does it."""
    return type("Mine", (Hook,), {method: answer if callable(answer) else lambda *_: answer})()


@pytest.mark.parametrize(
    ("method", "answer", "rows", "said"),
    [
        ("ahead", 0, 0, f"Mine.ahead returned 0: {POINTS}"),
        ("ahead", 2.0, 0, f"Mine.ahead returned 2.0: {POINTS}"),
        ("ahead", fails, 0, "Mine.ahead raised ZeroDivisionError: division by zero"),
        ("changes", 3, 0, f"Mine.changes returned 3: {PAIRS}"),
        ("changes", None, 0, f"Mine.changes returned None: {PAIRS}"),
        ("changes", "ab", 0, f"Mine.changes returned 'ab': {PAIRS}"),
        ("changes", [("a",)], 0, "Mine.changes returned ('a',): expected names and values, (name, value)"),
        ("changes", [("gain.x", 1)], 0, "component 'gain' (gain.fmu) has no variable 'x': it has u, k, y, doubled"),
        ("met", "yes", 11, f"Mine.met returned 'yes': {ROWS}"),
        ("met", True, 11, f"Mine.met returned True: {ROWS}"),
        ("met", -1, 11, f"Mine.met returned -1: {ROWS}"),
        ("met", 11, 11, f"Mine.met returned 11: {ROWS}"),
        ("met", fails, 11, "Mine.met raised ZeroDivisionError: division by zero"),
        ("after", fails, 1, "Mine.after raised ZeroDivisionError: division by zero"),
        ("end", fails, 11, "Mine.end raised ZeroDivisionError: division by zero"),
    ],
)
@pytest.mark.parametrize("solved", ["co-simulation", "model-exchange"])
def test_a_wrong_answer_ends_the_run_with_its_rows(chain, method, answer, rows, said, solved):
    solver = {"method": ModelExchange()} if solved == "model-exchange" else {}
    with pytest.raises(RunFailed) as failed:
        run(chain(), **TIMES, hooks=[mine(method, answer)], **solver)
    assert str(failed.value) == f"{said}; {rows} rows are kept"
    whole = run(chain(), **TIMES, **solver)
    assert np.array_equal(failed.value.result.data, whole.data[:rows])
    assert failed.value.result.manifest["outcome"]["message"] == said


@pytest.mark.parametrize(
    ("method", "answer", "said"),
    [
        ("prepare", fails, "Mine.prepare raised ZeroDivisionError: division by zero"),
        ("begin", fails, "Mine.begin raised ZeroDivisionError: division by zero"),
        ("for_manifest", 3, f"Mine.for_manifest returned 3: {ENTRIES}"),
        ("for_manifest", {"step": 3}, "Mine.for_manifest has 'step', which the run has: give it another name"),
        ("for_manifest", {"a": {1}}, "Mine.for_manifest returned what no manifest can hold: {1} is no number, text,"),
    ],
)
def test_a_wrong_answer_before_the_run_refuses_it(chain, method, answer, said):
    with pytest.raises(AdcsError) as refused:
        run(chain(), **TIMES, hooks=[mine(method, answer)])
    assert str(refused.value).startswith(said) and not isinstance(refused.value, RunFailed)


@pytest.mark.parametrize(
    ("method", "answer", "said"),
    [
        ("report", 3, f"Mine.report returned 3: {ENTRIES}"),
        ("report", None, f"Mine.report returned None: {ENTRIES}"),
        ("report", {1: 2}, f"Mine.report returned {{1: 2}}: {ENTRIES}"),
        ("report", fails, "Mine.report raised ZeroDivisionError: division by zero"),
        ("notes", "text", "Mine.notes returned 'text': expected a list of texts"),
        ("notes", [3], "Mine.notes returned [3]: expected a list of texts"),
    ],
)
def test_what_it_cannot_tell_at_the_end_is_a_warning(chain, method, answer, said):
    result = run(chain(), **TIMES, hooks=[mine(method, answer)])
    assert result.manifest["warnings"] == [said]
    assert result == run(chain(), **TIMES)


class Given:
    """A source whose values are whatever it is told."""

    names = ("plant.torque_disturbance_B",)

    def __init__(self, made):
        self.at = lambda times: made(len(times))

    def jump(self, after):
        return float("inf")


@pytest.mark.parametrize("method", [CoSimulation(), CoSimulation(adaptive=1e-3), ModelExchange()], ids=str)
@pytest.mark.parametrize(
    ("made", "said"),
    [
        (
            lambda n: np.zeros((n, 4)),
            r"^Given\.at returned values of shape \(\d+, 4\): expected \(\d+, 3\), a row",
        ),
        (lambda n: np.zeros(3), r"^Given\.at returned values of shape \(3,\): expected"),
        (lambda n: None, r"^Given\.at returned values of shape \(\): expected"),
        (lambda n: "x", r"^Given\.at raised ValueError: could not convert string to float: 'x'"),
        (fails, r"^Given\.at raised ZeroDivisionError: division by zero"),
    ],
)
def test_a_source_gives_a_row_of_numbers_for_each_time(method, made, said):
    class Fed(Hook):
        def prepare(self, outline):
            outline.sources.append(Given(made))

    with pytest.raises(AdcsError, match=said):
        run("observer-pd", **TIMES, method=method, hooks=[Fed()])


def test_what_sees_points_or_sets_something_is_asked_at_each():
    class Sets(Hook):
        seen = 0

        def changes(self, k):
            return [("controller.k_p", 3.0)] if k == 20 else []

        def after(self, point, time):
            self.seen += 1

    sets = Sets()
    result = run("observer-pd", stop_time=1, step=0.01, hooks=[sets])
    assert result == run("observer-pd", stop_time=1, step=0.01, hooks=[at(0.2, {"controller.k_p": 3.0})])
    assert sets.seen == 101


def test_two_reports_under_one_name_are_a_list(chain):
    hooks = [mine("report", {"peak": 1}), mine("report", {"peak": 2}), mine("report", {"own": [3]})]
    manifest = run(chain(), **TIMES, hooks=hooks).manifest
    assert (manifest["peak"], manifest["own"]) == ([1, 2], [3])


def test_what_is_made_of_a_hook_of_this_package_is_one_of_ones_own(chain):
    class Later(type(until("time > 0.4"))):
        def met(self, times, rows):
            return None

    result = run(chain(), **TIMES, hooks=[Later("time > 0.4")])
    assert (result.time[-1], result.manifest["watchers"]) == (1.0, ["Later"])
    with pytest.raises(AdcsError, match=r"^hooks: Later is part of this process, and cannot take part in an isolated"):
        run(chain(), **TIMES, hooks=[Later("time > 0.4")], isolated=True)


def test_values_are_those_of_when_they_were_given():
    values, names = np.array([1.0, 0.0, 0.0]), ["plant.q_BN"]
    change, save = at(0.5, {"plant.torque_disturbance_B": values}), Save(names)
    values[:] = 99
    names.append("plant.nothing")
    result = run("observer-pd", **TIMES, hooks=[change], save=save)
    assert result.manifest["settings"]["changes"] == [[0.5, "plant.torque_disturbance_B", [1.0, 0.0, 0.0]]]
    assert list(result) == ["plant.q_BN"]


@pytest.mark.parametrize(
    "parts",
    [
        {"save": Save(every=np.int64(2))},
        {"method": CoSimulation(adaptive=np.float32(1e-3))},
        {"method": ModelExchange(rtol=np.float32(1e-8))},
        {"method": CoSimulation(loops=LoopSolver(tolerance=np.float32(1e-8), max_iterations=np.int64(9)))},
        {"hooks": [at(0.5, {"controller.k_p": np.float32(3)})]},
        {"stop_time": np.float32(0.5), "step": np.float64(0.25)},
    ],
    ids=str,
)
def test_numbers_of_numpy_go_into_the_manifest(parts, tmp_path):
    result = run("observer-pd", **{**TIMES, **parts})
    result.write_manifest(tmp_path / "manifest.json")
    assert rerun(tmp_path / "manifest.json").result == result


def test_numbers_of_numpy_are_answers(chain, tmp_path):
    class Numbers(Hook):
        def ahead(self, k):
            return np.int64(3)

        def met(self, times, rows):
            found = np.flatnonzero(times >= 0.5)
            return found[0] if len(found) else None

        def report(self):
            return {"peak": np.float64(3.0), "all": np.arange(3), "pair": (1, 2)}

    result = run(chain(), **TIMES, hooks=[Numbers()])
    assert result.time[-1] == 0.5
    assert [result.manifest[name] for name in ("peak", "all", "pair")] == [3.0, [0, 1, 2], [1, 2]]
    result.write_manifest(tmp_path / "manifest.json")

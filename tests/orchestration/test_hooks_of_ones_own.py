"""Hooks that answer what they should not, or raise: told by their name, with all rows that were recorded."""

import numpy as np
import pytest

from adcs import AdcsError, Hook, ModelExchange, RunFailed, run

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
        ("after", fails, 11, "Mine.after raised ZeroDivisionError: division by zero"),
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

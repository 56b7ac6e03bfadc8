"""What is compared is the same system at the same rows; how long it takes is not tested."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks import coupled


def test_smooth_systems_are_those_without_anything_sampled() -> None:
    smooth = coupled.smooth()
    assert {"observer-pd", "six-dof", "adaptive-fuel-full", "velocity-free-tracking"} <= set(smooth)
    assert not {"quest-observer-pd", "hil-spacecraft", "trigo-bs"} & set(smooth)


def test_all_ways_lead_to_the_same_solution() -> None:
    rows = {row.way: row for row in coupled.measure("observer-pd", coupled.WAYS | coupled.MORE_WAYS, 1)}
    assert all(row.cpu_ms > 0 for row in rows.values())
    errors = {way: row.error for way, row in rows.items()}
    assert errors["exact"] == errors["DOP853, rtol 1e-12"] < 1e-10
    assert errors["DOP853, rtol 1e-12, with a table of inputs"] < 1e-10
    assert errors["DOP853, rtol 1e-11"] < 1e-9
    assert errors["SciPy's DOP853, rtol 1e-11"] < 1e-9
    assert errors["CVode, rtol 1e-10"] < 1e-6
    assert 1e-3 < errors["exchanged"] < 0.1


def test_rows_farther_apart_than_exchanges_are_the_same_rows() -> None:
    exact, exchanged = coupled.exact("six-dof").outputs, coupled.exchanged("six-dof").outputs
    assert {name: values.shape for name, values in exact.items()} == {n: v.shape for n, v in exchanged.items()}
    assert coupled.error(exchanged, exact) < 5e-3  # rows of other times would differ by more


def test_an_error_is_relative_to_the_size_of_its_output() -> None:
    large, small = np.array([[0.0, -200.0], [100.0, 0.0]]), np.array([1e-6, 0.0])
    reference = {"large": large, "small": small}
    assert coupled.error(reference, reference) == 0.0
    assert coupled.error({"large": large + 0.02, "small": small}, reference) == pytest.approx(1e-4)
    assert coupled.error({"large": large, "small": small + 5e-6}, reference) == pytest.approx(5e-3)


def test_results_are_written_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coupled, "smooth", lambda: ["velocity-free-tracking"])
    coupled.main(rounds=1, output=tmp_path)
    found = json.loads((tmp_path / "coupled.json").read_text(encoding="utf-8"))
    assert [row["system"] for row in found] == 2 * ["velocity-free-tracking"] + 5 * ["observer-pd"]
    assert found[0]["error"] < 1e-9 < found[1]["error"]

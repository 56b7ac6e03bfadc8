"""The benchmark of the elementary functions measures each of them; how long they take is not tested."""

import json
from pathlib import Path

import pytest

from benchmarks import elementary


def test_a_round_measures_every_function() -> None:
    measured = elementary.measure_round()
    assert list(measured) == ["sin", "cos", "sincos", "exp", "log"]
    assert all(time > 0 for times in measured.values() for time in times)


def test_ratios_are_taken_within_a_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = iter([{"sin": (1.0, 2.0, 8.0, 4.0)}, {"sin": (30.0, 10.0, 9.0, 9.0)}, {"sin": (5.0, 5.0, 1.0, 2.0)}])
    monkeypatch.setattr(elementary, "measure_round", lambda: next(rounds))
    elementary.main(rounds=3, output=tmp_path)
    found = json.loads((tmp_path / "elementary.json").read_text(encoding="utf-8"))
    assert found["sin"] == {"chained": {"ns": 5.0, "ratio": 1.0}, "independent": {"ns": 8.0, "ratio": 1.0}}

"""The benchmark of the twenty runs counts what it runs; how long that takes is not tested."""

import json
from pathlib import Path

import pytest

from benchmarks import backstepping


def test_a_round_runs_all_twenty_systems() -> None:
    measured = backstepping.measure_round(stop_time=1.0)
    assert 0 < measured.stepping < measured.whole


def test_results_are_written_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = iter([backstepping.Round(9.0, 9.0), backstepping.Round(1.0, 2.0), backstepping.Round(3.0, 4.0)])
    monkeypatch.setattr(backstepping, "measure_round", lambda *_: next(rounds))
    backstepping.main(rounds=2, output=tmp_path)
    found = json.loads((tmp_path / "backstepping.json").read_text(encoding="utf-8"))
    assert found["simulated_s"] == 22000.0
    assert found["whole"] == {"cpu_s": 3.0, "simulated_s_per_cpu_s": pytest.approx(22000 / 3)}
    assert found["stepping"]["cpu_s"] == 2.0

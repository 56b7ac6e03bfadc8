"""The benchmark of the lockstep flies what it says; how long that takes is not tested."""

import json
from pathlib import Path

import pytest

from benchmarks import lockstep


def test_a_round_answers_every_point() -> None:
    measured = lockstep.measure_round(50)
    assert measured.wall > 0
    assert measured.cpu > 0


def test_results_are_written_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = iter(
        [lockstep.Round(3e-3, 1e-3, 2e-4), lockstep.Round(1e-3, 1e-3, 2e-4), lockstep.Round(2e-3, 1e-3, 2e-4)]
    )
    monkeypatch.setattr(lockstep, "measure_round", lambda _: next(rounds))
    lockstep.main(rounds=3, points=100, output=tmp_path)
    found = json.loads((tmp_path / "lockstep.json").read_text(encoding="utf-8"))
    assert found["points_per_s"] == pytest.approx(500)
    assert len(found["rounds"]) == 3

"""The ring is a ring, and its bodies are what they are alone; how long a step takes is not tested."""

import json
from pathlib import Path

import numpy as np
import pytest

from adcs import run
from benchmarks import ring


def test_each_body_is_fed_by_the_one_before_it() -> None:
    made = ring.system(3)
    links = {(c.source.partition(".")[0], c.target.partition(".")[0]) for c in made.connections}
    assert links == {("body0", "body1"), ("body1", "body2"), ("body2", "body0")}
    three = run(made, stop_time=1.0, step=0.01)
    two = run(ring.system(2), stop_time=1.0, step=0.01)
    # what feeds body 1 is the same in both
    assert np.abs(three["body1.omega_BN_B"] - two["body1.omega_BN_B"]).max() < 1e-15


def test_results_are_written_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring, "SIZES", (1, 4))
    ring.main(rounds=1, component_steps=1000, output=tmp_path)
    found = json.loads((tmp_path / "ring.json").read_text(encoding="utf-8"))
    assert [cost["size"] for cost in found] == [1, 4]
    assert all(cost["step"] > 0 for cost in found)

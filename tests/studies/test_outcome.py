from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from adcs.library.outcome import Outcome, Row, Runner, as_json, claims_table, verdict, write_csv
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table

NAMES = ["study", "table", "cell", "settings", "printed", "ours", "relative_error", "verdict", "note"]
NUMBER = Row("x", "Table 1", "a", "10 Hz", 2.0, 2.1, 0.05, "reproduced")
CLAIM = Row("x", "Sec. 1", "b, c", "none", "within 60 s", float("nan"), None, "not reproduced", 'never "settled"')


def test_json_has_the_fixed_names_and_no_nan() -> None:
    rows = json.loads(as_json([NUMBER, CLAIM]))
    assert [list(row) for row in rows] == [NAMES, NAMES]
    assert rows[0]["ours"] == 2.1
    assert rows[1]["ours"] is None
    assert rows[1]["note"] == 'never "settled"'


def test_csv(tmp_path: Path) -> None:
    write_csv(tmp_path / "rows.csv", [NUMBER, CLAIM])
    with (tmp_path / "rows.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == NAMES
    assert (rows[0]["relative_error"], rows[1]["cell"]) == ("0.05", "b, c")


def test_outcomes_add_up() -> None:
    one = Outcome([NUMBER], [Panel("p", "y", [])], [Table("t", [], [])], [KeyNumber("k", 1)])
    both = one + Outcome([CLAIM]) + one
    assert both.rows == [NUMBER, CLAIM, NUMBER]
    assert (len(both.panels), len(both.tables), len(both.key_numbers)) == (2, 2, 2)
    assert one.rows == [NUMBER]


def test_relative_error_is_a_column_only_where_there_is_one() -> None:
    assert "relative error" in claims_table([NUMBER, CLAIM], "", "").columns
    table = claims_table([CLAIM], "", "")
    assert "relative error" not in table.columns
    assert table.rows[0][table.columns.index("verdict")] == "not reproduced"


def test_verdict() -> None:
    assert (verdict(True), verdict(False)) == ("reproduced", "not reproduced")


def test_runner_reports_progress_over_all_runs() -> None:
    seen: list[tuple[float, str]] = []

    class Result:
        def __init__(self, name: str) -> None:
            self.manifest = {"name": name}

    def run(system: Any, *, step: float, method: Any, progress: Any) -> Any:
        assert (step, method.kind) == (0.1, "co-simulation")
        progress(0.5)
        return Result(system)

    runner = Runner(lambda done, text: seen.append((done, text)), 2, run)
    runner("first", "a", step=0.1)  # type: ignore[arg-type]
    runner("second", "b", step=0.1)  # type: ignore[arg-type]
    assert seen == [(0.0, "first"), (0.25, "first"), (0.5, "second"), (0.75, "second")]
    assert runner.runs == [("first", {"name": "a"}), ("second", {"name": "b"})]


@pytest.mark.parametrize("row", [NUMBER, CLAIM])
def test_rows_cannot_be_changed(row: Row) -> None:
    with pytest.raises(AttributeError):
        row.ours = 1.0  # type: ignore[misc]

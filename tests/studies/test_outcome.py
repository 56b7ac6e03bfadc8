from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from adcs.library.outcome import Claim, Outcome, as_json, claims_table, tally, write_csv
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table

NAMES = [
    "study",
    "table",
    "cell",
    "settings",
    "reading",
    "counted",
    "printed",
    "ours",
    "relative_error",
    "verdict",
    "note",
]
NUMBER = Claim("Table 1", "a", "10 Hz", 2.0, 2.1, True, error=0.05, reading="as made")
CLAIM = Claim("Sec. 1", "b, c", "none", "within 60 s", float("nan"), False, 'never "settled"')
MISPRINT = Claim("Sec. 2", "d", "", "+", "-", None)
LITERAL = Claim("Table 1", "a", "10 Hz", 2.0, 3.0, False, reading="as printed")


def test_json_has_the_fixed_names_and_no_nan() -> None:
    rows = json.loads(as_json(Outcome([NUMBER, CLAIM]).rows("x")))
    assert [list(row) for row in rows] == [NAMES, NAMES]
    assert (rows[0]["study"], rows[0]["table"], rows[0]["ours"], rows[0]["reading"]) == ("x", "Table 1", 2.1, "as made")
    assert (rows[1]["ours"], rows[1]["relative_error"]) == (None, None)
    assert rows[1]["note"] == 'never "settled"'


def test_csv(tmp_path: Path) -> None:
    write_csv(tmp_path / "rows.csv", Outcome([NUMBER, CLAIM]).rows("x"))
    with (tmp_path / "rows.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == NAMES
    assert (rows[0]["relative_error"], rows[1]["cell"]) == ("0.05", "b, c")


def test_outcomes_add_up() -> None:
    one = Outcome([NUMBER], [Panel("p", "y", [])], [Table("t", [], [])], [KeyNumber("k", 1)])
    both = one + Outcome([CLAIM], counted="as made") + one
    assert both.claims == [NUMBER, CLAIM, NUMBER]
    assert (len(both.panels), len(both.tables), len(both.key_numbers), both.counted) == (2, 2, 2, "as made")
    assert one.claims == [NUMBER]


def test_what_a_section_shows_is_sorted_by_kind() -> None:
    panel, table, number = Panel("p", "y", []), Table("t", [], []), KeyNumber("k", 1)
    outcome = Outcome.of(iter([table, NUMBER, number, panel, CLAIM]), "as made")
    assert outcome == Outcome([NUMBER, CLAIM], [panel], [table], [number], "as made")


def test_a_section_gives_its_heading_to_what_has_none_and_shows_its_claims_first() -> None:
    own = Outcome([CLAIM], [Panel("p", "y", [])], [Table("t", [], []), Table("u", [], [], group="other")])
    shown = own.within("5.1", "The statements")
    assert [(table.title, table.group) for table in shown.tables] == [
        ("The statements", "5.1"),
        ("t", "5.1"),
        ("u", "other"),
    ]
    assert shown.panels[0].group == "5.1"
    assert len(own.within("5.1", "").tables) == 2


def test_relative_error_is_a_column_only_where_there_is_one() -> None:
    assert "relative error" in claims_table([NUMBER, CLAIM], "").columns
    table = claims_table([CLAIM], "")
    assert "relative error" not in table.columns
    assert table.rows[0][table.columns.index("verdict")] == "not reproduced"


def test_verdict() -> None:
    assert [c.verdict for c in (NUMBER, CLAIM, MISPRINT)] == ["reproduced", "not reproduced", "wrong in print"]


def test_the_score_counts_the_reading_that_counts_and_what_is_of_none() -> None:
    outcome = Outcome([NUMBER, LITERAL, CLAIM, MISPRINT], counted="as made")
    assert outcome.scored() == [NUMBER, CLAIM, MISPRINT]
    assert [row["counted"] for row in outcome.rows("x")] == [True, False, True, True]
    assert tally(outcome.scored()) == {"reproduced": 1, "not reproduced": 1, "wrong in print": 1}
    assert tally(outcome.claims) == {"reproduced": 1, "not reproduced": 2, "wrong in print": 1}
    assert tally([]) == {}


@pytest.mark.parametrize("claim", [NUMBER, CLAIM])
def test_claims_cannot_be_changed(claim: Claim) -> None:
    with pytest.raises(AttributeError):
        claim.measure = 1.0  # type: ignore[misc]

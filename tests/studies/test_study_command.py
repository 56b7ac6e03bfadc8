from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from adcs import AdcsError
from adcs.cli import study as cli
from adcs.library.entry import StudyEntry
from adcs.library.outcome import Claim, Outcome, Progress
from orchestration.results.plots import Panel, Series
from tests.invoking import invoke

MANIFEST = {
    "started": "2020-01-01",
    "system": {
        "name": "loop",
        "components": {"plant": {"file": "RigidBody.fmu", "fmi_version": "2.0", "sha256": "ab12"}},
    },
    "settings": {"step": 0.01},
    "seeds": {},
    "versions": {"fmpy": "1"},
    "timing": {"cpu_s": 0.5},
}


@dataclass(frozen=True)
class Choices:
    settled: float = 0.02
    draws: int = 4


def run(choices: Choices, progress: Progress) -> tuple[Outcome, list[tuple[str, dict[str, Any]]]]:
    progress(0.5, "working")
    claims = [
        Claim("Table 1", "a", "", 1.0, choices.settled, True, reading="as made"),
        Claim("Table 1", "a", "", 1.0, 5.0, False, reading="literal"),
        *(Claim("Table 2", f"missed {i}", "", 1.0, 2.0, False) for i in range(1, choices.draws)),
    ]
    curve = Series("s", np.arange(3), np.arange(3))
    panel = Panel("p", "y", [curve], group="1.2  First & last")
    return Outcome(claims, [panel], counted="as made"), [("the run", MANIFEST)]


@pytest.fixture(autouse=True)
def toy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(cli, "STUDIES", {"toy": StudyEntry("toy", "A toy", "Nothing.", Choices, run)})
    monkeypatch.chdir(tmp_path)


def test_json_is_all_that_is_printed_to_stdout() -> None:
    result = invoke(cli.app, ["toy", "--json", "--set", "settled=0.5"])
    assert result.exit_code == 0
    assert json.loads(result.stdout)[0]["ours"] == 0.5


def test_files() -> None:
    result = invoke(cli.app, ["toy"])
    assert result.exit_code == 0
    folder = Path("results/study-toy")
    names = {"index.html", "rows.csv", "rows.json", "runs.json", "1-2-first-last.png"}
    assert {file.name for file in folder.iterdir()} == names
    assert "4 claims, as made: 1 reproduced, 3 not reproduced" in result.stdout
    assert str(folder / "index.html") in result.stdout
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "adcs study toy" in page
    assert "ab12" in page
    assert "<b>1</b> reproduced" in page
    assert "<b>3</b> not reproduced" in page, "the score of the terminal"
    assert "as made" in page
    assert json.loads((folder / "runs.json").read_text(encoding="utf-8")) == [{"run": "the run", **MANIFEST}]


def lines(*arguments: str) -> list[str]:
    """What is printed, without the frames of tables and the spaces."""
    text = invoke(cli.app, ["toy", *arguments]).stdout
    return [" ".join(line.strip("│┃ ").replace("│", " ").split()) for line in text.splitlines()]


def test_verdicts_are_counted_by_place_and_reading_and_the_misses_named() -> None:
    shown = lines()
    assert "Table 1 as made 1" in shown
    assert "Table 1 literal 1" in shown
    assert "Table 2 3" in shown
    assert "all as made 1" in shown
    assert "all literal 1" in shown
    assert "Table 2 missed 3 1 2" in shown
    assert not [line for line in shown if line.startswith("Table 1 a 1")], "neither what holds nor what does not count"


def test_many_misses_are_cut_and_all_shows_everything() -> None:
    shown = lines("--set", "draws=31")
    assert "Table 2 missed 20 1 2" in shown
    assert "Table 2 missed 21 1 2" not in shown
    assert "and 10 more: the report has all, and so have --all and --json" in shown
    everything = lines("--set", "draws=31", "--all")
    assert "Table 2 missed 30 1 2 not reproduced" in everything
    assert "Table 1 a 1 5 not reproduced" in everything


def test_out_names_the_folder() -> None:
    invoke(cli.app, ["toy", "--out", "there"])
    assert Path("there/index.html").exists()


def test_a_second_study_gets_the_next_number_and_force_replaces() -> None:
    assert [invoke(cli.app, ["toy"]).stdout.split()[-1] for _ in range(2)] == [
        "results/study-toy/index.html",
        "results/study-toy-2/index.html",
    ]
    assert invoke(cli.app, ["toy", "--force"]).stdout.split()[-1] == "results/study-toy/index.html"


def test_unknown_study() -> None:
    result = invoke(cli.app, ["nothing"])
    assert isinstance(result.exception, AdcsError)
    assert str(result.exception) == "no study 'nothing': choose one of toy"


def test_choices() -> None:
    assert cli.with_changes(Choices(), ["draws=2", "settled=0.1"]) == Choices(0.1, 2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("setled=1", "no choice 'setled': choose one of settled, draws, as in --set settled=VALUE"),
        ("draws=0.5", "choice draws = '0.5': expected a number (int)"),
        ("settled", "choice settled = '': expected a number (float)"),
    ],
)
def test_bad_choices_are_refused_in_one_line(change: str, message: str) -> None:
    with pytest.raises(AdcsError) as error:
        cli.with_changes(Choices(), [change])
    assert str(error.value) == message

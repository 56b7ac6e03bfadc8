"""No run writes over the results of another unasked: the folder gets the next number."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hostile import adcs

from adcs import AdcsError
from orchestration.isolation import journal
from orchestration.isolation.folder import STUDY, new_results

SHORT = ("--stop", 0.1, "--no-report", "--format", "csv", "--json")


def files(out: str) -> list[str]:
    found: list[str] = json.loads(out)["files"]
    return found


def test_a_second_run_gets_the_next_number_and_force_replaces(tmp_path: Path) -> None:
    places = []
    for _ in range(3):
        code, out, err = adcs("run", "observer-pd", *SHORT, cwd=tmp_path)
        assert (code, err) == (0, "")
        places.append(files(out)[0])
    names = ["observer-pd", "observer-pd-2", "observer-pd-3"]
    assert places == [f"results/{name}/result.csv" for name in names]
    first = (tmp_path / places[0]).stat().st_mtime_ns
    code, out, _ = adcs("run", "observer-pd", *SHORT, "--out", "results/observer-pd", cwd=tmp_path)
    assert files(out)[0] == "results/observer-pd-4/result.csv"
    assert (tmp_path / places[0]).stat().st_mtime_ns == first
    code, out, _ = adcs("run", "observer-pd", *SHORT, "--force", cwd=tmp_path)
    assert (code, files(out)[0]) == (0, "results/observer-pd/result.csv")
    assert (tmp_path / places[0]).stat().st_mtime_ns > first
    assert sorted(file.name for file in (tmp_path / places[0]).parent.iterdir()) == ["manifest.json", "result.csv"]


def test_a_run_that_is_refused_takes_no_number(tmp_path: Path) -> None:
    adcs("run", "observer-pd", *SHORT, "--out", "out", cwd=tmp_path)
    code, _, _ = adcs("run", "observer-pd", *SHORT, "--out", "out", "--record", "plant.nothing", cwd=tmp_path)
    assert (code, [file.name for file in tmp_path.iterdir()]) == (2, ["out"])


@pytest.mark.parametrize("left", [journal.NAME, "report.html", "previous", *STUDY])
def test_what_any_command_or_a_run_that_died_left_counts(tmp_path: Path, left: str) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / left).write_text("mine")
    with new_results(tmp_path / "out", replace=False) as results:
        assert results.path == tmp_path / "out-2"
    with new_results(tmp_path / "out", replace=True) as results:
        assert results.path == tmp_path / "out"
    assert (tmp_path / "out" / left).read_text() == "mine"
    assert not (tmp_path / "out-2").exists()


def test_files_that_are_no_results_do_not_count(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("")
    with new_results(tmp_path, replace=False) as results:
        assert results.path == tmp_path


def test_runs_at_once_get_numbers_of_their_own(tmp_path: Path) -> None:
    def one(_: int) -> str:
        code, out, err = adcs("run", "observer-pd", *SHORT, "--out", "out", cwd=tmp_path)
        assert (code, err) == (0, "")
        return files(out)[0]

    with ThreadPoolExecutor(3) as pool:
        assert sorted(pool.map(one, range(3))) == ["out-2/result.csv", "out-3/result.csv", "out/result.csv"]


def test_of_two_that_hold_a_folder_the_second_gets_a_number_and_force_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with new_results(out, replace=False), new_results(out, replace=False) as second:
        assert second.path == tmp_path / "out-2"
        with pytest.raises(AdcsError, match="belongs to a run that goes on"), new_results(out, replace=True):
            pass


def test_a_folder_without_a_name_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "manifest.json").write_text("mine")
    monkeypatch.chdir(tmp_path)
    message = r"^\. holds the results of another run, and has no name to put a number to: give another folder by --out"
    with pytest.raises(AdcsError, match=message), new_results(Path(), replace=False):
        pass


@pytest.mark.parametrize(
    "words",
    [
        ("--checkpoint", "c.npz", "--adaptive", 1e-3),
        ("--mavlink", "--method", "model-exchange"),
        ("--delay", "plant.torque_B=1", "--method", "model-exchange"),
        ("--every", "controller=2", "--adaptive", 1e-3),
        ("--at", "0.5s", "tracker.seed=3"),
        ("--checkpoint", "."),
        ("--input-table", "t.csv", "--at", "0.5s", "plant.torque_disturbance_B=1,2,3"),
        ("--resume", "other.npz"),
    ],
    ids=str,
)
def test_words_that_do_not_go_together_leave_all_as_it_was(tmp_path: Path, words: tuple[object, ...]) -> None:
    (tmp_path / "t.csv").write_text("time,plant.torque_disturbance_B[1]\n0,0\n")
    code, _, err = adcs("run", "full-state-pd", *SHORT, "--checkpoint", "other.npz", "--out", "other", cwd=tmp_path)
    assert code == 0, err
    adcs("run", "observer-pd", *SHORT, "--out", "out", cwd=tmp_path)
    before = {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()}
    for force in ((), ("--force",)):
        code, _, err = adcs("run", "observer-pd", *SHORT, "--out", "out", *words, *force, cwd=tmp_path)
        assert (code, len(err.splitlines())) == (2, 1), err
        assert {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()} == before
    assert sorted(file.name for file in tmp_path.iterdir()) == ["other", "other.npz", "out", "t.csv"]

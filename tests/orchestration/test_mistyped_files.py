"""A slip in the path of a file costs a line with the file that was perhaps meant."""

import json
from pathlib import Path

import pytest

from adcs.cli.app import app
from fmus.nearby import instead
from tests.invoking import invoke


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("mission.py", "my_law.hpp", "their_thing.fmu", "loop.ssp", "table.csv", "state.npz", "flight.tlog"):
        Path(name).write_text("def slew(): pass\n")
    Path("roles.toml").write_text("")
    Path("secret.key").write_text("x")
    Path("results/observer-pd").mkdir(parents=True)
    Path("results/observer-pd/manifest.json").write_text("{}")
    Path("results/observer-pd/report.html").write_text("")
    return tmp_path


RUN = ("run", "observer-pd", "--in-process", "--stop", "1s")


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("run", "misson.py"), "misson.py is no file: did you mean mission.py?"),
        (("run", "misson.py:slew"), "misson.py is no file: did you mean mission.py?"),
        (("run", "mission.py:slwe"), "mission.py has no system 'slwe': did you mean slew?"),
        (("run", "mission"), "no system 'mission': did you mean mission.py"),
        (("run", "mission.ssp"), "cannot open mission.ssp: No such file or directory: did you mean mission.py?"),
        (("info", "Mission.py"), "Mission.py is no file: did you mean mission.py?"),
        (("build", "my_lw.hpp"), "my_lw.hpp is no file: did you mean my_law.hpp?"),
        (
            ("run", "their_thin.fmu"),
            "cannot open their_thin.fmu: No such file or directory: did you mean their_thing.fmu?",
        ),
        (
            ("info", "their_thin.fmu"),
            "cannot open their_thin.fmu: No such file or directory: did you mean their_thing.fmu?",
        ),
        (("check", "their_thin.fmu"), "their_thin.fmu is no file: did you mean their_thing.fmu?"),
        (("run", "lop.ssp"), "cannot open lop.ssp: No such file or directory: did you mean loop.ssp?"),
        (("linearize", "lopp.ssp"), "cannot open lopp.ssp: No such file or directory: did you mean loop.ssp?"),
        (("export", "misson.py"), "misson.py is no file: did you mean mission.py?"),
        (
            (*RUN, "--input-table", "tabel.csv"),
            "cannot open tabel.csv: No such file or directory: did you mean table.csv?",
        ),
        ((*RUN, "--resume", "stat.npz"), "cannot open stat.npz: No such file or directory: did you mean state.npz?"),
        ((*RUN, "--mavlink", "--key", "secrt.key"), "secrt.key: No such file or directory: did you mean secret.key?"),
        ((*RUN, "--mavlink", "--map", "role.toml"), "(No such file or directory: did you mean roles.toml?)"),
        (("replay", "fligt.tlog"), "cannot read fligt.tlog: No such file or directory: did you mean flight.tlog?"),
        (("rerun", "results/observer-dp"), "there is no manifest.json: did you mean results/observer-pd?"),
        (("open", "results/observr-pd"), "does not exist: did you mean results/observer-pd/report.html?"),
        (("open", "result/observer-pd"), "does not exist: did you mean results/observer-pd/report.html?"),
        (("recover", "results/observerpd"), "no folder results/observerpd: did you mean results/observer-pd?"),
        (
            ("hil", "hil-spacecraft", "--actuators", "tble.csv"),
            "tble.csv: No such file or directory: did you mean table.csv?",
        ),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_the_file_that_was_meant_is_named(here: Path, words: tuple[str, ...], meant: str) -> None:
    ended = invoke(app, [*words])
    assert meant in str(ended.exception), ended
    assert "\n" not in str(ended.exception)
    assert not Path("results/observerpd").exists()


def test_checking_a_file_that_is_not_there_names_the_one_that_is(here: Path) -> None:
    ended = invoke(app, ["check", "./their_thng.fmu", "--json"])
    assert "their_thng.fmu is no file: did you mean their_thing.fmu?" in str(ended.exception) + ended.stdout


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("mission.py", ""),
        ("entirely_different.py", ""),
        ("no/such/folder/mission.py", ""),
        ("reslts/observer-pd/manifest.json", ": did you mean results/observer-pd/manifest.json?"),
        ("a\0b.py", ""),
        ("x" * 5000 + ".py", ""),
        ("", ""),
    ],
)
def test_what_is_like_a_path(here: Path, path: str, said: str) -> None:
    assert instead(path) == said


def test_three_at_most_and_the_likest_first(here: Path) -> None:
    for name in ("law_a.hpp", "law_b.hpp", "law_c.hpp", "law_ab.hpp", ".law_.hpp", "law_.py"):
        Path(name).touch()
    assert instead("law_.hpp") == ": did you mean law_a.hpp or law_ab.hpp or law_b.hpp?"
    assert json.loads(Path("results/observer-pd/manifest.json").read_text()) == {}

"""A command loads what it needs: large libraries take longer to load than most commands to do what they are for."""

import subprocess
import sys
from pathlib import Path

import pytest

DRAWING = {"matplotlib", "plotly", "jinja2", "markdown", "latex2mathml", "contourpy"}
SPECIAL = {"scipy", "h5py", "pymavlink", "pandas", "xarray", "lief", "ziglang"}
NUMERIC = {"numpy", "fmpy"}

PROGRAM = """
import runpy, sys
try:
    runpy.run_module("adcs", run_name="__main__")
except SystemExit as ended:
    assert not ended.code, ended.code
sys.stderr.write(" ".join({name.partition(".")[0] for name in sys.modules}))
"""
RUN = ["run", "full-state-pd", "--stop", "1s", "--in-process", "--format", "csv", "--no-report"]


def loaded(program: str, *arguments: str, folder: Path) -> set[str]:
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=folder)
    return set(done.stderr.split())


@pytest.mark.parametrize(
    ("arguments", "none_of"),
    [
        ([], NUMERIC | SPECIAL | DRAWING),
        (["--help"], NUMERIC | SPECIAL | DRAWING),
        (["--version"], NUMERIC | SPECIAL | DRAWING),
        (["list"], NUMERIC | SPECIAL | DRAWING),
        (RUN, SPECIAL | DRAWING),
    ],
    ids=lambda value: " ".join(value[:1]) if isinstance(value, list) else "",
)
def test_no_large_library_is_loaded_for_nothing(arguments: list[str], none_of: set[str], tmp_path: Path) -> None:
    found = loaded(PROGRAM, *arguments, folder=tmp_path)
    assert found & none_of == set()
    assert "cyclopts" in found


def test_who_watches_a_run_loads_nothing_of_it(tmp_path: Path) -> None:
    program = "import sys, adcs.__main__; sys.stderr.write(' '.join({m.partition('.')[0] for m in sys.modules}))"
    found = loaded(program, folder=tmp_path)
    assert found & (NUMERIC | SPECIAL | DRAWING | {"cyclopts", "rich", "fmus", "orchestration"}) == set()
    assert "adcs" in found


def test_a_list_loads_no_system_of_this_project(tmp_path: Path) -> None:
    program = PROGRAM.replace('name.partition(".")[0]', "name")
    found = loaded(program, "list", folder=tmp_path)
    of_systems = {"adcs.library.thakur.entries", "adcs.library.thakur.observer.systems", "orchestration.system"}
    assert found & of_systems == set() and "adcs.library.thakur.catalogue" in found

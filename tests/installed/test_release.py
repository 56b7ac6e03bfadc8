"""What `make release` makes is the same, byte for byte, wherever and whenever it is made."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.installed.conftest import ROOT

_BILL = ("--pyproject", "pyproject.toml", "--mc-type", "library", "--output-reproducible", "-o")


def _released(root: Path, to: Path, modified: int, umask: int) -> dict[str, bytes]:
    """Return wheel, sdist and bill of materials of a clone, whose files have this time (s since 1970) and mode."""
    subprocess.run(["git", "clone", "--quiet", ROOT, root], check=True, umask=umask)
    shutil.copytree(ROOT / "build" / "carried", root / "build" / "carried")
    for path in root.rglob("*"):
        if ".git" not in path.parts:
            os.utime(path, (modified, modified))
    python = [sys.executable, "-m"]
    for command in (
        [*python, "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps", "--wheel-dir", to, "."],
        [*python, "build", "--sdist", "--outdir", to, "."],
        [Path(sys.executable).with_name("cyclonedx-py"), "requirements", "requirements/run.lock", *_BILL, to / "bill"],
        [*python, "adcs.bill", to / "bill"],
    ):
        subprocess.run(command, check=True, cwd=root, capture_output=True, umask=umask)
    return {path.name: path.read_bytes() for path in to.iterdir()}


def test_it_depends_on_neither_folder_nor_time_nor_umask(installed, tmp_path):
    one = _released(tmp_path / "one", tmp_path / "of one", 1_600_000_000, 0o022)
    other = _released(tmp_path / "b" / "other", tmp_path / "of other", 1_700_000_000, 0o077)
    assert len(one) == 3
    assert one == other

"""An option of a method is declared in one place: a field of its class, and everything else follows."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
FIELD = '''
    damping: float = field(default=1.0, kw_only=True)
    """How much of each exchanged value is taken."""
    longest: Seconds | None = field(default=None, kw_only=True)
    """The longest of something."""
    order: int = field(default=4, kw_only=True)
    """How often."""
'''
CLASS = '    kind: ClassVar[Kind] = "co-simulation"\n'


def extended(folder: Path) -> Path:
    """A copy of the packages with one more field, and nothing else."""
    for package in ("adcs", "orchestration", "fmus", "hil_bridge"):
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("dist", "__pycache__"))
    (folder / "fmus" / "dist").symlink_to(ROOT / "fmus" / "dist")
    for name in ("src", "build", "pyproject.toml", "LICENSE"):
        (folder / name).symlink_to(ROOT / name)
    method = folder / "orchestration" / "running" / "method.py"
    text = method.read_text(encoding="utf-8")
    assert text.count(CLASS) == 1
    method.write_text(text.replace(CLASS, CLASS + FIELD), encoding="utf-8")
    return folder


def test_a_field_is_argument_option_help_manifest_and_rerun(tmp_path):
    copy = extended(tmp_path / "copy")
    environment = os.environ | {"PYTHONPATH": str(copy), "COLUMNS": "80", "MPLBACKEND": "agg"}

    def adcs(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "adcs", *arguments]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)

    help_ = " ".join(adcs("run", "--help").stdout.replace("│", "").split())
    assert "--damping FLOAT How much of each exchanged value is taken. [default: 1.0]" in help_
    assert "--longest TIME The longest of something." in help_
    run = ("run", "observer-pd", "--stop", "1s", "--no-report", "--out", "first")
    assert adcs(*run, "--damping", "0.5", "--longest", "2min", "--order", "3").returncode == 0
    settings = json.loads((tmp_path / "first" / "manifest.json").read_text())["settings"]
    assert (settings["damping"], settings["longest"], settings["order"]) == (0.5, 120.0, 3)
    for option, word in (("--longest", "soon"), ("--order", "1.5")):
        wrong = adcs(*run, option, word)
        assert wrong.returncode == 2 and option in wrong.stderr and wrong.stderr.count("\n") == 1
    again = adcs("rerun", "first", "--json")
    assert json.loads(again.stdout)["differences"] == []
    assert json.loads((tmp_path / "first-2" / "manifest.json").read_text())["settings"]["damping"] == 0.5
    refused = adcs(*run, "--method", "model-exchange", "--damping", "0.5")
    assert refused.stderr == ("adcs: --damping 0.5: an option of co-simulation, leave out --method model-exchange\n")
    wrong = adcs(*run, "--damping", "half")
    assert wrong.returncode == 2 and "damping" in wrong.stderr and wrong.stderr.count("\n") == 1

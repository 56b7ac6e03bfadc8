"""What the wheel does where it is installed, without a compiler and without this repository."""

import filecmp
import json
import subprocess
import sys
import time
import zipfile

import pytest

import fmus


@pytest.fixture(scope="module")
def first_run(installed):
    """The first thing that a new user does, in an empty folder."""
    began = time.perf_counter()
    ended = installed.adcs("run", "observer-pd", "--json")
    took = time.perf_counter() - began
    installed.measured.add("first run, in an empty folder", took, "s")
    installed.measured.add("made with a filled cache, and the first run", installed.took + took, "s", aim=30)
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr == ""
    return json.loads(ended.stdout)


def test_it_is_small(installed):
    assert installed.wheel.name.endswith("-py3-none-any.whl")
    assert installed.wheel.stat().st_size <= 4_000_000
    packages = {path.name.partition("-")[0] for path in installed.package.parent.glob("*.dist-info")}
    assert "numpy" in packages
    size = sum(path.lstat().st_size for path in installed.environment.rglob("*"))
    assert size <= 500_000_000
    assert installed.wheel.stat().st_size <= 200_000 * len(fmus.components())
    assert not packages & {"ziglang", "cmeel_eigen", "lief", "matplotlib", "pymavlink"}


def test_a_system_runs_at_once_with_its_key_numbers(installed, first_run):
    numbers = {number["label"]: number["value"] for number in first_run["key_numbers"]}
    assert first_run["outcome"]["status"] == "complete"
    assert numbers["Largest torque"] == pytest.approx(12.012, abs=0.0005)
    assert numbers["Attitude tracking error converged"] == pytest.approx(42.5, abs=0.005)
    assert numbers["Rate estimation error at the end"] == pytest.approx(1.578e-9, rel=1e-3)
    folder = installed.home / "results" / "observer-pd"
    assert sorted(path.name for path in folder.iterdir()) == [
        "manifest.json",
        "report.html",
        "result.csv",
        "result.mat",
    ]
    began = time.perf_counter()
    assert installed.adcs("run", "observer-pd", "--json").returncode == 0
    installed.measured.add("second run", time.perf_counter() - began, "s")


def test_its_result_is_that_of_this_repository(installed, first_run, tmp_path):
    command = [
        sys.executable,
        "-m",
        "adcs",
        "run",
        "observer-pd",
        "--no-report",
        "--format",
        "csv",
        "--out",
        tmp_path / "here",
    ]
    subprocess.run(command, check=True, capture_output=True)
    theirs = installed.home / "results" / "observer-pd" / "result.csv"
    assert filecmp.cmp(tmp_path / "here" / "result.csv", theirs, shallow=False)


@pytest.fixture(scope="module")
def models(installed, first_run):
    """A folder with all its FMUs."""
    began = time.perf_counter()
    ended = installed.adcs("fmus", "--to", "models")
    installed.measured.add("adcs fmus, all of them", time.perf_counter() - began, "s")
    assert ended.stdout == f"{2 * len(fmus.components())} FMUs are in models\n", ended.stderr
    return installed.home / "models"


def test_its_fmus_are_those_that_are_built_here_for_all_platforms(models, tmp_path):
    built = fmus.build(["RigidBody"], all_platforms=True, dist=tmp_path)
    for fmu in built:
        assert (models / fmu.name).read_bytes() == fmu.read_bytes()
    with zipfile.ZipFile(built[1]) as archive:
        assert len([name for name in archive.namelist() if name.startswith("binaries/")]) == 5


def test_fmus_are_small(installed, models, tmp_path):
    """Of one platform all, of five those that are no larger than most; docs/building.md says what is in them."""
    sizes = {path.name: path.stat().st_size / 1e3 for path in models.glob("*.fmu")}
    for path in fmus.build(["RigidBody"], dist=tmp_path):
        assert path.stat().st_size <= 350_000
        installed.measured.add(f"{path.name}, one platform", path.stat().st_size / 1e3, "kB", aim=350)
    for pattern, standard in (("RigidBody.fmu", "FMI 2.0"), ("RigidBody.fmi3.fmu", "FMI 3.0")):
        installed.measured.add(f"{pattern}, five platforms", sizes[pattern], "kB", aim=520)
        its = [size for name, size in sizes.items() if name.endswith(".fmi3.fmu") == (standard == "FMI 3.0")]
        assert sizes[pattern] <= 520
        assert sorted(its)[len(its) // 2] <= 520
        assert max(its) <= 600
        installed.measured.add(f"largest of {standard}, five platforms", max(its), "kB", aim=520)


def test_the_cache_has_version_and_content_in_its_path(installed, first_run):
    (cache,) = (installed.home / ".cache" / "adcs-fmus").iterdir()
    version, _, content = cache.name.partition("-")
    assert version == installed.wheel.name.split("-")[1]
    assert len(content) == 12
    assert (cache / "dist" / "RigidBody.fmu").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("bridge", "observer-pd"), "pymavlink is not installed: pip install 'adcs-fmus[mavlink]'"),
        (("hil", "hil-spacecraft"), "pymavlink is not installed: pip install 'adcs-fmus[mavlink]'"),
        (("run", "observer-pd", "--mavlink"), "pymavlink is not installed: pip install 'adcs-fmus[mavlink]'"),
    ],
)
def test_what_needs_more_says_so_in_one_line(installed, arguments, message):
    ended = installed.adcs(*arguments)
    assert (ended.returncode, ended.stdout, ended.stderr) == (1, "", f"adcs: {message}\n")


def test_an_edited_header_is_not_flown(installed, first_run):
    header = installed.package / "src" / "controllers" / "pd_tracking.hpp"
    text = header.read_text()
    try:
        header.write_text(text + "// edited\n")
        ended = installed.adcs("run", "observer-pd", "--json")
    finally:
        header.write_text(text)
    assert ended.returncode == 1
    assert ended.stderr == (
        "adcs: PdTracking.fmu was built from another src/controllers/pd_tracking.hpp, and no compiler is installed to "
        "build it: pip install 'adcs-fmus[build]'\n"
    )


@pytest.mark.parametrize(
    "command",
    [["list"], ["build", "RigidBody"], ["info", "RigidBody"], ["info", "observer-pd"], ["check", "RigidBody"]],
)
def test_it_tells_about_itself(installed, command):
    ended = installed.adcs(*command, "--json")
    assert ended.returncode == 0, ended.stderr
    assert "RigidBody" in ended.stdout

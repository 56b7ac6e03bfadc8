"""A project of somebody who has only the wheel and its extra `build`: a component, a system, a package."""

from __future__ import annotations

import json
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from tests.installed.conftest import Installed, make_environment

PROJECT = Path(__file__).with_name("project")


@pytest.fixture(scope="module")
def project(installed: Installed, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """The files of the project, in an environment with a compiler."""
    folder = tmp_path_factory.mktemp("outside")
    made = make_environment(folder / "environment", f"{installed.wheel}[build]", installed.cache, "pytest")
    installed.measured.add("making it with the extra `build` and pytest", made, "s")
    shutil.copytree(PROJECT, folder / "project")
    return Installed(installed.wheel, folder / "environment", folder / "project", installed.cache)


@pytest.fixture(scope="module")
def law(installed: Installed, project: Installed) -> Path:
    """The component that `adcs new` wrote, built."""
    written = project.adcs("new", "controller", "rate_law")
    assert written.returncode == 0, written.stderr
    began = time.perf_counter()
    built = project.adcs("build", "rate_law.hpp")
    installed.measured.add("first adcs build of a component", time.perf_counter() - began, "s")
    assert built.returncode == 0, built.stderr
    return project.home / "rate_law.hpp"


def test_the_test_that_was_written_with_it_passes(project, law):
    python = project.environment / "bin" / "python"
    ended = subprocess.run(
        [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", law.with_name("test_rate_law.py")],
        cwd=project.home,
        env=project.variables,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout
    assert " passed" in ended.stdout


def test_a_system_in_a_file_runs_with_it(project, law):
    ended = project.adcs("run", "mission.py", "--json", "--format", "csv", "--no-report")
    assert ended.returncode == 0, ended.stderr
    (path,) = (project.home / "results").glob("*/result.csv")
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    rate = [header.split(",").index(name) for name in header.split(",") if name.startswith("plant.omega_BN_B")]
    first, last = (np.linalg.norm([float(row.split(",")[column]) for column in rate]) for row in (rows[0], rows[-1]))
    assert first == pytest.approx(0.2693, abs=5e-5)
    assert last < 0.02 * first


def test_a_header_that_is_edited_is_built_again_before_it_flies(project, law):
    before = (project.home / "RateLaw.fmu").read_bytes()
    law.write_text(law.read_text(encoding="utf-8").replace("= -k", "= -2.0 * k"), encoding="utf-8")
    assert project.adcs("run", "mission.py", "--no-report", "--out", "again").returncode == 0
    assert (project.home / "RateLaw.fmu").read_bytes() != before


def test_systems_of_a_package_are_found_by_name(project):
    pip = [project.environment / "bin" / "python", "-m", "pip", "--quiet", "--cache-dir", project.cache]
    subprocess.run([*pip, "install", "--no-deps", project.home], check=True, cwd=project.home)
    listed = json.loads(project.adcs("list", "--json").stdout)
    assert "spinning" in json.dumps(listed)
    elsewhere = project.home / "elsewhere"
    elsewhere.mkdir()
    ended = project.adcs("run", "spinning", "--json", "--no-report", folder=elsewhere)
    assert ended.returncode == 0, ended.stderr
    assert json.loads(ended.stdout)["outcome"]["status"] == "complete"


# Components of a package, entry points `adcs.components`, belong here as soon as there are such.

"""What needs a package that not everyone has says so in one line, or does without; see also tests/installed."""

import importlib

import pytest

import fmus
from adcs import AdcsError
from adcs.cli.app import main
from orchestration.results import plots


def test_without_lief_the_other_checks_are_made(built, monkeypatch):
    monkeypatch.setattr(importlib.import_module("fmus.check"), "find_spec", lambda name: None)
    (finding,) = fmus.check(built / "RigidBody.fmu")
    assert (finding.rule, finding.severity) == ("binaries", "note")
    assert finding.message == (
        "the binaries are not looked into, for lief is not installed: pip install 'adcs-fmus[build]'"
    )


def test_without_a_compiler_build_says_what_to_install(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("fmus.paths.DIST", tmp_path)
    for module in ("fmus.toolchain", "adcs.cli.build"):
        monkeypatch.setattr(importlib.import_module(module), "is_installed", lambda: False)
    monkeypatch.setattr("sys.argv", ["adcs", "build", "RigidBody"])
    with pytest.raises(SystemExit, match="1"):
        main()
    assert capsys.readouterr().err == (
        "adcs: RigidBody.fmu is not built, and no compiler is installed to build it: pip install 'adcs-fmus[build]'\n"
    )


def test_an_installation_from_sources_without_a_compiler_is_told_of_the_wheel(monkeypatch, tmp_path):
    monkeypatch.setattr("fmus.paths.DIST", tmp_path)
    monkeypatch.setattr("fmus.toolchain.CHECKOUT", None)
    monkeypatch.setattr("fmus.toolchain.is_installed", lambda: False)
    way_out = "pip install 'adcs-fmus[build]', or install the wheel, which carries this project's components compiled"
    with pytest.raises(AdcsError) as refused:
        fmus.fmu_path("RigidBody")
    assert str(refused.value) == f"RigidBody.fmu is not built, and no compiler is installed to build it: {way_out}"
    with pytest.raises(AdcsError) as refused:
        fmus.build(["RigidBody"])
    assert str(refused.value) == f"no compiler is installed: {way_out}"
    monkeypatch.setattr("fmus.toolchain.CARRIED", tmp_path)  # which a wheel has
    with pytest.raises(AdcsError, match=r"no compiler is installed: pip install 'adcs-fmus\[build\]'$"):
        fmus.build(["RigidBody"])


def test_without_a_compiler_build_shows_what_is_there(monkeypatch, capsys):
    there = fmus.fmu_path("RigidBody")
    for module in ("fmus.toolchain", "adcs.cli.build"):
        monkeypatch.setattr(importlib.import_module(module), "is_installed", lambda: False)
    monkeypatch.setattr("sys.argv", ["adcs", "build", "RigidBody", "--json"])
    main()
    assert str(there) in capsys.readouterr().out


def test_without_matplotlib_there_is_no_picture(monkeypatch):
    assert plots.can_draw()
    monkeypatch.setattr(plots, "find_spec", lambda name: None)
    assert not plots.can_draw()
    with pytest.raises(AdcsError, match=r"Matplotlib, which is not installed: pip install 'adcs-fmus\[plot\]'$"):
        plots.make_figure([])

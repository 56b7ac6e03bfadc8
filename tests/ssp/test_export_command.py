"""`adcs export`."""

from __future__ import annotations

import pytest

from adcs import AdcsError, read_ssp, write_ssp
from adcs.catalogue import SYSTEMS
from adcs.cli.app import app
from tests.invoking import invoke


@pytest.fixture
def export(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        result = invoke(app, ["export", *arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        assert result.exit_code == 0, result.output
        return result.output

    return call


def test_a_system_by_name(export):
    printed = export("observer-pd", "--ssp")
    assert printed.startswith("observer-pd.ssp: 5 components, 9 connections, ")
    file = read_ssp("observer-pd.ssp")
    assert (file.stop_time, file.step, file.version) == (100.0, 0.01, "1.0")
    assert file.system.connections == SYSTEMS["observer-pd"].build().connections


def test_into_a_file_with_settings(export):
    export(
        "observer-pd",
        "--ssp",
        "a/b.ssp",
        "--fmi",
        "3",
        "--set",
        "tracker.half_angle=2deg",
        "--step",
        "0.1",
        "--stop",
        "7",
    )
    file = read_ssp("a/b.ssp")
    assert (file.stop_time, file.step, file.version) == (7.0, 0.1, "2.0")
    assert file.system.components["tracker"].start["half_angle"] == pytest.approx((0.0349065850398866,), rel=1e-14)


def test_from_a_file_into_another(export):
    export("observer-pd", "--ssp", "a.ssp")
    export("a.ssp", "--ssp", "b.ssp", "--set", "tracker.seed=9")
    assert read_ssp("b.ssp").system.components["tracker"].start["seed"] == (9,)
    assert read_ssp("b.ssp").step == 0.01


def test_a_file_that_is_there_is_replaced_only_if_it_is_asked_for(export, tmp_path):
    (tmp_path / "observer-pd.ssp").write_text("mine")
    with pytest.raises(AdcsError) as error:
        export("observer-pd")
    said = "observer-pd.ssp is there already: give another name, or "
    assert str(error.value) == f"{said}--force to replace it"
    with pytest.raises(AdcsError) as error:
        write_ssp("observer-pd", "observer-pd.ssp")
    assert str(error.value) == f"{said}force=True to replace it"
    assert (tmp_path / "observer-pd.ssp").read_text() == "mine"
    export("observer-pd", "--force")
    assert read_ssp("observer-pd.ssp").step == 0.01
    write_ssp("observer-pd", "observer-pd.ssp", step=0.5, force=True)
    assert read_ssp("observer-pd.ssp").step == 0.5
    assert [path.name for path in tmp_path.iterdir()] == ["observer-pd.ssp"]


def test_a_file_is_replaced_whole_or_not_at_all(export, tmp_path, monkeypatch):
    def full(*given):
        raise OSError(28, "No space left on device")

    (tmp_path / "x.ssp").write_text("mine")
    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(AdcsError, match=r"^cannot write x\.ssp: No space left on device$"):
        export("observer-pd", "x.ssp", "--force")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("x.ssp", "mine")]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nonsense"], "no system 'nonsense': `adcs list` shows all; or give an .ssp, .py or .fmu file"),
        (["observer-pd", "--ssp", "x.zip"], "x.zip does not end in .ssp: write adcs export observer-pd x.ssp"),
        (["x.ssp"], "say where to: adcs export x.ssp FILE.ssp"),
        (["x.ssp", "y.ssp"], "cannot open x.ssp"),
        (["x.ssp", "y.ssp", "--fmi", "3"], "the FMUs in x.ssp stay as they are"),
        (["observer-pd", "--set", "tracker.seed"], "--set tracker.seed: expected COMPONENT.VARIABLE=VALUE"),
        (["observer-pd", "--set", "tracker.sed=1"], "has no variable 'sed'"),
        (["observer-pd", "--step", "-1"], "step = -1.0: expected a positive number"),
    ],
)
def test_slips_are_named(export, arguments, message):
    with pytest.raises(AdcsError) as caught:
        export(*arguments)
    assert message in str(caught.value)

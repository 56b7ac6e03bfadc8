"""fmiVersion: a patch and a minor version of 3 are read as 3.0, everything else is refused, by the check as well."""

import importlib
import logging

import pytest

import fmus
from adcs import AdcsError, run
from adcs.cli.app import app
from fmus.check import check
from orchestration.fmu.file import open_fmu
from orchestration.single import single
from tests.invoking import invoke

from .small import changed, description2, description3, packed

MINOR = "is FMI 3.1: it is read as 3.0, to which a minor version adds only what may be ignored"


@pytest.fixture
def of_version(tmp_path):
    source = fmus.fmu_path("PdTracking", "3.0")
    return lambda text: changed(source, tmp_path / "c.fmu", ('fmiVersion="3.0"', f'fmiVersion="{text}"'))


@pytest.mark.parametrize("text", ["3.0", "3.0.1", "3.0.17", "3.1", "3.1.2", "3.12"])
def test_a_version_3_runs_as_3_0(of_version, text, caplog):
    path = of_version(text)
    system = single(path)
    result = run(system, stop_time=0.2, step=0.1)
    reference = run(single(fmus.fmu_path("PdTracking", "3.0")), stop_time=0.2, step=0.1)
    assert (result.data == reference.data).all()
    assert [r.message for r in caplog.records] == (
        [] if text.startswith("3.0") else [f"c.fmu {MINOR}".replace("3.1", text, 1)]
    )
    (component,) = result.manifest["system"]["components"].values()
    assert component["fmi_version"] == text


def test_the_warning_of_a_minor_version_comes_once(of_version, caplog):
    path = of_version("3.1")
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            open_fmu(path)
    assert [record.message for record in caplog.records] == [f"c.fmu {MINOR}"]


def test_info_shows_the_version_of_the_file(of_version):
    shown = invoke(app, ["info", str(of_version("3.0.1"))])
    assert shown.exit_code == 0
    assert "FMI 3.0.1, " in shown.output


@pytest.mark.parametrize("text", ["2.1", "2.0.4", "2", "3", "4.0", "3.01", "3.0.01", "3.0.1.2", "03.0", "3.x", ""])
def test_other_versions_are_refused(tmp_path, text):
    xml = description2 if text.startswith("2") else description3
    with pytest.raises(AdcsError) as error:
        open_fmu(packed(tmp_path / "c.fmu", xml("", version=text)))
    assert str(error.value) == f"{tmp_path}/c.fmu is FMI {text}: only 2.0 and 3.0 are supported"


@pytest.mark.parametrize("text", ["3.0-beta.2", "3.0.1-rc.1", "3.1-alpha.1"])
def test_pre_releases_are_refused(tmp_path, text):
    with pytest.raises(AdcsError) as error:
        open_fmu(packed(tmp_path / "c.fmu", description3("", version=text)))
    assert str(error.value) == f"{tmp_path}/c.fmu is FMI {text}, a pre-release: only 2.0 and 3.0 are supported"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("3.0.1", []),
        ("3.1", [("note", f"fmiVersion: it {MINOR}")]),
        ("3.0-beta.2", [("fault", "fmiVersion: it is FMI 3.0-beta.2, a pre-release: only 2.0 and 3.0 are supported")]),
    ],
)
def test_the_check_agrees(of_version, text, found, monkeypatch):
    monkeypatch.setattr(importlib.import_module("fmus.check"), "check_behaviour", lambda path: iter(()))
    findings = [(f.severity, f.message) for f in check(of_version(text)) if f.message.startswith("fmiVersion")]
    assert findings == found

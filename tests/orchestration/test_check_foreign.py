"""`adcs check` of FMUs of other origin: no false alarms, and still the true ones."""

from __future__ import annotations

from pathlib import Path

import event_fmus
import foreign_fmus
import pytest

import fmus
from fmus.checks.binary import needed_functions

SLAVES = Path(__file__).parent / "slaves"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("foreign")


def faults(path: Path) -> list[str]:
    return [finding.message for finding in fmus.check(path) if finding.severity == "fault"]


def notes(path: Path) -> list[str]:
    return [finding.message for finding in fmus.check(path) if finding.severity == "note"]


@pytest.mark.parametrize(
    ("model", "version"),
    [
        ("types", "2.0"),  # co-simulation only; texts
        ("types", "3.0"),
        ("clocks", "3.0"),  # input clocks, clocked variables
        ("latch", "3.0"),  # cannot be instantiated without event mode
        ("bouncer", "3.0"),  # nor without early return
        ("sizes", "3.0"),
    ],
)
def test_nothing_is_wrong_with_what_is_good(folder, model, version):
    path = foreign_fmus.build(model, folder, version)
    assert faults(path) == []
    assert all("wrong token" in note for note in notes(path))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_nor_with_model_exchange_only(folder, version):
    path = event_fmus.build("bouncing_ball", folder, version)
    assert faults(path) == []
    assert notes(path) == ["ModelExchange can be instantiated with a wrong token"]


def test_a_tool_that_is_missing_is_a_note(folder):
    (note,) = notes(foreign_fmus.build("tool", folder))
    assert "needs the tool that made it" in note
    assert "no licence" in note
    assert faults(foreign_fmus.build("tool", folder)) == []


def test_what_python_fmu_makes(folder):
    builder = pytest.importorskip("pythonfmu.builder").FmuBuilder
    builder.build_FMU(SLAVES / "late_slave.py", dest=folder)
    (fault,) = faults(folder / "LateSlave.fmu")  # which is one: FMI 2.0 asks for initial unknowns
    assert fault.startswith("ModelStructure/InitialUnknowns does not contain the expected set of variables")
    found = notes(folder / "LateSlave.fmu")
    assert "CoSimulation can be instantiated with a wrong token" in found
    assert "binaries/linux64/LateSlave.so needs libstdc++.so.6, which may not be installed" in found


@pytest.mark.parametrize(("version", "count"), [("2.0", 44), ("3.0", 75)])
def test_functions_of_interfaces(version, count):
    kinds = ("ModelExchange", "CoSimulation", "ScheduledExecution")
    assert len(needed_functions(version, kinds)) == count
    major = version[0]
    only = {kind: needed_functions(version, {kind}) for kind in kinds}
    assert f"fmi{major}DoStep" in only["CoSimulation"] - only["ModelExchange"]
    assert f"fmi{major}SetTime" in only["ModelExchange"] - only["CoSimulation"]
    assert f"fmi{major}GetVersion" in only["ModelExchange"] & only["CoSimulation"]
    if version == "2.0":
        assert (len(only["CoSimulation"]), len(only["ModelExchange"])) == (34, 35)

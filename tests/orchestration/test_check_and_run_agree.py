"""What a run refuses, a check finds; what a run takes, a check calls no fault unless a standard does."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from odd_fmus import GOOD, REFUSED, STRICTER, Odd

from adcs import AdcsError, run
from adcs.catalogue import find_system
from fmus.checks.behaviour import report
from orchestration import checking
from orchestration.fmu.file import open_fmu
from orchestration.running.method import method_of


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("odd")


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process of its own for each takes a second; none of these harms this one."""
    monkeypatch.setattr(checking, "check_behaviour", lambda path, module: checking.behaviour(path))


def refusals(path: Path) -> list[str]:
    """What a run of the file says with its own times, by each of its interfaces."""
    said = []
    try:
        model = open_fmu(path).model
        for kind, there in (("co-simulation", model.coSimulation), ("model-exchange", model.modelExchange)):
            if there or (kind == "co-simulation" and not model.modelExchange):
                entry = find_system(str(path))
                times = {"start_time": entry.start_time, "stop_time": entry.stop_time, "step": entry.step}
                try:
                    run(
                        entry.build(),
                        **times,
                        method=method_of(kind),
                    )
                except AdcsError as error:
                    said.append(str(error))
    except AdcsError as error:
        said.append(str(error))
    return said


def found(path: Path, severity: str) -> list[str]:
    return [finding.message for finding in checking.check(path) if finding.severity == severity]


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("odd", GOOD, ids=lambda odd: odd.name)
def test_what_a_run_takes_is_no_fault(folder: Path, odd: Odd) -> None:
    path = odd.build(folder)
    assert refusals(path) == []
    assert found(path, "fault") == []


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("odd", STRICTER, ids=lambda odd: odd.name)
def test_what_a_standard_forbids_is_a_fault_though_a_run_takes_it(folder: Path, odd: Odd) -> None:
    path = odd.build(folder)
    assert refusals(path) == []
    assert any(odd.check in message for message in found(path, "fault"))


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("odd", REFUSED, ids=lambda odd: odd.name)
def test_what_a_run_refuses_is_found(folder: Path, odd: Odd) -> None:
    path = odd.build(folder)
    said = refusals(path)
    assert any(odd.run in text for text in said), said
    findings = found(path, "note" if odd.note else "fault")
    assert any((odd.check or odd.run) in message for message in findings), findings
    if odd.note:
        assert found(path, "fault") == []


@pytest.mark.skipif(os.name == "nt", reason="the loader of Windows does not crash")
def test_a_library_that_crashes_the_loader_is_found(folder: Path) -> None:
    path = Odd("library cut off", "types", "3.0", library=lambda content: content[:2000]).build(folder)
    (message,) = [f.message for f in checking.check(path) if f.rule == "behaviour" and f.severity == "fault"]
    assert message.startswith(("CoSimulation: instantiating ended the process: SIG", "CoSimulation cannot be instant"))


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("deed", "message"),
    [
        ("segfault_instantiate", "ModelExchange: instantiating ended the process: SIGSEGV, a segmentation fault"),
        ("exit_initialise", "ModelExchange: initialising ended the process: exit code 0"),
        ("quit_terminate", "ModelExchange: terminating ended the process: exit code 0"),
        ("kill_free", "ModelExchange: freeing ended the process: SIGKILL, from outside, as for lack of memory"),
        (
            "segfault_doStep",
            "a run by co-simulation ends: hostile failed at t = 0 s: doStep ended the process: SIGSEGV, a segmentation "
            "fault; 1 rows are kept",
        ),
        (
            "segfault_setTime",
            "a run by model-exchange ends: hostile failed at t = 0 s: setTime ended the process: SIGSEGV, a "
            "segmentation fault; 0 rows are kept",
        ),
        ("hang_terminate", "ModelExchange: terminating does not end within 8 s"),
    ],
)
def test_what_ends_the_process_is_named(mock, deed, message, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ADCS_DEED", deed)
    if deed.startswith("hang"):
        monkeypatch.setattr("fmus.checks.behaviour._SECONDS", 8)
    (fault,) = [f for f in checking.check(mock("hostile")) if f.rule == "behaviour" and f.severity == "fault"]
    assert fault.message == message


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("version", ["3.0.1", "3.1"])
def test_a_later_version_is_judged_alike(folder: Path, version: str) -> None:
    odd = Odd(
        f"version {version}", "types", "3.0", lambda xml: xml.replace('fmiVersion="3.0"', f'fmiVersion="{version}"')
    )
    path = odd.build(folder)
    assert bool(refusals(path)) == bool(found(path, "fault"))


def test_findings_cross_to_another_process_by_kind(capsys: pytest.CaptureFixture[str]) -> None:
    from fmus.checks import Note

    report(iter([Note("a\nnote"), "a fault"]))
    assert capsys.readouterr().out == "note: a note\nfinding: a fault\nfrom here on: all was looked at\n"

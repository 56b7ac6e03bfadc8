"""Full disks, two runs in one folder, what killed runs leave behind: files are whole, or the old ones, or none."""

from __future__ import annotations

import json
import os
import subprocess
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest
from hostile import adcs, as_file, system

from adcs import AdcsError, RunFailed, Save, checkpoint, run
from fmus.lock import Lock
from orchestration.isolation import journal
from orchestration.isolation.folder import ResultsFolder
from orchestration.isolation.journal import Journal
from orchestration.process import temporary
from orchestration.process.disk import Disk
from orchestration.process.temporary import temporary_folder
from orchestration.process.writing import replacing

FULL = "No space left on device"


@pytest.fixture
def small_disk(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Path]:
    """A disk of 512 kB, or of as many as an indirect parameter says."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={getattr(request, 'param', 512)}k", "tmpfs", str(disk)]
    try:
        subprocess.run(mount, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("only root can make a small disk, on Linux")
    yield disk
    subprocess.run(["umount", "-l", str(disk)], check=True)


def test_a_full_disk_is_one_line_for_every_writer_and_leaves_no_half_file(chain, small_disk):
    result = run(chain(), stop_time=100, step=0.01)
    (small_disk / "result.csv").write_text("old")
    for kind in ("csv", "mat", "hdf5"):
        path = small_disk / f"result.{kind}"
        with pytest.raises(AdcsError, match=f"^cannot write {path}: {FULL}$"):
            getattr(result, f"write_{kind}")(path)
    assert [file.name for file in small_disk.iterdir()] == ["result.csv"]
    assert (small_disk / "result.csv").read_text() == "old"
    with (small_disk / "filler").open("wb", buffering=0) as filler, suppress(OSError):
        while True:
            filler.write(bytes(1024))
    with pytest.raises(AdcsError, match=f"manifest.json: {FULL}$"):
        result.write_manifest(small_disk / "manifest.json")
    with pytest.raises(AdcsError, match=f"small.h5: {FULL}$"):
        run(chain(), stop_time=1, step=0.5).write_hdf5(small_disk / "small.h5")


@pytest.mark.parametrize(("small_disk", "pages"), [(512, 124), (256, 60), (128, 28)], indirect=["small_disk"])
@pytest.mark.parametrize("stop", [100, 10_000])
def test_a_disk_that_fills_up_ends_a_run_with_the_rows_that_fitted(chain, small_disk, pages, stop):
    """However long it was to be: all pages of 4096 bytes but four, for what the run is and how it came out."""
    full = Journal(small_disk / "run.journal")
    with pytest.raises(RunFailed) as failed:
        run(chain(), stop_time=stop, step=0.01, save=Save(to=full))
    result = failed.value.result
    n = len(result.time)
    assert str(failed.value) == (
        f"no room for another row at t = {0.01 * n:.9g} s in {full.path}: {FULL}; {n} rows are kept"
    )
    assert n == pages * 4096 // (12 * 8)  # 12 numbers a row
    expected = run(chain(), stop_time=100, step=0.01)
    assert np.array_equal(result.data, expected.data[:n])
    kept = journal.read(full.path)
    assert np.array_equal(kept.times, expected.time[:n])
    assert (kept.failure["component"], kept.failure["time"]) == (None, 0.01 * n)


@pytest.mark.parametrize(("record", "rows"), [(["source.y"], 23 * 512), (None, 6 * 512)])
def test_hdf5_as_rows_come_keeps_what_fits(chain, small_disk, record, rows):
    path = small_disk / "result.h5"
    with pytest.raises(RunFailed, match=f"^cannot write {path}: {FULL}; "):
        run(chain(), stop_time=1000, step=0.01, save=Save(record, to=path))
    with h5py.File(path) as file:
        n = len(file["time"])
        assert file["source/y"].shape == (n, 3)
        assert json.loads(file["manifest"][()])["outcome"]["rows"] == n
    assert n == rows  # 25 or 102 bytes a row and 8 for its time, in 384 kB


@pytest.mark.parametrize("small_disk", [100], indirect=True)
def test_hdf5_as_rows_come_leaves_no_file_where_no_row_has_room(chain, small_disk):
    path = small_disk / "result.h5"
    with pytest.raises(RunFailed, match=f"^cannot write {path}: {FULL}; 0 rows are kept$") as failed:
        run(chain(), stop_time=1000, step=0.01, save=Save(["source.y"], to=path))
    assert failed.value.result["source.y"].shape == (0, 3)
    assert list(small_disk.iterdir()) == []


@pytest.mark.parametrize("small_disk", [100], indirect=True)
def test_a_component_that_fails_on_a_full_disk_is_still_what_is_told(faulty, small_disk):
    with pytest.raises(RunFailed, match=r"^wheel failed at t = 0\.5 s: .*; 0 rows are kept$") as failed:
        run(faulty("2.0", 1), stop_time=1, step=0.25, save=Save(to=small_disk / "result.h5"))
    assert failed.value.result.manifest["warnings"] == [f"cannot write {small_disk}/result.h5: {FULL}"]


def test_an_isolated_run_keeps_the_rows_that_its_file_has_no_room_for(chain, small_disk):
    path = small_disk / "result.h5"
    with pytest.raises(RunFailed) as failed:
        run(chain(), stop_time=100, step=0.01, save=Save(to=path), isolated=True)
    assert str(failed.value) == f"cannot write {path}: {FULL}; 10001 rows are kept"
    result = failed.value.result
    assert np.array_equal(result["integrator.y"], run(chain(), stop_time=100, step=0.01)["integrator.y"])
    assert result.manifest["outcome"]["message"] == f"cannot write {path}: {FULL}"
    assert list(small_disk.iterdir()) == []
    with pytest.raises(AdcsError, match=f"^cannot write {small_disk}: it is a folder$"):
        run(chain(), stop_time=100, step=0.01, save=Save(to=small_disk), isolated=True)


def test_hdf5_closes_in_peace_when_a_write_fails(tmp_path, monkeypatch):
    disk = Disk(tmp_path / "x.h5")
    file = h5py.File(disk, "w")
    file["values"] = np.arange(100.0)
    file.flush()

    def full(number, content):
        raise OSError(28, FULL)

    monkeypatch.setattr(os, "write", full)
    file["more"] = np.arange(100_000.0)
    assert file["more"][99_999] == 99_999.0  # also when it is read again
    file.close()
    with pytest.raises(AdcsError, match=FULL):
        disk.close()


def test_the_command_line_keeps_rows_that_no_file_has_room_for(mock, small_disk, tmp_path):
    as_file(mock, tmp_path, "fine_never")
    options = ("--stop", 80, "--step", 0.01, "--format", "csv", "--out", small_disk / "out", "--no-report")
    code, _, err = adcs("run", "fine_never.ssp", *options, cwd=tmp_path)
    assert code == 1
    out = small_disk / "out"
    assert f"cannot write {out}/result.csv: {FULL}; 8001 rows are kept in {out}: make room, then `adcs recover" in err
    assert len(err.splitlines()) == 1
    subprocess.run(["mount", "-o", "remount,size=4m", str(small_disk)], check=True)
    code, _, err = adcs("recover", out, cwd=tmp_path)
    assert code == 0, err
    assert len((out / "result.csv").read_text().splitlines()) == 8002
    assert json.loads((out / "manifest.json").read_text())["outcome"]["status"] == "complete"


@pytest.mark.parametrize("small_disk", [256], indirect=True)
def test_why_a_run_ended_is_told_by_the_line_the_manifest_and_what_is_recovered(mock, small_disk, tmp_path):
    as_file(mock, tmp_path, "fine_never")
    out = small_disk / "out"
    options = ("--stop", 1000, "--step", 0.01, "--format", "csv", "--out", out, "--no-report")
    code, _, err = adcs("run", "fine_never.ssp", *options, cwd=tmp_path)
    kept = len(journal.read(out / journal.NAME).times)
    assert kept > 5000
    reason = f"no room for another row at t = {0.01 * kept:.9g} s in {out}/run.journal: {FULL}"
    assert (code, err) == (
        1,
        f"adcs: {reason}; cannot write {out}/result.csv: {FULL}; {kept} rows are kept in {out}: make room, then "
        f"`adcs recover {out}`\n",
    )
    outcome = {"status": "failed", "component": None, "time": 0.01 * kept, "message": reason, "rows": kept}
    assert json.loads((out / "manifest.json").read_text())["outcome"] == outcome
    subprocess.run(["mount", "-o", "remount,size=4m", str(small_disk)], check=True)
    code, _, err = adcs("recover", out, cwd=tmp_path)
    assert (code, err) == (0, f"adcs: {reason}; {kept} rows are kept\n")
    assert json.loads((out / "manifest.json").read_text())["outcome"] == outcome
    assert len((out / "result.csv").read_text().splitlines()) == kept + 1


@pytest.mark.parametrize("small_disk", [12, 40], indirect=True)
def test_a_manifest_without_room_for_another_does_not_say_that_the_run_goes_on(small_disk, tmp_path):
    options = ("--stop", 20, "--format", "csv", "--out", small_disk / "out", "--no-report")
    code, _, err = adcs("run", "observer-pd", *options, cwd=tmp_path)
    assert code == 1
    assert len(err.splitlines()) == 1
    assert json.loads((small_disk / "out" / "manifest.json").read_text())["outcome"]["status"] == "failed"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_checkpoints_that_cannot_be_written_are_one_line_and_the_run_goes_on(capfd, tmp_path):
    from benchmarks import loop

    common = {"stop_time": 1, "step": 0.01}
    result = run(loop.system(), **common, hooks=[checkpoint("/dev/full", every=0.3)])
    told = f"cannot write /dev/full: {FULL}"
    assert capfd.readouterr().err == f"adcs: a checkpoint is missing, the run goes on: {told}\n"
    assert result.manifest["warnings"] == [f"no checkpoint at t = 0.3, 0.6, 0.9, ... s: {told}"]
    assert result.manifest["outcome"] == {"status": "complete", "rows": 101}
    assert np.array_equal(result.data, run(loop.system(), **common).data)
    with pytest.raises(AdcsError, match=f"^checkpoint = {tmp_path}: it is a folder: give the name of a file in it$"):
        run(loop.system(), **common, hooks=[checkpoint(tmp_path)])


def test_links_in_a_results_folder_are_replaced_and_not_followed(chain, tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    for name in ("result.csv", "result.mat", "result.h5", "manifest.json"):
        (out / name).symlink_to(victim)
    result = run(chain(), stop_time=1, step=0.5)
    result.write_csv(out / "result.csv")
    result.write_mat(out / "result.mat")
    result.write_hdf5(out / "result.h5")
    result.write_manifest(out / "manifest.json")
    assert victim.read_text() == "mine"
    assert not any(file.is_symlink() for file in out.iterdir())
    (out / "run.lock").symlink_to(victim)
    with pytest.raises(AdcsError, match=r"^cannot write to "), ResultsFolder(out):
        pass
    (out / "run.lock").unlink()
    (out / journal.NAME).symlink_to(victim)
    (out / "previous").symlink_to(tmp_path)
    with ResultsFolder(out) as folder:
        folder.clear()
    assert victim.read_text() == "mine"
    assert {file.name for file in out.iterdir()} == {"previous"}


def test_a_folder_is_of_one_run_at_a_time_and_a_dead_one_holds_nothing(tmp_path):
    with (
        ResultsFolder(tmp_path),
        pytest.raises(AdcsError, match=rf"belongs to a run that goes on \(process {os.getpid()}\)"),
    ):
        ResultsFolder(tmp_path).__enter__()
    (tmp_path / "run.lock").write_text("1")  # of one that was killed
    with ResultsFolder(tmp_path):
        assert Lock(tmp_path / "run.lock").holder == str(os.getpid())
    assert list(tmp_path.iterdir()) == []


def test_recover_wants_the_folder(tmp_path):
    (tmp_path / "result.csv").write_text("")
    code, _, err = adcs("recover", "result.csv", cwd=tmp_path)
    assert (code, err) == (2, "adcs: result.csv is a file: give the folder of the results, .\n")


def test_rows_that_nobody_recovered_are_never_removed(tmp_path):
    for content in ("first", "second", "third"):
        with ResultsFolder(tmp_path) as folder:
            folder.clear()
            folder.journal.write_text(content)
    with ResultsFolder(tmp_path) as folder:
        folder.clear()
        folder.forget()
    kept = {file.read_text() for file in tmp_path.glob(f"previous*/{journal.NAME}")}
    assert kept == {"first", "second", "third"}


def test_temporary_folders_of_killed_runs_are_removed_later(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    dead = tmp_path / "adcs-fmu-1-abc"
    dead.mkdir()
    (dead / ".alive").write_text("1")
    (dead / "binary.so").write_text("")
    foreign = tmp_path / "adcs-fmu-1-def"  # without our mark
    foreign.mkdir()
    with temporary_folder("fmu") as living:
        assert not dead.exists()
        temporary._clear_up.cache_clear()
        with temporary_folder("fmu"):
            assert living.exists()
    assert [file.name for file in tmp_path.iterdir()] == [foreign.name]


@pytest.mark.parametrize("name", ["result.csv", "run.journal"])
def test_a_write_that_fails_leaves_the_old_file(tmp_path, name):
    path = tmp_path / name
    path.write_text("old")
    with pytest.raises(AdcsError, match=f"^cannot write {path}: {FULL}$"), replacing(path) as new:
        new.write_text("half")
        raise OSError(28, FULL)
    assert [file.read_text() for file in tmp_path.iterdir()] == ["old"]


@pytest.mark.parametrize("cut", [0, 10, 63, 64, 4095, 4096, 12_000])
def test_a_journal_that_is_cut_off_or_none_is_refused_in_one_line(chain, tmp_path, cut):
    whole = Journal(tmp_path / "run.journal")
    run(chain(), stop_time=1, step=0.5, save=Save(to=whole))
    whole.close()
    assert len(journal.read(whole.path).times) == 3
    content = whole.path.read_bytes()
    whole.path.write_bytes(content[:cut])
    with pytest.raises(AdcsError, match=f"^{whole.path} is "):
        journal.read(whole.path)


def test_a_library_that_is_cut_off_is_named(mock, tmp_path):
    """Mapped, but not there: the loader gets SIGBUS, or says so."""
    cut = tmp_path / "cut.fmu"
    with zipfile.ZipFile(mock("hostile")) as whole, zipfile.ZipFile(cut, "w") as archive:
        for name in whole.namelist():
            content = whole.read(name)
            archive.writestr(name, content[: len(content) // 3] if name.startswith("binaries/") else content)
    made = system(mock, "fine_never")
    made.add("cut", cut)
    with pytest.raises(AdcsError, match=r"^cut: (instantiating ended the process: SIG|cannot instantiate cut\.fmu)"):
        run(made, stop_time=1, step=0.5, isolated=True)

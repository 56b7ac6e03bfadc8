"""Components that end their process, hang, or change it for all; runs that are killed; disks that are full."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import mocks
import numpy as np
import scipy.io
from hostile import adcs, as_file, start, system, until

from adcs import AdcsError, CoSimulation, ModelExchange, Result, RunFailed, Save, run
from benchmarks import loop
from fmus.lock import Lock
from orchestration.isolation import journal
from orchestration.isolation.journal import Journal
from tests.robustness import Attack

DEATHS = ("segfault", "abort", "exit", "quit", "kill", "trap", "overflow")
CALLS = ("instantiate", "initialise", "get", "doStep", "terminate", "free")
CALLS_3 = ("instantiate", "initialise", "doStep", "free")
ROWS = {"get": 5, "doStep": 6, "setTime": 5, "terminate": 11, "free": 11}
TIMES: dict[str, Any] = {"stop_time": 1.0, "step": 0.1}
CHANGES = ("rounding", "denormals", "folder", "umask", "signals", "locale", "close", "print")


def _mock(folder: Path) -> Callable[..., Path]:
    return lambda model, version="2.0", **settings: mocks.build(model, folder, version, **settings)


def _judged(name: str, run_it: Callable[[], Result]) -> str:
    """Empty, if what came of it is what the name says, with the right rows; else what is wrong."""
    call = name.partition("_")[2]
    expected = ROWS.get(call, 0)
    try:
        result, text = run_it(), ""
        if expected != 11:
            return f"{name}: it was taken for a success"
        if not any(name in warning for warning in result.manifest["warnings"]):
            return f"{name}: no warning"
    except RunFailed as failed:
        result, text = failed.result, str(failed)
    except AdcsError as error:
        return "" if expected == 0 and str(error).startswith(f"{name}: ") else f"{name}: {error}"
    if text and not text.startswith(f"{name} failed at t = "):
        return f"{name}: {text}"
    right = np.array_equal(result[f"{name}.y"], 1 + result.time / 1000) and len(result.time) == expected
    return "" if right else f"{name}: {len(result.time)} rows"


def deaths(folder: Path) -> Iterator[str]:
    for version, calls in (("2.0", CALLS), ("3.0", CALLS_3)):
        for call in calls:
            for deed in DEATHS:
                name = f"{deed}_{call}"
                made = system(_mock(folder), name, version)
                yield _judged(name, lambda m=made, v=version: run(m, **TIMES, isolated=True, fmi_version=v))
    for deed in DEATHS:
        made = system(_mock(folder), f"{deed}_setTime")
        yield _judged(f"{deed}_setTime", lambda m=made: run(m, **TIMES, isolated=True, method=ModelExchange()))


def hangs(folder: Path) -> Iterator[str]:
    for deed in ("hang", "spin"):
        for call in CALLS:
            name = f"{deed}_{call}"
            made = system(_mock(folder), name)
            yield _judged(name, lambda m=made: run(m, **TIMES, isolated=True, method=CoSimulation(timeout=1.0)))
        made = system(_mock(folder), f"{deed}_setTime")
        yield _judged(
            f"{deed}_setTime", lambda m=made: run(m, **TIMES, isolated=True, method=ModelExchange(timeout=1.0))
        )


def files(folder: Path) -> Iterator[str]:
    """Every death in doStep, and every kind of file."""
    for deed in DEATHS:
        name = f"{deed}_doStep"
        as_file(_mock(folder), folder, name)
        options = [word for kind in ("csv", "mat", "hdf5") for word in ("--format", kind)]
        code, _, err = adcs("run", f"{name}.ssp", "--stop", 1, "--step", 0.1, "--out", name, *options, cwd=folder)
        out = folder / name
        expected = [1 + 0.1 * k / 1000 for k in range(6)]
        wrong = [] if code == 1 and f"adcs: {name} failed at t = 0.5 s" in err else [f"exit code {code}, {err}"]
        try:
            table = np.genfromtxt(out / "result.csv", delimiter=",", names=True, deletechars="")
            rows = {"csv": table[f"{name}.y[-]"].tolist()}
            rows["mat"] = scipy.io.loadmat(out / "result.mat", simplify_cells=True)[name]["y"].tolist()
            with h5py.File(out / "result.h5") as file:
                rows["hdf5"] = file[f"{name}/y"][:].tolist()
            status = json.loads((out / "manifest.json").read_text())["outcome"]["status"]
            wrong += [f"{kind}: {values}" for kind, values in rows.items() if values != expected]
            wrong += [] if status == "failed" else [status]
        except OSError as error:
            wrong.append(str(error))
        yield f"{name}: {'; '.join(wrong)}" if wrong else ""


def kills(folder: Path) -> Iterator[str]:
    """kill -9 at random times of the run, of its supervisor, of both."""
    rng = random.Random(1)
    as_file(_mock(folder), folder, "fine_never")
    options = ("--stop", 1000, "--step", 0.01, "--real-time", 1, "--no-report", "--format", "csv")
    for number in range(30):
        who = ("run", "supervisor", "both")[number % 3]
        out = f"out-{number}"
        process = start("run", "fine_never.ssp", *options, "--out", out, cwd=folder)
        until(lambda out=out: _rows(folder / out) > 0)
        time.sleep(rng.uniform(0, 1.0))
        before = _rows(folder / out)
        child = int(Lock(folder / out / "run.lock").holder)
        if who != "run":
            process.kill()
        if who != "supervisor":
            os.kill(child, signal.SIGKILL)
        process.communicate()
        until(lambda out=out: not _held(folder / out / "run.lock"))
        if who == "both":
            adcs("recover", out, cwd=folder)
        try:
            lines = (folder / out / "result.csv").read_text().splitlines()[1:]
            times = [float(line.split(",")[0]) for line in lines]
            right = len(times) >= before and times == [0.01 * k for k in range(len(times))]
            yield "" if right else f"{who}: {len(times)} rows of {before}"
        except OSError as error:
            yield f"{who}: {error}"


def _rows(folder: Path) -> int:
    try:
        return len(journal.read(folder / journal.NAME).times)
    except AdcsError:
        return 0


def _held(path: Path) -> bool:
    if not path.exists():
        return False
    lock = Lock(path)
    if lock.take():
        lock.release()
        return False
    return True


@contextmanager
def _disk(folder: Path, kilobytes: int) -> Iterator[Path]:
    place = folder / f"disk-{kilobytes}"
    place.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", place], check=True)
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", place], check=True)


def disks(folder: Path) -> Iterator[str]:
    """Every writer on disks of many sizes; needs root."""
    if os.name != "posix" or os.getuid() != 0:
        return
    whole = run(loop.system(), stop_time=100, step=0.01)
    for kilobytes in [4, 8, 16, 64, 150, 300, 450, 600, 900, 1200, 1600, 1700, 1800, 2000, 2500, 3500]:
        with _disk(folder, kilobytes) as disk:
            for kind in ("csv", "mat", "hdf5", "manifest"):
                path = disk / f"result.{kind}"
                try:
                    getattr(whole, f"write_{kind}")(path)
                    size = path.stat().st_size
                    yield "" if size > 1000 else f"{kind} on {kilobytes} kB: {size} bytes"
                except AdcsError as error:
                    left = [file.name for file in disk.iterdir()]
                    yield (
                        f"{kind} on {kilobytes} kB: {error}, {left}"
                        if left or "No space left" not in str(error)
                        else ""
                    )
                path.unlink(missing_ok=True)
            for name, more in (
                ("journal", {"save": Save(to=Journal(disk / "run.journal"))}),
                ("hdf5", {"save": Save(to=disk / "r.h5")}),
            ):
                result: Result | None = None
                try:
                    result = run(loop.system(), stop_time=100, step=0.01, **more)
                except RunFailed as failed:
                    result = failed.result
                except AdcsError as error:
                    yield "" if "No space left" in str(error) else f"{name} on {kilobytes} kB: {error}"
                    continue
                n = len(result.time)
                same = all(np.array_equal(result[each], whole[each][:n]) for each in whole.names)
                yield "" if same else f"{name} on {kilobytes} kB: other values in {n} rows"


def changes(folder: Path) -> Iterator[str]:
    """In doStep, isolated; what another component computes must not change by a bit."""
    alone = run(loop.system(), **TIMES)
    for stepping in ("compiled", "python"):
        for deed in CHANGES:
            name = f"{deed}_doStep"
            made = loop.system()
            made.add(name, _mock(folder)("hostile"))
            try:
                result = run(made, **TIMES, method=CoSimulation(stepping=stepping), isolated=True)
            except AdcsError as error:
                yield f"{name}: {error}"
                continue
            same = np.array_equal(result["plant.q_BN"], alone["plant.q_BN"])
            told = any(name in warning for warning in result.manifest["warnings"]) or deed in ("print", "locale")
            yield "" if same and told else f"{name}, {stepping}: same {same}, {result.manifest['warnings']}"


ATTACKS = [
    Attack(
        "components that end their process: 7 ways, in every call from instantiating to freeing, both FMI versions and "
        "Model Exchange",
        "call and component named, all rows up to it kept with the right values; at the very end a warning",
        deaths,
    ),
    Attack("calls that hang, asleep or busy, in every call", "given up by `timeout`, named, rows kept", hangs),
    Attack(
        "components that end their process in `adcs run`, 7 ways",
        "one line, exit code 1; CSV, MAT and HDF5 with the right rows",
        files,
    ),
    Attack(
        "kill -9 at random times: of the run, of its supervisor, of both",
        "all rows up to the kill in `result.csv`, for both by `adcs recover`",
        kills,
    ),
    Attack(
        "full disks of 16 sizes: CSV, MAT, HDF5, manifest, journal, HDF5 as rows come",
        "one line and no half file; rows that fitted with the right values",
        disks,
    ),
    Attack(
        "components that change the process: 8 ways, both loops",
        "named, but for locale and printing; not a bit of another component's result changes",
        changes,
    ),
]

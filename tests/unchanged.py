"""Whether numbers are what they were: digests of all results, taken before and after a change that must not touch them.

    python -m tests.unchanged before.json                      # in the old tree: writes the digests
    python -m tests.unchanged after.json --against before.json   # in the new one: names what differs

They are taken of `result.csv` of each registered system and of `--json` of each study, by the command of this tree.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

STUDIES = ["deruiter", "six-dof", "thakur", "trigo", "velocity-free"]
ADCS = [sys.executable, "-m", "adcs"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="where the digests are written")
    parser.add_argument("--against", type=Path, help="digests that were written before")
    parser.add_argument("--only", choices=("systems", "studies"), help="one half of them")
    parser.add_argument("--jobs", type=int, default=2, help="how many runs side by side")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        found = dict(pool.map(lambda work: work(), _works(options.only, Path(folder))))
    options.file.write_text(json.dumps(dict(sorted(found.items())), indent=1) + "\n")
    if options.against:
        before = json.loads(options.against.read_text())
        differ = [name for name in found | before if found.get(name) != before.get(name)]
        differ = [name for name in differ if not options.only or name in found]
        for name in differ:
            print(f"{name}: {before.get(name, 'not there')[:12]} before, {found.get(name, 'not there')[:12]} now")
        print(f"{len(found) - len([n for n in differ if n in found])} of {len(found)} are what they were")
        sys.exit(bool(differ))


def _works(only: str | None, folder: Path) -> Iterator[Callable[[], tuple[str, str]]]:
    if only != "systems":
        for name in STUDIES:
            yield lambda name=name: _timed(f"study {name}", lambda: _study(name, folder))
    if only != "studies":
        listed = json.loads(_output("list", "--json"))
        for name in sorted(system["name"] for system in listed["systems"]):
            yield lambda name=name: _timed(f"system {name}", lambda: _system(name, folder))


def _timed(name: str, digest: Callable[[], str]) -> tuple[str, str]:
    began = time.monotonic()
    found = digest()
    print(f"{time.monotonic() - began:7.1f} s  {found[:12]}  {name}", flush=True)
    return name, found


def _system(name: str, folder: Path) -> str:
    out = folder / name
    _output("run", name, "--out", str(out), "--no-report", "--format", "csv")
    return hashlib.sha256((out / "result.csv").read_bytes()).hexdigest()


def _study(name: str, folder: Path) -> str:
    return hashlib.sha256(_output("study", name, "--json", "--out", str(folder / f"study-{name}"))).hexdigest()


def _output(*arguments: str) -> bytes:
    done = subprocess.run([*ADCS, *arguments], capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(f"adcs {' '.join(arguments)}: {done.stderr.decode(errors='replace').strip()}")
    return done.stdout


if __name__ == "__main__":
    main()

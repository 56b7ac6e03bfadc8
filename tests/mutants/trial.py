"""A component's mutants, compiled one after the other and given to the law's own test."""

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from multiprocessing import get_context
from pathlib import Path

from fmus import catalog
from fmus.build import ADAPTOR, build
from fmus.freshness import keep_record, read_record
from fmus.paths import BUILD, DIST, SOURCES
from fmus.toolchain import UNOPTIMISED, NotCompiled, compile_step, header_step, host, link_step, run_steps
from references.answers import LAWS, SAMPLED
from tests.laws import at_points
from tests.one_fmu import unpacked
from tests.sanitized import swap_binary

from . import report
from .changes import Mutant, chosen, unchanged
from .explained import reason
from .report import Outcome, Survivor

WORK = BUILD / "mutants"
TESTS = Path(at_points.__file__).parent
LIMIT = 60.0
"""Seconds after which a test that does not end has seen the mistake."""


def own_headers(header: Path) -> list[Path]:
    """A component's header, and those beside it that several components share."""
    found = [header]
    for path in found:
        for name in re.findall(r'#include "((?!fmi|math|attitude)[\w/]+\.hpp)"', path.read_text(encoding="utf-8")):
            other = SOURCES / name
            if other not in found and "declare(" not in other.read_text(encoding="utf-8"):
                found.append(other)
    return found


def library(name: str, include: str, mutant: Mutant) -> Path:
    """The mutant's binary, not optimised, which is quicker; NotCompiled if it is no C++."""
    place = WORK / name
    changed = place / mutant.header.relative_to(SOURCES)
    changed.parent.mkdir(parents=True, exist_ok=True)
    for old in place.rglob("*.hpp"):
        old.unlink()
    changed.write_text(mutant.text, encoding="utf-8")
    model = place / "model.cpp"
    model.write_text(f'#include "{include}"\n#include "fmi/export.hpp"\n\nADCS_EXPORT({name})\n', encoding="utf-8")
    target = host()
    begin = header_step(SOURCES / "fmi" / "export.hpp", WORK / "export.pch", target, level=UNOPTIMISED)
    made = compile_step(model, place / "model.o", target, "-w", "-iquote", str(place), header=begin, level=UNOPTIMISED)
    objects = [made.output, *(BUILD / "objects" / target.name / f"{part}.o" for part in ADAPTOR)]
    linked = link_step(objects, place / (name + target.suffix), target)
    made.output.unlink(missing_ok=True)
    linked.output.unlink(missing_ok=True)
    for step in (begin, made, linked):
        run_steps([step])
    return linked.output


def law_holds(name: str) -> None:
    """The test of this law, as in `test_every_law`, in FMI 2.0."""
    if name in LAWS:
        at_points.check_points(name, 2)
    if name in SAMPLED:
        at_points.check_instants(name, 2)
    at_points.check_dependencies(name)
    if name in LAWS and LAWS[name].rates(at_points.draw(name, 1)[0]):
        at_points.check_order(name, 2)


def _quietly(name: str) -> None:
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    try:
        law_holds(name)
    except BaseException:
        os._exit(1)
    os._exit(0)


def survives(name: str) -> bool:
    """Whether the law's test passes, in a process of its own: a mutant may crash, or never end."""
    child = get_context("fork").Process(target=_quietly, args=(name,))
    child.start()
    child.join(LIMIT)
    if child.is_alive():
        child.kill()
        child.join()
        return False
    return child.exitcode == 0


def seen_by_others(name: str, binary: Path) -> bool:
    """Whether another test of `tests/laws` that names the component fails, with the mutant in its FMUs."""
    files = [path for path in TESTS.glob("test_*.py") if re.search(rf"\b{name}\b", path.read_text(encoding="utf-8"))]
    if not files:
        return False
    dist = WORK / "dist"
    shutil.copytree(DIST, dist, dirs_exist_ok=True)
    for fmu in DIST.glob("*.fmu"):
        if fmu.name.split(".")[0] == name:
            swap_binary(fmu, dist / fmu.name, binary)
        if (record := read_record(fmu)) is not None:
            keep_record(dist / fmu.name, record)
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *map(str, files)]
    environment = os.environ | {"ADCS_DIST": str(dist)}
    return subprocess.run(command, env=environment, capture_output=True, check=False).returncode != 0


def tried(name: str, n: int) -> Outcome:
    """What becomes of n mutants of a component that compile."""
    component = catalog.find(name)
    build([name])
    folder, description = unpacked(name, 2)
    binary = next(Path(folder.name).glob(f"binaries/*/{description.coSimulation.modelIdentifier}{host().suffix}"))
    right = binary.read_bytes()
    same = library(name, component.include, unchanged(component.header)).read_bytes()
    whole = WORK / f"{name}{host().suffix}"
    whole.write_bytes(same)
    found: Outcome = {"killed": 0, "by_other_tests": 0, "not_compiled": 0, "seconds": 0.0, "survivors": []}
    began = time.time()
    for mutant in chosen(own_headers(component.header), 4 * n):
        if found["killed"] + found["by_other_tests"] + len(found["survivors"]) == n:
            break
        try:
            made = library(name, component.include, mutant)
        except NotCompiled:
            found["not_compiled"] += 1
            continue
        if made.read_bytes() == same:
            continue  # what this component does not use, of what others do
        put(binary, made.read_bytes())
        if not survives(name):
            found["killed"] += 1
        elif not reason(mutant.before, mutant.after) and seen_by_others(name, made):
            found["by_other_tests"] += 1
        else:
            where = f"{mutant.header.relative_to(SOURCES)}:{mutant.line}"
            survivor: Survivor = {"kind": mutant.kind, "where": where, "before": mutant.before, "after": mutant.after}
            found["survivors"].append(survivor)
    put(binary, right)
    assert survives(name), f"{name} itself fails its test"
    assert not (found["by_other_tests"] and seen_by_others(name, whole)), f"{name} itself fails the other tests"
    found["seconds"] = round(time.time() - began, 1)
    return found


def put(binary: Path, content: bytes) -> None:
    """In a new file: the old one may be loaded."""
    binary.unlink()
    binary.write_bytes(content)


def main(arguments: Sequence[str] = sys.argv[1:]) -> int:
    """Try mutants of the named components, of all by default; the report keeps what it has of others."""
    n = int(os.environ.get("MUTANTS", "12"))
    WORK.mkdir(parents=True, exist_ok=True)
    for name in arguments or [component.name for component in catalog.components()]:
        found = tried(name, n)
        report.write({**report.read(), name: found})
        seen = f"{found['killed']} + {found['by_other_tests']} seen"
        print(f"{name}: {seen}, {found['not_compiled']} not compiled, {found['seconds']} s", flush=True)
        for each in found["survivors"]:
            print(f"  survived: {each['kind']}, {each['where']}\n    {each['before']}\n    {each['after']}", flush=True)
    return 0

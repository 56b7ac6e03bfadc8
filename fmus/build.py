"""Builds the FMUs: compile and link what changed, ask the components what they are, pack."""

import hashlib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from fmus import catalog
from fmus.amalgamation import amalgamated
from fmus.catalog import Component
from fmus.describe import Description, run_describe
from fmus.errors import AdcsError
from fmus.pack import FILE_NAMES, pack
from fmus.paths import BUILD, DIST, EIGEN, LICENSE, PACKAGE, SOURCES
from fmus.toolchain import (
    TARGETS,
    Step,
    Target,
    compile_step,
    digest,
    header_step,
    host,
    included_files,
    link_step,
    program_step,
    run_steps,
    write_atomically,
)

Progress = Callable[[int, int, str], None]
"""Called with the number of steps done, of all steps, and the name of what was done."""

ADAPTOR = ("instance", "saved_state", "runtime", "fmi2", "fmi3")
"""Sources in src/fmi that every binary contains."""


def build(
    names: Sequence[str] | None = None,
    all_platforms: bool = False,
    progress: Progress = lambda done, total, what: None,
    dist: Path = DIST,
    work: Path = BUILD,
) -> list[Path]:
    """Builds `NAME.fmu` and `NAME.fmi3.fmu` of the named components, of all by default.

    They contain a binary for this machine, or for all platforms. What is up to date stays. Returns the FMUs' paths;
    AdcsError if a name is unknown or the compiler refuses something.
    """
    if isinstance(names, str):
        raise AdcsError(f"names = {names!r}: expected a list, [{names!r}]")
    components = [catalog.find(name) for name in names] if names else catalog.components()
    plans = [_Plan(component, TARGETS if all_platforms else (host(),), work) for component in components]
    shared = {s.output for p in plans for s in (*p.headers, *p.compiles)}
    total = len(shared) + sum(len(p.links) + len(FILE_NAMES) for p in plans)
    done = 0

    def count(what: str) -> None:
        nonlocal done
        done += 1
        progress(done, total, what)

    def run(steps: Iterable[Step]) -> None:
        unique = {step.output: step for step in steps}.values()
        run_steps(unique, lambda step: count(step.output.relative_to(work).as_posix()))

    run(step for plan in plans for step in plan.headers)
    run(step for plan in plans for step in plan.compiles)
    run(step for plan in plans for step in plan.links)
    built = []
    for plan in plans:
        for fmi_version, pattern in FILE_NAMES.items():
            path = dist / pattern.format(plan.component.name)
            plan.pack(fmi_version, path)
            count(path.name)
            built.append(path)
    return built


def describe(name: str, work: Path = BUILD) -> Description:
    """What a component declares; builds its describe program if need be. AdcsError if there is no such component."""
    plan = _Plan(catalog.find(name), (), work)
    run_steps(plan.headers)
    run_steps(plan.compiles)
    run_steps(plan.links)
    return run_describe(plan.describe_link.output)


class _Plan:
    """The steps for one component."""

    def __init__(self, component: Component, targets: Sequence[Target], work: Path) -> None:
        self.component = component
        self._work = work
        self._model = work / "models" / component.name / "model.cpp"
        code = f'#include "{component.include}"\n#include "fmi/export.hpp"\n\nADCS_EXPORT({component.name})\n'
        if not self._model.is_file() or self._model.read_text(encoding="utf-8") != code:
            write_atomically(self._model, code.encode())

        self._adaptor = {(t, s): self._compile_adaptor(s, t) for t in targets for s in ADAPTOR}
        headers = {t: self._header("export", t) for t in targets}
        self._models = {
            t: compile_step(self._model, self._object(component.name, t), t, header=headers[t]) for t in targets
        }
        self._binaries = {
            t: link_step(
                [self._models[t].output, *(self._adaptor[t, s].output for s in ADAPTOR)],
                work / "binaries" / t.name / (component.name + t.suffix),
                t,
            )
            for t in targets
        }
        machine = host()
        flag = "-DADCS_DESCRIBE"
        header = self._header("describe", machine, flag)
        describe = [
            compile_step(
                self._model, self._object(f"describe_{component.name}", machine), machine, flag, header=header
            ),
            compile_step(SOURCES / "fmi" / "describe.cpp", self._object("describe", machine), machine, flag),
            self._compile_adaptor("instance", machine),
            self._compile_adaptor("saved_state", machine),
            self._compile_adaptor("runtime", machine),
        ]
        self.describe_link = program_step([s.output for s in describe], work / "describe" / component.name, machine)
        self.headers = [header, *headers.values()]
        self.compiles = [*describe, *self._adaptor.values(), *self._models.values()]
        self.links = [self.describe_link, *self._binaries.values()]

    def pack(self, fmi_version: str, path: Path) -> None:
        """Writes the FMU unless it was packed from the same things before."""
        skipped = "fmi3" if fmi_version == "2.0" else "fmi2"  # a tool that compiles it has the headers of one version
        first = next(iter(self._models))
        adaptor = {s: self._adaptor[first, s] for s in ADAPTOR if s != skipped}
        sources = {
            _name_in_sources(file, self._model): file
            for step in (self._models[first], *adaptor.values())
            for file in included_files(step)
            if file.is_relative_to(EIGEN) or file.is_relative_to(SOURCES) or file == self._model
        }
        binaries = {target: step.output for target, step in self._binaries.items()}
        package = [file for pattern in ("*.py", "templates/*", "licenses/*") for file in sorted(PACKAGE.glob(pattern))]
        parts = [*binaries.values(), self.describe_link.output, *sources.values(), *package, LICENSE]
        key = [fmi_version, os.environ.get("SOURCE_DATE_EPOCH", ""), *sources, *map(digest, parts)]
        record = self._work / "packed" / f"{path.name}.txt"

        def state() -> str:
            return hashlib.sha256("\n".join([*key, digest(path)]).encode()).hexdigest()

        if path.is_file() and record.is_file() and record.read_text(encoding="utf-8") == state():
            return
        description = run_describe(self.describe_link.output)
        compiled = ["model.cpp", *(f"fmi/{s}.cpp" for s in adaptor)]
        contents = _contents(sources)
        write_atomically(path, pack(self.component, description, fmi_version, binaries, contents, compiled))
        write_atomically(record, state().encode())

    def _compile_adaptor(self, name: str, target: Target) -> Step:
        return compile_step(SOURCES / "fmi" / f"{name}.cpp", self._object(name, target), target)

    def _header(self, name: str, target: Target, *flags: str) -> Step:
        output = self._object(name, target).with_suffix(".pch")
        return header_step(SOURCES / "fmi" / "export.hpp", output, target, *flags)

    def _object(self, name: str, target: Target) -> Path:
        return self._work / "objects" / target.name / f"{name}.o"


def _contents(sources: Mapping[str, Path]) -> dict[str, bytes]:
    """Return what goes into `sources/` by its name there: the project's own files as they are, Eigen's in few."""
    eigen = [file for file in sources.values() if file.is_relative_to(EIGEN)]
    own = {name: file.read_bytes() for name, file in sources.items() if not file.is_relative_to(EIGEN)}
    return {**own, **amalgamated(eigen, EIGEN)}


def _name_in_sources(file: Path, model: Path) -> str:
    if file == model:
        return model.name
    base = EIGEN if file.is_relative_to(EIGEN) else SOURCES
    return file.relative_to(base).as_posix()

"""Builds the FMUs: compile and link what changed, ask the components what they are, pack."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fmus import catalog, freshness
from fmus.amalgamation import amalgamated
from fmus.carried import carried_description
from fmus.catalog import Component
from fmus.describe import Description, Misdeclared, described, parse
from fmus.eigen import UNUSED
from fmus.errors import AdcsError
from fmus.files import digest, make_folder, write_atomically
from fmus.lock import Lock
from fmus.mistakes import from_compiler, from_declaration, truncated
from fmus.pack import FILE_NAMES, Parts, is_own, licences, pack
from fmus.paths import BUILD, DIST, EIGEN, FMI_HEADERS, SOURCES
from fmus.toolchain import (
    INLINED,
    SMALL,
    TARGETS,
    UNOPTIMISED,
    NotCompiled,
    Step,
    Target,
    compile_step,
    compiler,
    header_step,
    host,
    included_files,
    link_step,
    program_step,
    run_steps,
    zig,
)

_log = logging.getLogger("adcs")

Progress = Callable[[int, int, str], None]
"""Called with the number of steps done, of all steps, and the name of what was done."""

ADAPTOR = ("messages", "instance", "access", "events", "derivatives", "saved_state", "runtime", "fmi2", "fmi3")
"""Sources in src/fmi that every binary contains."""

DESCRIBE_FLAGS = (
    "-DADCS_DESCRIBE",
    "-ftemplate-backtrace-limit=0",  # the line of the header is among what would be left out
    # what a law is never meant to be, and compiles; it is the first program that is made of a header
    *(
        f"-Werror={each}"
        for each in ("uninitialized", "return-type", "unused-comparison", "division-by-zero", "array-bounds", "format")
    ),
)
"""With which the program is compiled that says what a component declares."""


def build(
    names: Sequence[str] | None = None,
    all_platforms: bool = False,
    progress: Progress = lambda done, total, what: None,
    dist: Path = DIST,
    work: Path = BUILD,
) -> list[Path]:
    """Builds `NAME.fmu` and `NAME.fmi3.fmu` of the named components, of all by default.

    They contain a binary for this machine, or for all platforms. What is up to date stays. Returns the FMUs' paths;
    AdcsError if a name is unknown or the compiler refuses something. The FMUs of components that are gone are removed
    where all are built. Processes that build in the same place take turns.
    """
    if isinstance(names, str):
        raise AdcsError(f"names = {names!r}: expected a list, [{names!r}]")
    components = [each for name in names for each in catalog.meant(name)] if names else catalog.components()
    targets = TARGETS if all_platforms else (host(),)
    with _compiled(components, targets, work, progress, len(FILE_NAMES)) as (plans, count):
        built = []
        for plan in plans:
            for path in plan.pack(plan.component.home or dist):
                count(path.name)
                built.append(path)
    for deleted in freshness.recorded(dist) - set(built) if not names else _orphans(names):
        freshness.forget(deleted)
    return built


def _orphans(names: Iterable[str]) -> list[Path]:
    """The FMUs in the folders among these names whose headers are gone."""
    folders = [Path(name) for name in names if Path(name).is_dir()]
    return [fmu for folder in folders for fmu in freshness.recorded(folder) if freshness.orphaned(fmu)]


def parts(
    work: Path = BUILD, progress: Progress = lambda done, total, what: None
) -> list[tuple[Component, Parts, dict[str, Any]]]:
    """Build all components for all platforms; return what their FMUs are packed of, and their descriptions as JSON."""
    with _compiled(catalog.components(), TARGETS, work, progress) as (plans, _):
        return [(plan.component, plan.parts(), plan.described()) for plan in plans]


@contextmanager
def _compiled(
    components: Sequence[Component], targets: Sequence[Target], work: Path, progress: Progress, more: int = 0
) -> Iterator[tuple[list[_Plan], Callable[[str], None]]]:
    """Compile and link what is out of date; yield the plans, and what counts steps, of which `more` follow for each."""
    zig()  # refused now
    with _alone_in(work):
        plans = [_Plan(component, targets, work) for component in components]
        shared = {s.output for p in plans for s in (*p.headers, *p.compiles)}
        total = len(shared) + sum(len(p.links) + more for p in plans)
        done = 0

        def count(what: str) -> None:
            nonlocal done
            done += 1
            progress(done, total, what)

        def run(steps: Iterable[Step]) -> None:
            unique = {step.output: step for step in steps}.values()
            try:
                run_steps(unique, lambda step: count(step.output.relative_to(work).as_posix()))
            except NotCompiled as error:
                raise _in_a_line(error, plans) from None

        run(step for plan in plans for step in plan.headers)
        run(step for plan in plans for step in plan.compiles)
        run(step for plan in plans for step in plan.links)
        yield plans, count


def _in_a_line(error: NotCompiled, plans: Sequence[_Plan]) -> AdcsError:
    """Return what is wrong with the header of a component, if it is one of a component that was not compiled."""
    for plan in plans:
        if error.step in plan.own_steps:
            mistake = from_compiler(error.output, plan.component.header, plan.component.name)
            return AdcsError(f"{mistake}; the compiler's full output: {error.step.log}")
    return error


def describe(name: str, work: Path = BUILD) -> Description:
    """What a component declares; builds its describe program if need be. AdcsError if there is no such component."""
    component = catalog.find(name)
    known = carried_description(component)
    if known is not None:
        return known
    with _compiled([component], (), work, lambda done, total, what: None) as ((plan,), _):
        return parse(plan.described())


@contextmanager
def _alone_in(work: Path) -> Iterator[None]:
    """Let no other process build there meanwhile: what it made is up to date then."""
    make_folder(work)
    lock = Lock(work / ".building")
    told = False
    while not lock.take():
        if not told:
            _log.info(f"waiting for process {lock.holder}, which builds in {work}")
            told = True
        time.sleep(0.05)
    try:
        yield
    finally:
        lock.release()


class _Plan:
    """The steps for one component."""

    def __init__(self, component: Component, targets: Sequence[Target], work: Path) -> None:
        self.component = component
        self._work = self._own = work
        self._roots = () if component.root is None else (component.root,)
        if component.outside:
            self._own = work / "outside" / component.key
        self._include = tuple(f"-I{root}" for root in self._roots)
        self._model = self._own / "models" / component.name / "model.cpp"
        code = f'#include "{component.include}"\n#include "fmi/export.hpp"\n\nADCS_EXPORT({component.name})\n'
        if not self._model.is_file() or self._model.read_text(encoding="utf-8") != code:
            write_atomically(self._model, code.encode())

        self._adaptor = {(t, s): self._compile_adaptor(s, t) for t in targets for s in ADAPTOR}
        headers = {t: self._header("export", t) for t in targets}
        self._models = {
            t: compile_step(
                self._model, self._object(component.name, t, self._own), t, *self._include, header=headers[t]
            )
            for t in targets
        }
        self._binaries = {
            t: link_step(
                [self._models[t].output, *(self._adaptor[t, s].output for s in ADAPTOR)],
                self._own / "binaries" / t.name / (component.name + t.suffix),
                t,
            )
            for t in targets
        }
        # not optimised, which takes longer than the program runs
        machine = host()
        header = self._header("describe", machine, *DESCRIBE_FLAGS, level=UNOPTIMISED)
        describe = [
            compile_step(
                self._model,
                self._object(f"describe_{component.name}", machine, self._own),
                machine,
                *DESCRIBE_FLAGS,
                *self._include,
                header=header,
                level=UNOPTIMISED,
            ),
            compile_step(
                SOURCES / "fmi" / "describe.cpp",
                self._object("describe", machine),
                machine,
                *DESCRIBE_FLAGS,
                level=UNOPTIMISED,
            ),
            self._compile_adaptor("runtime", machine),
        ]
        self.describe_link = program_step(
            [s.output for s in describe], self._own / "describe" / component.name, machine
        )
        self.headers = [header, *headers.values()]
        self.compiles = [*describe, *self._adaptor.values(), *self._models.values()]
        self.links = [self.describe_link, *self._binaries.values()]
        self.own_steps = [describe[0], *self._models.values(), *self.links]

    def described(self) -> dict[str, Any]:
        """Return what the component declares, as JSON; AdcsError in one line if it declares what cannot be."""
        header, mistake = self.component.header, truncated(self.component.header)
        if mistake is not None:
            raise AdcsError(mistake)
        try:
            return described(self.describe_link.output)
        except Misdeclared as error:
            raise AdcsError(from_declaration(str(error), header, self.component.name)) from None

    def pack(self, dist: Path) -> Iterator[Path]:
        """Write the FMUs unless they were packed of the same things before; yield their paths."""
        record = freshness.make_record(self._made_of(), (target.name for target in self._binaries), compiler())
        parts: Parts | None = None
        for version, pattern in FILE_NAMES.items():
            path = dist / pattern.format(self.component.name)
            known = freshness.read_record(path)
            if known is None and self.component.outside and path.exists() and not is_own(path):
                raise AdcsError(f"{path} is there already, and not of this project's making: move it away")
            if known is None or known.without_fmu() != record:
                parts = parts or self.parts()
                write_atomically(path, pack(self.component, parts, version))
                freshness.keep_record(path, record)
            yield path

    def parts(self) -> Parts:
        """Return what the FMUs are packed of."""
        from fmus import icon  # not at the top: matplotlib takes a second to load

        name, kind = self.component.name, self.component.kind
        return Parts(
            description=parse(self.described()),
            binaries={target: step.output.read_bytes() for target, step in self._binaries.items()},
            sources={version: self._sources(version) for version in FILE_NAMES},
            icons={form: icon.draw(name, kind, form) for form in ("png", "svg")},
            licences=licences(),
            made_of=self._made_of(),
        )

    def _sources(self, fmi_version: str) -> dict[str, bytes]:
        """Return what goes into `sources/` by its name there: the project's own files as they are, Eigen's in few."""
        skipped = "fmi3" if fmi_version == "2.0" else "fmi2"  # a tool that compiles it has the headers of one version
        first = next(iter(self._models))
        steps = [self._models[first], *(self._adaptor[first, s] for s in ADAPTOR if s != skipped)]
        files = dict.fromkeys(file for step in steps for file in (*step.inputs, *included_files(step)))
        own = {
            file.relative_to(root).as_posix(): file.read_bytes()
            for root in (SOURCES, *self._roots)
            for file in files
            if file.is_relative_to(root) and file.is_file()
        }
        without = frozenset() if self.component.outside else UNUSED
        return {
            self._model.name: self._model.read_bytes(),
            **own,
            **amalgamated([file for file in files if file.is_relative_to(EIGEN)], EIGEN, without),
        }

    def _made_of(self) -> dict[str, str]:
        """Return the files that went into binaries and description, with the digests of their contents.

        Those of `src/` go by their names there, those of a component from elsewhere by their paths.
        """
        included = {file for step in (*self.headers, *self.compiles) for file in included_files(step)}
        files = included | {file for step in self.links for file in step.inputs}
        inside = {f.relative_to(SOURCES).as_posix(): digest(f) for f in sorted(files) if f.is_relative_to(SOURCES)}
        others = (SOURCES, EIGEN, FMI_HEADERS, self._work)
        outside = [f for f in sorted(files) if self._roots and not any(f.is_relative_to(place) for place in others)]
        for file in outside:
            if file.is_file() and not any(file.is_relative_to(root) for root in self._roots):
                raise AdcsError(
                    f"{self.component.header} includes {file}, which its FMU's sources cannot hold: put it into the "
                    "folder of the header"
                )
        return inside | {str(file): digest(file) for file in outside}

    def _compile_adaptor(self, name: str, target: Target) -> Step:
        return compile_step(SOURCES / "fmi" / f"{name}.cpp", self._object(name, target), target, level=SMALL)

    def _header(self, name: str, target: Target, *flags: str, level: Sequence[str] = INLINED) -> Step:
        output = self._object(name, target).with_suffix(".pch")
        return header_step(SOURCES / "fmi" / "export.hpp", output, target, *flags, level=level)

    def _object(self, name: str, target: Target, work: Path | None = None) -> Path:
        return (work or self._work) / "objects" / target.name / f"{name}.o"

"""Checks an FMU, own or foreign, more strictly than any one validator does."""

import zipfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from fmus.archive import LARGEST_XML, Archive
from fmus.checks import Note
from fmus.checks.archive import check_archive, check_layout, check_members
from fmus.checks.attributes import check_attributes
from fmus.checks.behaviour import check_behaviour
from fmus.checks.description import (
    check_companions,
    check_dependencies,
    check_dimensions,
    check_schema,
    check_standard,
    check_variables,
)
from fmus.checks.functions import FUNCTIONS, advice, bare, called_in
from fmus.checks.version import check_version
from fmus.errors import AdcsError
from fmus.nearby import instead
from fmus.pack import is_own
from fmus.readable import read_model
from fmus.references import unresolved
from fmus.toolchain import INSTALL
from fmus.xml import parse

BINARIES = (".so", ".dll", ".dylib")


@dataclass(frozen=True)
class Finding:
    """Something found in an FMU."""

    rule: str
    """Which check found it: archive, layout, standard, companions, variables, dependencies, binaries, sources,
    behaviour, run; the last one is about what `adcs run` refuses."""
    message: str
    severity: Literal["fault", "note"] = "fault"
    """A note is about what no standard forbids, but what some machine or tool cannot do with."""


def check(path: Path | str, behaviour: Callable[[Path], Iterable[str]] | None = None) -> list[Finding]:
    """Everything found in the FMU at `path`; empty if it is fine. It need not exist or be a ZIP file.

    `behaviour` is what runs it, instead of what `check_behaviour` does; `adcs check` takes a first step as well.
    """
    return list(dict.fromkeys(_check(Path(path), behaviour or check_behaviour)))


def _check(path: Path, behaviour: Callable[[Path], Iterable[str]]) -> Iterator[Finding]:
    try:
        if not path.is_file():
            raise FileNotFoundError(f"it is no file{instead(path)}")
        archive = zipfile.ZipFile(path)
    except Exception as error:  # zipfile lets those of struct, of decoding and others out of a damaged directory
        yield Finding("archive", f"{path} is no readable ZIP file: {error}")
        return
    with archive:
        try:
            with Archive(path) as safe:
                in_archive = list(_found("archive", check_archive(archive)))
                yield from in_archive
                content, root = _document(safe)
                yield from _found("standard", check_version(root.get("fmiVersion")))
                wrong = [*_found("standard", check_schema(root)), *_found("standard", unresolved(root))]
                yield from wrong
                yield from _found("variables", check_dimensions(root))
                model = _description(content, root)
                if not wrong:
                    yield from _found("standard", check_standard(model))
                interfaces = [i for i in (model.modelExchange, model.coSimulation, model.scheduledExecution) if i]
                yield from _found(
                    "layout", check_layout(safe, {i.modelIdentifier for i in interfaces}, model.fmiVersion)
                )
                yield from _found("companions", check_companions(safe, model))
                yield from _found("variables", check_variables(model, root))
                yield from _found("variables", check_attributes(root))
                yield from _found("dependencies", check_dependencies(model))
                kinds = {type(i).__name__ for i in interfaces}
                yield from _found("binaries", _check_binaries(safe, model.fmiVersion, kinds))
                if is_own(path):
                    yield from _found("sources", _check_laws(safe))
        except _Unreadable as error:
            yield Finding("standard", str(error))
            return
        except AdcsError as error:  # what is not even unpacked
            in_archive = list(_found("archive", check_members(archive)))
            yield from in_archive or [Finding("archive", str(error))]
            return
    if not any(finding.severity == "fault" for finding in in_archive):
        yield from _found("behaviour", behaviour(path))


def _check_binaries(archive: Archive, fmi_version: str, interfaces: set[str]) -> Iterator[str]:
    if find_spec("lief") is None:
        yield Note(f"the binaries are not looked into, for lief is not installed: {INSTALL}")
        return
    from fmus.checks.binary import check_binary  # not at the top: the library behind it takes a second to load

    for name in archive.names:
        if name.startswith("binaries/") and name.endswith(BINARIES):
            yield from check_binary(name, archive.read(name), fmi_version, interfaces)


def _check_laws(archive: Archive) -> Iterator[str]:
    """What laws call, in an FMU of this project's making: by their sources, and by what is not seen there."""
    told: set[str] = set()
    for name in archive.names:
        if name.startswith("sources/") and name.endswith((".hpp", ".cpp")):
            for line, function in called_in(archive.read(name, LARGEST_XML).decode(errors="replace")):
                told.add(bare(function))
                yield f"{name}:{line}: {advice(function)}"
    if find_spec("lief") is None:
        return  # which is said of the binaries
    from fmus.checks.binary import imported

    called = {
        function
        for name in archive.names
        if name.startswith("binaries/") and name.endswith(BINARIES)
        for function in imported(archive.read(name)) & FUNCTIONS
    }
    for function in sorted(called - told):
        yield f"its binary calls {advice(function)}"


class _Unreadable(Exception):
    """A description that cannot be looked at further."""


def _document(archive: Archive) -> tuple[bytes, Any]:
    """Return modelDescription.xml and its root element."""
    try:
        if "modelDescription.xml" not in archive.names:
            raise AdcsError("there is none")
        content = archive.read("modelDescription.xml", LARGEST_XML)
        return content, parse(content, "modelDescription.xml")
    except AdcsError as error:
        raise _Unreadable(f"modelDescription.xml cannot be read: {' '.join(str(error).split())}") from error


def _description(content: bytes, root: Any) -> Any:
    """Return what fmpy makes of modelDescription.xml."""
    try:
        return read_model(content, root, validate=False)
    except Exception as error:  # what is wrong in a way that fmpy has not thought of
        raise _Unreadable(f"modelDescription.xml cannot be read: {' '.join(str(error).split())}") from error


def _found(rule: str, messages: Iterable[str]) -> Iterator[Finding]:
    try:
        for message in messages:
            text = " ".join(message.split())
            yield Finding(rule, text, "note" if isinstance(message, Note) else "fault")
    except AdcsError:
        raise
    except Exception as error:  # in a description that breaks its schema, of which there is a finding as well
        yield Finding(rule, f"cannot be looked at: {' '.join(str(error).split())}")

"""Checks an FMU, own or foreign, more strictly than any one validator does."""

import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import fmpy

from fmus.checks.archive import check_archive, check_layout
from fmus.checks.behaviour import check_behaviour
from fmus.checks.description import check_companions, check_dependencies, check_standard, check_variables


@dataclass(frozen=True)
class Finding:
    """Something wrong with an FMU."""

    rule: str
    """Which check found it: archive, layout, standard, companions, variables, dependencies, binaries, behaviour."""
    message: str


def check(path: Path | str) -> list[Finding]:
    """Everything found wrong with the FMU at `path`; empty if it is fine. It need not exist or be a ZIP file."""
    return list(dict.fromkeys(_check(Path(path))))


def _check(path: Path) -> Iterator[Finding]:
    from fmus.checks.binary import check_binary  # not at the top: the library behind it takes a second to load

    def found(rule: str, messages: Iterable[str]) -> Iterator[Finding]:
        return (Finding(rule, message) for message in messages)

    try:
        archive = zipfile.ZipFile(path)
    except (OSError, zipfile.BadZipFile) as error:
        yield Finding("archive", f"{path} is no readable ZIP file: {error}")
        return
    with archive:
        in_archive = list(found("archive", check_archive(archive)))
        yield from in_archive
        yield from found("standard", check_standard(path))
        try:
            model = fmpy.read_model_description(str(path), validate=False)
        except Exception as error:
            yield Finding("standard", f"modelDescription.xml cannot be read: {error}")
            return
        interfaces = [i for i in (model.modelExchange, model.coSimulation, model.scheduledExecution) if i]
        yield from found("layout", check_layout(archive, {i.modelIdentifier for i in interfaces}))
        yield from found("companions", check_companions(archive, model))
        yield from found("variables", check_variables(model))
        yield from found("dependencies", check_dependencies(model))
        for name in archive.namelist():
            if name.startswith("binaries/") and name.endswith((".so", ".dll", ".dylib")):
                yield from found("binaries", check_binary(name, archive.read(name), model.fmiVersion))
    if not in_archive:
        yield from found("behaviour", check_behaviour(path))

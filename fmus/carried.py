"""What a wheel carries, so that FMUs need no compiler: binaries for all platforms, and what else they are packed of.

In its folder `carried/` there is an archive of each platform, `x86_64-linux.tar.xz`, with all that was compiled for
it, and `parts.tar.xz`: `components.json` says of each component what it declares and what its FMUs are made of, beside
icons, licences, and those sources that are no files of `src/`. A checkout has no such folder.
"""

from __future__ import annotations

import hashlib
import io
import json
import lzma
import tarfile
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from fmus.catalog import Component
from fmus.describe import Description, parse
from fmus.files import digest, write_atomically
from fmus.pack import FILE_NAMES, Parts
from fmus.paths import CARRIED, SOURCES
from fmus.toolchain import TARGETS, Target

_PARTS, _INDEX = "parts", "components.json"


def carry(
    folder: Path,
    components: Iterable[tuple[Component, Parts, dict[str, Any]]],
    more: Mapping[Target, Mapping[str, bytes]],
) -> None:
    """Write the archives.

    With each component come its parts, for all platforms, and its description as JSON; `more` is also compiled.
    """
    compiled = {target: dict(more[target]) for target in TARGETS}
    parts: dict[str, bytes] = {}
    index = {}
    for component, its, description in components:
        for target, content in its.binaries.items():
            compiled[target][f"{component.name}{target.suffix}"] = content
        parts |= {f"icons/{component.name}.{form}": content for form, content in its.icons.items()}
        parts |= {f"licences/{name}": text.encode() for name, text in its.licences.items()}
        brought = {name: content for sources in its.sources.values() for name, content in sources.items()}
        own = {name: hashlib.sha256(content).hexdigest() for name, content in brought.items()}
        foreign = {name: f"sources/{own[name][:16]}" for name in own if digest(SOURCES / name) != own[name]}
        parts |= {place: brought[name] for name, place in foreign.items()}
        index[component.name] = {
            "description": description,
            "made_of": its.made_of,
            "sources": {version: {n: foreign.get(n) for n in its.sources[version]} for version in FILE_NAMES},
        }
    parts[_INDEX] = json.dumps(index, separators=(",", ":")).encode()
    for name, files in ((_PARTS, parts), *((target.name, files) for target, files in compiled.items())):
        write_atomically(folder / f"{name}.tar.xz", _packed(files, name))


def carried_parts(component: Component) -> Parts | None:
    """Return what the FMUs of a component are packed of; None if it is not carried, or of other sources than these."""
    known = _known(component)
    if known is None:
        return None
    files = _files(_PARTS)
    return Parts(
        description=parse(known["description"]),
        binaries={target: _files(target.name)[f"{component.name}{target.suffix}"] for target in TARGETS},
        sources={
            version: {
                name: (SOURCES / name).read_bytes() if place is None else files[place] for name, place in its.items()
            }
            for version, its in known["sources"].items()
        },
        icons={form: files[f"icons/{component.name}.{form}"] for form in ("png", "svg")},
        licences={
            name.removeprefix("licences/"): content.decode()
            for name, content in files.items()
            if name.startswith("licences/")
        },
        made_of=known["made_of"],
    )


def carried_description(component: Component) -> Description | None:
    """Return what a component declares, where that is carried."""
    known = _known(component)
    return None if known is None else parse(known["description"])


def compiled(name: str, target: Target) -> bytes | None:
    """Return a file that was compiled for a platform, where it is carried."""
    return _files(target.name).get(name)


def _known(component: Component) -> dict[str, Any] | None:
    known = None if component.outside else _index().get(component.name)
    if known is None or any(digest(f"{SOURCES}/{name}") != content for name, content in known["made_of"].items()):
        return None
    return known


@cache
def _index() -> dict[str, dict[str, Any]]:
    content = _files(_PARTS).get(_INDEX)
    return {} if content is None else json.loads(content)


@cache
def _files(name: str) -> dict[str, bytes]:
    path = CARRIED / f"{name}.tar.xz"
    if not path.is_file():
        return {}
    with tarfile.open(path) as archive:
        return {member.name: archive.extractfile(member).read() for member in archive}  # type: ignore[union-attr]


def _packed(files: Mapping[str, bytes], name: str) -> bytes:
    """Return an archive that depends on names and contents only, in one stream: the binaries have much in common."""
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for member, content in sorted(files.items()):
            info = tarfile.TarInfo(member)
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    filters: list[dict[str, int]] = [{"id": lzma.FILTER_LZMA2, "preset": 9 | lzma.PRESET_EXTREME}]
    if name.startswith("x86"):
        filters.insert(0, {"id": lzma.FILTER_X86})
    return lzma.compress(plain.getvalue(), filters=filters)

"""The ZIP file and where things are in it."""

import re
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import PurePosixPath

from fmus.archive import LARGEST_XML, Archive
from fmus.checks import Note
from fmus.errors import AdcsError
from fmus.toolchain import TARGETS
from fmus.xml import parse

_TOP_LEVEL = {
    "modelDescription.xml",
    "model.png",
    "binaries",
    "documentation",
    "extra",
    "resources",
    "sources",
    "terminalsAndIcons",
}
_SUFFIXES = {
    **{t.name: t.suffix for t in TARGETS},
    **{t.fmi2_folder: t.suffix for t in TARGETS},
    "linux32": ".so",
    "win32": ".dll",
    "darwin32": ".dylib",
    "x86-linux": ".so",
    "x86-windows": ".dll",
}

_ONLY_IN_FMI2 = {
    "linux64": "x86_64-linux",
    "win64": "x86_64-windows",
    "darwin64": "x86_64-darwin or aarch64-darwin",
    "linux32": "x86-linux",
    "win32": "x86-windows",
    "darwin32": "x86-darwin",
}
"""Names of platforms, and how FMI 3 calls them."""


def check_archive(archive: zipfile.ZipFile) -> Iterator[str]:
    """Paths that unpack safely everywhere, and compression that every tool reads."""
    try:
        damaged = archive.testzip()
    except Exception as error:  # of zlib, or a header that does not fit the directory
        yield f"a file is damaged: {' '.join(str(error).split())}"
    else:
        if damaged:
            yield f"{damaged} is damaged: its checksum does not fit"
    yield from check_members(archive)


def check_members(archive: zipfile.ZipFile) -> Iterator[str]:
    """Of what is in the archive, all that can be seen without unpacking it."""
    for name, count in Counter(archive.namelist()).items():
        if count > 1:
            yield f"{name} is contained {count} times"
    for entry in archive.infolist():
        name = entry.orig_filename
        if "\\" in name:
            yield f"{name}: path has a backslash"
        if name.startswith("/") or re.match(r"[A-Za-z]:", name) or ".." in PurePosixPath(name).parts:
            yield f"{name}: path leads out of the FMU"
        if not name.isascii():
            yield Note(f"{name}: path has characters beyond ASCII")
        if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            yield f"{name}: compression method {entry.compress_type}, expected 0 (stored) or 8 (deflated)"
        if entry.flag_bits & 1:
            yield f"{name} is encrypted"
        if entry.external_attr >> 28 == 0o12:
            yield f"{name} is a symbolic link"


def check_layout(archive: Archive, identifiers: set[str], fmi_version: str) -> Iterator[str]:
    """Files where the standards want them; `identifiers` are the model identifiers."""
    files = {name for name in archive.names if not name.endswith("/")}
    for top in sorted({PurePosixPath(name).parts[0] for name in files} - _TOP_LEVEL):
        yield Note(f"{top} is no part of an FMU")
    folders: dict[str, set[str]] = {}
    for name in files:
        parts = PurePosixPath(name).parts
        if parts[0] == "binaries":
            folders.setdefault(parts[1], set()).add("/".join(parts[2:]))
    if not folders and not any(name.startswith("sources/") for name in files):
        yield "neither binaries nor sources are contained"
    for folder, contents in sorted(folders.items()):
        if folder not in _SUFFIXES:
            yield Note(f"binaries/{folder} is no platform: known are {', '.join(_SUFFIXES)}")
            continue
        if fmi_version.startswith("3.") and folder in _ONLY_IN_FMI2:
            yield f"binaries/{folder} is a platform of FMI 2, expected {_ONLY_IN_FMI2[folder]}"
        expected = {identifier + _SUFFIXES[folder] for identifier in identifiers}
        for name in sorted(expected - contents):
            yield f"binaries/{folder}/{name} is missing"
        for name in sorted(contents - expected):
            yield Note(f"binaries/{folder}/{name} is not expected there")
    for entry_point, folder in (
        ("documentation/index.html", "documentation/"),
        ("terminalsAndIcons/icon.png", "terminalsAndIcons/icon."),
    ):
        if entry_point not in files and any(name.startswith(folder) for name in files):
            yield f"{entry_point} is missing"
    licences = {name for name in files if name.startswith("documentation/licenses/")}
    if licences and not licences & {f"documentation/licenses/license.{kind}" for kind in ("txt", "html", "spdx")}:
        yield "documentation/licenses/license.txt is missing"
    yield from _check_sources(archive, files)


def _check_sources(archive: Archive, files: set[str]) -> Iterator[str]:
    listed = set()
    for document, path in (
        ("sources/buildDescription.xml", ".//SourceFile"),
        ("modelDescription.xml", ".//SourceFiles/File"),
    ):
        if document in files:
            try:
                root = parse(archive.read(document, LARGEST_XML), document)
            except AdcsError as error:
                yield str(error)
                continue
            listed |= {f"sources/{file.get('name')}" for file in root.iterfind(path)}
    for name in sorted(listed - files):
        yield f"{name} is to be compiled, but missing"
    if not listed and any(name.startswith("sources/") for name in files):
        yield Note("sources are contained, but nothing says what is to be compiled")

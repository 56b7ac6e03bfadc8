"""Puts an FMU together: description, binaries, sources, documentation, icon, licences."""

import io
import os
import re
import time
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from fmus import model_description
from fmus.catalog import Component
from fmus.describe import Description
from fmus.paths import FMI_HEADERS, LICENSE, PACKAGE
from fmus.terminals import terminals_and_icons
from fmus.toolchain import Target, universal_binary, zig
from fmus.xml import serialised

FILE_NAMES = {"2.0": "{}.fmu", "3.0": "{}.fmi3.fmu"}
"""FMI version -> name of the FMU of a component."""

LICENCE_OF_EIGEN = "MPL-2.0"
"""As each of its headers says at its top; the metadata of `cmeel-eigen`, which brings them, is of the packaging."""

_LICENCE_OVERVIEW = """\
This FMU is part of adcs-fmus, BSD 3-clause licence, adcs-fmus.txt.

Compiled in, and in sources/ where it is source code:
- Eigen (sources/Eigen), Mozilla Public License 2.0, Eigen.txt. Its source code is in this FMU, each module in one file,
  without headers that nothing here uses and without comments other than copyright notices; as its authors publish it:
  https://eigen.tuxfamily.org.
- C header files of the FMI standard, 2-clause BSD licence, FMI.txt.
- headers of libc++, Apache License 2.0 with LLVM exceptions, libcxx.txt.
- compiler support routines of Zig, MIT licence, zig.txt.
- in the Windows binary, startup code of MinGW-w64, mingw-w64.txt.
"""


@dataclass(frozen=True)
class Parts:
    """What the FMUs of a component are packed of."""

    description: Description
    binaries: Mapping[Target, bytes]
    """The same for both versions of FMI."""
    sources: Mapping[str, Mapping[str, bytes]]
    """FMI version -> what goes into `sources/`, by the names there."""
    icons: Mapping[str, bytes]
    """`png` and `svg`."""
    licences: Mapping[str, str]
    """Of what is compiled in, by the names of their files."""
    made_of: Mapping[str, str]
    """The files of `src/` that all this was made of, and the digests of their contents."""


def is_own(path: Path) -> bool:
    """Whether a file is an FMU that this project has made."""
    try:
        with zipfile.ZipFile(path) as archive, archive.open("modelDescription.xml") as description:
            return b'generationTool="adcs-fmus' in description.read(2000)
    except (OSError, KeyError, zipfile.BadZipFile):
        return False


def pack(component: Component, parts: Parts, fmi_version: str) -> bytes:
    """The FMU file."""
    from fmus import documentation  # not at the top: what writes it is loaded where there is something to write

    description, sources, icons = parts.description, parts.sources[fmi_version], parts.icons
    compiled = [name for name in sources if name.endswith(".cpp")]
    xml = model_description.fmi2(description, compiled) if fmi_version == "2.0" else model_description.fmi3(description)
    files = {
        "modelDescription.xml": xml,
        **({"model.png": icons["png"]} if fmi_version == "2.0" else {}),
        "documentation/index.html": documentation.page(component, description).encode(),
        **{f"documentation/licenses/{name}": text.encode() for name, text in sorted(parts.licences.items())},
        "terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(description, fmi_version),
        "terminalsAndIcons/icon.png": icons["png"],
        "terminalsAndIcons/icon.svg": icons["svg"],
        "sources/buildDescription.xml": _build_description(component.name, compiled),
        **{f"sources/{name}": content for name, content in sorted(sources.items())},
        **_binaries(component.name, fmi_version, parts.binaries),
    }
    return zipped(files)


def _binaries(name: str, fmi_version: str, binaries: Mapping[Target, bytes]) -> dict[str, bytes]:
    if fmi_version == "3.0":
        return {f"binaries/{t.name}/{name}{t.suffix}": content for t, content in binaries.items()}
    places: dict[str, list[bytes]] = {}
    for t, content in binaries.items():
        places.setdefault(f"binaries/{t.fmi2_folder}/{name}{t.suffix}", []).append(content)
    # importers look for the same folder on every Mac
    return {place: its[0] if len(its) == 1 else universal_binary(its) for place, its in places.items()}


def _build_description(name: str, compiled: Iterable[str]) -> bytes:
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = etree.SubElement(root, "BuildConfiguration", modelIdentifier=name)
    # the same digits as the binaries in this FMU: no fusing, which GCC 12 does in the SLP vectoriser all the same
    options = {"language": "C++17", "compilerOptions": "-O2 -ffp-contract=off -fno-tree-slp-vectorize"}
    file_set = etree.SubElement(configuration, "SourceFileSet", options)
    for file in compiled:
        etree.SubElement(file_set, "SourceFile", name=file)
    etree.SubElement(file_set, "IncludeDirectory", name=".")
    return serialised(root)


def licences() -> dict[str, str]:
    """The licences of what is compiled in, by the names of their files; some of them come with the compiler."""
    headers = (FMI_HEADERS / "fmi3Functions.h").read_text(encoding="utf-8")
    fmi = re.search(r"Copyright \(C\).*?(?=\*/)", headers, re.DOTALL)
    assert fmi, "the FMI headers carry their licence"
    folder = zig().parent
    lib = folder / "lib"
    return {
        "license.txt": _LICENCE_OVERVIEW,
        "adcs-fmus.txt": LICENSE.read_text(encoding="utf-8"),
        "Eigen.txt": (PACKAGE / "licenses" / f"{LICENCE_OF_EIGEN}.txt").read_text(encoding="utf-8"),
        "FMI.txt": fmi[0],
        "libcxx.txt": (lib / "libcxx" / "LICENSE.TXT").read_text(encoding="utf-8"),
        "zig.txt": (folder / "LICENSE").read_text(encoding="utf-8"),
        "mingw-w64.txt": (lib / "libc" / "mingw" / "COPYING").read_text(encoding="utf-8"),
    }


def zipped(files: Mapping[str, bytes]) -> bytes:
    """A ZIP archive that only depends on the files' names and contents."""
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH", 315532800))  # ZIP knows no time before 1980
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, time.gmtime(epoch)[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, compresslevel=9)
    return buffer.getvalue()

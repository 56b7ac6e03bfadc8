"""Builds the Reference-FMUs with this project's own compiler; nothing of their source is kept here."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path

from fmus.toolchain import host, zig

VERSIONS = (2, 3)


def commit(folder: Path) -> str:
    """The commit of the source, or that it is not known: a release is unpacked without its history."""
    found = subprocess.run(
        ["git", "-C", str(folder), "log", "-1", "--format=%H"], capture_output=True, text=True, check=False
    )
    top = subprocess.run(
        ["git", "-C", str(folder), "rev-parse", "--show-toplevel"], capture_output=True, text=True, check=False
    )
    own = top.returncode == 0 and Path(top.stdout.strip()).resolve() == folder.resolve()
    return found.stdout.strip() if own else "a source without history"


def build(source: Path, target: Path) -> Iterator[Path]:
    """Build each model in each version that it has, `NAME.fmu` in a folder for each version; yields the paths."""
    for version in VERSIONS:
        for description in sorted(source.glob(f"*/FMI{version}.xml")):
            yield _fmu(source, description.parent, version, target)


def _fmu(source: Path, model: Path, version: int, target: Path) -> Path:
    machine = host()
    folder = f"{machine.name}" if version == 3 else machine.fmi2_folder
    library = target / f"fmi{version}" / f"{model.name}{machine.suffix}"
    library.parent.mkdir(parents=True, exist_ok=True)
    files = [model / "model.c", source / "src" / f"fmi{version}Functions.c", source / "src" / "cosimulation.c"]
    flags = [
        "-target",
        machine.triple,
        "-O2",
        "-shared",
        "-fPIC",
        "-fvisibility=hidden",
        f"-DFMI_VERSION={version}",
        "-DDISABLE_PREFIX",
    ]
    includes = [f"-I{source / 'include'}", f"-I{model}"]
    subprocess.run([str(zig()), "cc", *flags, *includes, *map(str, files), "-o", str(library)], check=True)
    fmu = library.with_suffix(".fmu")
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(model / f"FMI{version}.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{folder}/{library.name}")
        for file in (*files, model / "config.h", *(source / "include").glob("*.h")):
            archive.write(file, f"sources/{file.name}")
        if version == 3:
            archive.write(model / "buildDescription.xml", "sources/buildDescription.xml")
        else:  # what its own build writes
            parts = "".join(f'#include "{file.name}"\n' for file in (files[1], files[0], files[2]))
            archive.writestr("sources/all.c", f"#define FMI_VERSION {version}\n{parts}")
        for resource in model.glob("*.txt"):
            archive.write(resource, f"resources/{resource.name}")
    return fmu

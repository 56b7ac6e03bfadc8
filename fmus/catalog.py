"""The components: one C++ header each, found in the source tree, or where somebody else has it."""

import hashlib
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Literal

from fmus.code import Place, code_lines, line_of
from fmus.errors import AdcsError
from fmus.freshness import orphaned
from fmus.nearby import instead
from fmus.packages import GROUP, component_files, points, warn_once
from fmus.paths import BUILD, SOURCES
from fmus.spelling import close

Kind = Literal["guidance", "plant", "environment", "sensor", "observer", "controller"]

KINDS: dict[str, Kind] = {
    "guidance": "guidance",
    "plant": "plant",
    "environment": "environment",
    "sensors": "sensor",
    "observers": "observer",
    "controllers": "controller",
}
"""Source folder -> kind of component, in the order of the data flow."""


@dataclass(frozen=True)
class Component:
    """A component header `src/<folder>/<snake_case>.hpp`, or any other one, that defines `struct CamelCase`."""

    name: str
    kind: str
    header: Path
    summary: str
    root: Path | None = None
    """The folder from which a header from elsewhere is included, and others beside it."""

    @property
    def include(self) -> str:
        """How C++ code includes the header."""
        return self.header.relative_to(self.root or SOURCES).as_posix()

    @property
    def outside(self) -> bool:
        """Whether it is none of this project's."""
        return self.root is not None

    @property
    def key(self) -> str:
        """Stands for the place of a header from elsewhere, of which several may have one name."""
        return hashlib.sha256(str(self.header).encode()).hexdigest()[:12]

    @property
    def home(self) -> Path | None:
        """The folder of the FMUs of a header from elsewhere: its own, if that can be written to."""
        if not self.outside:
            return None
        beside = self.header.parent
        return beside if os.access(beside, os.W_OK) else BUILD / "outside" / self.key / "fmus"

    @property
    def source(self) -> str:
        """What it is found by: its name, or the path of a header from elsewhere."""
        return str(self.header) if self.outside else self.name

    @property
    def text(self) -> str:
        """The header's leading `///` block: Markdown with LaTeX between dollar signs."""
        lines = []
        for line in self.header.read_text(encoding="utf-8").splitlines():
            if not line.startswith("///"):
                break
            lines.append(line[3:].removeprefix(" "))
        return "\n".join(lines) + "\n"


def components() -> list[Component]:
    """All components, in the order of `KINDS`, then by name."""
    headers = ((header, kind) for folder, kind in KINDS.items() for header in sorted((SOURCES / folder).glob("*.hpp")))
    return [component for header, kind in headers if (component := _component(header, kind))]


FILE_NAME = "[a-z][a-z0-9]*(_[a-z][a-z0-9]*)*"  # so that no two names become one in CamelCase


def meant(name: str) -> list[Component]:
    """The components that a name, a header, or a folder of headers stands for; AdcsError if there is none."""
    if not Path(name).is_dir():
        return [find(name)]
    headers = (path for path in sorted(Path(name).glob("*.hpp")) if "declare(" in path.read_text(errors="replace"))
    found = [from_header(path) for path in headers]
    if not found:
        raise AdcsError(f"{name} has no header of a component: `adcs new controller my_law --to {name}` writes one")
    return found


def struct_name(stem: str) -> str:
    """What the struct of a header is called: the file's name in CamelCase."""
    return "".join(word.capitalize() for word in stem.split("_"))


def is_header(name: str | Path) -> bool:
    """Whether this is the path of a component's header."""
    return Path(name).suffix == ".hpp"


def from_header(path: Path) -> Component:
    """The component that a header from anywhere declares; AdcsError in one line if it declares none."""
    header = Path(os.path.abspath(path))  # noqa: PTH100  without `..`, as the compiler names what it includes
    if not header.is_file():
        raise AdcsError(f"{path} is no file{instead(path)}")
    if not re.fullmatch(FILE_NAME, header.stem):
        raise AdcsError(f"{path}: small letters, digits and underscores make the name of a header, as in my_law.hpp")
    found = _component(header, "controller")
    if found is None:
        raise AdcsError(f"{path} declares no component: `adcs new controller my_law` writes one to begin with")
    code = header.read_text(encoding="utf-8")
    if not re.search(r'^\s*#\s*include\s*["<][^">]+\.hpp[">]', code, re.MULTILINE):
        raise AdcsError(f'{path} includes nothing that a component is made of: #include "fmi/declaration.hpp"')
    said = re.search(r'\bkind\s*=\s*"(\w*)"', code)
    kind = said[1] if said else KINDS.get(header.parent.name) or _assumed_kind(header, found.kind)
    if kind not in KINDS.values():
        raise AdcsError(
            f"{line_of(header, 'kind') or path}: kind = {kind!r} is unknown: use {' or '.join(KINDS.values())}"
        )
    return replace(found, kind=kind, header=header, root=header.parent)


def _assumed_kind(header: Path, kind: str) -> str:
    """Return the kind of a header that says none, and say so."""
    warn_once(f'{header} says no kind and is taken for a {kind}: static constexpr auto kind = "sensor"; is another')
    return kind


@dataclass(frozen=True)
class Brought:
    """A component that another package brings: its header, which is built when it is used, or FMUs."""

    name: str
    package: str
    """Whose it is, in words."""
    header: Path | None = None
    fmus: tuple[Path, ...] = ()


def brought(asked: str | None = None, run_code: bool = True) -> dict[str, Brought]:
    """The components of other packages by name; without `run_code` those that are found without running theirs.

    One whose name something else has, here or there, is told, if it is asked for by that name, or all are.
    """
    found: dict[str, Brought] = {}
    if not points(GROUP):
        return found
    own = {component.name for component in components()}
    for path, package in component_files(asked in own, run_code and asked not in own):
        header = path if is_header(path) else None
        if header is not None and "declare(" not in header.read_text(encoding="utf-8", errors="replace"):
            continue
        if header is None and orphaned(path):
            continue
        name = path.name.partition(".")[0] if header is None else struct_name(path.stem)
        known = found.get(name, Brought(name, package))
        if name in own or known.package != package or (header and known.header):
            whose = "this project" if name in own else known.package
            if asked in (None, name):
                warn_once(f"{name} is a component of {whose}; that of {package}, {path}, goes by its path only")
        elif header is None:
            found[name] = replace(known, fmus=(*known.fmus, path))
        else:
            found[name] = replace(known, header=header)
    return found


def find(name: str, others: Iterable[str] = ()) -> Component:
    """The component called `name`, or declared in this header; AdcsError if there is none.

    Those of this project come first, then those of other packages. One of the `others` may have been meant instead.
    """
    if is_header(name):
        return from_header(Path(name))
    if (own := _own(name)) is not None:
        return own
    theirs = brought(name)
    if name in theirs:
        if (header := theirs[name].header) is not None:
            return from_header(header)
        raise AdcsError(f"{name} of {theirs[name].package} is an FMU without its header: {theirs[name].fmus[0]}")
    meant = close(name, [*(component.name for component in components()), *theirs, *others])
    raise AdcsError(f"no component is called {name}: {f'did you mean {meant}?' if meant else '`adcs list` shows all'}")


def _own(name: str) -> Component | None:
    file = re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower() + ".hpp"
    for folder, kind in KINDS.items():  # where it should be; reading all of them takes a hundred times as long
        found = _component(SOURCES / folder / file, kind)
        if found is not None and found.name == name:
            return found
    return next((component for component in components() if component.name == name), None)


def _component(header: Path, kind: str) -> Component | None:
    try:
        status = header.stat()
    except (OSError, ValueError):  # none, or a name that none can have
        return None
    return _read(header, kind, status.st_mtime_ns, status.st_size)


def _misnamed(header: Path, name: str) -> str:
    """Say what a header has instead of the struct of this name."""
    others = [
        line for line in code_lines(header) if re.search(r"\b(?:struct|class)\s+\w+\s*(?:final\s*)?(?::|\{|$)", line[1])
    ]
    declared = next((number for number, line in code_lines(header) if "declare(" in line), 0)
    number, line = max((each for each in others if each[0] <= declared), default=(1, ""))
    place = Place(header, number)
    if re.search(rf"\bclass {name}\b", line):
        return f"{place}: a component is a struct, whose members are public (struct {name})"
    found = re.search(r"\b(?:struct|class)\s+(\w+)", line)
    instead = f", but {found[1]}" if found else ""
    return f"{place}: there is no `struct {name}`{instead}; a component's struct has its file's name in CamelCase"


@cache
def _read(header: Path, kind: str, _modified: int, _size: int) -> Component | None:
    name = struct_name(header.stem)
    try:
        code = header.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise AdcsError(f"{header} cannot be read ({error}): save it in UTF-8") from None
    if "declare(" not in code:
        return None  # shared between components
    if not re.search(rf"\bstruct {name}\b", code):
        raise AdcsError(_misnamed(header, name))
    summary = re.search(r'\bsummary\s*=\s*"([^"]*)"', code)
    return Component(name, kind, header, summary[1] if summary else "")

"""The shared libraries: that they suit their platform, need nothing special, and export the FMI functions only."""

import re
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import PurePosixPath

import lief

from fmus.checks import Note
from fmus.paths import FMI_HEADERS
from fmus.spelling import some

GLIBC_FLOOR = (2, 17)
_NEEDED = re.compile(
    r"(lib[cm]|ld-linux-[\w-]+)\.so\.\d+|KERNEL32\.dll|api-ms-win-crt-[\w-]+\.dll|/usr/lib/libSystem\.B\.dylib", re.I
)
"""Libraries that are part of every Linux, Windows 10 and macOS."""
_LINKER_MADE = {"_mh_dylib_header", "__dso_handle"}  # macOS has them in every library
_X86_32 = frozenset({"I386", "X86"})
_X86 = frozenset({"X86_64", "AMD64"})
_ARM = frozenset({"AARCH64", "ARM64"})
_ARCHITECTURES = {
    **dict.fromkeys(("linux64", "win64"), _X86),
    "darwin64": _X86 | _ARM,
    **dict.fromkeys(("x86_64-linux", "x86_64-windows", "x86_64-darwin"), _X86),
    **dict.fromkeys(("aarch64-linux", "aarch64-darwin", "aarch64-windows"), _ARM),
    **dict.fromkeys(("linux32", "win32", "darwin32", "x86-linux", "x86-windows"), _X86_32),
}
_FORMATS = {"linux": "ELF", "win": "PE", "darwin": "Mach-O"}
"""By how the name of a platform's system begins."""
_Library = lief.ELF.Binary | lief.PE.Binary | lief.MachO.Binary


_OF_INTERFACE = {
    "2": {
        "ModelExchange": "EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime "
        "SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates",
        "CoSimulation": "SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus "
        "GetIntegerStatus GetBooleanStatus GetStringStatus",
    },
    "3": {
        "ModelExchange": "InstantiateModelExchange EnterContinuousTimeMode CompletedIntegratorStep SetTime "
        "SetContinuousStates GetContinuousStateDerivatives GetEventIndicators GetContinuousStates "
        "GetNominalsOfContinuousStates GetNumberOfEventIndicators GetNumberOfContinuousStates",
        "CoSimulation": "InstantiateCoSimulation EnterStepMode GetOutputDerivatives DoStep",
        "ScheduledExecution": "InstantiateScheduledExecution ActivateModelPartition",
    },
}
"""Functions that only an FMU with this interface needs, by major version of FMI."""
_ALL = frozenset({"ModelExchange", "CoSimulation", "ScheduledExecution"})


def check_binary(name: str, content: bytes, fmi_version: str, interfaces: Collection[str] = _ALL) -> Iterator[str]:
    """`name` is the path in the FMU, `fmi_version` and `interfaces` those whose functions must be there."""
    folder = PurePosixPath(name).parts[1]
    parsed = _parsed(content)
    if parsed is None:
        yield f"{name} is no shared library"
        return
    expected_format = _format_of(folder)
    if expected_format not in (None, _format(parsed)):
        yield f"{name} is a library of the format {_format(parsed)}, expected {expected_format}"
        return
    slices = _slices(parsed)
    architectures = {_architecture(part) for part in slices}
    expected = _ARCHITECTURES.get(folder, architectures)
    if not architectures & expected:
        yield f"{name} is for {', '.join(sorted(architectures))}, expected {' or '.join(sorted(expected))}"
    for part in slices:
        if not _is_shared(part):
            yield f"{name} is no shared library, but {part.header.file_type.name.lower()}"  # type: ignore[union-attr]
        exported = set(_exports(part)) - _LINKER_MADE
        if missing := needed_functions(fmi_version, interfaces) - exported:
            yield f"{name} does not export {', '.join(sorted(missing))}"
        if extra := exported - functions("2.0") - functions("3.0"):
            yield Note(f"{name} exports {some(sorted(extra))}, which are no FMI functions")
        for library in _needs(part):
            if not _NEEDED.fullmatch(library):
                yield Note(f"{name} needs {library}, which may not be installed")
        if isinstance(part, lief.ELF.Binary):
            yield from _check_glibc(name, part)


def imported(content: bytes) -> set[str]:
    """Return the functions that a library takes from others, as C code calls them; none if it cannot be read."""
    parsed = _parsed(content)
    slices = [] if parsed is None else _slices(parsed)
    return {
        str(function.name).removeprefix("_" if isinstance(part, lief.MachO.Binary) else "")
        for part in slices
        for function in part.imported_functions
    }


def _parsed(content: bytes) -> _Library | lief.MachO.FatBinary | None:
    lief.logging.disable()
    universal = content.startswith(b"\xca\xfe\xba\xbe")  # of which `lief.parse` returns one library only
    parsed = (lief.MachO.parse(content) if universal else None) or lief.parse(content)
    return parsed if isinstance(parsed, _Library | lief.MachO.FatBinary) else None


def _slices(parsed: _Library | lief.MachO.FatBinary) -> list[_Library]:
    return list(parsed) if isinstance(parsed, lief.MachO.FatBinary) else [parsed]


def _format_of(folder: str) -> str | None:
    """Return the format of libraries of a platform, None where the folder's name is of no platform known here."""
    system = folder.rpartition("-")[2]
    return next((name for start, name in _FORMATS.items() if system.startswith(start)), None)


def _format(library: _Library | lief.MachO.FatBinary) -> str:
    match library:
        case lief.ELF.Binary():
            return "ELF"
        case lief.PE.Binary():
            return "PE"
    return "Mach-O"


def _is_shared(part: _Library) -> bool:
    match part:
        case lief.ELF.Binary():
            return part.header.file_type == lief.ELF.Header.FILE_TYPE.DYN
        case lief.MachO.Binary():
            return part.header.file_type in (lief.MachO.Header.FILE_TYPE.DYLIB, lief.MachO.Header.FILE_TYPE.BUNDLE)
    return True


@cache
def functions(fmi_version: str) -> frozenset[str]:
    """All functions of a version of FMI, from its header."""
    major = fmi_version[0]
    header = (FMI_HEADERS / f"fmi{major}Functions.h").read_text(encoding="utf-8")
    return frozenset(re.findall(rf"#\s*define\s+(fmi{major}\w+)\s+fmi{major}FullName\(", header))


def needed_functions(fmi_version: str, interfaces: Collection[str]) -> frozenset[str]:
    """The functions that all FMUs have, and those of these interfaces."""
    major = fmi_version[0]
    others = [names for interface, names in _OF_INTERFACE[major].items() if interface not in interfaces]
    return functions(fmi_version) - {f"fmi{major}{name}" for names in others for name in names.split()}


def _check_glibc(name: str, part: lief.ELF.Binary) -> Iterator[str]:
    for requirement in part.symbols_version_requirement:
        if not _NEEDED.fullmatch(str(requirement.name)):
            continue  # said already
        for version in requirement.get_auxiliary_symbols():
            version_name = str(version.name)
            match = re.fullmatch(r"GLIBC_([\d.]+)", version_name)
            if not match or tuple(map(int, match[1].split("."))) > GLIBC_FLOOR:
                floor = ".".join(map(str, GLIBC_FLOOR))
                yield Note(f"{name} needs {version_name} of {requirement.name}, expected GLIBC_{floor} or older")


def _architecture(part: _Library) -> str:
    match part:
        case lief.ELF.Binary():
            return part.header.machine_type.name
        case lief.PE.Binary():
            return part.header.machine.name
        case lief.MachO.Binary():
            return part.header.cpu_type.name


def _exports(part: _Library) -> list[str]:
    match part:
        case lief.PE.Binary():
            export = part.get_export()
            return [str(entry.name) for entry in export.entries] if export else []
        case lief.MachO.Binary():
            return [str(symbol.name).removeprefix("_") for symbol in part.exported_symbols]
        case lief.ELF.Binary():
            return [str(symbol.name) for symbol in part.exported_symbols]


def _needs(part: _Library) -> list[str]:
    if isinstance(part, lief.MachO.Binary):
        own_name = lief.MachO.LoadCommand.TYPE.ID_DYLIB
        return [str(library.name) for library in part.libraries if library.command != own_name]
    return [str(library) for library in part.libraries]

"""No law calls a function that the C library of each platform rounds in its own way."""

import re
import zipfile

import lief
import pytest

from fmus import catalog, fmu_path
from fmus.paths import SOURCES
from fmus.toolchain import host

FUNCTIONS = (
    *(
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sincos",
        "sinh",
        "cosh",
        "tanh",
        "asinh",
        "acosh",
        "atanh",
    ),
    *("exp", "exp2", "exp10", "expm1", "log", "log2", "log10", "log1p", "pow", "cbrt", "hypot", "fma"),
    *("erf", "erfc", "tgamma", "lgamma"),
)
"""Those that IEEE 754 does not round exactly, or that compilers may fuse. sqrt, abs, floor and ceil are exact."""
FORBIDDEN = re.compile(rf"\bstd::({'|'.join(FUNCTIONS)})\b|(?<![\w:])::({'|'.join(FUNCTIONS)})\s*\(")


@pytest.mark.parametrize(
    "line", ["using std::sin;", "x = std::pow(y, 3);", "return ::exp(x);", "using std::cos, std::sin;"]
)
def test_what_is_looked_for_is_found(line: str) -> None:
    assert FORBIDDEN.search(line)


@pytest.mark.parametrize("line", ["using math::sin;", "math::exp(x)", "std::sqrt(x)", "std::exponent", "table::log(x)"])
def test_nothing_else_is_found(line: str) -> None:
    assert not FORBIDDEN.search(line)


def test_sources_call_none_by_its_full_name() -> None:
    sources = [path for pattern in ("*.hpp", "*.cpp") for path in SOURCES.rglob(pattern)]
    assert len(sources) > 70
    found = [
        f"{path.relative_to(SOURCES)}:{number}: {line.strip()}"
        for path in sources
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if FORBIDDEN.search(line)
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("name", [component.name for component in catalog.components()])
def test_binaries_import_none(name: str) -> None:
    """Whatever the source says: the linker knows what is called."""
    target = host()
    with zipfile.ZipFile(fmu_path(name)) as fmu:
        binary = lief.parse(fmu.read(f"binaries/{target.fmi2_folder}/{name}{target.suffix}"))
    assert isinstance(binary, lief.ELF.Binary | lief.PE.Binary | lief.MachO.Binary)
    imported = {str(function.name).removeprefix("_") for function in binary.imported_functions}
    assert {"free", "malloc"} & imported  # they were read
    assert not imported & {f"{function}{suffix}" for function in FUNCTIONS for suffix in ("", "f", "l")}

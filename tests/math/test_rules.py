"""No law calls a function that the C library of each platform rounds in its own way."""

import re
import zipfile

import pytest

from fmus import catalog, fmu_path
from fmus.checks.binary import imported
from fmus.checks.functions import FUNCTIONS, called_in, offered
from fmus.paths import SOURCES
from fmus.toolchain import host


@pytest.mark.parametrize(
    "line", ["using std::sin;", "x = std::pow(y, 3);", "return ::exp(x);", "using std::cos, std::sin;"]
)
def test_what_is_looked_for_is_found(line: str) -> None:
    assert list(called_in(line))


@pytest.mark.parametrize(
    "line", ["using math::sin;", "math::exp(x)", "std::sqrt(x)", "std::exponent", "table::log(x)", "x;  // std::sin"]
)
def test_nothing_else_is_found(line: str) -> None:
    assert not list(called_in(line))


def test_every_function_is_in_the_table_of_the_contributing_guide() -> None:
    text = (SOURCES.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text[text.index("## Functions") : text.index("## Units")]
    assert set(offered()) == set(
        re.findall(r"`(\w+)\(", "".join(line.split("|")[1] for line in table.splitlines() if line[:1] == "|"))
    )


def test_sources_call_none_by_its_full_name() -> None:
    sources = [path for pattern in ("*.hpp", "*.cpp") for path in SOURCES.rglob(pattern)]
    assert len(sources) > 70
    found = [
        f"{path.relative_to(SOURCES)}:{number}: {function}"
        for path in sources
        for number, function in called_in(path.read_text(encoding="utf-8"))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("name", [component.name for component in catalog.components()])
def test_binaries_import_none(name: str) -> None:
    """Whatever the source says: the linker knows what is called."""
    target = host()
    with zipfile.ZipFile(fmu_path(name)) as fmu:
        called = imported(fmu.read(f"binaries/{target.fmi2_folder}/{name}{target.suffix}"))
    assert {"free", "malloc"} & called  # they were read
    assert not called & {f"{function}{suffix}" for function in FUNCTIONS for suffix in ("", "f", "l")}

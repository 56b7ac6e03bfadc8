"""What other packages bring by entry points: listed without running it, loaded when asked for, refused in a line."""

from __future__ import annotations

import gc
import sys
import warnings
from pathlib import Path

import pytest

import adcs
from adcs import listed
from adcs.catalogue import STUDIES, SYSTEMS, find_system
from adcs.cli.app import app
from fmus import catalog
from orchestration.system import Times
from tests.invoking import invoke

MODULE = """
import pathlib
pathlib.Path(__file__).with_name("was_run").touch()
from adcs import System, SystemEntry

def detumble():
    return System("detumble", "a tumbling body")

made = System("made", "made already")

async def waits():
    return System("waits")

hidden = lambda: waits()

def yields():
    yield System("yields")

def needs(mass):
    return System("needs")

def nothing():
    System("nothing")

class Mission:
    pass

class Kind(System):
    def __init__(self):
        super().__init__("kind")

class Object:
    def __call__(self):
        return System("object")

class Waiting:
    async def __call__(self):
        return System("object")

thing, waiting, number = Object(), Waiting(), 3

def nobody(result):
    return []

def entry(**more):
    given = {"make": detumble, "stop_time": 2, "step": 1, "figures": nobody, "key_numbers": nobody}
    return SystemEntry("full", "with figures", "their paper", **{**given, **more})

full = entry()

def late():
    return entry(stop_time="60s")

def unmade():
    return entry(make=detumble())

def makes_nothing():
    return entry(make=nothing)

def makes_trouble():
    return entry(make=lambda: 1 / 0)

def refuses():
    System("refuses").connect("a.b", "c.d")

async def headers():
    return "x.hpp"
"""
POINTS = """
[adcs.systems]
their-detumble = their_parts.inner:detumble
their-made = their_parts.inner:made
their-kind = their_parts.inner:Kind
their-thing = their_parts.inner:thing
waits = their_parts.inner:waits
hidden = their_parts.inner:hidden
yields = their_parts.inner:yields
needs = their_parts.inner:needs
nothing = their_parts.inner:nothing
mission = their_parts.inner:Mission
waiting = their_parts.inner:waiting
number = their_parts.inner:number
module = their_parts.inner
absent = their_parts.inner:absent
refuses = their_parts.inner:refuses
their-full = their_parts.inner:full
late = their_parts.inner:late
unmade = their_parts.inner:unmade
makes-nothing = their_parts.inner:makes_nothing
makes-trouble = their_parts.inner:makes_trouble

[adcs.components]
laws = their_parts.inner:headers
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package that leaves a file behind when its code runs; returns the path of that."""
    (tmp_path / "their_parts").mkdir()
    (tmp_path / "their_parts" / "__init__.py").write_text(MODULE.partition("from adcs")[0])
    (tmp_path / "their_parts" / "inner.py").write_text(MODULE)
    about = tmp_path / "their_parts-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their-parts\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(POINTS)
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("their_parts", "their_parts.inner"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return tmp_path / "their_parts" / "was_run"


def test_a_list_runs_nothing_of_a_package(package: Path) -> None:
    shown = " ".join(invoke(app, ["list"]).stdout.split())
    assert "their-detumble their_parts.inner:detumble, of the package their-parts" in shown
    assert "laws more components: their_parts.inner:headers, of the package their-parts" in shown
    assert not package.exists()
    assert "their-detumble" in adcs.systems() and not package.exists()
    assert find_system("observer-pd").name == "observer-pd" and not package.exists()
    for own in ("observer-pd", "RigidBody"):
        assert own in invoke(app, ["info", own]).stdout and not package.exists()
    assert adcs.systems()["their-detumble"].build().description == "a tumbling body"
    assert package.exists()


def test_what_may_stand_for_a_system(package: Path) -> None:
    names = ("detumble", "made", "kind", "thing")
    assert [find_system(f"their-{name}").build().name for name in names] == ["detumble", "made", "kind", "object"]


def test_an_entry_brings_its_times_and_what_its_report_shows(package: Path) -> None:
    entry = find_system("their-full")
    assert (entry.name, entry.reference, entry.build().times) == ("full", "their paper", Times(0.0, 2.0, 1.0))


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("late", "stop_time = '60s': expected a number"),
        ("unmade", "make = <System detumble: no components; 0 connections>: expected a function"),
        ("makes-nothing", "what make of the system full returns = None: expected an adcs.System"),
        ("makes-trouble", "ZeroDivisionError: division by zero"),
    ],
)
def test_an_entry_with_a_mistake_is_told_in_a_line(package: Path, name: str, why: str) -> None:
    with pytest.raises(adcs.AdcsError) as refused:
        find_system(name).build()
    assert str(refused.value) == f"the system {name} of the package their-parts cannot be loaded: {why}"


WRITE = "write a function without arguments that returns an adcs.System"
EXPECTED = "expected an adcs.System, or a function without arguments that returns one"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("waits", "their_parts.inner:waits is async, and nobody awaits it: write def, without async"),
        ("waiting", "their_parts.inner:waiting is async, and nobody awaits it: write def, without async"),
        ("yields", "their_parts.inner:yields yields, and is run by nobody: return an adcs.System"),
        ("needs", f"their_parts.inner:needs needs mass: {WRITE}"),
        ("nothing", f"their_parts.inner:nothing returned None: {EXPECTED}"),
        ("mission", f"their_parts.inner:Mission is a class: {WRITE}"),
        ("number", f"their_parts.inner:number is 3: {EXPECTED}"),
        (
            "module",
            "their_parts.inner is a module: name the function in it that returns an adcs.System, "
            "their_parts.inner:FUNCTION",
        ),
        ("absent", "AttributeError: module 'their_parts.inner' has no attribute 'absent'"),
        ("refuses", "'a.b': system 'refuses' has no component 'a': it has none"),
    ],
)
def test_what_is_no_system_is_told_in_a_line(package: Path, name: str, why: str) -> None:
    with pytest.raises(adcs.AdcsError) as refused:
        find_system(name)
    assert str(refused.value) == f"the system {name} of the package their-parts cannot be loaded: {why}"


def test_nobody_is_told_of_a_coroutine_that_was_never_awaited(package: Path) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with pytest.raises(
            adcs.AdcsError, match=r"hidden returned <coroutine object waits at .*: expected an adcs.System"
        ):
            find_system("hidden")
        gc.collect()
    assert [str(each.message) for each in caught if each.category is RuntimeWarning] == []


@pytest.mark.filterwarnings("error")
def test_an_async_function_for_folders_is_told_in_a_line(package: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert catalog.brought("NoSuchLaw") == {}
    assert caplog.messages == [
        "the components laws of the package their-parts cannot be found: their_parts.inner:headers is async, and "
        "nobody awaits it: write def, without async"
    ]


def test_what_is_listed_is_what_is_there() -> None:
    assert {name: entry.description for name, entry in SYSTEMS.items()} == listed.SYSTEMS
    assert [entry.name for entry in SYSTEMS.values()] == [*listed.SYSTEMS]
    assert [entry.name for entry in STUDIES.values()] == [*listed.STUDIES]
    assert repr(STUDIES) == "<deruiter, six-dof, thakur, trigo, velocity-free>"
    assert len(SYSTEMS) == 44 and "nothing" not in SYSTEMS
    with pytest.raises(KeyError):
        SYSTEMS["nothing"]

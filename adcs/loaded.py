"""A system that another package brings, loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import EntryPoint
from inspect import isclass, iscoroutine
from types import ModuleType
from typing import Any, TypeVar

from fmus.callables import unfit
from fmus.errors import AdcsError, Failed, shown
from fmus.packages import package_of
from orchestration.entry import SystemEntry
from orchestration.from_file import entry_of
from orchestration.system import System

_EXPECTED = "an adcs.System"
_Made = TypeVar("_Made")


def load(point: EntryPoint) -> SystemEntry:
    """Return the system: a `SystemEntry`, a `System`, or what a function returns that is one of them."""
    found = _telling(point, lambda: _found(point))
    if isinstance(found, System):
        return entry_of(found, point.name)
    return replace(found, make=lambda: _telling(point, found.build))


def _telling(point: EntryPoint, work: Callable[[], _Made]) -> _Made:
    """Do what runs code of the package; an error in it is told with whose it is."""
    try:
        return work()
    except (Exception, SystemExit) as error:
        kind = Failed if isinstance(error, AdcsError) and error.failed else AdcsError
        why = str(error) if isinstance(error, AdcsError) else f"{type(error).__name__}: {error}"
        told = f"the system {point.name} of {package_of(point)} cannot be loaded: {shown(why, 300)}"
        raise kind(told) from error


def _found(point: EntryPoint) -> System | SystemEntry:
    found: Any = point.load()
    why = _no_maker(found, point)
    if not why and callable(found):
        found = found()
        why = _no_system(found, f"{point.value} returned")
    if why:
        raise AdcsError(why)
    assert isinstance(found, System | SystemEntry)
    return found


def _no_maker(found: Any, point: EntryPoint) -> str:
    """Say why what an entry point names is neither a system nor a function to be called for one; empty if it is."""
    if isinstance(found, ModuleType):
        return f"{point.value} is a module: name the function in it that returns {_EXPECTED}, {point.value}:FUNCTION"
    if not callable(found):
        return _no_system(found, f"{point.value} is")
    if isclass(found) and not issubclass(found, System | SystemEntry):
        return f"{point.value} is a class: write a function without arguments that returns {_EXPECTED}"
    why = unfit(found, _EXPECTED)
    return f"{point.value} {why}" if why else ""


def _no_system(found: Any, said: str) -> str:
    if isinstance(found, System | SystemEntry):
        return ""
    if iscoroutine(found):
        found.close()  # else Python says at some time that nobody awaited it
    return f"{said} {shown(repr(found), 80)}: expected {_EXPECTED}, or a function without arguments that returns one"

"""The types of what runs and sessions are asked for: a wrong one is refused before it goes deeper."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from typing import Any

from fmus.errors import AdcsError, shown
from orchestration import expected
from orchestration.plan.loops import LoopSolver
from orchestration.running.hook import Hook
from orchestration.system import check_system

Rule = Callable[[str, object], None]


def check(function: Callable[..., Any], given: Mapping[str, Any], **rules: Rule) -> None:
    """Refuse arguments of this function that are of a wrong type; None is right where it is the default.

    Most arguments have one rule in all functions; those that mean something else here get theirs by name.
    """
    defaults = {name: p.default for name, p in inspect.signature(function).parameters.items()}
    for name, rule in (_RULES | rules).items():
        if name in defaults and not (given[name] is None and defaults[name] is None):
            rule(name, given[name])


def _count(name: str, value: object, least: int = 1) -> None:
    if not isinstance(value, int) or value < least:
        raise expected.refused(name, value, f"a whole number of steps from {least}")


def _changes(name: str, value: object) -> None:
    for change in expected.collection(name, value):
        if not isinstance(change, list | tuple) or len(change) != 3:
            raise AdcsError(f"{name}: {shown(repr(change))} is no change: expected (time, name, value)")
        time, variable, _ = change
        expected.text(f"{name}: name", variable)
        expected.number(f"{name}: time", time)


def _watchers(name: str, value: object) -> None:
    for watcher in expected.collection(name, value):
        if not isinstance(watcher, Hook):
            raise expected.refused(name, watcher, "hooks, as adcs.Hook describes them")


def _function(name: str, value: object) -> None:
    if not callable(value):
        raise expected.refused(name, value, "what can be called")


def loop_solver(name: str, value: object) -> None:
    """Refuse what is no LoopSolver."""
    if not isinstance(value, LoopSolver):
        raise expected.refused(name, value, 'a LoopSolver, as adcs.LoopSolver("newton")')


def _loop_solver_or_its_fields(name: str, value: object) -> None:
    if not isinstance(value, Mapping):
        loop_solver(name, value)
        return
    known = [field.name for field in fields(LoopSolver)]
    for key in value:
        if key not in known:
            raise AdcsError(f"{name}: {key!r} is unknown: use {', '.join(known)}")


_RULES: dict[str, Rule] = {
    "system": lambda name, value: check_system(value),
    **dict.fromkeys(("stop_time", "step", "start_time", "rtol", "atol", "timeout"), expected.number),
    **dict.fromkeys(("real_time", "adaptive", "checkpoint_every"), expected.number),
    "record_every": _count,
    "steps": partial(_count, least=0),
    "external": expected.texts,
    **dict.fromkeys(("inputs", "hdf5", "checkpoint", "resume"), expected.path),
    "until": expected.text,
    "changes": _changes,
    "watchers": _watchers,
    "progress": _function,
    "solve_loops": _loop_solver_or_its_fields,
}

"""The types of what runs and sessions are asked for: a wrong one is refused before it goes deeper."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from orchestration import expected
from orchestration.running.hook import Hook
from orchestration.system import check_system

Rule = Callable[[str, object], object]


def check(function: Callable[..., Any], given: Mapping[str, Any], **rules: Rule) -> None:
    """Refuse arguments of this function that are of a wrong type; None is right where it is the default.

    Most arguments have one rule in all functions; those that mean something else here get theirs by name.
    """
    defaults = {name: p.default for name, p in inspect.signature(function).parameters.items()}
    for name, rule in (_RULES | rules).items():
        if name in defaults and not (given[name] is None and defaults[name] is None):
            rule(name, given[name])


def _hooks(name: str, value: object) -> None:
    for hook in expected.collection(name, value):
        if not isinstance(hook, Hook):
            raise expected.refused(name, hook, "hooks, as adcs.until(...), or what adcs.Hook describes")


def _function(name: str, value: object) -> None:
    if not callable(value):
        raise expected.refused(name, value, "what can be called")


def _yes_or_no(name: str, value: object) -> None:
    if not isinstance(value, bool):
        raise expected.refused(name, value, "True or False")


def made(kind: type, example: str) -> Rule:
    """Return the rule that something is of a class; `example` says how one is made."""

    def rule(name: str, value: object) -> None:
        if not isinstance(value, kind):
            raise expected.refused(name, value, example)

    return rule


_RULES: dict[str, Rule] = {
    "system": lambda name, value: check_system(value),
    **dict.fromkeys(("stop_time", "step", "start_time"), expected.seconds),
    "record_every": partial(expected.count, what="a whole number of steps"),
    "steps": partial(expected.count, what="a whole number of steps", least=0),
    "external": expected.texts,
    "resume": expected.path,
    "hooks": _hooks,
    "progress": _function,
    "isolated": _yes_or_no,
}

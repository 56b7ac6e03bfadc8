"""Puts together what components changed that was not theirs: of the process, and of the thread that called them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from orchestration.engine import Engine
from orchestration.engine.python_loop import PythonLoop
from orchestration.instances.instance import Instance
from orchestration.process.guard import Guard


def overstepped(
    instances: Mapping[str, Instance], guard: Guard | None, loops: Iterable[Engine | PythonLoop]
) -> list[str]:
    """Return it as sentences, each once."""
    told = [] if guard is None else guard.warnings([name for name, i in instances.items() if not i.ours])
    for loop in loops:
        if isinstance(loop, Engine):
            told += [f"{who}: changed {w}, which was changed back" for who, what in loop.changed.items() for w in what]
    return list(dict.fromkeys(told))

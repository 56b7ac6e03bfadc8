"""Asks hooks, which may be anybody's: an answer of a wrong kind, or an error, is told by the name of who made it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from fmus.errors import AdcsError, shown
from orchestration import expected
from orchestration.process.watch import Hung
from orchestration.running.change import Change
from orchestration.running.hook import Hook


def ask(hook: Hook, method: str, *arguments: Any) -> Any:
    """Return what a hook answers, checked and made plain. Its errors become AdcsError, so that rows are kept."""
    name = f"{type(hook).__name__}.{method}"
    try:
        answer = getattr(hook, method)(*arguments)
    except (AdcsError, Hung):
        raise
    except Exception as error:
        raise AdcsError(f"{name} raised {type(error).__name__}: {shown(str(error), 200)}") from error
    return _RULES[method](name, answer, *arguments) if method in _RULES else answer


def _wrong(name: str, answer: object, what: str) -> AdcsError:
    return AdcsError(f"{name} returned {shown(repr(answer))}: expected {what}")


def _whole(answer: object) -> int | None:
    return int(answer) if isinstance(answer, int | np.integer) and not isinstance(answer, bool) else None


def _points(name: str, answer: object, k: int) -> int:
    points = _whole(answer)
    if points is None or points < 1:
        raise _wrong(name, answer, "a number of points from 1")
    return points


def _changes(name: str, answer: object, k: int) -> list[Change]:
    if not isinstance(answer, Sequence) or isinstance(answer, str):
        raise _wrong(name, answer, "a list of names and values, [(name, value)]")
    return [change if isinstance(change, Change) else _change(name, change, k) for change in answer]


def _change(name: str, answer: object, k: int) -> Change:
    if not isinstance(answer, tuple | list) or len(answer) != 2 or not isinstance(answer[0], str):
        raise _wrong(name, answer, "names and values, (name, value)")
    return Change(k, *answer)


def _row(name: str, answer: object, times: Sequence[float], rows: object) -> int | None:
    if answer is None:
        return None
    row = _whole(answer)
    if row is None or not 0 <= row < len(times):
        raise _wrong(name, answer, f"None, or the index of one of {len(times)} rows")
    return row


def _texts(name: str, answer: object) -> list[str]:
    try:
        expected.texts(name, answer)
    except AdcsError:
        raise _wrong(name, answer, "a list of texts") from None
    return list(answer)  # type: ignore[call-overload, no-any-return]


def _entries(name: str, answer: object) -> dict[str, Any]:
    if not isinstance(answer, Mapping) or not all(isinstance(key, str) for key in answer):
        raise _wrong(name, answer, "a dict, {name: value}")
    try:
        plain: dict[str, Any] = json.loads(json.dumps(dict(answer), default=_plain))
    except (TypeError, ValueError) as error:
        raise AdcsError(f"{name} returned what no manifest can hold: {error}") from None
    return plain


def _plain(value: object) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{shown(repr(value))} is no number, text, list or dict")


_RULES: dict[str, Callable[..., Any]] = {
    "ahead": _points,
    "changes": _changes,
    "met": _row,
    "notes": _texts,
    "report": _entries,
    "for_manifest": _entries,
}

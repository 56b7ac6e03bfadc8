"""What stands for arguments that a function does not have: those of one version ago, and of a command line."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from fmus.errors import AdcsError, shown
from fmus.spelling import close, hint

_METHOD, _SAVE = "method", "save"
_PARTS = {
    "solver": (_METHOD, ""),
    "rtol": (_METHOD, "rtol="),
    "atol": (_METHOD, "atol="),
    "stepping": (_METHOD, "stepping="),
    "adaptive": (_METHOD, "adaptive="),
    "solve_loops": (_METHOD, "loops="),
    "loops": (_METHOD, "loops="),
    "timeout": (_METHOD, "timeout="),
    "record": (_SAVE, ""),
    "record_every": (_SAVE, "every="),
    "every": (_SAVE, "every="),
    "hdf5": (_SAVE, "to="),
    "journal": (_SAVE, "to="),
    "to": (_SAVE, "to="),
}
"""Which argument it is part of now, and what goes before its value there."""

_COUPLED = {"solver", "rtol", "atol"}
_METHODS = {"model-exchange": "adcs.ModelExchange", "co-simulation": "adcs.CoSimulation"}

_HOOKS = {
    "at": "adcs.at(time, {{name: value}})",
    "changes": "adcs.at(time, {{name: value}})",
    "inputs": "adcs.inputs({})",
    "until": "adcs.until({})",
    "real_time": "adcs.pace({})",
    "checkpoint": "adcs.checkpoint({})",
    "checkpoint_every": "adcs.checkpoint(path, every={})",
    "watchers": "...",
}

_ELSEWHERE = {
    "at": "time={}",
    "out": "result.write_csv(path) of what it returns, or save=adcs.Save(to=path) for HDF5",
    "save": "record={}",
    "set": "system.set(name, value) before",
    "delay": "system.delay(target, seconds=...) before",
}
"""Options of a command line that are something else in Python."""


def refuse_unknown(function: Callable[..., Any], given: Mapping[str, Any]) -> None:
    """Refuse all arguments of one call that a function does not have, in one line with what stands for them."""
    has = inspect.signature(function).parameters
    unknown = {name: value for name, value in given.items() if name not in has}
    method = given.get("method")
    if isinstance(method, str) and method in _METHODS and "method" in has:
        unknown = {"method": method, **unknown}
    if unknown:
        missing = f"has no such argument{'s' * (len(unknown) > 1)}"
        why = "takes no text for a method" if "method" in unknown else missing
        raise AdcsError(f"{', '.join(unknown)}: {function.__name__}() {why}: {'; '.join(_ways(unknown, has))}")


def _ways(unknown: Mapping[str, Any], has: Mapping[str, Any]) -> Iterator[str]:
    left = dict(unknown)
    written = []
    for argument in (_METHOD, _SAVE):
        parts = {n: left.pop(n) for n in unknown if n in _PARTS and _PARTS[n][0] == argument and argument in has}
        named = left.pop("method", None) if argument == _METHOD else None
        if parts or named:
            made = "adcs.Save" if argument == _SAVE else _method(parts, named, has)
            values = [f"{_PARTS[name][1]}{_text(value)}" for name, value in parts.items()]
            values.sort(key=lambda value: "=" in value)  # those without a name first
            written.append(f"{argument}={made}({', '.join(values)})")
    hooks = [_HOOKS[name].format(_text(left.pop(name))) for name in unknown if name in _HOOKS and "hooks" in has]
    if hooks:
        written.append(f"hooks=[{', '.join(hooks)}]")
    if written:
        yield f"write {', '.join(written)}"
    for name, value in left.items():
        if name in _ELSEWHERE:
            yield f"write {_ELSEWHERE[name].format(_text(value))}"
        elif meant := close(name, has):
            yield f"did you mean {meant.partition(' or ')[0]}?"
        else:
            yield hint(name, has)


def _method(parts: Mapping[str, Any], named: str | None, has: Mapping[str, Any]) -> str:
    coupled = bool(_COUPLED & parts.keys()) or "save" not in has  # a linearisation has no other
    return _METHODS[named or ("model-exchange" if coupled else "co-simulation")]


def _text(value: Any) -> str:
    return shown(repr(value), 80)

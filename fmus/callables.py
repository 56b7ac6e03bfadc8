"""Functions of other people's that are called for what they return: whether they can be."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, isasyncgenfunction, isclass, iscoroutinefunction, isgeneratorfunction, signature
from typing import Any

_OPTIONAL = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)


def unfit(function: Callable[..., Any], expected: str) -> str:
    """Say why a function cannot be called for what is expected, in words that follow its name; empty if it can."""
    called = function if isclass(function) else getattr(function, "__call__", function)  # noqa: B004  an object's, too
    for code in (function, called):
        if iscoroutinefunction(code) or isasyncgenfunction(code):
            return "is async, and nobody awaits it: write def, without async"
        if isgeneratorfunction(code):
            return f"yields, and is run by nobody: return {expected}"
    try:
        parameters = signature(function).parameters.values()
    except (TypeError, ValueError):  # of some that are written in C
        return ""
    needed = [p.name for p in parameters if p.default is Parameter.empty and p.kind not in _OPTIONAL]
    if needed:
        return f"needs {' and '.join(needed)}: write a function without arguments that returns {expected}"
    return ""

"""A system from a Python file of anybody's: a function that returns one, or the system itself."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from inspect import Parameter, isfunction, signature
from pathlib import Path
from types import ModuleType
from typing import Any

from fmus.errors import AdcsError, shown
from fmus.spelling import close
from orchestration.system import System

_OPTIONAL = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)


def is_python(name: str) -> bool:
    """Whether a name is that of a Python file, `mission.py`, or of something in one, `mission.py:slew`."""
    return named(name)[0].suffix == ".py"


def named(name: str) -> tuple[Path, str]:
    """Return the path of a file, and the name of what is meant in it; empty if that is not said."""
    path, marked, inside = name.rpartition(".py:")
    return (Path(f"{path}.py"), inside) if marked else (Path(name), "")


def system_from_python(name: str) -> System:
    """Return the system; AdcsError in one line if there is none, or not one alone, or the file fails."""
    path, wanted = named(name)
    if not path.is_file():
        raise AdcsError(f"{path} is no file")
    folder = str(path.absolute().parent)
    sys.path.insert(0, folder)  # for what the file imports from beside itself
    before, written = set(sys.modules), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # nor of these is a compiled copy to be mistaken for the file
    try:
        module = _loaded(path)
        makers = _makers(module)
        if not wanted and len(makers) == 1:
            (wanted,) = makers
        if not makers:
            raise AdcsError(f"{path} has no system: write a function without arguments that returns an adcs.System")
        if not wanted:
            each = " or ".join(f"{path}:{name}" for name in makers)
            raise AdcsError(f"{path} has several systems: give one, {each}")
        if wanted not in makers:
            hint = f"did you mean {meant}?" if (meant := close(wanted, makers)) else f"it has {', '.join(makers)}"
            raise AdcsError(f"{path} has no system {shown(repr(wanted))}: {hint}")
        system = _told(path, makers[wanted])
    finally:
        sys.path.remove(folder)
        sys.dont_write_bytecode = written
        for name in set(sys.modules) - before:  # another file may have others of these names beside it
            if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(folder):
                del sys.modules[name]
    if not isinstance(system, System):
        raise AdcsError(f"{path}:{wanted} returned {shown(repr(system))}: expected an adcs.System")
    return system


def _loaded(path: Path) -> ModuleType:
    """Import the file under a name that nothing else has; again each time, as it may have been changed."""
    name = f"adcs_file_{sha256(str(path.absolute()).encode()).hexdigest()[:12]}"
    spec = spec_from_file_location(name, path)
    assert spec is not None
    module = module_from_spec(spec)
    sys.modules[name] = module  # where dataclasses and pickle look for it
    # not by its loader, whose compiled copy counts as new for a second if the size has stayed
    _told(path, lambda: exec(compile(path.read_bytes(), path, "exec"), vars(module)))
    return module


def _makers(module: ModuleType) -> dict[str, Callable[[], Any]]:
    """Return what makes a system, by name: those that say so, or else whatever can be called without arguments."""
    own = {name: value for name, value in vars(module).items() if not name.startswith("_")}
    made: dict[str, Callable[[], Any]] = {
        name: partial(_itself, value) for name, value in own.items() if isinstance(value, System)
    }
    functions = {
        name: value
        for name, value in own.items()
        if isfunction(value) and value.__module__ == module.__name__ and _without_arguments(value)
    }
    saying = {name: value for name, value in functions.items() if _returns_a_system(value)}
    return {**made, **(saying or ({} if made else functions))}


def _itself(system: System) -> System:
    return system


def _without_arguments(function: Callable[..., Any]) -> bool:
    parameters = signature(function).parameters.values()
    return all(p.default is not Parameter.empty or p.kind in _OPTIONAL for p in parameters)


def _returns_a_system(function: Callable[..., Any]) -> bool:
    said = function.__annotations__.get("return")
    return said is System or (isinstance(said, str) and said.rpartition(".")[2] == System.__name__)


def _told(path: Path, work: Callable[[], Any]) -> Any:
    """Do what runs code of the file; an error in it is told with its line."""
    try:
        return work()
    except (Exception, SystemExit) as error:
        if isinstance(error, SyntaxError) and error.filename:
            where, text = f"{error.filename}:{error.lineno}", f"SyntaxError: {error.msg}"
        else:
            here = (str(path), str(path.absolute()))
            frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in here]
            where = f"{path}:{frames[-1].lineno}" if frames else str(path)
            text = str(error) if isinstance(error, AdcsError) else f"{type(error).__name__}: {error}"
        raise AdcsError(f"{where}: {shown(text, 300)}") from error

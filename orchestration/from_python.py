"""A system from a Python file of anybody's: a function that returns one, or the system itself."""

from __future__ import annotations

import re
import sys
import traceback
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from inspect import Parameter, isfunction
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

from fmus.callables import unfit
from fmus.errors import AdcsError, shown
from fmus.nearby import instead
from fmus.spelling import close
from orchestration.fmu.beside import looked_for_in
from orchestration.system import System


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
        raise AdcsError(f"{path} is no file{instead(path)}")
    folder = str(path.absolute().parent)
    sys.path.insert(0, folder)  # for what the file imports from beside itself
    before, written = set(sys.modules), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # nor of these is a compiled copy to be mistaken for the file
    try:
        with looked_for_in(path.absolute().parent):
            module = _loaded(path)
            makers = _makers(module)
            wanted = wanted or _meant(path, module, makers)
            if wanted not in makers:
                raise AdcsError(_none_of(path, wanted, vars(module), makers))
            system = _told(path, makers[wanted])
    finally:
        sys.path.remove(folder)
        sys.dont_write_bytecode = written
        for name in set(sys.modules) - before:  # another file may have others of these names beside it
            if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(folder):
                del sys.modules[name]
    if not isinstance(system, System):
        others = [f"{path}:{name}" for name in makers if name != wanted]
        more = f"; there is also {' or '.join(others)}" if others else ""
        raise AdcsError(f"{path}:{wanted} returned {shown(repr(system))}: expected an adcs.System{more}")
    return system


def _loaded(path: Path) -> ModuleType:
    """Import the file under a name that nothing else has; again each time, as it may have been changed."""
    name = f"adcs_file_{sha256(str(path.absolute()).encode()).hexdigest()[:12]}"
    spec = spec_from_file_location(name, path)
    assert spec is not None
    module = module_from_spec(spec)
    sys.modules[name] = module  # where dataclasses and pickle look for it
    # not by its loader, whose compiled copy counts as new for a second if the size has stayed
    _told(path, lambda: exec(compile(path.read_bytes(), path, "exec", dont_inherit=True), vars(module)))
    return module


def _makers(module: ModuleType) -> dict[str, Callable[[], Any]]:
    """Return what can make a system, by name: systems, and functions without arguments that say nothing else."""
    makers: dict[str, Callable[[], Any]] = {}
    for name, value in vars(module).items():
        if name.startswith("_"):
            continue
        if isinstance(value, System):
            makers[name] = partial(_itself, value)
        elif _is_own(value, module) and not _why_not(value) and _says(value) is not False:
            makers[name] = value
    return makers


def _meant(path: Path, module: ModuleType, makers: dict[str, Callable[[], Any]]) -> str:
    """Return the name of the one that is meant without one: helpers say less than what is or returns a `System`."""
    clear = [n for n, made in makers.items() if isinstance(made, partial) or _says(made)]
    names = clear or list(makers)
    if len(names) == 1:
        return names[0]
    if names:
        each = " or ".join(f"{path}:{name}" for name in names)
        way = "" if clear else ", or write -> System behind those that return one"
        raise AdcsError(f"{path} has several systems: give one, {each}{way}")
    for name, value in vars(module).items():
        if _is_own(value, module) and _says(value) and (why := _why_not(value)):
            raise AdcsError(f"{path}:{name} {why}")
    raise AdcsError(f"{path} has no system: write a function without arguments that returns an adcs.System")


def _none_of(path: Path, wanted: str, inside: dict[str, Any], makers: dict[str, Callable[[], Any]]) -> str:
    """Say why what is asked for by name is no system."""
    if isfunction(inside.get(wanted)) and (why := _why_not(inside[wanted])):
        return f"{path}:{wanted} {why}"
    if meant := close(wanted, makers):
        hint = f"did you mean {meant}?"
    else:
        hint = f"it has {', '.join(makers)}" if makers else "it has none"
    return f"{path} has no system {shown(repr(wanted))}: {hint}"


def _is_own(value: Any, module: ModuleType) -> bool:
    return isfunction(value) and value.__module__ == module.__name__ and value.__name__ != "<lambda>"


def _why_not(function: Callable[..., Any]) -> str:
    return unfit(function, "an adcs.System")


def _says(function: Callable[..., Any]) -> bool | None:
    """Whether a function says that it returns a system; None if it says nothing."""
    said = function.__annotations__.get("return", Parameter.empty)
    if said is Parameter.empty or said is Any or said == "Any":
        return None
    if isinstance(said, str):  # in quotes, or after `from __future__`
        said = function.__globals__.get(said.strip("'\""), said)
    if isinstance(said, str):
        return re.search(rf"\b{System.__name__}\b", said) is not None
    return any(isinstance(each, type) and issubclass(each, System) for each in get_args(said) or (said,))


def _itself(system: System) -> System:
    return system


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

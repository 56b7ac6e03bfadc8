"""fmpy's classes of FMUs, but that they look at the signatures of their functions once, not for each instance."""

from __future__ import annotations

from typing import Any


def inspected_once(base: Any) -> Any:
    """Return a subclass that takes the types of the C functions from its first instance; it costs a millisecond."""
    known: dict[str, tuple[list[str], list[Any], Any]] = {}

    def load_functions(self: Any) -> None:
        if not known:
            base._loadFunctions(self)
            known.update({name: (f.argnames, f.argtypes, f.restype) for name, f in self._functions.items()})
            return
        for name, (argnames, argtypes, restype) in known.items():
            function = getattr(self.dll, name)
            function.argnames, function.argtypes, function.restype = argnames, argtypes, restype
            self._functions[name] = function

    # of the same name, from which fmpy knows the version of FMI
    return type(base.__name__, (base,), {"_loadFunctions": load_functions})

"""What there is by name, and what each is in a line. Nothing is loaded for that, and no code of others runs."""

from __future__ import annotations

import pkgutil
from collections.abc import Collection
from importlib import import_module
from importlib.metadata import EntryPoint

from adcs import library, others
from fmus import catalog
from fmus.packages import told

# Each folder of `library` brings its own, in its module `catalogue`; its `entries` has what stands for the names.
_BROUGHT = {
    folder.name: import_module(f"{library.__name__}.{folder.name}.catalogue")
    for folder in pkgutil.iter_modules(library.__path__)
    if folder.ispkg
}
SYSTEMS: dict[str, str] = {name: text for brought in _BROUGHT.values() for name, text in brought.SYSTEMS.items()}
"""What each system of this project is."""
FOLDERS: dict[str, str] = {
    name: folder for folder, brought in _BROUGHT.items() for name in (*brought.SYSTEMS, *brought.STUDIES)
}
"""Which folder each system and each study is in."""
STUDIES: tuple[str, ...] = tuple(name for brought in _BROUGHT.values() for name in brought.STUDIES)


def descriptions() -> dict[str, str]:
    """Return what each system is; of one that another package brings, what is loaded for it, and whose that is."""
    own = own_components()
    others.warn_of_clashes(SYSTEMS, "a system")
    others.warn_of_clashes(own, "a component")
    return SYSTEMS | {name: told(point) for name, point in theirs(own).items()}


def theirs(components: Collection[str]) -> dict[str, EntryPoint]:
    """Return the systems of other packages that go by their names, which none of this project's components has."""
    return {name: point for name, point in others.names().items() if name not in SYSTEMS and name not in components}


def own_components() -> set[str]:
    """Return the names of the components of this project."""
    return {component.name for component in catalog.components()}

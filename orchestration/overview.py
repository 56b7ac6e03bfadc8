"""A system in a line, and as a block diagram for a notebook."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from orchestration.diagram import Box, svg

if TYPE_CHECKING:
    from orchestration.system import Component, Connection, System

_NAMES = 8  # components in a line
_MOST = 40  # components that can be taken in


def text(system: System) -> str:
    """Return its name, its components with their FMUs, and how many connections there are."""
    components = [f"{c.name} ({c.fmu.path.name})" for c in system.components.values()]
    more = f" and {len(components) - _NAMES} more" if len(components) > _NAMES else ""
    return f"<System {system.name}: {', '.join(components[:_NAMES]) or 'no components'}{more}; {_connections(system)}>"


def html(system: System) -> str:
    """Return a block diagram; of a system that is too large for one, its numbers."""
    n = len(system.components)
    about = f"<b>{escape(system.name)}</b>{': ' if system.description else ''}{escape(system.description)}"
    if 0 < n <= _MOST:
        return f'<p>{about}</p><div style="overflow-x:auto">{_diagram(system)}</div>'
    size = f"{n} components, too many to be drawn" if n else "no components"
    return f"<p>{about}<br>{size}; {_connections(system)}</p>"


def _diagram(system: System) -> str:
    carried: dict[tuple[str, str], list[Connection]] = {}
    for connection in system.connections:
        ends = connection.source.partition(".")[0], connection.target.partition(".")[0]
        carried.setdefault(ends, []).append(connection)
    blocks = {
        name: Box(_block(component, carried.get((name, name), [])), component.fmu.model.description or "")
        for name, component in system.components.items()
    }
    arrows = {
        ends: Box(list(dict.fromkeys(map(_label, each))), "\n".join(f"{c.source} to {c.target}" for c in each))
        for ends, each in carried.items()
    }
    return svg(blocks, arrows)


def _block(component: Component, to_itself: list[Connection]) -> list[str]:
    every = [f"every {component.every} steps"] if component.every > 1 else []
    return [component.name, component.fmu.path.name, *every, *(f"{_label(c)} to itself" for c in to_itself)]


def _label(connection: Connection) -> str:
    variable = connection.source.partition(".")[2]
    if connection.delay_steps:
        return f"{variable} +{connection.delay_steps} step{'s' if connection.delay_steps > 1 else ''}"
    return f"{variable} +{connection.delay:g} s" if connection.delay else variable


def _connections(system: System) -> str:
    n = len(system.connections)
    return f"{n} connection{'s' if n != 1 else ''}"

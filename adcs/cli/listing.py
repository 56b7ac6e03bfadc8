"""`adcs list`: the components and the systems that there are."""

from __future__ import annotations

from rich.table import Table

from adcs.catalogue import SYSTEMS
from adcs.cli.command import command
from adcs.cli.printing import OUT, Json, print_json
from fmus import catalog
from fmus.built import built

app = command("list", "adcs list", "adcs list --json")


@app.default
def list_command(*, as_json: Json = False) -> None:
    """List the components and the systems made of them."""
    components = catalog.components()
    there = {c.name: {version: str(path) for version, path in built(c).items()} for c in components}
    systems = [{"name": name, "description": system.description} for name, system in SYSTEMS.items()]
    if as_json:
        entries = [
            {"name": c.name, "kind": c.kind, "description": c.summary, "fmus": there[c.name]} for c in components
        ]
        print_json({"components": entries, "systems": systems})
        return
    table = Table("Component", "Kind", "Description", "Built for FMI")
    for c in components:
        table.add_row(c.name, c.kind, c.summary, ", ".join(there[c.name]) or "[dim]when used[/dim]")
    OUT.print(table)
    table = Table("System", "Description")
    for system in systems:
        table.add_row(system["name"], system["description"])
    OUT.print(table)

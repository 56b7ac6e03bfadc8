"""`adcs list`: the components and the systems that there are."""

from __future__ import annotations

from rich.table import Table

from adcs.catalogue import descriptions
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
    listed = [{"name": name, "description": text} for name, text in descriptions().items()]
    if as_json:
        entries = [
            {"name": c.name, "kind": c.kind, "description": c.summary, "fmus": there[c.name]} for c in components
        ]
        print_json({"components": entries, "systems": listed})
        return
    table = Table("Component", "Kind", "Description", "Built for FMI")
    for c in components:
        table.add_row(c.name, c.kind, c.summary, ", ".join(there[c.name]) or "[dim]when used[/dim]")
    OUT.print(table)
    table = Table("System", "Description")
    for system in listed:
        table.add_row(system["name"], system["description"])
    OUT.print(table)

"""`adcs list`: the components and the systems that there are."""

from __future__ import annotations

from adcs.catalogue import descriptions
from adcs.cli.columns import show
from adcs.cli.command import command
from adcs.cli.printing import Json, print_json
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
    built_for = [", ".join(there[c.name]) or "when used" for c in components]
    rows = [[c.name, c.kind, versions] for c, versions in zip(components, built_for, strict=True)]
    show(["Component", "Kind", "Built for FMI"], rows, [c.summary for c in components])
    print()
    show(["System"], [[system["name"]] for system in listed], [system["description"] for system in listed])

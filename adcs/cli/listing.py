"""`adcs list`: the components and the systems that there are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from adcs.cli.columns import show
from adcs.cli.command import command
from adcs.cli.printing import Json, print_json
from adcs.listed import descriptions
from fmus import catalog
from fmus.built import built
from fmus.catalog import Component
from fmus.errors import AdcsError
from fmus.packages import told, told_by_code, warn_once

app = command("list", "adcs list", "adcs list --json")


@app.default
def list_command(*, as_json: Json = False) -> None:
    """List the components and the systems made of them."""
    theirs = catalog.brought(run_code=False)
    components = [*catalog.components(), *_of_headers(c.header for c in theirs.values() if c.header)]
    there = {c.name: {version: str(path) for version, path in built(c).items()} for c in components}
    ready = {c.name: _of_fmus(c.fmus) for c in theirs.values() if not c.header}
    ready |= {point.name: ({}, f"more components: {told(point)}") for point in told_by_code()}
    listed = [{"name": name, "description": text} for name, text in descriptions().items()]
    if as_json:
        entries = [
            {"name": c.name, "kind": c.kind, "description": c.summary, "fmus": there[c.name]} for c in components
        ] + [
            {"name": name, "kind": "", "description": text, "fmus": versions}
            for name, (versions, text) in ready.items()
        ]
        print_json({"components": entries, "systems": listed})
        return
    built_for = [", ".join(there[c.name]) or "when used" for c in components]
    rows = [[c.name, c.kind, versions] for c, versions in zip(components, built_for, strict=True)]
    rows += [[name, "", ", ".join(versions)] for name, (versions, _) in ready.items()]
    texts = [*(c.summary for c in components), *(text for _, text in ready.values())]
    show(["Component", "Kind", "Built for FMI"], rows, texts)
    print()
    show(["System"], [[system["name"]] for system in listed], [system["description"] for system in listed])


def _of_headers(headers: Iterable[Path]) -> Iterator[Component]:
    """Yield the components of other packages; one that cannot be read hides no others."""
    for header in headers:
        try:
            yield catalog.from_header(header)
        except AdcsError as error:
            warn_once(str(error))


def _of_fmus(paths: Iterable[Path]) -> tuple[dict[str, str], str]:
    """Return FMUs without headers by their versions of FMI, and what they are; or why they cannot be read."""
    from orchestration.fmu.file import open_fmu  # which takes longer to load than the rest of this command

    try:
        models = {path: open_fmu(path).model for path in paths}
    except AdcsError as error:
        return {}, str(error)
    versions = {model.fmiVersion: str(path) for path, model in models.items()}
    return versions, next((model.description for model in models.values() if model.description), "")

"""Adds licences to a bill of materials: `python -m adcs.bill FILE`, which `cyclonedx-py` has made of pinned packages.

Pins say none, so they are those that the metadata of the installed packages declare.
"""

from __future__ import annotations

import json
import sys
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from fmus.files import write_atomically
from fmus.pack import LICENCE_OF_EIGEN

_SHORT = 60  # characters of a field that names a licence; others hold its text


def main(bill: Path) -> None:
    """Complete it."""
    content = json.loads(bill.read_text(encoding="utf-8"))
    content["components"] = [_completed(component) for component in content["components"]]
    write_atomically(bill, json.dumps(content, indent=2).encode() + b"\n")


def _completed(component: dict[str, Any]) -> dict[str, Any]:
    try:
        found = licences(distribution(component["name"]))
    except PackageNotFoundError:  # one for another platform
        return component
    return dict(sorted({**component, **({"licenses": found} if found else {})}.items()))


def licences(package: Distribution) -> list[dict[str, Any]]:
    """Return the licences of a package, as CycloneDX 1.6 writes them: its expression, else its classes, else its text.

    That of Eigen's headers is beside that of cmeel-eigen, which is of the packaging alone.
    """

    def said(field: str) -> list[str]:
        return package.metadata.get_all(field) or []

    for declared in said("License-Expression"):
        if package.name == "cmeel-eigen":
            return [{"expression": f"{declared} AND {LICENCE_OF_EIGEN}", "acknowledgement": "concluded"}]
        return [{"expression": declared, "acknowledgement": "declared"}]
    classes = [each.split(" :: ") for each in said("Classifier") if each.startswith("License ::")]
    names = [each[-1] for each in classes] or said("License")
    named = [{"license": {"name": n, "acknowledgement": "declared"}} for n in names if len(n) <= _SHORT]
    return named or [_text(package, name) for name in said("License-File")]


def _text(package: Distribution, name: str) -> dict[str, Any]:
    files = (file for file in package.files or () if file.match(f"*.dist-info/**/{name}"))
    content = next((file.read_text(encoding="utf-8") for file in files), "")
    return {"license": {"name": name, "text": {"content": content}, "acknowledgement": "declared"}}


if __name__ == "__main__":
    main(Path(sys.argv[1]))

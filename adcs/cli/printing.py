"""Where commands print, and the option by which they print for programs."""

from __future__ import annotations

import json
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console

OUT = Console()
ERR = Console(stderr=True)

Json = Annotated[bool, Parameter(name="--json", help="Print JSON for machines.")]


def print_json(data: Any) -> None:
    """Print data for a program."""
    print(json.dumps(data, indent=2))

"""Puts what `make dist` has compiled into the wheel; one that is built without it needs the compiler."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Carry(BuildHookInterface):
    """Asked by hatchling before it packs."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder if it is there; an editable installation takes all from the checkout."""
        if version == "standard" and (Path(self.root) / "build" / "carried").is_dir():
            build_data["force_include"]["build/carried"] = "fmus/carried"

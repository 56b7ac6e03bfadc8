"""Makes what a wheel carries: `python -m adcs.wheel FOLDER`, with the compiler for all platforms."""

from __future__ import annotations

import sys
from pathlib import Path

from fmus.build import parts
from fmus.carried import carry
from fmus.toolchain import TARGETS
from orchestration.engine import library_for


def main(folder: Path) -> None:
    """Write the archives into the folder."""
    engines = {target: library_for(target) for target in TARGETS}
    more = {target: {library.name: library.read_bytes()} for target, library in engines.items()}
    carry(folder, parts(), more)
    for archive in sorted(folder.glob("*.tar.xz")):
        print(f"{archive.stat().st_size / 1e3:6.0f} kB  {archive.name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

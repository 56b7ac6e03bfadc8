"""Completes a folder of what is to be published: `python -m adcs.release FOLDER`, where wheel and sdist are already.

It adds a zip of all FMUs for all platforms, with checksums in it, and the checksums of all that is in the folder.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory

from fmus.build import build
from fmus.files import write_atomically
from fmus.pack import zipped

_SUMS = "SHA256SUMS"


def main(folder: Path) -> None:
    """Write them."""
    with TemporaryDirectory() as dist:
        fmus = {path.name: path.read_bytes() for path in build(all_platforms=True, dist=Path(dist))}
    archive = folder / f"adcs_fmus-{metadata.version('adcs-fmus')}-fmus.zip"
    write_atomically(archive, zipped({**fmus, _SUMS: checksums(fmus)}))
    files = {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.name != _SUMS}
    write_atomically(folder / _SUMS, checksums(files))
    for name, content in files.items():
        print(f"{len(content) / 1e6:6.2f} MB  {name}")


def checksums(files: Mapping[str, bytes]) -> bytes:
    """Return what `sha256sum --check` reads."""
    return "".join(f"{hashlib.sha256(content).hexdigest()}  {name}\n" for name, content in files.items()).encode()


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Where things are, in a checkout and in an installed wheel."""

import hashlib
import os
from importlib import metadata, util
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def _checkout() -> Path | None:
    root = PACKAGE.parent
    return root if (root / "pyproject.toml").is_file() and (root / "src" / "fmi").is_dir() else None


def _user_cache() -> Path:
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "adcs-fmus" / _installed()


def _installed() -> str:
    """Version and content of what is installed: two that differ in a file share nothing."""
    try:
        distribution = metadata.distribution("adcs-fmus")
    except metadata.PackageNotFoundError:
        return "unknown"
    record = distribution.read_text("RECORD") or ""  # each file, with the hash of its content
    ours = sorted(line for line in record.splitlines() if line.startswith("fmus/") and "sha256=" in line)
    content = "\n".join(line for line in ours if ".pyc" not in line)
    return f"{distribution.version}-{hashlib.sha256(content.encode()).hexdigest()[:12]}"


def _eigen() -> Path:
    headers = "cmeel.prefix/include/eigen3"
    try:
        return Path(str(metadata.distribution("cmeel-eigen").locate_file(headers)))
    except metadata.PackageNotFoundError:
        return PACKAGE / headers


def _fmpy() -> Path:
    found = util.find_spec("fmpy")  # not imported: with NumPy, it takes longer than all that most commands do
    assert found is not None and found.origin is not None, "it is among the requirements"
    return Path(found.origin).parent


CHECKOUT = _checkout()
SOURCES = CHECKOUT / "src" if CHECKOUT else PACKAGE / "src"  # a wheel carries the C++ sources inside the package
CARRIED = PACKAGE / "carried"  # what a wheel has compiled; nothing of it is in a checkout or an sdist
LICENSE = (CHECKOUT or PACKAGE) / "LICENSE"
BUILD = (CHECKOUT or _user_cache()) / "build"
# site-packages may not be writable; ADCS_DIST puts the FMUs elsewhere.
DIST = Path(os.environ.get("ADCS_DIST") or (PACKAGE if CHECKOUT else _user_cache()) / "dist").resolve()

FMPY = _fmpy()
FMI_HEADERS = FMPY / "c-code"
EIGEN = _eigen()  # not there where nothing can be compiled

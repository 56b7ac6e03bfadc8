"""Where things are, in a checkout and in an installed wheel."""

import os
from importlib import metadata
from pathlib import Path

import fmpy

PACKAGE = Path(__file__).resolve().parent


def _checkout() -> Path | None:
    root = PACKAGE.parent
    return root if (root / "pyproject.toml").is_file() and (root / "src" / "fmi").is_dir() else None


def _user_cache() -> Path:
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "adcs-fmus"


def _eigen() -> Path:
    headers = "cmeel.prefix/include/eigen3"
    try:
        return Path(str(metadata.distribution("cmeel-eigen").locate_file(headers)))
    except metadata.PackageNotFoundError:
        return PACKAGE / headers


CHECKOUT = _checkout()
SOURCES = CHECKOUT / "src" if CHECKOUT else PACKAGE / "src"  # a wheel carries the C++ sources inside the package
LICENSE = (CHECKOUT or PACKAGE) / "LICENSE"
BUILD = (CHECKOUT or _user_cache()) / "build"
# site-packages may not be writable; ADCS_DIST puts the FMUs elsewhere.
DIST = Path(os.environ.get("ADCS_DIST") or (PACKAGE if CHECKOUT else _user_cache()) / "dist").resolve()

FMI_HEADERS = Path(fmpy.__file__).parent / "c-code"
EIGEN = _eigen()  # not there where nothing can be compiled

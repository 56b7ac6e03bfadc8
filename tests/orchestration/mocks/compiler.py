"""Compiles a mock: its own C, what it leaves out, and the variables that it was made with."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import fmpy

from fmus.paths import BUILD
from fmus.toolchain import zig

HERE = Path(__file__).parent


def compile_library(model: str, unused: str, variables: str, binary: Path) -> None:
    """Make a shared library of `MODEL.c` and `UNUSED.c`, which include `variables.h`."""
    generated = binary.with_suffix(".include")
    generated.mkdir()
    (generated / "variables.h").write_text(variables)
    headers = Path(fmpy.__file__).parent / "c-code"
    cache = {"ZIG_GLOBAL_CACHE_DIR": str(BUILD / "zig"), "ZIG_LOCAL_CACHE_DIR": str(BUILD / "zig")}
    command = [zig(), "cc", "-std=c11", "-O1", "-shared", "-fPIC", f"-I{headers}", f"-I{generated}", f"-I{HERE}"]
    sources = [HERE / f"{model}.c", HERE / f"{unused}.c"]
    subprocess.run([*command, *sources, "-lm", "-o", binary], check=True, env=os.environ | cache)

"""The elementary functions of src/math, compiled like the FMUs."""

import subprocess
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.paths import BUILD
from fmus.toolchain import compile_step, host, program_step, run_steps

Floats = NDArray[np.float64]


def apply(function: str, *x: Floats) -> Floats:
    """The function of every element, or of every pair or three of elements; the names are in functions.cpp."""
    arguments = np.stack(np.broadcast_arrays(*x), axis=-1).astype(float)
    done = subprocess.run([_program(), function], input=arguments.tobytes(), capture_output=True, check=True)
    return np.frombuffer(done.stdout)


@cache
def _program() -> Path:
    target, folder = host(), BUILD / "tests" / "math"
    compiled = compile_step(Path(__file__).with_name("functions.cpp"), folder / "functions.o", target)
    program = program_step([compiled.output], folder / "functions", target)
    run_steps([compiled])
    run_steps([program])
    return program.output

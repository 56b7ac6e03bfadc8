"""Builds and calls the hand-written loop, with the compiler and flags of the FMUs."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks import loop
from fmus.paths import BUILD
from fmus.toolchain import Step, compile_step, host, run_steps
from orchestration.plan.lowering import Floats


def make(steps: int) -> Callable[[], Floats]:
    """A function that takes so many steps and returns the final attitude, (4,)."""
    library = _library()
    inertia, q_RN = _pointer(loop.INERTIA), _pointer(loop.Q_RN)
    state = np.concatenate((loop.START_Q_BN / np.linalg.norm(loop.START_Q_BN), loop.START_OMEGA_BN_B))

    def take_steps() -> Floats:
        library.monolithic(steps, loop.STEP, inertia, loop.K_P, loop.K_V, q_RN, _pointer(state))
        return state[:4]

    return take_steps


def _pointer(values: Floats) -> ctypes.c_void_p:
    return ctypes.c_void_p(values.ctypes.data)


@cache
def _library() -> ctypes.CDLL:
    target, folder = host(), BUILD / "benchmarks"
    compiled = compile_step(Path(__file__).with_name("monolithic.cpp"), folder / "monolithic.o", target)
    output = folder / f"monolithic{target.suffix}"
    link = ("cc", "-target", target.triple, "-fno-sanitize=undefined", "-s", "-shared", str(compiled.output))
    run_steps([compiled])
    run_steps([Step(output, (*link, "-o", str(output)), (compiled.output,))])
    library = ctypes.CDLL(str(output))
    double, pointer = ctypes.c_double, ctypes.c_void_p
    library.monolithic.argtypes = (ctypes.c_longlong, double, pointer, double, double, pointer, pointer)
    library.monolithic.restype = None
    return library

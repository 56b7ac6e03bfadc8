"""Systems of FMUs: wiring, co-simulation, coupled Model Exchange, results."""

from orchestration.accuracy import Estimate, estimate_error
from orchestration.cosim import steps
from orchestration.coupled import CoupledModel
from orchestration.loops import LoopSolver
from orchestration.results import Result, RunFailed, RunInterrupted
from orchestration.run import run
from orchestration.session import CoSimulation
from orchestration.system import Connection, System

__all__ = [
    "CoSimulation",
    "Connection",
    "CoupledModel",
    "Estimate",
    "LoopSolver",
    "Result",
    "RunFailed",
    "RunInterrupted",
    "System",
    "estimate_error",
    "run",
    "steps",
]

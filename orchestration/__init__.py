"""Systems of FMUs: wiring, co-simulation, coupled Model Exchange, results."""

from orchestration.cosim import steps
from orchestration.coupled import CoupledModel
from orchestration.results import Result, RunFailed, RunInterrupted
from orchestration.run import run
from orchestration.system import Connection, System

__all__ = ["Connection", "CoupledModel", "Result", "RunFailed", "RunInterrupted", "System", "run", "steps"]

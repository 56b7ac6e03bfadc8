"""Coupled Model Exchange: all components as one ordinary differential equation, with state and time events."""

from orchestration.coupled.integrators import SolverName
from orchestration.coupled.model import CoupledModel
from orchestration.coupled.simulation import CoupledSimulation

__all__ = ["CoupledModel", "CoupledSimulation", "SolverName"]

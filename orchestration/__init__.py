"""Systems of FMUs: their wiring, co-simulation, coupled Model Exchange, results. Programs import `adcs`."""

_MOVED = """
Connection CoupledModel Estimate LoopSolver Result RunFailed RunInterrupted Session System estimate_error run steps
"""


def __getattr__(name: str) -> None:
    moved = {"CoSimulation": "Session"}.get(name, name)
    if moved not in _MOVED.split():
        raise AttributeError(f"module 'orchestration' has no attribute {name!r}")
    raise ImportError(f"orchestration.{name} is adcs.{moved} now: write `from adcs import {moved}`")

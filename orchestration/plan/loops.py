"""Algebraic loops: inputs u of some components that depend on themselves, u = G(u), solved at every propagation."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np

from fmus.errors import AdcsError
from orchestration import expected
from orchestration.instances.instance import CallFailed, Instance
from orchestration.plan.lowering import Call, Floats, Loop, Plan
from orchestration.plan.propagation import execute, gather

LoopMethod = Literal["newton", "fixed-point"]

_METHODS = " or ".join(map(repr, get_args(LoopMethod)))
_HALVINGS = 10  # of a Newton step that makes the residual grow
_MACHINE = float(np.finfo(float).eps)


@dataclass(frozen=True)
class LoopSolver:
    """How loops are solved.

    Newton's method takes the FMUs' directional derivatives, differences where they have none; "fixed-point" repeats
    u = G(u), which ends only if G contracts. The residual must fall to `tolerance * (1 + |u|)` in every element.
    """

    method: LoopMethod = "newton"
    tolerance: float = 1e-10
    max_iterations: int = 50

    def __post_init__(self) -> None:
        if not isinstance(self.method, str) or self.method not in get_args(LoopMethod):
            raise AdcsError(f"loop method {self.method!r} is unknown: use {_METHODS}")
        object.__setattr__(self, "tolerance", expected.number("loop tolerance", self.tolerance))
        if not 8 * _MACHINE <= self.tolerance < 1:
            raise AdcsError(f"loop tolerance = {self.tolerance}: expected a number from {8 * _MACHINE:.1e} to 1")
        most = expected.count("loop max_iterations", self.max_iterations, "a whole number")
        object.__setattr__(self, "max_iterations", most)


def loop_solver(given: object) -> LoopSolver | None:
    """Return the solver that is meant: by itself, or by the name of its method; None if none is."""
    if given is None or isinstance(given, LoopSolver):
        return given
    if not isinstance(given, str):
        raise expected.refused("loops", given, f"{_METHODS}, or adcs.LoopSolver(...)")
    return LoopSolver(given)  # type: ignore[arg-type]


@dataclass
class LoopReport:
    """What solving a loop took, over a run: `residual` is the worst that was accepted, relative as in the tolerance."""

    path: str
    method: str
    solved: int = 0
    iterations: int = 0
    most_iterations: int = 0
    residual: float = 0.0


class Loops:
    """The loops of a plan, for its instances."""

    def __init__(
        self, plan: Plan, instances: Mapping[str, Instance], solver: LoopSolver, initial: bool = False
    ) -> None:
        self._loops = [_Solver(loop, plan.signals, instances, solver, initial) for loop in plan.loops]

    def solve(self, number: int) -> None:
        """Make inputs and outputs of a loop agree. CallFailed if they do not."""
        self._loops[number].solve()

    @property
    def reports(self) -> list[dict[str, Any]]:
        """One for each loop, for the manifest."""
        return [asdict(loop.report) for loop in self._loops]


class _Solver:
    def __init__(
        self, loop: Loop, signals: Floats, instances: Mapping[str, Instance], solver: LoopSolver, initial: bool
    ) -> None:
        self._loop, self._signals, self._instances, self._settings = loop, signals, instances, solver
        bounds = np.cumsum([0, *(len(call.where) for call in loop.sets)])
        self._parts = [slice(i, j) for i, j in itertools.pairwise(bounds)]
        fed = [f"{call.component}.{element}" for call in loop.sets for element in call.elements]
        self._name = f"the algebraic loop of {', '.join(fed[:6])}{', ...' if len(fed) > 6 else ''}"
        if not initial:
            self._refuse_inputs_set_once()
        discrete = any(call.type not in ("Float64", "Float32") for call in (*loop.sets, *loop.gets))
        self._newton = solver.method == "newton" and not discrete
        components = dict.fromkeys(call.component for call in loop.sets)
        self._exact = not initial and all(instances[c].has_directional_derivatives for c in components)
        self.report = LoopReport(", ".join(fed), "newton" if self._newton else "fixed-point")

    def _refuse_inputs_set_once(self) -> None:
        """Refuse a loop through an input that an FMU, in an event, lets be set only once at an instant."""
        for call in self._loop.sets:
            instance = self._instances[call.component]
            if instance.kind == "model-exchange" or instance.fmu.clocks:
                for port in instance.fmu.ports.values():
                    if port.set_once and set(port.references) & set(call.references):
                        raise AdcsError(
                            f"{self._name} cannot be solved: {call.component}.{port.name} may be set only once at an "
                            "instant (canHandleMultipleSetPerTimeInstant), give a connection of it a delay"
                        )

    def solve(self) -> None:
        u = self._present()
        residual = self._residual(u)
        for iteration in range(self._settings.max_iterations + 1):
            size = self._size(residual, u)
            if size <= self._settings.tolerance:
                self._count(iteration, size)
                return
            if iteration < self._settings.max_iterations:
                u, residual = self._newton_step(u, residual) if self._newton else self._repeat(u, residual)
        raise CallFailed(
            self._loop.sets[0].component,
            f"{self._name} is not solved after {self._settings.max_iterations} iterations of {self.report.method}, "
            f"relative residual {size:.1e}: try the other method, a looser tolerance, or a delay in the loop",
        )

    def _count(self, iterations: int, size: float) -> None:
        self.report.solved += 1
        self.report.iterations += iterations
        self.report.most_iterations = max(self.report.most_iterations, iterations)
        self.report.residual = max(self.report.residual, size)

    def _present(self) -> Floats:
        """The inputs as the FMUs have them: the last solution, also after the state of all of them was restored."""
        values = [
            self._instances[c.component].get(c.references, len(c.where), f"reading {c.elements[0]}", c.type)
            for c in self._loop.sets
        ]
        return np.concatenate([np.asarray(v, float) for v in values])

    def _gathered(self) -> Floats:
        return np.concatenate([gather(call, self._signals) for call in self._loop.sets])

    def _residual(self, u: Floats) -> Floats:
        """G(u) - u; leaves inputs and outputs of the FMUs, and the signals, as u makes them."""
        for call, part in zip(self._loop.sets, self._parts, strict=True):
            action = f"setting {call.elements[0].partition('[')[0]}"
            self._instances[call.component].set(call.references, u[part].tolist(), action, call.type)
        for call in self._loop.gets:
            execute(call, self._signals, self._instances)
        return self._gathered() - u

    @staticmethod
    def _size(residual: Floats, u: Floats) -> float:
        return float(np.max(np.abs(residual) / (1 + np.abs(u))))

    def _repeat(self, u: Floats, residual: Floats) -> tuple[Floats, Floats]:
        after = u + residual
        return after, self._residual(after)

    def _newton_step(self, u: Floats, residual: Floats) -> tuple[Floats, Floats]:
        jacobian = self._jacobian(u, residual) - np.eye(len(u))
        try:
            step = np.linalg.solve(jacobian, -residual)
        except np.linalg.LinAlgError:
            raise CallFailed(
                self._loop.sets[0].component,
                f"{self._name} has no unique solution: its Jacobian is singular; put a delay or a state into it",
            ) from None
        for halving in range(_HALVINGS + 1):
            after = u + step / 2**halving
            there = self._residual(after)
            if halving == _HALVINGS or np.linalg.norm(there) < np.linalg.norm(residual):
                break
        return after, there

    def _jacobian(self, u: Floats, residual: Floats) -> Floats:
        """dG/du (n, n)."""
        if not self._exact:
            return self._differences(u, residual)
        rates = np.zeros((len(self._signals), len(u)))
        for set_, part in zip(self._loop.sets, self._parts, strict=True):
            for get in self._loop.gets:
                if get.component == set_.component:
                    rates[get.where, part] += self._block(self._instances[get.component], get, set_)
        rows = [rates[call.where] * (1.0 if call.factor is None else call.factor[:, None]) for call in self._loop.sets]
        return np.concatenate(rows)

    @staticmethod
    def _block(instance: Instance, get: Call, set_: Call) -> Floats:
        """What one set call does to one get call, by directional derivatives."""
        n = len(set_.where)
        columns = np.empty((len(get.where), n))
        for j in range(n):
            seed = [1.0 if i == j else 0.0 for i in range(n)]
            columns[:, j] = instance.directional_derivative(get.references, set_.references, seed, len(get.where))
        return columns

    def _differences(self, u: Floats, residual: Floats) -> Floats:
        columns = np.empty((len(u), len(u)))
        for j in range(len(u)):
            h = np.sqrt(_MACHINE) * (1 + abs(u[j]))
            moved = u.copy()
            moved[j] += h
            columns[:, j] = (self._residual(moved) - residual) / h
            columns[j, j] += 1  # the residual is G(u) - u
        return columns

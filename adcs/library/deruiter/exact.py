"""Exact states and no disturbance: the Lyapunov function, convergence, and the projection at work."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from adcs.library.deruiter.design import parameters
from adcs.library.deruiter.settings import INERTIA, Choices
from adcs.library.deruiter.signals import (
    ATTITUDE,
    DISTANCES,
    FILTERED,
    RATE,
    THETA,
    THETA_P,
    distance_panel,
    signals,
)
from adcs.library.deruiter.systems import exact_states
from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.trajectory import Array, Runs, Trajectory, norm_panel
from orchestration.results.plots import Panel, Series
from orchestration.running.method import ModelExchange

OUTPUT_STEP = 0.25  # s
STRETCH, STRETCHES = 630.0, 5  # s; the sinusoids of the reference have a common period of 628 s
ROUNDING = 1e-6  # on the edge of G the integrator may be off by its tolerance, and that much more


def exact(choices: Choices) -> Section:
    """The law as it is, and with fast adaptation."""
    fast = replace(choices, gamma=choices.fast * choices.gamma, gamma_p=choices.fast * choices.gamma_p)
    adaptation = {"adaptation as chosen": choices, f"adaptation {choices.fast:g} times faster": fast}
    stop, method = STRETCH * STRETCHES, ModelExchange()
    runs = {
        name: Simulation(f"exact states, {name}", exact_states(c), signals, stop, OUTPUT_STEP, method)
        for name, c in adaptation.items()
    }

    def show(found: Runs) -> Iterator[Shown]:
        slow, quick = found
        yield _slow_modes(slow, found[slow])
        yield _convergence(quick, found[quick])
        yield from (_edge(name, run, choices) for name, run in found.items())
        yield norm_panel(ATTITUDE, found)
        yield norm_panel(RATE, found)
        yield _lyapunov_panel(found, adaptation)
        yield distance_panel(found, choices.epsilon)

    return Section("Exact states, no disturbance", "Convergence and projection", show, runs)


def _peaks(run: Trajectory) -> tuple[list[float], str, str]:
    """Peaks of |q| over equal stretches after the transient, the same as text, and what they are."""
    peaks = [run.between(i * STRETCH, (i + 1) * STRETCH).peak(ATTITUDE) for i in range(1, STRETCHES)]
    note = f"peaks of |q| over the {STRETCHES - 1} stretches of {STRETCH:g} s after the first"
    return peaks, ", ".join(f"{p:.3g}" for p in peaks), note


def _slow_modes(name: str, run: Trajectory) -> Claim:
    peaks, ours, note = _peaks(run)
    return Claim("Remark 3", "over-parametrisation may lead to slow modes", name,
                 "slow", ours, peaks[-1] > peaks[0] / 2,
                 f"{note}; slow: the last is above half of the first")  # fmt: skip


def _convergence(name: str, run: Trajectory) -> Claim:
    peaks, ours, note = _peaks(run)
    return Claim("Sec. III", "tracking errors converge without disturbance", name,
                 "to zero", ours, all(b < a for a, b in pairwise(peaks)),
                 f"{note}; judged by their falling throughout, as over shorter ones they do not")  # fmt: skip


def _edge(name: str, run: Trajectory, choices: Choices) -> Claim:
    """The estimates stay in G and G_p."""
    edge = float(np.sqrt(1 + choices.epsilon))
    farthest = {distance.symbol: run.peak(distance) for distance in DISTANCES}
    acting = [symbol for symbol, value in farthest.items() if value > 1]
    return Claim("Projection, 2)", "estimates stay in G and G_p", name,
                 f"at most √(1+ε) = {edge:.5g} times η, η_p",
                 ", ".join(f"{symbol}: {value:.5g}" for symbol, value in farthest.items()),
                 max(farthest.values()) <= edge * (1 + ROUNDING),
                 f"the projection acts on {' and '.join(acting)}" if acting else "the projection never acts",
    )  # fmt: skip


def _balance(run: Trajectory, choices: Choices) -> tuple[Array, Array]:
    """V, Eq. (49), and V(0) - k times the integral of the squared filtered rate error."""
    from scipy.integrate import cumulative_simpson  # here, for whoever only lists the systems

    theta, theta_p = parameters(INERTIA)
    squares = [
        np.sum(run[FILTERED] ** 2, axis=1),
        np.sum((run[THETA] - theta) ** 2, axis=1) / choices.gamma,
        np.sum((run[THETA_P] - theta_p) ** 2, axis=1) / choices.gamma_p,
    ]
    values: Array = np.sum(squares, axis=0) / 2
    return values, values[0] - choices.k * cumulative_simpson(squares[0], x=run.time, initial=0.0)


def _lyapunov_panel(runs: Runs, adaptation: dict[str, Choices]) -> Panel:
    series = []
    for color, (name, run) in enumerate(runs.items()):
        values, expected = _balance(run, adaptation[name])
        series.append(Series(f"V, {name}", run.time, values, color=color))
        series.append(Series(f"V(0) - k ∫‖ω̃‖² dt, {name}", run.time, expected, "dash", color=color + 2))
    note = "Both curves are the same as long as the projection rests; where it acts V is smaller."
    return Panel("Lyapunov function (49)", "V [rad²/s²]", series, log=True, note=note)

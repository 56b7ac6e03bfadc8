"""Exact states and no disturbance: the Lyapunov function, convergence, and the projection at work."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from adcs.library.deruiter.design import parameters
from adcs.library.deruiter.settings import INERTIA, Choices
from adcs.library.deruiter.signals import ATTITUDE, RATE, Signals, distance_panel, norm_panel, signals
from adcs.library.deruiter.systems import RECORD, exact_states
from adcs.library.outcome import Outcome, Row, Runner, claims_table, verdict
from orchestration.results.plots import Panel, Series
from orchestration.results.result import Result
from orchestration.running.method import ModelExchange
from orchestration.running.save import Save

GROUP = "Exact states, no disturbance"
RUNS = 2
OUTPUT_STEP = 0.25  # s
STRETCH, STRETCHES = 630.0, 5  # s; the sinusoids of the reference have a common period of 628 s
ROUNDING = 1e-6  # on the edge of G the integrator may be off by its tolerance, and that much more

Array = NDArray[np.float64]


def exact(run: Runner, choices: Choices) -> tuple[Outcome, dict[str, Signals]]:
    """Run the law as it is and with fast adaptation; returns the outcome and the runs."""
    settings = {"stop_time": STRETCH * STRETCHES, "step": OUTPUT_STEP, "method": ModelExchange(), "save": Save(RECORD)}
    fast = replace(choices, gamma=choices.fast * choices.gamma, gamma_p=choices.fast * choices.gamma_p)
    names = {"adaptation as chosen": choices, f"adaptation {choices.fast:g} times faster": fast}
    results = {name: run(f"exact states, {name}", exact_states(c), **settings) for name, c in names.items()}
    runs = {name: signals(result) for name, result in results.items()}
    (slow_name, fast_name), (slow, quick) = runs, runs.values()
    rows = [
        _convergence(slow_name, slow, remark=True),
        _convergence(fast_name, quick, remark=False),
        *(_edge(name, r, choices) for name, r in runs.items()),
    ]
    balance = {name: (runs[name].time, *_balance(results[name], names[name])) for name in names}
    panels = [
        norm_panel(ATTITUDE, runs, "Attitude tracking error", GROUP),
        norm_panel(RATE, runs, "Rate tracking error", GROUP),
        _lyapunov_panel(balance),
        distance_panel(runs, choices.epsilon, "Parameter estimates", GROUP),
    ]
    tables = [claims_table(rows, "Convergence and projection", GROUP)]
    return Outcome(rows, panels, tables), runs


def _convergence(name: str, run: Signals, remark: bool) -> Row:
    """Peaks of |q| over equal stretches after the transient."""
    peaks = [run.after(i * STRETCH, (i + 1) * STRETCH).peak(ATTITUDE) for i in range(1, STRETCHES)]
    ours = ", ".join(f"{p:.3g}" for p in peaks)
    note = f"peaks of |q| over the {STRETCHES - 1} stretches of {STRETCH:g} s after the first"
    if remark:
        stalled = peaks[-1] > peaks[0] / 2
        return Row(
            "deruiter",
            "Remark 3",
            "over-parametrisation may lead to slow modes",
            name,
            "slow",
            ours,
            None,
            verdict(stalled),
            f"{note}; slow: the last is above half of the first",
        )
    falls = all(b < a for a, b in pairwise(peaks))
    return Row(
        "deruiter",
        "Sec. III",
        "tracking errors converge without disturbance",
        name,
        "to zero",
        ours,
        None,
        verdict(falls),
        f"{note}; judged by their falling throughout, as over shorter ones they do not",
    )


def _edge(name: str, run: Signals, choices: Choices) -> Row:
    """The estimates stay in G and G_p."""
    edge = float(np.sqrt(1 + choices.epsilon))
    farthest = {symbol: float(run.distance[key].max()) for key, symbol in (("theta", "θ"), ("theta_p", "θ_p"))}
    acting = [symbol for symbol, value in farthest.items() if value > 1]
    return Row(
        "deruiter",
        "Projection, 2)",
        "estimates stay in G and G_p",
        name,
        f"at most √(1+ε) = {edge:.5g} times η, η_p",
        ", ".join(f"{symbol}: {value:.5g}" for symbol, value in farthest.items()),
        None,
        verdict(max(farthest.values()) <= edge * (1 + ROUNDING)),
        f"the projection acts on {' and '.join(acting)}" if acting else "the projection never acts",
    )


def _balance(result: Result, choices: Choices) -> tuple[Array, Array]:
    """V, Eq. (49), and V(0) - k times the integral of the squared filtered rate error."""
    from scipy.integrate import cumulative_simpson  # here, for whoever only lists the systems

    theta, theta_p = parameters(INERTIA)
    squares = [
        np.sum(result["controller.filtered_rate_B"] ** 2, axis=1),
        np.sum((result["controller.theta_est"] - theta) ** 2, axis=1) / choices.gamma,
        np.sum((result["controller.theta_p_est"] - theta_p) ** 2, axis=1) / choices.gamma_p,
    ]
    values: Array = np.sum(squares, axis=0) / 2
    return values, values[0] - choices.k * cumulative_simpson(squares[0], x=result.time, initial=0.0)


def _lyapunov_panel(balance: dict[str, tuple[Array, Array, Array]]) -> Panel:
    series = []
    for color, (name, (time, values, expected)) in enumerate(balance.items()):
        series.append(Series(f"V, {name}", time, values, color=color))
        series.append(Series(f"V(0) - k ∫‖ω̃‖² dt, {name}", time, expected, "dash", color=color + 2))
    note = "Both curves are the same as long as the projection rests; where it acts V is smaller."
    return Panel("Lyapunov function (49)", "V [rad²/s²]", series, log=True, note=note, group=GROUP)

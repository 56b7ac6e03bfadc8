"""What the thesis concludes from its tables (Secs. 9.3 and 9.4), judged in each reading."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees
from typing import NamedTuple

from adcs.library.outcome import Claim
from adcs.library.trigo.metrics import Metrics
from adcs.library.trigo.printed import Run
from adcs.library.trigo.settings import (
    ADAPTIVE,
    ATTITUDE_REQUIREMENT,
    CONTROL_RATE,
    CONTROLLERS,
    RATE_REQUIREMENT,
    STATIC,
    TORQUE_LIMIT,
    Controller,
    Reading,
    Scenario,
)

Runs = Mapping[Run, Metrics]
Judge = Callable[[Runs], tuple[str, bool]]
"""What we find, and whether the statement holds by that."""

SECTION = "Secs. 9.3, 9.4"
ALL: tuple[Controller, ...] = tuple(CONTROLLERS)


class Statement(NamedTuple):
    """A statement of the text."""

    scenario: Scenario
    what: str
    printed: str
    judge: Judge


def _each(values: Mapping[Controller, float], form: str) -> str:
    return ", ".join(f"{CONTROLLERS[c]} {value:{form}}" for c, value in values.items())


def _of(
    runs: Runs, controllers: Sequence[Controller], scenario: Scenario, value: Callable[[Metrics], float]
) -> dict[Controller, float]:
    return {c: value(runs[Run(c, scenario)]) for c in controllers}


def _pointing(metrics: Metrics) -> float:
    return max(theta for theta, _ in metrics.worst.values())


def _rate(metrics: Metrics) -> float:
    return max(omega for _, omega in metrics.worst.values())


LIMITS: dict[Callable[[Metrics], float], float] = {_pointing: ATTITUDE_REQUIREMENT, _rate: RATE_REQUIREMENT}


def _within(scenario: Scenario, worst: Callable[[Metrics], float], inside: Sequence[Controller]) -> Judge:
    """That these keep the requirement after the peaks, and the others do not."""

    def judge(runs: Runs) -> tuple[str, bool]:
        outside = [c for c in ALL if c not in inside]
        values = _of(runs, (*inside, *outside), scenario, worst)
        holds = all((value <= LIMITS[worst]) == (c in inside) for c, value in values.items())
        return _each(values, ".3g"), holds

    return judge


def _ordered(scenario: Scenario, best_first: Sequence[Controller], value: Callable[[Metrics], float]) -> Judge:
    def judge(runs: Runs) -> tuple[str, bool]:
        values = _of(runs, best_first, scenario, value)
        return _each(values, ".3g"), list(values.values()) == sorted(values.values())

    return judge


def _scanning(metrics: Metrics) -> float:
    return metrics.pointing["scanning"]


def _steady(metrics: Metrics) -> float:
    return metrics.pointing["steady"]


def _relative(metrics: Metrics) -> float:
    return metrics.estimation / metrics.disturbance


def _degrees(runs: Runs) -> tuple[str, bool]:
    worst = _of(runs, STATIC, "wheel", lambda m: _pointing(m) / 3600)
    return ", ".join(f"{CONTROLLERS[c]} {w:.2f} deg" for c, w in worst.items()), all(
        0.3 < w < 2 for w in worst.values()
    )


def _damage(runs: Runs) -> tuple[str, bool]:
    ratio = {c: _scanning(runs[Run(c, "mirror")]) / _scanning(runs[Run(c, "nominal")]) for c in STATIC}
    return ", ".join(f"{CONTROLLERS[c]} {r:.3g} times" for c, r in ratio.items()), all(r > 1.5 for r in ratio.values())


def _less_work(runs: Runs) -> tuple[str, bool]:
    work = _of(runs, ALL, "wheel", lambda m: 1e3 * m.workload)
    return _each(work, ".4g"), max(work[c] for c in ADAPTIVE) < min(work[c] for c in STATIC)


POINTING, RATE = "worst pointing error [arcsec]", "worst rate error [arcsec/s]"
ESTIMATION = "relative estimation error, from small to large"
STATEMENTS = (
    Statement("nominal", "scanning error RMS [arcsec], from small to large", "BS least, TF most",
              _ordered("nominal", ("bs", "rbs", "tf"), _scanning)),
    Statement("nominal", POINTING, "all within 30", _within("nominal", _pointing, ALL)),
    Statement("nominal", RATE, "all within 1", _within("nominal", _rate, ALL)),
    Statement("mismatch", POINTING, "only the adaptive laws within 30", _within("mismatch", _pointing, ADAPTIVE)),
    Statement("mismatch", RATE, "only the adaptive laws within 1", _within("mismatch", _rate, ADAPTIVE)),
    Statement("mismatch", ESTIMATION, "NESO and I&I much better than TF",
              _ordered("mismatch", ("ii", "neso", "tf"), _relative)),
    Statement("wheel", "worst pointing error of the static laws", "about a degree", _degrees),
    Statement("wheel", POINTING, "only the adaptive laws within 30", _within("wheel", _pointing, ADAPTIVE)),
    Statement("wheel", RATE, "only I&I within 1", _within("wheel", _rate, ("ii",))),
    Statement("wheel", ESTIMATION, "I&I best, then NESO, then TF", _ordered("wheel", ("ii", "neso", "tf"), _relative)),
    Statement("wheel", "workload [mJ]", "slightly less with the adaptive laws", _less_work),
    Statement("mirror", "scanning error RMS over that of the nominal case", "static laws much worse", _damage),
    Statement("mirror", POINTING, "only the adaptive laws within 30", _within("mirror", _pointing, ADAPTIVE)),
    Statement("mirror", RATE, "only I&I within 1", _within("mirror", _rate, ("ii",))),
    Statement("mirror", ESTIMATION, "I&I by far best, then NESO, then TF",
              _ordered("mirror", ("ii", "neso", "tf"), _relative)),
    Statement("mirror", "steady error RMS [arcsec], from small to large", "of the adaptive laws NESO most",
              _ordered("mirror", ("ii", "tf", "neso"), _steady)),
)  # fmt: skip


def judged(runs: Runs, reading: Reading) -> list[Claim]:
    """A claim per statement, on the runs of one reading."""
    claims = []
    for scenario, what, printed, judge in STATEMENTS:
        (ours, holds), name = judge(runs), reading.name
        note = "from 20 s after the beginning of each stretch" if "worst" in what else ""
        claims.append(Claim(SECTION, f"{scenario}: {what}", name, printed, ours, holds, note, reading=name))
    return [*claims, _limits(runs, reading)]


def _limits(runs: Runs, reading: Reading) -> Claim:
    those = [m for run, m in runs.items() if run.rate == CONTROL_RATE]
    limit = reading.acceleration_limit
    reached = sum(m.command_rate >= limit * (1 - 1e-9) for m in those)
    torque = max(m.torque for m in those)
    ours = (
        f"rate of x_2,c at its limit of {degrees(limit):.2f} deg/s² in {reached} of {len(those)} runs; "
        f"torque at most {torque:.4f} of {TORQUE_LIMIT:.4f} N·m"
    )
    cell, printed, note = (
        "limits of the command filters",
        "not reached in any run",
        "at the start, where x_2,c comes from 0",
    )
    holds = reached == 0 and torque < TORQUE_LIMIT
    return Claim(SECTION, cell, reading.name, printed, ours, holds, note, reading=reading.name)

"""What the thesis concludes from its tables (Secs. 9.3 and 9.4), judged in each reading."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import degrees

from adcs.library.outcome import Row, verdict
from adcs.library.trigo.catalogue import Controller, Scenario
from adcs.library.trigo.metrics import Metrics
from adcs.library.trigo.printed import Run
from adcs.library.trigo.settings import (
    ADAPTIVE,
    ATTITUDE_REQUIREMENT,
    CONTROL_RATE,
    CONTROLLERS,
    RATE_REQUIREMENT,
    TORQUE_LIMIT,
    Reading,
)

Runs = Mapping[Run, Metrics]
SECTION = "Secs. 9.3, 9.4"
STATIC: tuple[Controller, ...] = ("bs", "rbs")
ALL: tuple[Controller, ...] = tuple(CONTROLLERS)


@dataclass(frozen=True)
class Claim:
    """A statement of the text; `judge` gives what we find and whether the statement holds."""

    cell: str
    printed: str
    judge: Callable[[Runs], tuple[str, bool]]


def _each(runs: Runs, controllers: Sequence[Controller], scenario: Scenario, value: Callable[[Metrics], float]) -> str:
    return ", ".join(f"{CONTROLLERS[c]} {value(runs[Run(c, scenario)]):.3g}" for c in controllers)


def _worst(metrics: Metrics, which: int) -> float:
    return max(pair[which] for pair in metrics.worst.values())


def _within(
    scenario: Scenario, which: int, inside: Sequence[Controller], outside: Sequence[Controller]
) -> Callable[[Runs], tuple[str, bool]]:
    """The worst error after the peaks: pointing (0) or rate (1)."""
    limit = (ATTITUDE_REQUIREMENT, RATE_REQUIREMENT)[which]

    def judge(runs: Runs) -> tuple[str, bool]:
        worst = {c: _worst(runs[Run(c, scenario)], which) for c in ALL}
        holds = all(worst[c] <= limit for c in inside) and all(worst[c] > limit for c in outside)
        return _each(runs, (*inside, *outside), scenario, lambda m: _worst(m, which)), holds

    return judge


def _ordered(
    scenario: Scenario, best_first: Sequence[Controller], value: Callable[[Metrics], float]
) -> Callable[[Runs], tuple[str, bool]]:
    def judge(runs: Runs) -> tuple[str, bool]:
        values = [value(runs[Run(c, scenario)]) for c in best_first]
        return _each(runs, best_first, scenario, value), values == sorted(values)

    return judge


def _scanning(metrics: Metrics) -> float:
    return metrics.pointing["scanning"]


def _steady(metrics: Metrics) -> float:
    return metrics.pointing["steady"]


def _relative(metrics: Metrics) -> float:
    return metrics.estimation / metrics.disturbance


def _degrees(runs: Runs) -> tuple[str, bool]:
    worst = {c: _worst(runs[Run(c, "wheel")], 0) / 3600 for c in STATIC}
    return ", ".join(f"{CONTROLLERS[c]} {w:.2f} deg" for c, w in worst.items()), all(
        0.3 < w < 2 for w in worst.values()
    )


def _damage(runs: Runs) -> tuple[str, bool]:
    ratio = {c: _scanning(runs[Run(c, "mirror")]) / _scanning(runs[Run(c, "nominal")]) for c in STATIC}
    return ", ".join(f"{CONTROLLERS[c]} {r:.3g} times" for c, r in ratio.items()), all(r > 1.5 for r in ratio.values())


def _less_work(runs: Runs) -> tuple[str, bool]:
    work = {c: 1e3 * runs[Run(c, "wheel")].workload for c in ALL}
    text = ", ".join(f"{CONTROLLERS[c]} {w:.4g}" for c, w in work.items())
    return text, max(work[c] for c in ADAPTIVE) < min(work[c] for c in STATIC)


CLAIMS = (
    Claim("nominal: scanning error RMS [arcsec], from small to large", "BS least, TF most",
          _ordered("nominal", ("bs", "rbs", "tf"), _scanning)),
    Claim("nominal: worst pointing error [arcsec]", "all within 30", _within("nominal", 0, ALL, ())),
    Claim("nominal: worst rate error [arcsec/s]", "all within 1", _within("nominal", 1, ALL, ())),
    Claim("mismatch: worst pointing error [arcsec]", "only the adaptive laws within 30",
          _within("mismatch", 0, ADAPTIVE, STATIC)),
    Claim("mismatch: worst rate error [arcsec/s]", "only the adaptive laws within 1",
          _within("mismatch", 1, ADAPTIVE, STATIC)),
    Claim("mismatch: relative estimation error, from small to large", "NESO and I&I much better than TF",
          _ordered("mismatch", ("ii", "neso", "tf"), _relative)),
    Claim("wheel: worst pointing error of the static laws", "about a degree", _degrees),
    Claim("wheel: worst pointing error [arcsec]", "only the adaptive laws within 30",
          _within("wheel", 0, ADAPTIVE, STATIC)),
    Claim("wheel: worst rate error [arcsec/s]", "only I&I within 1",
          _within("wheel", 1, ("ii",), ("bs", "rbs", "tf", "neso"))),
    Claim("wheel: relative estimation error, from small to large", "I&I best, then NESO, then TF",
          _ordered("wheel", ("ii", "neso", "tf"), _relative)),
    Claim("wheel: workload [mJ]", "slightly less with the adaptive laws", _less_work),
    Claim("mirror: scanning error RMS over that of the nominal case", "static laws much worse", _damage),
    Claim("mirror: worst pointing error [arcsec]", "only the adaptive laws within 30",
          _within("mirror", 0, ADAPTIVE, STATIC)),
    Claim("mirror: worst rate error [arcsec/s]", "only I&I within 1",
          _within("mirror", 1, ("ii",), ("bs", "rbs", "tf", "neso"))),
    Claim("mirror: relative estimation error, from small to large", "I&I by far best, then NESO, then TF",
          _ordered("mirror", ("ii", "neso", "tf"), _relative)),
    Claim("mirror: steady error RMS [arcsec], from small to large", "of the adaptive laws NESO most",
          _ordered("mirror", ("ii", "tf", "neso"), _steady)),
)  # fmt: skip


def judged(runs: Runs, reading: Reading) -> list[Row]:
    """A row per claim, on the runs of one reading."""
    rows = []
    for claim in CLAIMS:
        ours, holds = claim.judge(runs)
        note = "from 20 s after the beginning of each stretch" if "worst" in claim.cell else ""
        rows.append(Row("trigo", SECTION, claim.cell, reading.name, claim.printed, ours, None, verdict(holds), note))
    return [*rows, _limits(runs, reading)]


def _limits(runs: Runs, reading: Reading) -> Row:
    those = [m for run, m in runs.items() if run.rate == CONTROL_RATE]
    limit = reading.acceleration_limit
    reached = sum(m.command_rate >= limit * (1 - 1e-9) for m in those)
    torque = max(m.torque for m in those)
    ours = (
        f"rate of x_2,c at its limit of {degrees(limit):.2f} deg/s² in {reached} of {len(those)} runs; "
        f"torque at most {torque:.4f} of {TORQUE_LIMIT:.4f} N·m"
    )
    return Row(
        "trigo",
        SECTION,
        "limits of the command filters",
        reading.name,
        "not reached in any run",
        ours,
        None,
        verdict(reached == 0 and torque < TORQUE_LIMIT),
        "at the start, where x_2,c comes from 0",
    )

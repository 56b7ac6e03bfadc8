"""What the thesis concludes from its tables (Secs. 9.3 and 9.4), judged in each reading."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import degrees

from adcs.library.outcome import Claim
from adcs.library.trigo.catalogue import Controller, Scenario
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
    Reading,
)

Five = Mapping[Controller, Metrics]
"""The measures of the five controllers in a scenario."""
Judge = Callable[[Five], tuple[str, bool]]
"""What we find, and whether the statement holds by that."""

SECTION = "Secs. 9.3, 9.4"


def _each(values: Mapping[Controller, float], form: str = ".3g", unit: str = "") -> str:
    return ", ".join(f"{CONTROLLERS[c]} {value:{form}}{unit}" for c, value in values.items())


def _pointing(metrics: Metrics) -> float:
    return max(theta for theta, _ in metrics.worst.values())


def _rate(metrics: Metrics) -> float:
    return max(omega for _, omega in metrics.worst.values())


def _within(worst: Callable[[Metrics], float], limit: float, *inside: Controller) -> Judge:
    """That these keep the requirement after the peaks, and the others do not."""

    def judge(five: Five) -> tuple[str, bool]:
        values = {c: worst(five[c]) for c in (*inside, *(c for c in CONTROLLERS if c not in inside))}
        return _each(values), all((value <= limit) == (c in inside) for c, value in values.items())

    return judge


def _ordered(value: Callable[[Metrics], float], *best_first: Controller) -> Judge:
    def judge(five: Five) -> tuple[str, bool]:
        values = {c: value(five[c]) for c in best_first}
        return _each(values), list(values.values()) == sorted(values.values())

    return judge


def _relative(metrics: Metrics) -> float:
    return metrics.estimation / metrics.disturbance


def _degrees(five: Five) -> tuple[str, bool]:
    worst = {c: _pointing(five[c]) / 3600 for c in STATIC}
    return _each(worst, ".2f", " deg"), all(0.3 < w < 2 for w in worst.values())


def _less_work(five: Five) -> tuple[str, bool]:
    work = {c: 1e3 * five[c].workload for c in CONTROLLERS}
    return _each(work, ".4g"), max(work[c] for c in ADAPTIVE) < min(work[c] for c in STATIC)


THETA, OMEGA = (_pointing, ATTITUDE_REQUIREMENT), (_rate, RATE_REQUIREMENT)
POINTING, RATE = "worst pointing error [arcsec]", "worst rate error [arcsec/s]"
ESTIMATION, DAMAGE = (
    "relative estimation error, from small to large",
    "scanning error RMS over that of the nominal case",
)
STATEMENTS: tuple[tuple[Scenario, str, str, Judge | None], ...] = (
    ("nominal", "scanning error RMS [arcsec], from small to large", "BS least, TF most",
     _ordered(lambda m: m.pointing["scanning"], "bs", "rbs", "tf")),
    ("nominal", POINTING, "all within 30", _within(*THETA, *CONTROLLERS)),
    ("nominal", RATE, "all within 1", _within(*OMEGA, *CONTROLLERS)),
    ("mismatch", POINTING, "only the adaptive laws within 30", _within(*THETA, *ADAPTIVE)),
    ("mismatch", RATE, "only the adaptive laws within 1", _within(*OMEGA, *ADAPTIVE)),
    ("mismatch", ESTIMATION, "NESO and I&I much better than TF", _ordered(_relative, "ii", "neso", "tf")),
    ("wheel", "worst pointing error of the static laws", "about a degree", _degrees),
    ("wheel", POINTING, "only the adaptive laws within 30", _within(*THETA, *ADAPTIVE)),
    ("wheel", RATE, "only I&I within 1", _within(*OMEGA, "ii")),
    ("wheel", ESTIMATION, "I&I best, then NESO, then TF", _ordered(_relative, "ii", "neso", "tf")),
    ("wheel", "workload [mJ]", "slightly less with the adaptive laws", _less_work),
    ("mirror", "scanning error RMS over that of the nominal case", "static laws much worse", None),
    ("mirror", POINTING, "only the adaptive laws within 30", _within(*THETA, *ADAPTIVE)),
    ("mirror", RATE, "only I&I within 1", _within(*OMEGA, "ii")),
    ("mirror", ESTIMATION, "I&I by far best, then NESO, then TF", _ordered(_relative, "ii", "neso", "tf")),
    ("mirror", "steady error RMS [arcsec], from small to large", "of the adaptive laws NESO most",
     _ordered(lambda m: m.pointing["steady"], "ii", "tf", "neso")),
)  # fmt: skip
"""Scenario, what is stated of it, what is printed, and how it is judged; None: against the nominal scenario."""


def judged(runs: Mapping[Run, Metrics], reading: Reading) -> Iterator[Claim]:
    """A claim per statement, on the runs of one reading."""
    for scenario, what, printed, judge in STATEMENTS:
        five = {c: runs[Run(c, scenario)] for c in CONTROLLERS}
        ours, holds = judge(five) if judge else _damage(five, {c: runs[Run(c, "nominal")] for c in STATIC})
        yield Claim(SECTION, f"{scenario}: {what}", reading.name,
                    printed, ours, holds,
                    "from 20 s after the beginning of each stretch" if "worst" in what else "",
                    reading=reading.name)  # fmt: skip
    yield _limits([metrics for run, metrics in runs.items() if run.rate == CONTROL_RATE], reading)


def _damage(five: Five, nominal: Five) -> tuple[str, bool]:
    ratio = {c: five[c].pointing["scanning"] / nominal[c].pointing["scanning"] for c in STATIC}
    return _each(ratio, ".3g", " times"), all(r > 1.5 for r in ratio.values())


def _limits(those: Sequence[Metrics], reading: Reading) -> Claim:
    limit = reading.acceleration_limit
    reached, torque = sum(m.command_rate >= limit * (1 - 1e-9) for m in those), max(m.torque for m in those)
    return Claim(SECTION, "limits of the command filters", reading.name,
                 "not reached in any run",
                 f"rate of x_2,c at its limit of {degrees(limit):.2f} deg/s² in {reached} of {len(those)} runs; "
                 f"torque at most {torque:.4f} of {TORQUE_LIMIT:.4f} N·m",
                 reached == 0 and torque < TORQUE_LIMIT,
                 "at the start, where x_2,c comes from 0", reading=reading.name)  # fmt: skip

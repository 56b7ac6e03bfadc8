"""What Sec. 3.4 shows of a run: tracking errors, torque, estimates and principal moments; and how they are drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from adcs.library import attitude
from adcs.library.outcome import Row, Verdict
from adcs.library.thakur.adaptive.settings import FUEL_RATES, MASSES, THETA
from orchestration.results.plots import Guide, Panel, Series, told_apart
from orchestration.results.result import Result

Array = NDArray[np.float64]

ATTITUDE, RATE, TORQUE = "attitude error", "rate error", "control torque"
SYMBOLS = {ATTITUDE: "‖q_ev‖", RATE: "‖ω_e‖ [deg/s]", TORQUE: "‖u‖ [N·m]"}
THETA_LABELS = ("J11", "J12", "J13", "J22", "J23", "J33")
ESTIMATES = ("mass_est", "sigma_est", "J_1_est")
"""The estimate of J_1 by the name it has in the controllers, of which each has at most one."""
TRUE_J_1 = {
    "mass_est": np.array(MASSES),
    "sigma_est": np.array(FUEL_RATES),
    ("J_1_est", 6): -np.hstack([m * np.eye(3) for m in MASSES]).ravel(),
    ("J_1_est", 3): np.diag(FUEL_RATES).ravel(),
}
_TINY = 1e-9  # s


@dataclass(frozen=True)
class Track:
    """One run, sampled at `time` (N,).

    `norms` maps ATTITUDE, RATE [deg/s] and TORQUE [N.m] to arrays (N,); `theta` (N, 6) [kg.m2]; `sigma` (N, k) the
    estimate of J_1 (k = 0: none) and `true_sigma` (k,); `moments` (N, 3) the principal moments of inertia [kg.m2] in
    ascending order; `extra` further recorded scalars.
    """

    time: Array
    norms: Mapping[str, Array]
    theta: Array
    sigma: Array
    true_sigma: Array
    moments: Array
    extra: Mapping[str, Array] = field(default_factory=dict)

    def between(self, name: str, start: float, end: float) -> Array:
        """The norm from `start` to `end` [s]."""
        kept = (self.time >= start - _TINY) & (self.time <= end + _TINY)
        return self.norms[name][kept]

    def end(self, name: str) -> float:
        """The last value of the norm."""
        return float(self.norms[name][-1])

    def peak(self, name: str) -> float:
        """Largest norm."""
        return float(self.norms[name].max())

    def settling_time(self, name: str, part: float) -> float:
        """Time from which on the norm stays below `part` of its peak [s]; NaN if it does not."""
        return attitude.settling_time(self.time, self.norms[name], part * self.peak(name))

    def area(self, name: str, start: float, end: float) -> float:
        """Integral of the norm from `start` to `end` [s]."""
        kept = (self.time >= start - _TINY) & (self.time <= end + _TINY)
        return float(np.trapezoid(self.norms[name][kept], self.time[kept]))

    def theta_error(self) -> Array:
        """Norm of the error of theta over time [kg.m2], (N,)."""
        return attitude.norm(self.theta - np.array(THETA))

    def sigma_error(self) -> Array:
        """Norm of the error of the estimate of J_1 as a part of the norm of the true value, (N,)."""
        return attitude.norm(self.sigma - self.true_sigma) / float(np.linalg.norm(self.true_sigma))

    def at(self, time: float) -> int:
        """Index of the sample at `time` [s], or of the last one before it."""
        return int(np.searchsorted(self.time, time + _TINY)) - 1

    def triangle_margin(self) -> float:
        """Least value over time of the sum of the smaller two principal moments less the largest [kg.m2], (3.5)."""
        return float((self.moments[:, 0] + self.moments[:, 1] - self.moments[:, 2]).min())


def track(result: Result) -> Track:
    """The run of any system of Sec. 3.4."""
    norms = {
        ATTITUDE: attitude.norm(result["controller.q_BR"][:, 1:]),
        RATE: np.degrees(attitude.norm(result["controller.omega_BR_B"])),
        TORQUE: attitude.norm(result["controller.torque_B"]),
    }
    n = len(result.time)
    sigma, true_sigma = np.zeros((n, 0)), np.zeros(0)
    for name in ESTIMATES:
        if f"controller.{name}" in result.names:
            values = result[f"controller.{name}"]
            sigma = values.reshape(n, -1)
            true_sigma = TRUE_J_1[name if values.ndim == 2 else (name, values.shape[2])]
    inertia = result["plant.J_B"] if "plant.J_B" in result.names else np.zeros((0, 3, 3))
    extra: dict[str, Array] = {
        name: result[name]
        for name in ("controller.implementability", "plant.fuel_left", "plant.torque_impulse")
        if name in result.names
    }
    moments = np.asarray(np.linalg.eigvalsh(inertia), dtype=float)
    return Track(result.time, norms, result["controller.theta_est"], sigma, true_sigma, moments, extra)


def row(
    section: str, cell: str, settings: str, printed: float | str, ours: float | str, result: Verdict, note: str = ""
) -> Row:
    """A row of this chapter; the relative error where both are numbers."""
    both = isinstance(printed, float) and isinstance(ours, float) and printed != 0
    error = abs(float(ours) - float(printed)) / abs(float(printed)) if both else None
    return Row("thakur", section, cell, settings, printed, ours, error, result, note)


def norm_panel(
    name: str,
    runs: Mapping[str, Track],
    title: str,
    group: str,
    *,
    log: bool = True,
    until: float | None = None,
    guides: Sequence[Guide] = (),
) -> Panel:
    """The norm of an error or of the torque, a curve per run."""
    series = []
    for color, (label, run) in enumerate(runs.items()):
        kept = slice(None) if until is None else slice(run.at(until) + 1)
        series.append(Series(label, run.time[kept], run.norms[name][kept], color=color))
    return Panel(title, SYMBOLS[name], series, log, guides=guides, group=group)


def moments_panel(runs: Mapping[str, Track], title: str, group: str) -> Panel:
    """Principal moments of inertia, runs told apart by the dashes."""
    series = [
        Series(f"{label} λ{i + 1}".strip(), run.time, run.moments[:, i], dash, color=i)
        for label, run, dash in told_apart(runs)
        for i in range(3)
    ]
    return Panel(title, "principal moments [kg·m²]", series, group=group)


def theta_panel(run: Track, title: str, group: str) -> Panel:
    """The estimate of J_0 as solid curves, the true values dashed."""
    return _estimate_panel(run.time, run.theta, np.array(THETA), THETA_LABELS, title, "θ̂ [kg·m²]", group)


def sigma_panel(run: Track, labels: Sequence[str], unit: str, title: str, group: str) -> Panel:
    """The estimate of J_1 as solid curves, the true values dashed; many of them are drawn thin and without label."""
    return _estimate_panel(run.time, run.sigma, run.true_sigma, labels, title, f"Ĵ₁ [{unit}]", group)


def _estimate_panel(
    time: Array, values: Array, true: Array, labels: Sequence[str], title: str, y_label: str, group: str
) -> Panel:
    faint = values.shape[1] > len(labels)
    names = [f"{i + 1}" for i in range(values.shape[1])] if faint else list(labels)
    series = [Series(name, time, values[:, i], color=i % 8, faint=faint) for i, name in enumerate(names)]
    ends = [time[0], time[-1]]
    series += [
        Series("true values" if i == 0 else "", ends, [value, value], "dash", color=i % 8, faint=i > 0)
        for i, value in enumerate(true)
    ]
    return Panel(title, y_label, series, group=group)

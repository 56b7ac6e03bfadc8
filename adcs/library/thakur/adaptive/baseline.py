"""Sec. 3.4, Fig. 3.3: both laws with known, constant inertia, and the numbers and signs that can be checked by hand."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot, sqrt

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section, Simulation
from adcs.library.thakur.adaptive import settings as settings
from adcs.library.thakur.adaptive.settings import FREQUENCIES, Reading
from adcs.library.thakur.adaptive.signals import ATTITUDE, RATE, TORQUE, track
from adcs.library.thakur.adaptive.systems import baseline, comparison_baseline
from adcs.library.thakur.choices import Choices
from adcs.library.trajectory import Runs, norm_panel
from orchestration.results.report import KeyNumber
from orchestration.running.method import ModelExchange

WHERE = "Sec. 3.4"
PROPOSED, COMPARISON = "proposed", "comparison"
OUTPUT_STEP = 0.1  # s
SHOWN, DRAWN = 100.0, 60.0  # s
ALIKE = 1.5  # similar and comparable are within this factor
SAME = 0.01  # a printed number is reproduced within this part of it


def known_inertia(_: Choices) -> Section:
    """Fig. 3.3, and the claims that need no simulation."""
    runs = {
        name: Simulation(f"{name} law, known inertia, coupled", build(), track, SHOWN, OUTPUT_STEP, ModelExchange())
        for name, build in ((PROPOSED, baseline), (COMPARISON, comparison_baseline))
    }

    def show(pair: Runs) -> Iterator[Shown]:
        shown = {name: run.until(DRAWN) for name, run in pair.items()}
        least, note = min(run.settled(RATE, 0.02) for run in pair.values()), "first of both laws, to 2% of its peak"
        yield from _similar(pair)
        yield from _numbers()
        yield from SIGNS
        yield norm_panel(RATE, shown, "Fig. 3.3  Rate tracking error")
        yield norm_panel(ATTITUDE, shown, "Fig. 3.3  Attitude tracking error")
        yield norm_panel(TORQUE, shown, "Fig. 3.3  Control torque", log=False)
        yield KeyNumber("Known inertia: rate error converged", least, "s", note)

    title = "The statements on known inertia, and what is printed"
    return Section("3.4  Constant and known inertia", title, show, runs)


def alike(ratio: float) -> bool:
    """Whether a ratio is about 1."""
    return 1 / ALIKE < ratio < ALIKE


def _similar(pair: Runs) -> Iterator[Claim]:
    both = f"{PROPOSED} / {COMPARISON}"
    for error in (ATTITUDE, RATE):
        times = [run.settled(error, 0.02) for run in pair.values()]
        peaks = [run.peak(error) for run in pair.values()]
        ratio = times[0] / times[1]
        yield Claim(WHERE, f"{error}: ratio of the times of convergence", both,
                    "similar (about 1)", ratio, alike(ratio),
                    f"{times[0]:.3g} s and {times[1]:.3g} s to 2 % of the peaks, {peaks[0]:.3g} and {peaks[1]:.3g}; "
                    f"judged at a factor of {ALIKE:g}")  # fmt: skip
    peaks = [run.peak(TORQUE) for run in pair.values()]
    ratio = peaks[0] / peaks[1]
    yield Claim(WHERE, "largest torque: ratio", both,
                "similar (about 1)", ratio, alike(ratio),
                f"{peaks[0]:.3g} and {peaks[1]:.3g} N.m; judged at a factor of {ALIKE:g}")  # fmt: skip


def peak_rate(reading: Reading) -> float:
    """Largest |r(t)| of (3.58) over the figures' 400 s [rad/s], with the minus sign in the first exponent."""
    g, w = settings.GUIDANCE, FREQUENCIES[reading]
    t = np.linspace(0.0, settings.STOP_TIME, 400_001)
    fade = np.exp(-g["decay"] * t**2)
    r = g["amplitude"] * np.cos(w * t) * (1 - fade) + (g["ramp"] + g["wobble"] * np.sin(w * t)) * t * fade
    return float(np.abs(r).max())


def zeta(rate_bound: float) -> float:
    """zeta* of (3.43) [rad/s] for a bound on the reference rate [rad/s]."""
    p = settings.FUEL_PROJECTION
    return 2 * (1 / (3 * hypot(p["sigma_bound"], p["sigma_margin"])) - rate_bound - 0.5)


def level(zeta_: float) -> float:
    """The right-hand side of (3.46)."""
    p, g, a = settings.FUEL_PROJECTION, settings.ADAPTIVE_GAINS, settings.FUEL_ADAPTATION
    least, largest = settings.EIGENVALUE_MIN, settings.EIGENVALUE_MAX
    theta = (hypot(p["theta_bound"], p["theta_margin"]) + p["theta_bound"]) ** 2
    sigma = (hypot(p["sigma_bound"], p["sigma_margin"]) + p["sigma_bound"]) ** 2
    inner = least / 2 * ((zeta_ - 1) ** 2 - 1) - 4 * (g["beta"] + g["k_v"])
    return 2 / largest * (inner - theta / (2 * a["gamma_1"]) - sigma / (2 * a["gamma_2"]))


def triangle_impulse() -> float:
    """Torque impulse at which the inertia with fuel loss no longer satisfies the triangle inequality (3.5) [N.m.s]."""
    from scipy.optimize import brentq  # here, for whoever only lists the systems

    J_0, J_1 = np.array(settings.INERTIA), np.diag(settings.FUEL_RATES)

    def margin(impulse: float) -> float:
        moments = np.linalg.eigvalsh(J_0 - impulse * J_1)
        return float(moments[0] + moments[1] - moments[2])

    return float(brentq(margin, 0.0, 2800.0))


def _numbers() -> list[Claim]:
    J_0 = np.array(settings.INERTIA)
    bounds = {reading: peak_rate(reading) for reading in FREQUENCIES}
    slow, fast = (sqrt(3) * bound for bound in bounds.values())  # the true omega_B for 0.3 and 1 rad/s
    start, largest = float(np.linalg.norm(settings.START["omega_BN_B"])), float(np.linalg.eigvalsh(J_0)[-1])
    levels, impulse = (level(zeta(slow)), level(zeta(fast))), triangle_impulse()
    least = np.linalg.eigvalsh(J_0 - impulse * np.diag(settings.FUEL_RATES))[0]
    printed_zeta, printed_level = zeta(settings.RATE_BOUND), level(settings.ZETA)
    return [
        _number("λmax, largest eigenvalue of J_0 [kg.m2]", "(3.57)", settings.EIGENVALUE_MAX, largest),
        _number("‖ω_e(0)‖ [rad/s]", "start of Sec. 3.4", 0.0024, start,
                "√6/1000: the printed value is cut off after two digits", 1e-4 / 0.0024),
        _number("ω_B = sup ‖ω_r‖ [rad/s]", "(3.58) as printed, frequency 0.3", settings.RATE_BOUND, slow,
                f"sup |r| is {bounds['printed']:.4f}, and ‖[1 1 1]‖ = √3 comes on top. With the frequency 1 rad/s of "
                f"the original profile sup |r| is {bounds['original']:.4f}: the printed value fits that, without √3",
                None),
        _number("ζ* of (3.43) [rad/s]", "from the printed ω_B", settings.ZETA, printed_zeta,
                f"with the true ω_B {zeta(slow):.2f} (0.3 rad/s) and {zeta(fast):.2f} (1 rad/s)"),
        _number("right-hand side of (3.46)", "from the printed ζ*", settings.LEVEL, printed_level,
                f"with the true ω_B {levels[0]:.2f} and {levels[1]:.2f}"),
        Claim(WHERE, "(3.46): (‖ω_e(0)‖ + 1)² below the right-hand side", "with the true ω_B, both frequencies",
              "satisfied", f"{(1 + start) ** 2:.3f} < {min(levels):.2f}", (1 + start) ** 2 < min(levels)),
        Claim(WHERE, "λmin = 0.5 kg.m2 at dry mass, with (3.5) for all time", "J_0 and J_1 of Sec. 3.4", "both",
              f"(3.5) fails below λmin = {least:.3g} kg.m2", None,
              f"J_0 - J_1 ψ violates the triangle inequality from ψ = {impulse:.0f} N.m.s on, long before its "
              "least eigenvalue is 0.5: so much fuel no real body could carry. The simulations do not get that far"),
    ]  # fmt: skip


def _number(cell: str, which: str, printed: float, ours: float, note: str = "", within: float | None = SAME) -> Claim:
    """A printed number beside ours, reproduced within that part of it; None: it is wrong in print."""
    error = abs(ours - printed) / abs(printed)
    return Claim(WHERE, cell, which, printed, ours, None if within is None else error <= within, note, error)


SIGNS = (
    Claim(WHERE, "second term of the comparison law (3.53)", "tests/laws/test_adaptive_loop.py",
          "-gamma W_f W_fᵀ[…]", "+gamma W_f W_fᵀ[…]", None,
          "with a plus the loop stays on its manifold, η' = -alpha η, to 1e-8; with the printed minus it does not, "
          "and passes 5 rad/s after 4.6 s for constant inertia"),
    Claim(WHERE, "ω_rB below (3.36)", "tests/laws/test_adaptive_loop.py", "C(q_r) ω_r", "C(q_e) ω_r", None,
          "with C(q_r) the Lyapunov identity of Theorem 3.2.1 fails"),
    Claim(WHERE, "r(t), (3.58), first exponent", "t = 400 s", "1 - exp(+0.01 t²)", "1 - exp(-0.01 t²)", None,
          "a minus sign is missing: as printed r would overflow any number before 400 s"),
)  # fmt: skip

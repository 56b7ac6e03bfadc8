"""The feasible gain regions, Fig. 2, with the gains of the simulations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from adcs.library.outcome import Claim, Shown
from adcs.library.sections import Section
from adcs.library.velocity_free.gain_region import (
    A_RANGE,
    B_RANGE,
    CONDITIONS,
    FILTER_BOUNDS,
    STABILISATION,
    TRACKING,
    Array,
    Bounds,
    Region,
    margins,
    region,
    search,
)
from adcs.library.velocity_free.settings import GAINS, START, Choices
from orchestration.results.plots import Dash, Panel, Series
from orchestration.results.report import KeyNumber, Table

GROUP = "Fig. 2  Feasible gain regions"
RIGOROUS = "1 + mu_v"
CASES: Mapping[str, tuple[str, Bounds]] = {"stabilisation": ("2a", STABILISATION), "tracking": ("2b", TRACKING)}
POINT = f"a = {GAINS['a']:g}, b = {GAINS['b']:g}"


def feasible(choices: Choices) -> Section:
    """Both regions for each bound on the filter's part, and the verdict on the gains of the simulations."""
    return Section(GROUP, "The statements on the gains", lambda _: _feasible(choices))


def _feasible(choices: Choices) -> Iterator[Shown]:
    cells: list[list[object]] = []
    regions: dict[str, Region] = {}
    gains = np.array([GAINS["a"]]), np.array([GAINS["b"]])
    for case, (figure, bounds) in CASES.items():
        drawn: dict[str, Region] = {}
        for label, bound in FILTER_BOUNDS.items():
            with_bound = replace(bounds, filter_bound=bound, start_rate=choices.start_rate)
            found, free = search(*gains, with_bound, generations=300)
            at = margins(*gains, free, with_bound)
            drawn[label] = region(with_bound, choices.grid)
            values = [float(x[0]) for x in (at.definite, at.roots, at.nested, at.start)]
            residual = float(at.residual[0]) if found[0] > 0 else None
            cells.append([case, label, drawn[label].share, *values, "yes" if found[0] > 0 else "no", residual])
            if label == RIGOROUS:
                yield _gains_lie_inside(case, figure, float(found[0]))
        regions[case] = drawn[RIGOROUS]
        yield _panel(case, figure, drawn)
        share = regions[case].share
        yield KeyNumber(f"{case.capitalize()}: feasible part of the square", share, "", f"bound {RIGOROUS}")
    yield _no_smaller(regions)
    yield _start_rate(choices)
    yield _table(cells)


def _gains_lie_inside(case: str, figure: str, margin: float) -> Claim:
    return Claim("Sec. V", "gains of the simulations lie in the region", f"{case}, {POINT}",
                 "feasible (> 0)", margin, margin > 0,
                 f"smallest relative margin of the conditions, Fig. {figure}; bound {RIGOROUS} on the filter term; "
                 "with the bound 2 the gains are outside, see the table")  # fmt: skip


def _no_smaller(regions: Mapping[str, Region]) -> Claim:
    stabilisation, tracking = regions["stabilisation"], regions["tracking"]
    outside = int((tracking.inside & ~stabilisation.inside).sum())
    return Claim("Sec. V", "stabilisation region no smaller than the tracking region",
                 "grid points of tracking outside it",
                 "0", float(outside), outside == 0,
                 f"shares of the square {stabilisation.share:.3f} and {tracking.share:.3f}")  # fmt: skip


def _start_rate(choices: Choices) -> Claim:
    """‖dw(0)‖ is printed as 0.01; the simulation starts with 0.0995. Does it matter to the regions?"""
    shares = [
        region(replace(bounds, start_rate=rate), choices.grid).share
        for bounds in (STABILISATION, TRACKING)
        for rate in (0.01, 0.1)
    ]
    return Claim("Sec. V", "bound on the initial rate error in rad/s", "‖δω(0)‖",
                 0.01, float(np.linalg.norm(START["omega_BN_B"])), None,
                 "the runs start at 0.0995 rad/s, ten times the printed bound and so outside of what it covers; parts "
                 f"of the square that are feasible with 0.01 and with 0.1: {shares[0]:.4f}, {shares[1]:.4f} "
                 f"(stabilisation), {shares[2]:.4f}, {shares[3]:.4f} (tracking): (89) hardly binds")  # fmt: skip


def _table(cells: list[list[object]]) -> Table:
    columns = ["case", "bound of the filter term", "feasible part", *(f"margin {c}" for c in CONDITIONS)]
    columns += ["feasible", "V₀ in the residual set [N·m]"]
    note = (
        f"Margins at {POINT}, each the relative distance from failing (of Q1 > 0: the eigenvalue 1/k4 in 1/s), for the "
        "choice of c1, c2, ξ that makes the smallest of them largest; V1 ≥ 0 holds by construction. 1 + μ_v is "
        "rigorous; 1 holds without measurement error; 2 follows from (59) alone. The last column is what the "
        f"proof promises for V₀ in the end. V₀ at rest is at most 4a = {4 * GAINS['a']:g} N·m for any attitude, so the "
        "promise says that the state stays bounded, and nothing about the attitude."
    )
    return Table("Regions and margins", columns, cells, note)


def _panel(case: str, figure: str, drawn: Mapping[str, Region]) -> Panel:
    series = []
    for color, (label, found) in enumerate(drawn.items()):
        dash: Dash = "solid" if label == RIGOROUS else "dash"
        for i, line in enumerate(_boundary(found)):
            series.append(Series(f"bound {label}", line[:, 0], line[:, 1], dash, color, faint=i > 0))
    series.append(Series(POINT, [GAINS["a"]], [GAINS["b"]], color=3, markers=True))
    (a, A), (b, B) = A_RANGE, B_RANGE
    corners = Series("searched", [a, A, A, a, a], [b, b, B, B, b], "dot", 7)
    return Panel(
        f"Fig. {figure}  Feasible gains, {case}",
        "b [N·m·s]",
        [*series, corners],
        x_label="a [N·m]",
        note="Feasible is what lies above a line, or to the left of it.",
    )


def _boundary(found: Region) -> list[Array]:
    """Where the margin passes through zero, as lines (n, 2) of a and b."""
    from contourpy import contour_generator  # here, for whoever only lists the systems

    lines: Any = contour_generator(found.a, found.b, np.clip(found.margin, -1, 1)).lines(0.0)
    return [np.asarray(line, dtype=float) for line in lines]

"""The gain region against its conditions written one by one, these against the dynamics; the study, shortened."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from adcs import AdcsError
from adcs import run as run_system
from adcs.catalogue import STUDIES, SYSTEMS
from adcs.library.sections import conduct
from adcs.library.velocity_free import feasible, gain_region, loops, study
from adcs.library.velocity_free.gain_region import (
    FILTER_BOUNDS,
    STABILISATION,
    TRACKING,
    Bounds,
    margins,
    region,
    search,
)
from adcs.library.velocity_free.settings import Choices
from adcs.library.velocity_free.systems import BUILDERS
from adcs.listed import SYSTEMS as DESCRIPTIONS
from references.observer_pd import rate_along
from references.velocity_free import INERTIA, Conditions, Errors

POINT = np.array([0.2]), np.array([0.8])


def parameters(bounds: Bounds) -> dict[str, float]:
    return {
        "nu": bounds.rate,
        "nu_dot": bounds.acceleration,
        "mu_v": bounds.attitude_error,
        "mu_w": bounds.error_rate,
        "mu_d": bounds.torque,
        "mu_J": bounds.inertia_error,
        "filter": bounds.filter_bound,
        "start_attitude": bounds.start_attitude,
        "start_rate": bounds.start_rate,
    }


def chosen(a: float, b: float, free: Any) -> tuple[float, float, Any]:
    """c1, c2 and xi that six free numbers stand for."""
    low, _, high = np.linalg.eigvalsh(INERTIA)
    c2 = high / np.sqrt(1 - 0.01**2) * (1 + np.exp(free[0]))
    c1 = max(c2 / (2 * low), np.sqrt(high / (2 * a) + c2**2 / (low * b))) * (1 + np.exp(free[1]))
    return c1, c2, 1 / (1 + np.exp(-free[2:]))


@pytest.mark.parametrize("bounds", [STABILISATION, TRACKING], ids=["stabilisation", "tracking"])
def test_margins_are_those_of_the_conditions_one_by_one(bounds: Bounds) -> None:
    rng = np.random.default_rng(1)
    compared = 0
    _, near = search(*POINT, bounds, generations=40)
    for _ in range(300):
        a, b = rng.uniform(0.1, 0.3), rng.uniform(0.5, 1.5)
        free = near[0] + 0.3 * rng.normal(size=6) if compared < 40 else rng.normal(size=6)
        ours = margins(np.array(a), np.array(b), free, bounds)
        theirs = Conditions(a, b, *chosen(a, b, free), parameters(bounds), INERTIA)
        assert ours.definite == pytest.approx(theirs.inverse_k4, rel=1e-9, abs=1e-9)
        if ours.definite > 0:
            real = bool(np.isreal(theirs.roots).all())
            assert (ours.roots > 0) == (real and theirs.roots[0] > 0)
            if ours.roots > 0:
                r_1, r_2 = theirs.roots
                residual = theirs.gain4 * r_1**2 + theirs.gain5 * r_1
                assert ours.nested == pytest.approx(theirs.gain4 * r_2**2 / residual - 1, rel=1e-6)
                assert ours.start == pytest.approx(theirs.gain4 * r_2**2 / theirs.V_start - 1, rel=1e-6)
                compared += 1
        if compared > 60:
            break
    assert compared > 20


def test_the_bound_60_holds_for_the_error_dynamics() -> None:
    """V' of (36) along (23), (26), by differences, is never above the bound that the conditions are built on.

    States from large to small, so that each term leads somewhere; errors at their bounds, which are magnified. Without
    these the bound is broken.
    """
    rng = np.random.default_rng(2)
    p = {"nu": 0.3, "nu_dot": 0.2, "mu_v": 0.3, "mu_w": 0.2, "mu_d": 0.02, "mu_J": 0.01, "filter": 1.3}
    p |= {"start_attitude": 0.1, "start_rate": 0.1}
    low, _, high = np.linalg.eigvalsh(INERTIA)

    def within(size: float, n: int = 3) -> Any:
        v = rng.normal(size=n)
        return v / np.linalg.norm(v) * size

    certain, broken = p | {"mu_v": 0.0, "mu_w": 0.0, "mu_d": 0.0, "mu_J": 0.0}, 0.0
    for _ in range(400):
        size = 10 ** rng.uniform(-2, 0)
        a, b = rng.uniform(0.05, 0.3), rng.uniform(0.1, 1.5)
        c2 = high / np.sqrt(1 - p["mu_v"] ** 2) * rng.uniform(1.1, 3)
        c1 = max(c2 / (2 * low), np.sqrt(high / (2 * a) + c2**2 / (low * b))) * rng.uniform(1.01, 3)
        xi = np.array([rng.uniform(0.1, 0.9), 0.5, 0.5, 0.5])
        conditions = Conditions(a, b, c1, c2, xi, p, INERTIA)
        D = rng.normal(size=(3, 3))
        D = (D + D.T) / np.linalg.norm(D + D.T, 2) * p["mu_J"]
        v = within(p["mu_v"] * rng.uniform())
        tilde = np.append(np.sqrt(1 - v @ v), v)
        part = within(size * rng.uniform())
        dq = np.append(np.sqrt(1 - part @ part), part)
        uncertain = (within(2 * p["mu_w"]), within(p["nu"]), within(p["nu_dot"]), within(p["mu_d"]))
        sigma = dq * (1 - size * rng.uniform())
        point = Errors(dq, within(2 * size * rng.uniform()), sigma, tilde, *uncertain, INERTIA, INERTIA + D, a, b)
        x = point.x
        slope = rate_along(
            lambda _, y: np.array(point.V(y, c1, c2, conditions.c3)),  # noqa: B023
            0.0,
            x,
            point.rates(x),
            h=1e-4,
        )
        z = np.array([np.linalg.norm(dq[1:]), np.linalg.norm(x[4:7]), np.linalg.norm(point.filter_rate(x))])
        assert conditions.bound(z, point.V_0(x)) - float(slope) > -1e-8
        blind = Conditions(a, b, c1, c2, xi, certain, INERTIA)
        broken = max(broken, float(slope) - blind.bound(z, point.V_0(x)))
    assert broken > 0.1


@pytest.mark.parametrize(
    ("case", "bound", "feasible_"),
    [
        (STABILISATION, "1", True),
        (STABILISATION, "1 + mu_v", True),
        (STABILISATION, "2", False),
        (TRACKING, "1", True),
        (TRACKING, "1 + mu_v", True),
        (TRACKING, "2", False),
    ],
)
def test_the_gains_of_the_simulations(case: Bounds, bound: str, feasible_: bool) -> None:
    margin, _ = search(*POINT, replace(case, filter_bound=FILTER_BOUNDS[bound]), generations=200)
    assert (margin[0] > 0) == feasible_
    assert abs(margin[0]) > 0.05


def test_regions() -> None:
    """The tracking region lies within the stabilising one, and both have an end towards small b and large a."""
    stabilising, tracking = (region(bounds, 13, rounds=20) for bounds in (STABILISATION, TRACKING))
    assert not (tracking.inside & ~stabilising.inside).any()
    assert stabilising.share == pytest.approx(0.83, abs=0.05)
    assert tracking.share == pytest.approx(0.79, abs=0.05)
    for found in (stabilising, tracking):
        assert found.margin.shape == (13, 13)
        assert found.inside[0].mean() < 0.1
        assert found.inside[-1].all()
    worse = region(replace(TRACKING, torque=0.05), 9, rounds=10)
    assert worse.share < tracking.share


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Bounds(inertia=np.diag([1.0, 1.0, -1.0])),
            "bounds: inertia is not a symmetric positive definite 3 x 3",
        ),
        (lambda: Bounds(torque=-1.0), "bounds: torque = -1: expected 0 or more"),
        (lambda: Bounds(attitude_error=1.0), "bounds: attitude_error = 1 bounds the vector part of a unit quaternion"),
        (lambda: search([0.2, 0.1], [0.8], STABILISATION), r"gains: a has shape \(2,\) and b \(1,\)"),
        (lambda: search([-0.2], [0.8], STABILISATION), "gains: a and b must be positive"),
        (lambda: Choices(mass=0.0), "choice mass = 0: expected a positive mass"),
        (lambda: Choices(steady_from=300.0), "choice steady_from = 300: expected earlier than stop_time"),
    ],
)
def test_bad_input_is_refused_in_one_line(make: Any, message: str) -> None:
    with pytest.raises(AdcsError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("name", "build"), BUILDERS.items())
def test_the_systems_are_registered_run_and_are_shown(name: str, build: Any) -> None:
    entry, system = SYSTEMS[name], build()
    assert (system.name, system.description) == (name, entry.description) == (entry.name, DESCRIPTIONS[name])
    result = run_system(system, stop_time=1.0, step=0.01)
    panels = entry.figures(result)
    assert {panel.group for panel in panels} >= {"Tracking", "Control"}
    assert {number.label for number in entry.key_numbers(result)} >= {"Largest torque"}


def test_the_study_on_short_runs() -> None:
    """Two seeds and 30 s: what must come out does, and the report has its figures."""
    choices = Choices(seeds=2, stop_time=30.0, steady_from=20.0, grid=9, step=0.01)
    outcome, _ = conduct([loops.problem(choices, loops.PROBLEMS[1])])
    by_cell = {row.statement.split(":")[0]: row for row in outcome.claims}
    bounded = by_cell["attitude tracking error does not converge to zero but is bounded"]
    assert 1e-3 < float(bounded.measure) < 0.02  # type: ignore[arg-type]
    assert [panel.title[:7] for panel in outcome.panels[:3]] == ["Fig. 4a", "Fig. 4a", "Fig. 4b"]
    shown, _ = conduct([feasible.feasible(choices)])
    assert [row.verdict for row in shown.claims] == ["reproduced"] * 3 + ["wrong in print"]
    assert STUDIES["velocity-free"].run is study.run
    assert gain_region.CONDITIONS == ("Q1 > 0", "(79)", "(86)", "(89)")

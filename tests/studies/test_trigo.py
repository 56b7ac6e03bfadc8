"""The study of the thesis: its transcription, its measures, and the tables that come out of full runs."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

from adcs import Save, System, run
from adcs.catalogue import STUDIES, SYSTEMS
from adcs.library.outcome import Claim
from adcs.library.trigo import study, views
from adcs.library.trigo.catalogue import SCENARIOS
from adcs.library.trigo.departures import DEPARTURES, undone
from adcs.library.trigo.metrics import Metrics, measure
from adcs.library.trigo.printed import Cell, Run, cells
from adcs.library.trigo.settings import (
    ARCSEC,
    AS_MADE,
    AS_PRINTED,
    CONTROLLERS,
    CORRECTED,
    RATES,
    Choices,
    Reading,
    known_inertia,
    mirror_moments,
    parallel_axis,
)
from adcs.library.trigo.systems import ESTIMATE, build, exchange_step, recorded, stride
from orchestration.results.plots import Panel

CHOICES = Choices()
AT_10_HERTZ = cells(())


def full(which: Run, reading: Reading) -> Metrics:
    """One full run and its measures."""
    system = build(which.controller, which.scenario, reading, which.rate)
    step = exchange_step(which.scenario, reading, which.rate)
    save = Save(recorded(system), every=stride(step, which.rate))
    return measure(run(system, stop_time=1100.0, step=step, save=save))


@pytest.fixture(scope="module")
def as_made() -> dict[Run, Metrics]:
    """The twenty runs of Tables 9.6 to 9.16."""
    return {Run(c, s): full(Run(c, s), AS_MADE) for s in SCENARIOS for c in CONTROLLERS}


def judged(cell: Cell, metrics: dict[Run, Metrics]) -> Claim:
    return study._claim(cell, AS_MADE, metrics, CHOICES)


# --- what was typed off -----------------------------------------------------------------------------------------------


def test_all_cells_are_there() -> None:
    count = Counter(cell.table for cell in cells(RATES))
    assert [count[f"Table 9.{i}"] for i in range(6, 20)] == [15, 5, 30, 6, 5, 30, 6, 5, 30, 6, 5, 90, 90, 36]
    assert len({(c.table, c.label) for c in cells(RATES)}) == 359, "no two cells have the same name"


def test_printed_ratios_are_those_of_the_printed_numbers() -> None:
    """To what the digits allow; two are known to be divided by the wrong number."""
    plain = {(c.run, c.measure): c for c in cells(RATES) if c.over is None}
    wrong = []
    checked = 0
    for cell in cells(RATES):
        if cell.over is None:
            continue
        above, below = plain[cell.run, cell.measure], plain[cell.over, cell.measure]
        least = (above.printed - above.half_digit) / (below.printed + below.half_digit) - cell.half_digit
        most = (above.printed + above.half_digit) / (below.printed - below.half_digit) + cell.half_digit
        checked += 1
        if not least <= cell.printed <= most:
            wrong.append(cell.text)
    assert checked == 45 + 90 + 18
    assert sorted(wrong) == ["147.424", "282.624"]


# --- the numbers ------------------------------------------------------------------------------------------------------


def test_tables_9_6_to_9_16_come_out(as_made: dict[Run, Metrics]) -> None:
    """All 143 cells within 0.1 % or half their last digit, but for the seven that are wrong in print."""
    rows = [judged(cell, as_made) for cell in AT_10_HERTZ]
    assert Counter(row.verdict for row in rows) == {"reproduced": 136, "wrong in print": 7}
    wrong = [row for row in rows if row.verdict == "wrong in print"]
    assert {row.where for row in wrong} == {"Table 9.11", "Table 9.13"}


def test_numbers_of_three_digits_or_more_come_out_to_three_parts_in_ten_thousand(as_made: dict[Run, Metrics]) -> None:
    """Where print has digits enough to see it: scanning and estimation to 0.02 %, the others to 0.03 %."""
    seen = 0
    for cell in AT_10_HERTZ:
        if cell.over is not None or cell.meant is not None or cell.half_digit > 1e-4 * cell.printed:
            continue
        seen += 1
        limit = 2e-4 if cell.measure in ("scanning", "estimation") else 3e-4
        assert abs(cell.of(as_made) / cell.printed - 1) < limit, cell.label
    assert seen > 35


@pytest.mark.parametrize(
    ("which", "name", "printed"),
    [
        (Run("ii", "wheel", 50.0), "scanning", 4.655),
        (Run("neso", "wheel", 20.0), "entire", 8.839),
        (Run("tf", "mirror", 20.0), "scanning", 8.198),
        (Run("bs", "wheel", 20.0), "steady", 396.397),
    ],
)
def test_cells_at_other_rates_come_out(which: Run, name: str, printed: float) -> None:
    assert full(which, AS_MADE).pointing[name] == pytest.approx(printed, rel=3e-4)


def test_the_literal_reading_is_another_simulation() -> None:
    """Its nominal run misses the table by a factor of four, because it differentiates its reference analytically."""
    metrics = full(Run("bs", "nominal"), AS_PRINTED)
    assert metrics.pointing["entire"] == pytest.approx(2.092, abs=5e-4)
    assert metrics.pointing["scanning"] == pytest.approx(0.529, abs=5e-4)


def test_with_the_right_spin_inertia_the_mirror_hardly_disturbs(as_made: dict[Run, Metrics]) -> None:
    made = as_made[Run("bs", "mirror")]
    right = full(Run("bs", "mirror"), CORRECTED)
    assert made.disturbance > 200 * right.disturbance
    assert right.pointing["scanning"] == pytest.approx(as_made[Run("bs", "nominal")].pointing["scanning"], rel=1e-3)
    assert made.pointing["scanning"] > 3 * right.pointing["scanning"]


def test_each_departure_matters(as_made: dict[Run, Metrics]) -> None:
    """Taken back alone, each of them moves the cell that is shown for it."""
    plain = {(c.run, c.measure): c for c in AT_10_HERTZ if c.over is None}
    for departure in DEPARTURES:
        if departure.field in ("disturbance_held", "mirror_size"):
            continue  # 0.5 s each, and tested above in other words
        cell = plain[departure.run, departure.measure]
        without = cell.of({departure.run: full(departure.run, undone(departure))})
        made = cell.of(as_made)
        assert abs(without - made) > 1e-4 * made, departure.field


# --- settings and measures --------------------------------------------------------------------------------------------


def test_inertias_are_those_of_print() -> None:
    """(9.3) as printed to three digits; the cuboid of 30 g; the parallel axis of the wheel."""
    printed = [[3.053, 0.030, 0.168], [0.030, 3.054, -0.166], [0.168, -0.166, 2.143]]
    np.testing.assert_allclose(known_inertia("mismatch"), printed, atol=6e-4)
    np.testing.assert_allclose(mirror_moments((0.005, 0.05, 0.05)), [1.25e-5, 6.3125e-6, 6.3125e-6], rtol=1e-14)
    np.testing.assert_allclose(
        parallel_axis(1.0, (0.043, 0.0, 0.014)),
        [[0.000196, 0, -0.000602], [0, 0.002045, 0], [-0.000602, 0, 0.001849]],
        atol=1e-15,
    )


class Made:
    """A made-up result, of any length, with the signals that the study reads."""

    manifest: dict[str, Any] = {"timing": {"cpu_s": 0.0}}  # noqa: RUF012

    def __init__(self, system: System, stop: float = 1100.0, step: float = 1.0) -> None:
        self.time = np.arange(0, stop + step / 2, step)
        self.names = system.outputs()

    def __getitem__(self, name: str) -> np.ndarray:
        if name == "plant.workload":
            return 1e-3 * self.time
        rng = np.random.default_rng(list(name.encode()))
        return 1e-5 * rng.normal(size=(len(self.time), 3))


def test_measures_of_a_known_signal() -> None:
    """theta_e = 7 arcsec up to 300 s, 3 from there, 5 from 500 s on; the start itself does not count."""
    result: Any = Made(build("tf"), step=0.1)
    t = result.time
    theta = np.where(t < 300 - 1e-9, 7.0, np.where(t <= 500 + 1e-9, 3.0, 5.0)) * ARCSEC
    theta[0] = 1.0
    signals = {
        "law.sigma_RB": np.outer(np.tan(theta / 4), [0.6, 0.0, -0.8]),
        "law.z_2_B": np.outer(np.where(t < 510, 9.0, 2.0) * ARCSEC, [0.0, 1.0, 0.0]),
        "plant.torque_unmodelled_B": np.outer(np.ones_like(t), [0.0, 3e-6, 4e-6]),
        ESTIMATE: np.outer(np.ones_like(t), [0.0, 3e-6, 3e-6]),
        "plant.workload": 1e-3 * t / 1100,
        "law.omegaDot_c_B": np.zeros((len(t), 3)),
        "law.torque_raw_B": np.zeros((len(t), 3)),
    }

    class Known(Made):
        def __getitem__(self, name: str) -> np.ndarray:
            return signals[name]

    metrics = measure(Known(build("tf"), step=0.1))
    assert metrics.pointing["steady"] == pytest.approx(3, rel=1e-9)
    scanning = np.sqrt((1 * 9 + 6000 * 25) / 6001)
    assert metrics.pointing["scanning"] == pytest.approx(scanning, rel=1e-9)
    entire = np.sqrt((2999 * 49 + 2001 * 9 + 6000 * 25) / 11000)
    assert metrics.pointing["entire"] == pytest.approx(entire, rel=1e-9)
    assert metrics.worst["steady"] == pytest.approx((3, 9), rel=1e-9)
    assert metrics.worst["scanning"] == pytest.approx((5, 2), rel=1e-9)
    assert metrics.estimation == pytest.approx(1e-6, rel=1e-9)
    assert metrics.disturbance == pytest.approx(5e-6, rel=1e-9)
    assert metrics.workload == pytest.approx(1e-3)


def test_a_row_says_how_it_was_judged() -> None:
    cell = next(c for c in AT_10_HERTZ if c.text == "282.624")
    blank = {"worst": {}, "estimation": 0.0, "disturbance": 0.0, "workload": 0.0, "command_rate": 0.0, "torque": 0.0}
    pointing = {Run("bs", "wheel"): 234.41, Run("bs", "nominal"): 1.0}
    metrics = {which: Metrics(pointing={"scanning": value}, **blank) for which, value in pointing.items()}
    row = judged(cell, metrics)
    assert row.verdict == "wrong in print"
    assert row.printed == 282.624
    assert row.measure == pytest.approx(234.41)
    assert row.error == pytest.approx(234.41 / 282.624 - 1)
    assert "entire trajectory" in row.note


# --- the whole, on made-up runs ---------------------------------------------------------------------------------------


def test_the_study_has_two_claims_for_each_cell_and_all_figures() -> None:
    labels: list[str] = []

    def simulate(system: System, **_: Any) -> Any:
        return Made(system)

    outcome, runs = study.run(CHOICES, lambda done, text: labels.append(text), simulate)
    tables = [row for row in outcome.claims if row.where.startswith("Table")]
    assert Counter(row.settings for row in tables) == {AS_MADE.name: 359, AS_PRINTED.name: 359}
    claims = [row for row in outcome.claims if row.where.startswith("Sec")]
    assert len(claims) == 4 + 3 * 17
    titles = " ".join(panel.title for panel in outcome.panels)
    for figure in ("9.3a", "9.4:", "9.5:", "9.6:", "9.7:", "9.8a", "9.8b", "9.9a", "9.10b", "9.11b", "E.1a", "E.9:"):
        assert f"Fig. {figure}" in titles
    for figure in (f"E.{i}" for i in range(1, 11)):
        assert f"Fig. {figure}" in titles
    assert all(isinstance(panel, Panel) for panel in outcome.panels)
    assert next(t.title for t in outcome.tables) == "Table 9.6: pointing error, nominal"
    assert len(runs) == 3 * 20 + 2 * 30 + 4 + len(DEPARTURES) - 1, "BS without the exceptions is that of CORRECTED"


def test_requirements_are_marked_in_the_figures() -> None:
    system = build("ii", "mirror")
    result: Any = Made(system)
    panels = {panel.title: panel for panel in views.figures(result)}
    assert [guide.value for guide in panels["Pointing error"].guides] == [30.0]
    assert [guide.value for guide in panels["Norm of the rate error"].guides] == [1.0]
    assert "Workload" in [number.label for number in views.key_numbers(result)]


def test_euler_angles_are_those_of_the_order_3_2_1() -> None:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("ZYX", [[10, 20, 30], [-40, 5, 60]], degrees=True)
    np.testing.assert_allclose(views.euler_321(turn.as_mrp()), [[30, 20, 10], [60, 5, -40]], atol=1e-10)


def test_twenty_systems_and_the_study_go_by_name() -> None:
    names = [name for name in SYSTEMS if name.startswith("trigo-")]
    assert len(names) == 20
    assert {"trigo-bs", "trigo-ii-mirror", "trigo-neso-wheel", "trigo-tf-mismatch"} <= set(names)
    assert STUDIES["trigo"].choices is Choices
    for name in names:
        assert SYSTEMS[name].stop_time == 1100.0
        assert SYSTEMS[name].step == 0.1

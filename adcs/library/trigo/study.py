"""The study of chapter 9 as a whole."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf, isfinite
from typing import Any

from adcs.library.outcome import Outcome, Progress, Row, Runner, Verdict, claims_table, verdict
from adcs.library.trigo.catalogue import SCENARIOS, Scenario
from adcs.library.trigo.conclusions import judged
from adcs.library.trigo.departures import DEPARTURES, departures
from adcs.library.trigo.metrics import Metrics, measure
from adcs.library.trigo.printed import TABLES, Cell, Run, cells
from adcs.library.trigo.settings import (
    AS_MADE,
    AS_PRINTED,
    ATTITUDE_REQUIREMENT,
    CONTROLLERS,
    CORRECTED,
    RATE_REQUIREMENT,
    RATES,
    Choices,
    Reading,
)
from adcs.library.trigo.systems import build, exchange_step, recorded, stride
from adcs.library.trigo.views import GROUPS, reference_panels, scenario_panels, worst_requirement
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result, RunFailed
from orchestration.running.run import run as run_system
from orchestration.running.save import Save

TITLE = "Five backstepping attitude controllers of a micro-satellite"
SUMMARY = (
    "A micro-satellite in low orbit slews and scans under five backstepping laws, in four scenarios: undisturbed, with "
    "a wrong inertia, with a saturated reaction wheel, and with a moving mirror. Every cell of Tables 9.6 to 9.19 is "
    "set beside what these components compute in the reading with which the tables come out, and in the literal "
    "reading of the text. A third reading has the physics right."
)
RATE_SCENARIOS: tuple[Scenario, ...] = ("wheel", "mirror")
RATE_GROUP = "Other control rates"
DIVERGING = tuple((c, s) for s in RATE_SCENARIOS for c in ("neso", "ii"))


def run(
    choices: Choices, progress: Progress, simulate: Callable[..., Result] = run_system
) -> tuple[Outcome, list[tuple[str, Mapping[str, Any]]]]:
    """Run everything; returns the outcome, and label and manifest of each run."""
    rates = RATES if choices.other_rates else ()
    slow = len(DIVERGING) if rates else 0
    others = len(RATE_SCENARIOS) * len(CONTROLLERS) * len(rates)
    total = 3 * len(SCENARIOS) * len(CONTROLLERS) + 2 * others + slow + 2 * len(DEPARTURES)
    runner = Runner(progress, total, simulate)

    shown: list[Any] = []
    metrics = {AS_MADE: _all(runner, AS_MADE, rates, choices, shown)}
    metrics[AS_PRINTED] = _all(runner, AS_PRINTED, rates, choices)
    metrics[CORRECTED] = _all(runner, CORRECTED, (), choices)

    rows, tables = [], []
    for group, those in _grouped(cells(tuple(rates))):
        made = [_row(cell, AS_MADE, metrics[AS_MADE], choices) for cell in those]
        literal = [_row(cell, AS_PRINTED, metrics[AS_PRINTED], choices) for cell in those]
        rows += [row for pair in zip(made, literal, strict=True) for row in pair]
        names = dict.fromkeys(cell.table for cell in those)
        tables += [_table(name, group, those, made, literal, metrics[CORRECTED]) for name in names]
    if rates:
        slow_rows = [_divergence(runner, choices, *which) for which in DIVERGING]
        rows += slow_rows
        tables.append(claims_table(slow_rows, "At 5 Hz with the gains of 10 Hz", RATE_GROUP))
    for reading in metrics:
        claims = judged(metrics[reading], reading)
        rows += claims
        tables.append(claims_table(claims, f"What the text concludes, {reading.name}", "Conclusions"))
    tables.append(_requirements(metrics))
    tables.append(departures(runner, choices))
    return Outcome(rows, shown, tables, _key_numbers(rows)), runner.runs


def _all(
    run: Runner, reading: Reading, rates: tuple[float, ...], choices: Choices, panels: list[Any] | None = None
) -> dict[Run, Metrics]:
    """All runs of a reading; with `panels` given, its figures are added there."""
    found = {}
    for scenario in SCENARIOS:
        results = {}
        for controller in CONTROLLERS:
            which = Run(controller, scenario)
            results[controller] = _simulate(run, which, reading, choices, figures=panels is not None)
            found[which] = measure(
                results[controller], stride(exchange_step(scenario, reading, which.rate), which.rate)
            )
        if panels is not None:
            if scenario == "nominal":
                panels += reference_panels(results["bs"])
            panels += scenario_panels(scenario, results)
    for rate in rates:
        for scenario in RATE_SCENARIOS:
            for controller in CONTROLLERS:
                which = Run(controller, scenario, rate)
                result = _simulate(run, which, reading, choices)
                found[which] = measure(result, stride(exchange_step(scenario, reading, rate), rate))
    return found


def _simulate(run: Runner, which: Run, reading: Reading, choices: Choices, figures: bool = False) -> Result:
    system = build(which.controller, which.scenario, reading, which.rate)
    label = f"{CONTROLLERS[which.controller]}, {which.scenario}, {which.rate:g} Hz, {reading.name}"
    step = exchange_step(which.scenario, reading, which.rate)
    return run(label, system, stop_time=choices.stop_time, step=step, save=Save(recorded(system, figures)))


def _grouped(all_cells: list[Cell]) -> list[tuple[str, list[Cell]]]:
    groups: dict[str, list[Cell]] = {}
    for cell in all_cells:
        late = float(cell.table.removeprefix("Table 9.")) >= 17
        groups.setdefault(RATE_GROUP if late else GROUPS[cell.run.scenario], []).append(cell)
    return list(groups.items())


def _row(cell: Cell, reading: Reading, metrics: Mapping[Run, Metrics], choices: Choices) -> Row:
    ours = cell.of(metrics)

    def agrees(printed: float) -> bool:
        return abs(ours - printed) <= max(choices.agreement * abs(printed), cell.half_digit)

    result: Verdict = verdict(agrees(cell.printed))
    note = f"within {100 * choices.agreement:g} % or half the last digit"
    if cell.meant is not None:
        note = f"{cell.why}: {cell.meant:.6g} is meant"
        result = "wrong in print" if agrees(cell.meant) else "not reproduced"
    error = (ours - cell.printed) / cell.printed if isfinite(ours) else inf
    return Row("trigo", cell.table, cell.label, reading.name, cell.printed, ours, error, result, note)


def _table(
    name: str, group: str, those: list[Cell], made: list[Row], literal: list[Row], corrected: Mapping[Run, Metrics]
) -> Table:
    lines: list[list[object]] = []
    for cell, first, second in zip(those, made, literal, strict=True):
        if cell.table != name:
            continue
        line: list[object] = [cell.label, cell.text, cell.rounded(first.ours), _percent(first), first.verdict]
        line += [cell.rounded(second.ours), _percent(second)]
        if group != RATE_GROUP:
            line.append(cell.rounded(cell.of(corrected)))
        lines.append(line)
    columns = ["cell", "printed", "as made", "error", "verdict", "as printed", "error "]
    if group != RATE_GROUP:
        columns.append("corrected")
    beside = "the literal reading stands" if group == RATE_GROUP else "the literal reading and the corrected one stand"
    note = f"The verdict is on the reading of the tables; {beside} beside it."
    return Table(f"{name}: {TABLES[name]}", columns, lines, note, group)


def _percent(row: Row) -> str:
    error = row.relative_error
    if error is None or not isfinite(error):
        return "diverged"
    return f"{100 * error:+.2f} %" if abs(error) < 1 else f"{100 * error:+.0f} %"


def _divergence(run: Runner, choices: Choices, controller: str, scenario: Scenario) -> Row:
    """One of the runs at 5 Hz that the text says diverge without reduced gains."""
    system = build(controller, scenario, AS_MADE, 5.0, reduced_gains=False)  # type: ignore[arg-type]
    label = f"{CONTROLLERS[controller]}, {scenario}, 5 Hz, gains of 10 Hz"  # type: ignore[index]
    try:
        result = run(label, system, stop_time=choices.stop_time, step=0.2, save=Save(recorded(system)))
        worst = measure(result).worst["scanning"][0]
        ours, holds = f"pointing error up to {worst / 3600:.3g} deg while scanning", worst > 3600
    except RunFailed as failed:
        ours, holds = f"stopped at {failed.result.time[-1]:g} s: values beyond the range of numbers", True
    return Row(
        "trigo",
        "Sec. 9.3.5",
        f"{CONTROLLERS[controller]}, {scenario}, 5 Hz with the gains of 10 Hz",  # type: ignore[index]
        AS_MADE.name,
        "diverges",
        ours,
        None,
        verdict(holds),
        "diverged: a pointing error above 1 deg while scanning, or values without end",
    )


def _requirements(metrics: Mapping[Reading, Mapping[Run, Metrics]]) -> Table:
    columns = ["scenario", "controller", *(reading.name for reading in metrics)]
    lines: list[list[object]] = []
    for scenario in SCENARIOS:
        for controller, name in CONTROLLERS.items():
            line: list[object] = [GROUPS[scenario], name]
            for runs in metrics.values():
                worst = runs[Run(controller, scenario)].worst.values()
                theta, omega = (max(values) for values in zip(*worst, strict=True))
                line.append(f"{theta:.3g} arcsec, {omega:.3g} arcsec/s: {worst_requirement(theta, omega)}")
            lines.append(line)
    note = (
        "Largest errors from 20 s after the beginning of each stretch; required are "
        f"{ATTITUDE_REQUIREMENT:g} arcsec and {RATE_REQUIREMENT:g} arcsec/s (9.11)."
    )
    return Table("Requirements", columns, lines, note, "Conclusions")


def _key_numbers(rows: list[Row]) -> list[KeyNumber]:
    numbers = []
    for reading in (AS_MADE, AS_PRINTED):
        those = [row for row in rows if row.settings == reading.name and row.table.startswith("Table")]
        held = sum(row.verdict == "reproduced" for row in those)
        wrong = sum(row.verdict == "wrong in print" for row in those)
        more = f", and {wrong} are wrong in print" if wrong else ""
        numbers.append(KeyNumber(f"Cells reproduced, {reading.name}", f"{held} of {len(those)}", "", more.strip(", ")))
    return numbers

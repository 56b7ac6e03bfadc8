"""The study of chapter 9 as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite
from typing import Any

from adcs.library.outcome import Claim, Shown, claims_table, tally
from adcs.library.sections import Section, failed_at, study_of
from adcs.library.trigo.catalogue import SCENARIOS
from adcs.library.trigo.conclusions import judged
from adcs.library.trigo.departures import departures
from adcs.library.trigo.loops import FIGURES, RATE_SCENARIOS, Plan, of_reading, plan, simulation, with_figures
from adcs.library.trigo.metrics import Metrics, measure
from adcs.library.trigo.printed import TABLES, Cell, Run, cells
from adcs.library.trigo.settings import (
    AS_MADE,
    AS_PRINTED,
    CONTROLLERS,
    CORRECTED,
    RATES,
    READINGS,
    Choices,
    Reading,
)
from adcs.library.trigo.views import GROUPS, reference_panels, scenario_panels
from orchestration.results.plots import Panel
from orchestration.results.report import KeyNumber, Table
from orchestration.results.result import Result

TITLE = "Five backstepping attitude controllers of a micro-satellite"
SUMMARY = (
    "A micro-satellite in low orbit slews and scans under five backstepping laws, in four scenarios: undisturbed, with "
    "a wrong inertia, with a saturated reaction wheel, and with a moving mirror. Every cell of Tables 9.6 to 9.19 is "
    "set beside what these components compute in the reading with which the tables come out, and in the literal "
    "reading of the text. A third reading has the physics right."
)
RATE_GROUP = "Other control rates"
DIVERGING = tuple(Run(c, s, 5.0) for s in RATE_SCENARIOS for c in ("neso", "ii"))


def sections(choices: Choices) -> list[Section]:
    """The tables, what the text concludes, and where the reading of the tables departs from it."""
    rates = RATES if choices.other_rates else ()
    runs = with_figures(plan(AS_MADE, rates, choices)) | plan(AS_PRINTED, rates, choices) | plan(CORRECTED, (), choices)
    made = [_tables(runs, rates, choices), _conclusions(runs), departures(choices)]
    if rates:
        made.insert(1, _diverging(choices))
    return made


run = study_of(sections)


def _tables(runs: Plan, rates: Sequence[float], choices: Choices) -> Section:
    """Tables 9.6 to 9.19, and the figures."""

    def show(found: Mapping[Any, Any]) -> Iterator[Shown]:
        metrics = {name: of_reading(found, reading) for name, reading in READINGS.items()}
        claims = []
        for table in TABLES:
            those = [cell for cell in cells(rates) if cell.table == table]
            made, literal = (
                [_claim(c, reading, metrics[reading.name], choices) for c in those] for reading in (AS_MADE, AS_PRINTED)
            )
            claims += [claim for pair in zip(made, literal, strict=True) for claim in pair]
            if those:
                yield _table(table, those, made, literal, metrics[CORRECTED.name])
        yield from claims
        yield from _panels(found)
        yield from _key_numbers(claims)

    return Section("", "", show, runs, counted=AS_MADE.name)


def _panels(found: Mapping[Any, Any]) -> list[Panel]:
    panels = reference_panels(found[FIGURES, Run("bs", "nominal")])
    for scenario in SCENARIOS:
        panels += scenario_panels(scenario, {c: found[FIGURES, Run(c, scenario)] for c in CONTROLLERS})
    return panels


def _claim(cell: Cell, reading: Reading, metrics: Mapping[Run, Metrics], choices: Choices) -> Claim:
    ours, name = cell.of(metrics), reading.name

    def agrees(printed: float) -> bool:
        return abs(ours - printed) <= max(choices.agreement * abs(printed), cell.half_digit)

    holds: bool | None = agrees(cell.printed)
    note = f"within {100 * choices.agreement:g} % or half the last digit"
    if cell.meant is not None:
        holds, note = None if agrees(cell.meant) else False, f"{cell.why}: {cell.meant:.6g} is meant"
    error = (ours - cell.printed) / cell.printed if isfinite(ours) else inf
    return Claim(cell.table, cell.label, name, cell.printed, ours, holds, note, error, name)


def _table(
    name: str, those: list[Cell], made: list[Claim], literal: list[Claim], corrected: Mapping[Run, Metrics]
) -> Table:
    at_rates = all(cell.run.rate not in {run.rate for run in corrected} for cell in those)
    lines: list[list[object]] = []
    for cell, first, second in zip(those, made, literal, strict=True):
        line: list[object] = [cell.label, cell.text, cell.rounded(first.measure), _percent(first), first.verdict]
        line += [cell.rounded(second.measure), _percent(second)]
        lines.append(line if at_rates else [*line, cell.rounded(cell.of(corrected))])
    columns = ["cell", "printed", "as made", "error", "verdict", "as printed", "error "]
    beside = "the literal reading stands" if at_rates else "the literal reading and the corrected one stand"
    note = f"The verdict is on the reading of the tables; {beside} beside it."
    group = RATE_GROUP if at_rates else GROUPS[those[0].run.scenario]
    return Table(f"{name}: {TABLES[name]}", columns if at_rates else [*columns, "corrected"], lines, note, group)


def _percent(claim: Claim) -> str:
    error = claim.error
    if error is None or not isfinite(error):
        return "diverged"
    return f"{100 * error:+.2f} %" if abs(error) < 1 else f"{100 * error:+.0f} %"


def _diverging(choices: Choices) -> Section:
    """The runs at 5 Hz that the text says diverge without reduced gains."""
    runs = {run: simulation(run, AS_MADE, choices, reduced_gains=False) for run in DIVERGING}
    runs = {
        run: replace(one, label=f"{one.label}, gains of 10 Hz", view=_end, may_fail=True) for run, one in runs.items()
    }

    def show(found: Mapping[Run, tuple[str, bool]]) -> Iterator[Shown]:
        for run, (ours, holds) in found.items():
            yield Claim("Sec. 9.3.5", f"{CONTROLLERS[run.controller]}, {run.scenario}, 5 Hz with the gains of 10 Hz",
                        AS_MADE.name,
                        "diverges", ours, holds,
                        "diverged: a pointing error above 1 deg while scanning, or values without end",
                        reading=AS_MADE.name)  # fmt: skip

    return Section(RATE_GROUP, "At 5 Hz with the gains of 10 Hz", show, runs)


def _end(result: Result) -> tuple[str, bool]:
    """How such a run ends, and whether that is a divergence."""
    if failed_at(result) is not None:
        return f"stopped at {result.time[-1]:g} s: values beyond the range of numbers", True
    worst = measure(result).worst["scanning"][0]
    return f"pointing error up to {worst / 3600:.3g} deg while scanning", worst > 3600


def _conclusions(runs: Plan) -> Section:
    def show(found: Mapping[Any, Any]) -> Iterator[Shown]:
        for name, reading in READINGS.items():
            claims = list(judged(of_reading(found, reading), reading))
            yield from claims
            yield claims_table(claims, f"What the text concludes, {name}")

    return Section("Conclusions", "", show, runs)


def _key_numbers(claims: list[Claim]) -> list[KeyNumber]:
    numbers = []
    for reading in (AS_MADE, AS_PRINTED):
        counts = tally(claim for claim in claims if claim.reading == reading.name)
        label, cells_ = f"Cells reproduced, {reading.name}", f"{counts.get('reproduced', 0)} of {sum(counts.values())}"
        wrong = counts.get("wrong in print", 0)
        numbers.append(KeyNumber(label, cells_, "", f"and {wrong} are wrong in print" if wrong else ""))
    return numbers

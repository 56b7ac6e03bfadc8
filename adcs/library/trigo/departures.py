"""Where the reading that makes the tables departs from the text, and what each departure alone is worth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from adcs.library.outcome import Shown
from adcs.library.sections import Section, Simulation
from adcs.library.trigo.loops import simulation
from adcs.library.trigo.metrics import Metrics
from adcs.library.trigo.printed import Measure, Run, cells
from adcs.library.trigo.settings import AS_MADE, AS_PRINTED, Choices, Reading
from orchestration.results.report import Table

FITTED, CHOSEN = "fitted", "chosen"


class Departure(NamedTuple):
    """`field` of the reading; `kind` says how it was found; the cell of `run` and `measure` shows what it is worth."""

    field: str
    text: str
    made: str
    kind: str
    run: Run
    measure: Measure


DEPARTURES = (
    Departure("slew_start", "no start time", "20.62 s", FITTED, Run("bs", "nominal"), "entire"),
    Departure("acceleration_limit", "0.15 deg/s² for x_2,c", "0.10 deg/s²", FITTED, Run("bs", "nominal"), "entire"),
    Departure("lag", "no lag", "the reference is that of one period ago", CHOSEN, Run("ii", "nominal"), "scanning"),
    Departure("rate_by_difference", "nothing on the reference rate", "backward difference", CHOSEN,
              Run("bs", "nominal"), "scanning"),
    Departure("exceptions", "n = 1.073e-3 rad/s", "1.070e-3 in this run", CHOSEN, Run("bs", "nominal"), "entire"),
    Departure("mirror_size", "l, w, h = 5, 50, 50 mm", "50, 50, 5 mm in (4.26)", CHOSEN, Run("bs", "mirror"), "steady"),
    Departure("disturbance_held", "a continuous torque", "computed once per control step and held", CHOSEN,
              Run("ii", "mirror"), "estimation"),
    Departure("neso_inertia_twice", "β_2 = B J_0", "β_2 = B J_0 J_0", CHOSEN, Run("neso", "wheel"), "estimation"),
    Departure("neso_torque_delay", "the torque T_c", "that of the step before", CHOSEN, Run("neso", "wheel"),
              "estimation"),
    Departure("update_first", "nothing on the order", "TF and I&I update, then use", CHOSEN, Run("ii", "mirror"),
              "entire"),
)  # fmt: skip


def undone(departure: Departure) -> Reading:
    """The reading of the tables with this one departure taken back."""
    changed = {departure.field: getattr(AS_PRINTED, departure.field)}
    return replace(AS_MADE, name=f"without: {departure.made}", **changed)


def departures(choices: Choices) -> Section:
    """The tables' reading with each departure taken back, and what its cell becomes."""
    known = {(cell.run, cell.measure): cell for cell in cells(()) if cell.over is None}
    runs: dict[Run | Departure, Simulation] = {}
    for departure in DEPARTURES:
        runs[departure.run] = simulation(departure.run, AS_MADE, choices)
        runs[departure] = simulation(departure.run, undone(departure), choices)

    def show(found: Mapping[Run | Departure, Metrics]) -> Iterator[Shown]:
        rows: list[list[object]] = []
        for departure in DEPARTURES:
            cell = known[departure.run, departure.measure]
            values = [cell.rounded(cell.of({departure.run: found[of]})) for of in (departure.run, departure)]
            where = f"{cell.table}, {cell.label}"
            rows.append([departure.text, departure.made, departure.kind, where, cell.text, *values])
        columns = ["the text", "as the tables were made", "how found", "cell", "printed", "as made"]
        note = (
            "Each line is the reading of the tables with only this departure taken back. Fitted: a number chosen to "
            "meet several cells. Chosen: one of a few possible readings, picked because its cells agree."
        )
        yield Table("Departures from the text, one by one", [*columns, "this one as in the text"], rows, note)

    return Section("Readings", "", show, runs)

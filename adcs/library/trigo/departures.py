"""Where the reading that makes the tables departs from the text, and what each departure alone is worth."""

from __future__ import annotations

from dataclasses import dataclass, replace

from adcs.library.outcome import Runner
from adcs.library.trigo.metrics import measure
from adcs.library.trigo.printed import Cell, Run, cells
from adcs.library.trigo.settings import AS_MADE, AS_PRINTED, Choices, Reading
from adcs.library.trigo.systems import build, exchange_step, recorded, stride
from orchestration.results.report import Table
from orchestration.running.save import Save

TABLE_TITLE = "Departures from the text, one by one"


@dataclass(frozen=True)
class Departure:
    """`field` of the reading; `kind` says how it was found; the cell of `run` and `measure` shows what it is worth."""

    field: str
    text: str
    made: str
    kind: str
    run: Run
    measure: str


DEPARTURES = (
    Departure("slew_start", "no start time", "20.62 s", "fitted", Run("bs", "nominal"), "entire"),
    Departure("acceleration_limit", "0.15 deg/s² for x_2,c", "0.10 deg/s²", "fitted", Run("bs", "nominal"), "entire"),
    Departure("lag", "no lag", "the reference is that of one period ago", "chosen", Run("ii", "nominal"), "scanning"),
    Departure(
        "rate_by_difference",
        "nothing on the reference rate",
        "backward difference",
        "chosen",
        Run("bs", "nominal"),
        "scanning",
    ),
    Departure("exceptions", "n = 1.073e-3 rad/s", "1.070e-3 in this run", "chosen", Run("bs", "nominal"), "entire"),
    Departure(
        "mirror_size", "l, w, h = 5, 50, 50 mm", "50, 50, 5 mm in (4.26)", "chosen", Run("bs", "mirror"), "steady"
    ),
    Departure(
        "disturbance_held",
        "a continuous torque",
        "computed once per control step and held",
        "chosen",
        Run("ii", "mirror"),
        "estimation",
    ),
    Departure("neso_inertia_twice", "β_2 = B J_0", "β_2 = B J_0 J_0", "chosen", Run("neso", "wheel"), "estimation"),
    Departure(
        "neso_torque_delay",
        "the torque T_c",
        "that of the step before",
        "chosen",
        Run("neso", "wheel"),
        "estimation",
    ),
    Departure(
        "update_first",
        "nothing on the order",
        "TF and I&I update, then use",
        "chosen",
        Run("ii", "mirror"),
        "entire",
    ),
)


def undone(departure: Departure) -> Reading:
    """The reading of the tables with this one departure taken back."""
    return replace(AS_MADE, name=AS_MADE.name, **{departure.field: getattr(AS_PRINTED, departure.field)})


def departures(run: Runner, choices: Choices) -> Table:
    """Run the tables' reading with each departure taken back, and show what its cell becomes."""
    known = {(c.run, c.measure): c for c in cells(()) if c.over is None}
    rows: list[list[object]] = []
    for departure in DEPARTURES:
        cell: Cell = known[departure.run, departure.measure]  # type: ignore[index]
        values = []
        for reading in (AS_MADE, undone(departure)):
            controller, scenario, rate = departure.run.controller, departure.run.scenario, departure.run.rate
            system = build(controller, scenario, reading, rate)
            step = exchange_step(scenario, reading, rate)
            result = run(
                f"without: {departure.made}",
                system,
                stop_time=choices.stop_time,
                step=step,
                save=Save(recorded(system)),
            )
            values.append(cell.rounded(cell.of({departure.run: measure(result, stride(step, rate))})))
        rows.append([departure.text, departure.made, departure.kind, f"{cell.table}, {cell.label}", cell.text, *values])
    columns = [
        "the text",
        "as the tables were made",
        "how found",
        "cell",
        "printed",
        "as made",
        "this one as in the text",
    ]
    note = (
        "Each line is the reading of the tables with only this departure taken back. Fitted: a number chosen to meet "
        "several cells. Chosen: one of a few possible readings, picked because its cells agree."
    )
    return Table(TABLE_TITLE, columns, rows, note, "Readings")

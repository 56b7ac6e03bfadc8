"""The runs of the study: every controller in every scenario, at a rate, in a reading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from adcs.library.exchange import whole
from adcs.library.sections import Simulation
from adcs.library.trigo.catalogue import SCENARIOS, Scenario
from adcs.library.trigo.metrics import Metrics, measure
from adcs.library.trigo.printed import Run
from adcs.library.trigo.settings import CONTROL_RATE, CONTROLLERS, Choices, Reading
from adcs.library.trigo.systems import build, exchange_step, recorded, stride

RATE_SCENARIOS: tuple[Scenario, ...] = ("wheel", "mirror")

Plan = dict[Any, Simulation]
"""By reading and `Run`; those whose figures are shown by `FIGURES` and `Run`, too."""
FIGURES = "figures"


def simulation(run: Run, reading: Reading, choices: Choices, reduced_gains: bool | None = None) -> Simulation:
    """One of them, with a row at each control instant, of which the measures are taken."""
    system = build(run.controller, run.scenario, reading, run.rate, reduced_gains)
    step = exchange_step(run.scenario, reading, run.rate)
    label = f"{CONTROLLERS[run.controller]}, {run.scenario}, {run.rate:g} Hz, {reading.name}"
    every = stride(step, run.rate)
    return Simulation(label, system, measure, choices.stop_time, step, every=every, record=recorded(system))


def plan(reading: Reading, rates: Sequence[float], choices: Choices) -> Plan:
    """All controllers in all scenarios at 10 Hz, and in two of them at other rates [Hz]."""
    runs = [Run(controller, scenario) for scenario in SCENARIOS for controller in CONTROLLERS]
    runs += [Run(c, scenario, rate) for rate in rates for scenario in RATE_SCENARIOS for c in CONTROLLERS]
    return {(reading.name, run): simulation(run, reading, choices) for run in runs}


def with_figures(runs: Plan) -> Plan:
    """The same, and the whole results of those at 10 Hz beside them."""
    shown = {(FIGURES, run): replace(one, view=whole) for (_, run), one in runs.items() if run.rate == CONTROL_RATE}
    return runs | shown


def of_reading(found: Mapping[Any, Any], reading: Reading) -> dict[Run, Metrics]:
    """The measures of the runs of a reading."""
    return {run: metrics for (name, run), metrics in found.items() if name == reading.name}

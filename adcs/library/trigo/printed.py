"""Tables 9.6 to 9.19 as printed, and what each of their cells is a measure of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from adcs.library.trigo.catalogue import SCENARIOS, Controller, Scenario
from adcs.library.trigo.metrics import Metrics
from adcs.library.trigo.settings import ADAPTIVE, CONTROL_RATE, CONTROLLERS

Measure = Literal["entire", "steady", "scanning", "estimation", "relative estimation", "workload"]
POINTING: tuple[Measure, ...] = ("entire", "steady", "scanning")
UNITS: dict[Measure, str] = {
    "entire": "arcsec",
    "steady": "arcsec",
    "scanning": "arcsec",
    "estimation": "µN·m",
    "relative estimation": "1",
    "workload": "mJ",
}
LABELS: dict[Measure, str] = {
    "entire": "pointing error RMS, entire",
    "steady": "pointing error RMS, steady",
    "scanning": "pointing error RMS, scanning",
    "estimation": "estimation error RMS",
    "relative estimation": "estimation error / disturbance",
    "workload": "workload",
}

TABLES = {
    "Table 9.6": "pointing error, nominal",
    "Table 9.7": "workload, nominal",
    "Table 9.8": "pointing error, inertial mismatch",
    "Table 9.9": "estimation error, inertial mismatch",
    "Table 9.10": "workload, inertial mismatch",
    "Table 9.11": "pointing error, saturated wheel",
    "Table 9.12": "estimation error, saturated wheel",
    "Table 9.13": "workload, saturated wheel",
    "Table 9.14": "pointing error, moving payload",
    "Table 9.15": "estimation error, moving payload",
    "Table 9.16": "workload, moving payload",
    "Table 9.17": "pointing error at other control rates, saturated wheel",
    "Table 9.18": "pointing error at other control rates, moving payload",
    "Table 9.19": "estimation error at other control rates",
}


@dataclass(frozen=True)
class Run:
    """Which run a cell is of; `rate` in Hz."""

    controller: Controller
    scenario: Scenario
    rate: float = CONTROL_RATE


@dataclass(frozen=True)
class Cell:
    """A printed number: `measure` of `run`, or its ratio to that of `over`. `meant` is what the print should say."""

    table: str
    text: str
    run: Run
    measure: Measure
    over: Run | None = None
    meant: float | None = None
    why: str = ""

    @property
    def printed(self) -> float:
        """The number in print."""
        return float(self.text)

    @property
    def half_digit(self) -> float:
        """Half a unit of its last digit."""
        decimals = len(self.text.partition(".")[2])
        return float(0.5 * 10.0**-decimals)

    def rounded(self, value: object) -> str:
        """A number with as many decimals as this cell has in print."""
        return f"{value:.{len(self.text.partition('.')[2])}f}"

    @property
    def label(self) -> str:
        """What it is, for people."""
        rate = f" at {self.run.rate:g} Hz" if self.run.rate != CONTROL_RATE else ""
        scenario = f", {self.run.scenario}" if self.table == "Table 9.19" else ""
        ratio = ""
        if self.over is not None:
            ratio = ", ratio to 10 Hz" if self.over.scenario == self.run.scenario else ", ratio to nominal"
        unit = "" if self.over or UNITS[self.measure] == "1" else f" [{UNITS[self.measure]}]"
        return f"{CONTROLLERS[self.run.controller]}{rate}{scenario}: {LABELS[self.measure]}{ratio}{unit}"

    def of(self, metrics: Mapping[Run, Metrics]) -> float:
        """This cell from our runs."""
        value = _value(metrics[self.run], self.measure)
        return value if self.over is None else value / _value(metrics[self.over], self.measure)


def _value(metrics: Metrics, measure: Measure) -> float:
    if measure == "estimation":
        return 1e6 * metrics.estimation
    if measure == "relative estimation":
        return metrics.estimation / metrics.disturbance
    if measure == "workload":
        return 1e3 * metrics.workload
    return metrics.pointing[measure]


_PRINTED = """
9.6  nominal  entire                     |     8.343     9.855    12.422     9.916    10.282
9.6  nominal  steady                     |     0.009     0.012     0.018     0.012     0.012
9.6  nominal  scanning                   |    10.059    12.290    15.833    12.329    12.261
9.7  nominal  workload                   |     1.511     1.511     1.512     1.511     1.511
9.8  mismatch entire                     |    23.831    18.872    12.436     9.937    10.294
9.8  mismatch entire           / nominal |     2.856     1.915     1.001     1.002     1.001
9.8  mismatch steady                     |     0.375     0.232     0.018     0.011     0.012
9.8  mismatch steady           / nominal |    43.426    19.374     0.991     0.989     0.997
9.8  mismatch scanning                   |    31.157    24.572    15.842    12.342    12.263
9.8  mismatch scanning         / nominal |     3.097     1.999     1.001     1.001     1.000
9.9  mismatch estimation                 |    13.726     1.189     0.891
9.9  mismatch relative                   |     0.336     0.029     0.022
9.10 mismatch workload                   |     1.511     1.511     1.512     1.511     1.511
9.11 wheel    entire                     |  1777.237  1094.907    15.517    11.989    10.888
9.11 wheel    entire           / nominal |   213.021   111.102     1.249     1.209     1.059
9.11 wheel    steady                     |   397.513   246.016     0.024     0.015     0.013
9.11 wheel    steady           / nominal | 45981.869 20564.724     1.284     1.288     1.082
9.11 wheel    scanning                   |  2357.932  1452.863    20.048    15.185    13.140
9.11 wheel    scanning         / nominal |   282.624   147.424     1.266     1.232     1.072
9.12 wheel    estimation                 |    46.653    32.834    13.705
9.12 wheel    relative                   |     0.010     0.007     0.003
9.13 wheel    workload                   |     1.862     1.859     1.853     1.853     1.853
9.14 mirror   entire                     |    31.395    18.566    12.612    10.239    10.323
9.14 mirror   entire           / nominal |     3.763     1.884     1.015     1.033     1.004
9.14 mirror   steady                     |    30.139    15.637     2.113     2.502     0.765
9.14 mirror   steady           / nominal |  3486.340  1307.123   114.818   216.812    61.750
9.14 mirror   scanning                   |    31.805    19.889    15.977    12.580    12.285
9.14 mirror   scanning         / nominal |     3.162     1.618     1.009     1.020     1.002
9.15 mirror   estimation                 |    26.939    23.919     8.826
9.15 mirror   relative                   |     0.172     0.152     0.056
9.16 mirror   workload                   |     1.671     1.664     1.661     1.661     1.656
9.17 wheel    entire     5 Hz            |  1778.083  1095.681    25.641    24.794    19.856
9.17 wheel    entire     5 Hz  / 10 Hz   |     1.000     1.001     1.652     2.068     1.824
9.17 wheel    entire     20 Hz           |  1776.788  1094.541    11.738     8.839     7.223
9.17 wheel    entire     20 Hz / 10 Hz   |     1.000     1.000     0.756     0.737     0.663
9.17 wheel    entire     50 Hz           |  1776.792  1094.500    10.560     7.798     5.817
9.17 wheel    entire     50 Hz / 10 Hz   |     1.000     1.000     0.681     0.650     0.534
9.17 wheel    steady     5 Hz            |   396.412   245.333     0.039     0.032     0.026
9.17 wheel    steady     5 Hz  / 10 Hz   |     0.997     0.997     1.638     2.143     2.037
9.17 wheel    steady     20 Hz           |   396.397   245.325     0.017     0.010     0.008
9.17 wheel    steady     20 Hz / 10 Hz   |     0.997     0.997     0.723     0.697     0.593
9.17 wheel    steady     50 Hz           |   397.508   246.013     0.015     0.009     0.005
9.17 wheel    steady     50 Hz / 10 Hz   |     1.000     1.000     0.629     0.577     0.375
9.17 wheel    scanning   5 Hz            |  2358.317  1453.387    33.972    32.814    26.279
9.17 wheel    scanning   5 Hz  / 10 Hz   |     1.000     1.000     1.695     2.161     2.000
9.17 wheel    scanning   20 Hz           |  2357.462  1452.454    14.628    10.390     7.467
9.17 wheel    scanning   20 Hz / 10 Hz   |     1.000     1.000     0.730     0.684     0.568
9.17 wheel    scanning   50 Hz           |  2357.492  1452.416    12.703     8.448     4.655
9.17 wheel    scanning   50 Hz / 10 Hz   |     1.000     1.000     0.634     0.556     0.354
9.18 mirror   entire     5 Hz            |    34.098    24.394    23.993    19.539    18.588
9.18 mirror   entire     5 Hz  / 10 Hz   |     1.086     1.314     1.902     1.908     1.801
9.18 mirror   entire     20 Hz           |    30.669    16.874     7.502     6.548     6.542
9.18 mirror   entire     20 Hz / 10 Hz   |     0.977     0.909     0.595     0.640     0.634
9.18 mirror   entire     50 Hz           |    30.461    16.431     5.463     5.218     5.066
9.18 mirror   entire     50 Hz / 10 Hz   |     0.970     0.885     0.433     0.510     0.491
9.18 mirror   steady     5 Hz            |    30.486    15.750     2.095     5.860     1.499
9.18 mirror   steady     5 Hz  / 10 Hz   |     1.012     1.007     0.991     2.342     1.959
9.18 mirror   steady     20 Hz           |    30.020    15.606     2.116     2.158     0.767
9.18 mirror   steady     20 Hz / 10 Hz   |     0.996     0.998     1.001     0.863     1.003
9.18 mirror   steady     50 Hz           |    29.948    15.588     2.118     1.954     0.768
9.18 mirror   steady     50 Hz / 10 Hz   |     0.994     0.997     1.002     0.781     1.004
9.18 mirror   scanning   5 Hz            |    36.544    29.252    31.738    25.360    24.568
9.18 mirror   scanning   5 Hz  / 10 Hz   |     1.149     1.471     1.986     2.016     2.000
9.18 mirror   scanning   20 Hz           |    30.490    16.798     8.198     6.531     6.180
9.18 mirror   scanning   20 Hz / 10 Hz   |     0.959     0.845     0.513     0.519     0.503
9.18 mirror   scanning   50 Hz           |    30.079    15.823     3.810     3.144     2.570
9.18 mirror   scanning   50 Hz / 10 Hz   |     0.946     0.796     0.238     0.250     0.209
9.19 wheel    relative   5 Hz            |     0.012     0.017     0.006
9.19 wheel    relative   5 Hz  / 10 Hz   |     1.146     2.333     2.033
9.19 wheel    relative   20 Hz           |     0.010     0.006     0.003
9.19 wheel    relative   20 Hz / 10 Hz   |     0.932     0.861     1.000
9.19 wheel    relative   50 Hz           |     0.009     0.006     0.003
9.19 wheel    relative   50 Hz / 10 Hz   |     0.913     0.778     1.000
9.19 mirror   relative   5 Hz            |     0.234     0.366     0.122
9.19 mirror   relative   5 Hz  / 10 Hz   |     1.364     2.398     2.160
9.19 mirror   relative   20 Hz           |     0.152     0.131     0.056
9.19 mirror   relative   20 Hz / 10 Hz   |     0.884     0.859     1.000
9.19 mirror   relative   50 Hz           |     0.146     0.118     0.056
9.19 mirror   relative   50 Hz / 10 Hz   |     0.849     0.775     1.000
"""
"""A line for each row of the tables: table, scenario, measure, rate unless 10 Hz, what it is a ratio to; then BS, RBS,
TF, NESO, I&I, or the last three of them. Estimation errors are in micronewton metres, or relative."""

_DIVIDED_WRONGLY = {"282.624": 2357.932 / 10.059, "147.424": 1452.863 / 12.290}
_BY_ENTIRE = "printed is the quotient by the nominal value of the entire trajectory"
_TEN_TIMES = "the whole table is printed ten times too small"


def cells(rates: Sequence[float]) -> list[Cell]:
    """All printed cells, those of Tables 9.17 to 9.19 at the given rates [Hz] only, in the order of the tables."""
    return [cell for cell in _read() if cell.run.rate in (CONTROL_RATE, *rates)]


def _read() -> Iterator[Cell]:
    names: Any = {"relative": "relative estimation"}
    for line in _PRINTED.strip().splitlines():
        place, _, values = line.partition("|")
        what, _, base = place.partition("/")
        table, scenario, measure, *at = what.split()
        rate, texts = float(at[0]) if at else CONTROL_RATE, values.split()
        for controller, text in zip(CONTROLLERS if len(texts) == 5 else ADAPTIVE, texts, strict=True):
            run, over = Run(controller, _scenario(scenario), rate), None
            if base:
                over = Run(controller, "nominal") if base.strip() == "nominal" else Run(controller, run.scenario)
            meant, why = _DIVIDED_WRONGLY.get(text), _BY_ENTIRE if text in _DIVIDED_WRONGLY else ""
            if table == "9.13":
                meant, why = 10 * float(text), _TEN_TIMES
            yield Cell(f"Table {table}", text, run, names.get(measure, measure), over, meant, why)


def _scenario(text: str) -> Scenario:
    return next(scenario for scenario in SCENARIOS if scenario == text)

"""Tables 9.6 to 9.19 as printed, and what each of their cells is a measure of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from adcs.library.trigo.catalogue import Controller, Scenario
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


# Rows of controllers BS, RBS, TF, NESO, I&I.
_POINTING: dict[str, tuple[Scenario, dict[Measure, str]]] = {
    "9.6": (
        "nominal",
        {
            "entire": "8.343 9.855 12.422 9.916 10.282",
            "steady": "0.009 0.012 0.018 0.012 0.012",
            "scanning": "10.059 12.290 15.833 12.329 12.261",
        },
    ),
    "9.8": (
        "mismatch",
        {
            "entire": "23.831 18.872 12.436 9.937 10.294",
            "steady": "0.375 0.232 0.018 0.011 0.012",
            "scanning": "31.157 24.572 15.842 12.342 12.263",
        },
    ),
    "9.11": (
        "wheel",
        {
            "entire": "1777.237 1094.907 15.517 11.989 10.888",
            "steady": "397.513 246.016 0.024 0.015 0.013",
            "scanning": "2357.932 1452.863 20.048 15.185 13.140",
        },
    ),
    "9.14": (
        "mirror",
        {
            "entire": "31.395 18.566 12.612 10.239 10.323",
            "steady": "30.139 15.637 2.113 2.502 0.765",
            "scanning": "31.805 19.889 15.977 12.580 12.285",
        },
    ),
}
_TO_NOMINAL: dict[str, dict[Measure, str]] = {
    "9.8": {
        "entire": "2.856 1.915 1.001 1.002 1.001",
        "steady": "43.426 19.374 0.991 0.989 0.997",
        "scanning": "3.097 1.999 1.001 1.001 1.000",
    },
    "9.11": {
        "entire": "213.021 111.102 1.249 1.209 1.059",
        "steady": "45981.869 20564.724 1.284 1.288 1.082",
        "scanning": "282.624 147.424 1.266 1.232 1.072",
    },
    "9.14": {
        "entire": "3.763 1.884 1.015 1.033 1.004",
        "steady": "3486.340 1307.123 114.818 216.812 61.750",
        "scanning": "3.162 1.618 1.009 1.020 1.002",
    },
}
_DIVIDED_WRONGLY = {"282.624": 2357.932 / 10.059, "147.424": 1452.863 / 12.290}
_WORK: dict[str, tuple[Scenario, str]] = {
    "9.7": ("nominal", "1.511 1.511 1.512 1.511 1.511"),
    "9.10": ("mismatch", "1.511 1.511 1.512 1.511 1.511"),
    "9.13": ("wheel", "1.862 1.859 1.853 1.853 1.853"),
    "9.16": ("mirror", "1.671 1.664 1.661 1.661 1.656"),
}
# Rows of TF, NESO, I&I: error in micronewton metres, and its ratio to the disturbance.
_ESTIMATION: dict[str, tuple[Scenario, str, str]] = {
    "9.9": ("mismatch", "13.726 1.189 0.891", "0.336 0.029 0.022"),
    "9.12": ("wheel", "46.653 32.834 13.705", "0.010 0.007 0.003"),
    "9.15": ("mirror", "26.939 23.919 8.826", "0.172 0.152 0.056"),
}
# Rows of five controllers at a rate, and the ratios to 10 Hz printed below them.
_RATES: dict[str, tuple[Scenario, dict[Measure, dict[float, tuple[str, str]]]]] = {
    "9.17": (
        "wheel",
        {
            "entire": {
                5: ("1778.083 1095.681 25.641 24.794 19.856", "1.000 1.001 1.652 2.068 1.824"),
                20: ("1776.788 1094.541 11.738 8.839 7.223", "1.000 1.000 0.756 0.737 0.663"),
                50: ("1776.792 1094.500 10.560 7.798 5.817", "1.000 1.000 0.681 0.650 0.534"),
            },
            "steady": {
                5: ("396.412 245.333 0.039 0.032 0.026", "0.997 0.997 1.638 2.143 2.037"),
                20: ("396.397 245.325 0.017 0.010 0.008", "0.997 0.997 0.723 0.697 0.593"),
                50: ("397.508 246.013 0.015 0.009 0.005", "1.000 1.000 0.629 0.577 0.375"),
            },
            "scanning": {
                5: ("2358.317 1453.387 33.972 32.814 26.279", "1.000 1.000 1.695 2.161 2.000"),
                20: ("2357.462 1452.454 14.628 10.390 7.467", "1.000 1.000 0.730 0.684 0.568"),
                50: ("2357.492 1452.416 12.703 8.448 4.655", "1.000 1.000 0.634 0.556 0.354"),
            },
        },
    ),
    "9.18": (
        "mirror",
        {
            "entire": {
                5: ("34.098 24.394 23.993 19.539 18.588", "1.086 1.314 1.902 1.908 1.801"),
                20: ("30.669 16.874 7.502 6.548 6.542", "0.977 0.909 0.595 0.640 0.634"),
                50: ("30.461 16.431 5.463 5.218 5.066", "0.970 0.885 0.433 0.510 0.491"),
            },
            "steady": {
                5: ("30.486 15.750 2.095 5.860 1.499", "1.012 1.007 0.991 2.342 1.959"),
                20: ("30.020 15.606 2.116 2.158 0.767", "0.996 0.998 1.001 0.863 1.003"),
                50: ("29.948 15.588 2.118 1.954 0.768", "0.994 0.997 1.002 0.781 1.004"),
            },
            "scanning": {
                5: ("36.544 29.252 31.738 25.360 24.568", "1.149 1.471 1.986 2.016 2.000"),
                20: ("30.490 16.798 8.198 6.531 6.180", "0.959 0.845 0.513 0.519 0.503"),
                50: ("30.079 15.823 3.810 3.144 2.570", "0.946 0.796 0.238 0.250 0.209"),
            },
        },
    ),
}
_ESTIMATION_RATES: dict[Scenario, dict[float, tuple[str, str]]] = {
    "wheel": {
        5: ("0.012 0.017 0.006", "1.146 2.333 2.033"),
        20: ("0.010 0.006 0.003", "0.932 0.861 1.000"),
        50: ("0.009 0.006 0.003", "0.913 0.778 1.000"),
    },
    "mirror": {
        5: ("0.234 0.366 0.122", "1.364 2.398 2.160"),
        20: ("0.152 0.131 0.056", "0.884 0.859 1.000"),
        50: ("0.146 0.118 0.056", "0.849 0.775 1.000"),
    },
}


def cells(rates: tuple[float, ...]) -> list[Cell]:
    """All printed cells, those of Tables 9.17 to 9.19 at the given rates [Hz] only, in the order of the tables."""
    made = [*_at_10_hertz(), *_at_other_rates(rates)]
    return sorted(made, key=lambda cell: float(cell.table.removeprefix("Table 9.")))


def _at_10_hertz() -> Iterator[Cell]:
    for number, (scenario, rows) in _POINTING.items():
        for measure, row in rows.items():
            for controller, text in zip(CONTROLLERS, row.split(), strict=True):
                yield Cell(f"Table {number}", text, Run(controller, scenario), measure)
            if number not in _TO_NOMINAL:
                continue
            for controller, text in zip(CONTROLLERS, _TO_NOMINAL[number][measure].split(), strict=True):
                yield Cell(
                    f"Table {number}",
                    text,
                    Run(controller, scenario),
                    measure,
                    Run(controller, "nominal"),
                    _DIVIDED_WRONGLY.get(text),
                    "printed is the quotient by the nominal value of the entire trajectory",
                )
    for number, (scenario, row) in _WORK.items():
        for controller, text in zip(CONTROLLERS, row.split(), strict=True):
            meant = 10 * float(text) if number == "9.13" else None
            yield Cell(
                f"Table {number}",
                text,
                Run(controller, scenario),
                "workload",
                meant=meant,
                why="the whole table is printed ten times too small",
            )
    for number, (scenario, errors, ratios) in _ESTIMATION.items():
        measures: tuple[Measure, Measure] = ("estimation", "relative estimation")
        for measure, row in zip(measures, (errors, ratios), strict=True):
            for controller, text in zip(ADAPTIVE, row.split(), strict=True):
                yield Cell(f"Table {number}", text, Run(controller, scenario), measure)


def _at_other_rates(rates: tuple[float, ...]) -> Iterator[Cell]:
    for number, (scenario, measures) in _RATES.items():
        for measure, by_rate in measures.items():
            for rate in rates:
                for row, relative in zip(by_rate[rate], (False, True), strict=True):
                    for controller, text in zip(CONTROLLERS, row.split(), strict=True):
                        over = Run(controller, scenario) if relative else None
                        yield Cell(f"Table {number}", text, Run(controller, scenario, rate), measure, over)
    for scenario, rows in _ESTIMATION_RATES.items():
        for rate in rates:
            for row, relative in zip(rows[rate], (False, True), strict=True):
                for controller, text in zip(ADAPTIVE, row.split(), strict=True):
                    over = Run(controller, scenario) if relative else None
                    yield Cell("Table 9.19", text, Run(controller, scenario, rate), "relative estimation", over)

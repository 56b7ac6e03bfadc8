"""Panels of curves, drawn twice: interactive by Plotly for the report, and as a PNG by Matplotlib."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fmus.errors import AdcsError
from orchestration.fmu.file import element_names
from orchestration.process.writing import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Dash = Literal["solid", "dash", "dot"]
Run = TypeVar("Run")

# Of middle lightness: legible on white and on near-black alike.
PALETTE = ("#3b7dd8", "#e2703a", "#2e9e6b", "#b05cc6", "#c79a1e", "#d94f70", "#1fa2b8", "#7d8796")
GUIDE_COLOR = "#8a93a3"
POINTS_IN_REPORT = 1500  # per curve; more than the pixels a panel is wide
POINTS_IN_PNG = 6000
_DPI_IN_NOTEBOOK = 75  # of a figure that is made for twice as many
_MOST_IN_LEGEND = 12  # curves of a variable; with more, a legend says nothing
_ROUNDING = 1e-14  # relative; a smaller change is of no curve
_SINGLE = 1e-3  # relative; a smaller change is not to be seen in single precision
_MATPLOTLIB_DASH: dict[Dash, Any] = {"solid": "-", "dash": (0, (5, 2)), "dot": (0, (1.2, 1.6))}


@dataclass(frozen=True)
class Series:
    """One curve, `x` and `y` of shape (N,). `color` is a place in the palette; by default the position in the panel."""

    label: str
    x: ArrayLike
    y: ArrayLike
    dash: Dash = "solid"
    color: int | None = None
    markers: bool = False
    faint: bool = False  # one of many: thin, and not in the legend


@dataclass(frozen=True)
class Guide:
    """A thin straight line at a value of one axis: a threshold, an instant."""

    value: float
    label: str = ""
    axis: Literal["x", "y"] = "y"


@dataclass(frozen=True)
class Panel:
    """One pair of axes; `group` is a heading shared by several.

    On a logarithmic axis values that are not positive are left out.
    """

    title: str
    y_label: str
    series: Sequence[Series]
    log: bool = False
    note: str = ""
    x_label: str = "time [s]"
    log_x: bool = False
    guides: Sequence[Guide] = ()
    group: str = ""


def components(label: str, time: ArrayLike, vectors: ArrayLike, dash: Dash = "solid") -> list[Series]:
    """One curve per column of `vectors` (N, n), coloured by column, labelled `label 1`, `label 2`, ..."""
    columns = np.asarray(vectors, dtype=float).T
    return [Series(f"{label} {i + 1}".strip(), time, column, dash, color=i) for i, column in enumerate(columns)]


def told_apart(runs: Mapping[str, Run]) -> Iterator[tuple[str, Run, Dash]]:
    """Yield up to three runs with their labels, each with a dash of its own."""
    dashes: tuple[Dash, ...] = get_args(Dash)
    for (label, run), dash in zip(runs.items(), dashes, strict=False):
        yield label, run, dash


def over_time(name: str, time: ArrayLike, values: ArrayLike, unit: str | None) -> Panel:
    """A recorded variable (N, *shape), with a curve for each element; `name` is `component.variable`."""
    columns = np.asarray(values, dtype=float)
    labels = element_names(name.partition(".")[2], columns.shape[1:])
    columns = columns.reshape(len(columns), len(labels)).T
    many = len(labels) > _MOST_IN_LEGEND
    series = [Series(label, time, column, faint=many) for label, column in zip(labels, columns, strict=True)]
    return Panel(name, f"[{unit or '-'}]", series)


def thin(x: ArrayLike, y: ArrayLike, points: int) -> tuple[Array, Array]:
    """About `points` of the samples (x, y), each (N,): first, last, and the extremes of equal stretches, in order.

    No peak is lost, whatever the number of points. NaN (a gap) is kept where a whole stretch is NaN.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    count = len(y)
    if count <= points:
        return x, y
    width = -(-2 * count // points)  # samples per stretch, two of which are kept
    stretches = np.pad(y, (0, -count % width), constant_values=np.nan).reshape(-1, width)
    start = width * np.arange(len(stretches))
    lowest = start + np.where(np.isnan(stretches), np.inf, stretches).argmin(axis=1)
    highest = start + np.where(np.isnan(stretches), -np.inf, stretches).argmax(axis=1)
    kept = np.unique(np.concatenate([[0], lowest, highest, [count - 1]]))
    return x[kept], y[kept]


def _points(panel: Panel, series: Series, limit: int) -> tuple[Array, Array]:
    x, y = np.array(series.x, dtype=float), np.array(series.y, dtype=float)
    if x.shape != y.shape or x.ndim != 1:
        raise ValueError(
            f"series {series.label!r} of panel {panel.title!r}: x is {x.shape}, y is {y.shape}, expected (N,)"
        )
    if panel.log:
        y[~(y > 0)] = np.nan
    if panel.log_x:
        x[~(x > 0)] = np.nan
    return thin(x, y, limit)


def limits(panel: Panel) -> dict[str, tuple[float, float] | None]:
    """The ends of the axes `x` and `y`, for both pictures: all values and guides, with some room above and below.

    None where there is nothing to be seen.
    """
    points = [_points(panel, series, POINTS_IN_PNG) for series in panel.series]
    markers = any(series.markers for series in panel.series)
    found: dict[str, tuple[float, float] | None] = {}
    for i, (name, log) in enumerate((("x", panel.log_x), ("y", panel.log))):
        values = np.concatenate([*(each[i] for each in points), [g.value for g in panel.guides if g.axis == name]])
        values = values[np.isfinite(values) & ((values > 0) | (not log))]
        found[name] = _room(values, log, 0.0 if name == "x" and not markers else 0.05) if len(values) else None
    return found


def _room(values: Array, log: bool, part: float) -> tuple[float, float]:
    """Ends of an axis for these values, with a part of their span more at each end; a constant is in the middle."""
    low, high = float(values.min()), float(values.max())
    if log:
        ends = np.log10([low, high])
        ends += np.array([-1, 1]) * (part * (ends[1] - ends[0]) or 0.5 * (low == high))
        return float(10 ** ends[0]), float(10 ** ends[1])
    size = max(abs(low), abs(high))
    if high - low <= _ROUNDING * size:
        return low - 0.05 * (size or 1.0), high + 0.05 * (size or 1.0)
    more = part * (high - low)
    return low - more, high + more


def _color(series: Series, position: int) -> str:
    return PALETTE[(position if series.color is None else series.color) % len(PALETTE)]


def _in_legend(panel: Panel, series: Series) -> bool:
    return len(panel.series) > 1 and not series.faint


def plotly_figure(panel: Panel) -> dict[str, Any]:
    """The panel as a Plotly figure (`data`, `layout`), colours of text and grid left to the page."""
    traces = []
    ends = limits(panel)
    for position, series in enumerate(panel.series):
        x, y = _points(panel, series, POINTS_IN_REPORT)
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers" if series.markers else "lines",
                "x": _packed(x),
                "y": _packed(y),
                "name": series.label,
                "showlegend": _in_legend(panel, series),
                "opacity": 0.55 if series.faint else 1.0,
                "line": {
                    "color": _color(series, position),
                    "dash": series.dash,
                    "width": 1.0 if series.faint else 1.8,
                    "simplify": False,  # else a ripple of less than a pixel or so becomes a polygon
                },
                "marker": {"size": 8},
            }
        )
    axis = {"showline": True, "zeroline": False, "automargin": True, "exponentformat": "power", "hoverformat": ".4g"}
    layout: dict[str, Any] = {
        "xaxis": {**axis, "title": {"text": panel.x_label}, "type": "log" if panel.log_x else "linear"},
        "yaxis": {**axis, "title": {"text": panel.y_label}, "type": "log" if panel.log else "linear"},
        "hovermode": "closest" if len(panel.series) > 8 or panel.log_x else "x unified",
        "legend": {"orientation": "h", "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom"},
        "margin": {"l": 64, "r": 14, "t": 30, "b": 46},
        "shapes": [_plotly_guide(guide) for guide in panel.guides],
        "annotations": [_plotly_guide_label(panel, guide) for guide in panel.guides if guide.label],
    }
    for name, log in (("x", panel.log_x), ("y", panel.log)):
        end = ends[name]
        if end is not None:  # in decades where the axis is
            layout[f"{name}axis"] |= {"range": [float(np.log10(e)) if log else e for e in end], "autorange": False}
        if log:
            layout[f"{name}axis"] |= {"dtick": _decade_ticks(end), "tickfont": {"size": 10}}
    return {"data": traces, "layout": layout}


def _decade_ticks(ends: tuple[float, float] | None) -> int | str:
    """Plotly's `dtick` of a logarithmic axis: 1, 2, 5, 10, ... on a short one, else at most about eight decades."""
    decades = float(np.log10(ends[1] / ends[0])) if ends else 1.0
    return "D2" if decades < 2 else int(np.ceil(decades / 8))


def _packed(values: Array) -> dict[str, str]:
    """As plotly.js takes arrays in JSON; single precision is a quarter of the size of text and finer than a pixel.

    Double where the values change little: a ripple on a large constant.
    """
    finite = values[np.isfinite(values)]
    little = len(finite) > 0 and np.ptp(finite) < _SINGLE * np.abs(finite).max()
    kind = "f8" if little else "f4"
    return {"dtype": kind, "bdata": b64encode(values.astype(f"<{kind}").tobytes()).decode("ascii")}


def _plotly_guide(guide: Guide) -> dict[str, Any]:
    along, across = ("y", "x") if guide.axis == "x" else ("x", "y")
    return {
        "type": "line",
        f"{along}ref": "paper",
        f"{along}0": 0,
        f"{along}1": 1,
        f"{across}ref": across,
        f"{across}0": guide.value,
        f"{across}1": guide.value,
        "line": {"color": GUIDE_COLOR, "width": 1, "dash": "dot"},
    }


def _plotly_guide_label(panel: Panel, guide: Guide) -> dict[str, Any]:
    log = panel.log_x if guide.axis == "x" else panel.log
    value = float(np.log10(guide.value)) if log else guide.value  # annotations, unlike shapes, count in decades
    place: dict[str, Any] = (
        {"x": value, "y": 1, "yref": "paper", "xanchor": "left", "yanchor": "top"}
        if guide.axis == "x"
        else {"x": 1, "xref": "paper", "y": value, "xanchor": "right", "yanchor": "bottom"}
    )
    return {**place, "text": guide.label, "showarrow": False, "font": {"size": 11, "color": GUIDE_COLOR}}


def can_draw() -> bool:
    """Whether there is what draws pictures: Matplotlib, which the extra `plot` brings."""
    return find_spec("matplotlib") is not None


def write_png(path: str | Path, panels: Sequence[Panel], title: str = "", columns: int = 2) -> None:
    """All panels in one picture; the folder of `path` is made if it is missing."""
    figure = make_figure(panels, title, columns)
    with replacing(path) as name:
        figure.savefig(name, facecolor="white")


def make_figure(panels: Sequence[Panel], title: str = "", columns: int = 2) -> Figure:
    """All panels in one figure of Matplotlib, row by row in a grid; it shows itself in a notebook."""
    if not can_draw():
        raise AdcsError("pictures are drawn by Matplotlib, which is not installed: pip install 'adcs-fmus[plot]'")
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # not at the top: takes most of a second to load
    from matplotlib.figure import Figure

    class Plot(Figure):
        """A figure that needs no pyplot, which would keep it in memory, and draw it twice where it is shown."""

        def _repr_png_(self) -> bytes:
            written = BytesIO()
            self.savefig(written, format="png", dpi=_DPI_IN_NOTEBOOK, facecolor="white", metadata={"Software": None})
            return written.getvalue()

    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    figure = Plot(figsize=(6.4 * columns, 3.9 * rows + (0.5 if title else 0)), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, fontsize=14, fontweight="bold", x=0.01, ha="left")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, panel in zip(grid, panels, strict=False):
        _draw(axes, panel)
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.12)  # type: ignore[union-attr,call-arg]
    return figure


def _draw(axes: Axes, panel: Panel) -> None:
    for position, series in enumerate(panel.series):
        x, y = _points(panel, series, POINTS_IN_PNG)
        axes.plot(
            x,
            y,
            color=_color(series, position),
            linestyle=_MATPLOTLIB_DASH[series.dash],
            linewidth=0.8 if series.faint else 1.5,
            alpha=0.55 if series.faint else 1.0,
            marker="o" if series.markers else "",
            markersize=5,
            label=series.label if _in_legend(panel, series) else "_",
        )
    for guide in panel.guides:
        _draw_guide(axes, guide)
    if panel.log:
        axes.set_yscale("log")
    if panel.log_x:
        axes.set_xscale("log")
    ends = limits(panel)
    if ends["x"] is not None:
        axes.set_xlim(ends["x"])
    if ends["y"] is not None:
        axes.set_ylim(ends["y"])
    labels = [series.label for series in panel.series if _in_legend(panel, series)]
    lines = -(-len(labels) * (max(map(len, labels)) + 7) // 95) if labels else 0  # about 95 characters fit in one
    if labels:
        place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.01, 1.0), "borderaxespad": 0.2}
        axes.legend(fontsize=8.5, frameon=False, ncols=-(-len(labels) // lines), columnspacing=1.4, **place)
    axes.set_title(panel.title, loc="left", fontsize=11, fontweight="bold", pad=8 + 13 * lines)
    axes.set_xlabel(panel.x_label, color="#555")
    axes.set_ylabel(panel.y_label, color="#555")
    axes.grid(color="#e3e6eb", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(color="#b9c0cb", labelcolor="#444", labelsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color("#b9c0cb")


def _draw_guide(axes: Axes, guide: Guide) -> None:
    style: dict[str, Any] = {"color": GUIDE_COLOR, "linewidth": 0.9, "linestyle": _MATPLOTLIB_DASH["dot"]}
    text: dict[str, Any] = {"color": GUIDE_COLOR, "fontsize": 8, "textcoords": "offset points"}
    if guide.axis == "x":
        axes.axvline(guide.value, **style)
        axes.annotate(guide.label, (guide.value, 1), xycoords=("data", "axes fraction"), xytext=(3, -9), **text)
    else:
        axes.axhline(guide.value, **style)
        axes.annotate(
            guide.label, (1, guide.value), xycoords=("axes fraction", "data"), xytext=(-3, 3), ha="right", **text
        )

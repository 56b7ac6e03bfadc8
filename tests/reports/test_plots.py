from __future__ import annotations

import base64
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from orchestration.results.plots import (
    POINTS_IN_REPORT,
    Guide,
    Panel,
    Series,
    _draw,
    components,
    limits,
    plotly_figure,
    thin,
    told_apart,
    write_png,
)


def unpacked(values: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(values["bdata"]), f"<{values['dtype']}")


def pixels(path: Path) -> tuple[int, int, bytes]:
    """Width, height and the filtered image data of a PNG."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", data[16:24])
    body, at = b"", 8
    while at < len(data):
        (length,), kind = struct.unpack(">I", data[at : at + 4]), data[at + 4 : at + 8]
        if kind == b"IDAT":
            body += data[at + 8 : at + 8 + length]
        at += 12 + length
    return width, height, zlib.decompress(body)


class TestThin:
    def test_short_series_are_left_alone(self) -> None:
        x, y = thin(range(10), range(10), 10)
        assert x.tolist() == y.tolist() == list(range(10))

    @pytest.mark.parametrize("count", [101, 1000, 99_999])
    def test_keeps_ends_and_every_peak(self, count: int) -> None:
        time = np.linspace(0, 1, count)
        values = np.sin(5 * time)
        values[count // 3], values[2 * count // 3] = 7.0, -7.0  # two spikes of one sample
        x, y = thin(time, values, 100)
        assert len(y) <= 102
        assert (x[0], y[0], x[-1], y[-1]) == (time[0], values[0], time[-1], values[-1])
        assert x[y.argmax()] == time[count // 3]
        assert x[y.argmin()] == time[2 * count // 3]
        assert (np.diff(x) > 0).all()

    def test_what_is_kept_was_there(self) -> None:
        time = np.arange(5000.0)
        values = np.random.default_rng(1).normal(size=5000)
        x, y = thin(time, values, 300)
        assert (y == values[x.astype(int)]).all()

    def test_gaps_survive_and_do_not_hide_peaks(self) -> None:
        values = np.zeros(10_000)
        values[::2] = np.nan
        values[2000:4000] = np.nan
        values[7001] = 3.0
        x, y = thin(np.arange(10_000.0), values, 200)
        assert np.nanmax(y) == 3.0
        assert np.isnan(y[(x > 2100) & (x < 3900)]).all()


class TestPlotly:
    def test_values_units_and_names(self) -> None:
        panel = Panel("rate", "ω [rad/s]", components("w", [0.0, 1.0], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "dash"))
        figure = plotly_figure(panel)
        assert [trace["name"] for trace in figure["data"]] == ["w 1", "w 2", "w 3"]
        assert [unpacked(trace["y"]).tolist() for trace in figure["data"]] == [[1, 4], [2, 5], [3, 6]]
        assert {trace["line"]["dash"] for trace in figure["data"]} == {"dash"}
        assert figure["layout"]["yaxis"]["title"]["text"] == "ω [rad/s]"
        assert figure["layout"]["xaxis"]["title"]["text"] == "time [s]"
        assert figure["layout"]["yaxis"]["type"] == "linear"

    def test_dashes_tell_three_runs_apart(self) -> None:
        given = list(told_apart({"a": 1, "b": 2, "c": 3, "d": 4}))
        assert given == [("a", 1, "solid"), ("b", 2, "dash"), ("c", 3, "dot")]

    def test_logarithmic_axis_leaves_out_what_is_not_positive(self) -> None:
        given = np.array([0.0, 1.0, -1.0, np.nan, 10.0])
        figure = plotly_figure(Panel("", "", [Series("a", np.arange(5), given)], log=True))
        assert np.isnan(unpacked(figure["data"][0]["y"])).tolist() == [True, False, True, True, False]
        assert figure["layout"]["yaxis"]["type"] == "log"
        assert given[0] == 0.0  # the caller's array is not touched

    @pytest.mark.parametrize(("low", "high", "tick"), [(1, 50, "D2"), (1e-4, 1, 1), (1e-12, 1, 2)])
    def test_ticks_of_a_logarithmic_axis(self, low: float, high: float, tick: Any) -> None:
        figure = plotly_figure(Panel("", "", [Series("a", [1, 2], [low, high])], log=True))
        assert figure["layout"]["yaxis"]["dtick"] == tick

    def test_all_of_nothing_on_a_logarithmic_axis(self) -> None:
        figure = plotly_figure(Panel("", "", [Series("a", [1, 2], [0.0, 0.0])], log=True))
        assert np.isnan(unpacked(figure["data"][0]["y"])).all()

    def test_long_series_are_thinned(self) -> None:
        time = np.linspace(0, 100, 100_001)
        figure = plotly_figure(Panel("", "", [Series("a", time, np.cos(time))]))
        assert len(unpacked(figure["data"][0]["x"])) <= 2 * POINTS_IN_REPORT

    def test_guide_on_a_logarithmic_axis_is_labelled_in_decades(self) -> None:
        series, guide = Series("a", [0, 1], [1.0, 1e-3]), Guide(0.01, "1 %")
        layout = plotly_figure(Panel("", "", [series], log=True, guides=[guide]))["layout"]
        assert layout["shapes"][0]["y0"] == layout["shapes"][0]["y1"] == 0.01
        assert layout["annotations"][0]["y"] == pytest.approx(-2)
        assert layout["annotations"][0]["text"] == "1 %"

    def test_faint_series_and_single_ones_stay_out_of_the_legend(self) -> None:
        one = plotly_figure(Panel("", "", [Series("a", [0], [0])]))
        many = plotly_figure(Panel("", "", [Series("a", [0], [0]), Series("b", [0], [0], faint=True)]))
        assert [trace["showlegend"] for trace in one["data"] + many["data"]] == [False, True, False]

    def test_unequal_lengths_are_refused_by_name(self) -> None:
        with pytest.raises(ValueError, match=r"series 'w' of panel 'rate': x is \(3,\), y is \(2,\)"):
            plotly_figure(Panel("rate", "", [Series("w", [0, 1, 2], [0, 1])]))


class TestBoth:
    """report.html and report.png show the same."""

    RIPPLE = 5.0 + 1e-9 * np.sin(np.linspace(0, 60, 4000))
    PANELS = (
        Panel("plain", "w [rad/s]", components("w", np.linspace(0, 9, 50), np.linspace([0, 1, -2], [3, 1, 2], 50))),
        Panel("log", "error", [Series("e", [0, 1, 2, 3], [1.0, 0.0, 1e-4, 1e-7])], log=True, guides=[Guide(1e-9, "g")]),
        Panel("both", "y", [Series("s", [0.01, 0.1, 1], [3.0, 2.0, 1.0], markers=True)], log=True, log_x=True),
        Panel("constant", "H", [Series("H", [0, 1], [2.0, 2.0])]),
        Panel("ripple", "E [J]", [Series("E", np.linspace(0, 60, 4000), RIPPLE)]),
        Panel("instants", "y", [Series("y", [0, 1], [0.0, 1.0])], guides=[Guide(1.5, "later", "x"), Guide(-1.0)]),
        Panel("nothing", "y", [Series("y", [0, 1], [0.0, 0.0])], log=True),
    )

    @pytest.mark.parametrize("panel", PANELS, ids=lambda panel: panel.title)
    def test_the_same_axes_and_curves(self, panel: Panel) -> None:
        layout = plotly_figure(panel)["layout"]
        traces = plotly_figure(panel)["data"]
        axes = Figure().subplots()
        _draw(axes, panel)
        for name, log in (("x", panel.log_x), ("y", panel.log)):
            axis = layout[f"{name}axis"]
            assert axis["type"] == getattr(axes, f"get_{name}scale")() == ("log" if log else "linear")
            assert axis["title"]["text"] == getattr(axes, f"get_{name}label")()
            if limits(panel)[name] is None:
                continue
            ends = [10**end for end in axis["range"]] if log else axis["range"]
            assert ends == pytest.approx(getattr(axes, f"get_{name}lim")(), rel=1e-12)
            assert axis["autorange"] is False
        lines = [line for line in axes.get_lines() if len(line.get_xdata()) > 2 or line.get_label() in ("H", "y", "_")]
        for series, trace, line in zip(panel.series, traces, lines, strict=False):
            y = np.asarray(line.get_ydata(), float)
            assert np.nanmax(unpacked(trace["y"]), initial=-9) == pytest.approx(np.nanmax(y, initial=-9), rel=1e-7)
            assert np.nanmin(unpacked(trace["y"]), initial=99) == pytest.approx(np.nanmin(y, initial=99), rel=1e-7)
            assert (trace["name"], trace["line"]["color"]) == (series.label, line.get_color())

    def test_a_ripple_on_a_large_constant_is_seen(self) -> None:
        trace = plotly_figure(self.PANELS[4])["data"][0]
        assert trace["line"]["simplify"] is False
        values = unpacked(trace["y"])
        assert values.max() - values.min() == pytest.approx(2e-9, rel=1e-6)
        assert len(np.unique(values)) > 1000  # in single precision: one
        low, high = limits(self.PANELS[4])["y"] or (0, 0)
        assert high - low == pytest.approx(2.2e-9, rel=1e-6)

    def test_room_and_guides(self) -> None:
        assert limits(self.PANELS[0]) == {"x": (0.0, 9.0), "y": (-2.25, 3.25)}
        assert limits(self.PANELS[3])["y"] == (1.9, 2.1)
        assert limits(self.PANELS[5]) == {"x": (0.0, 1.5), "y": (-1.1, 1.1)}
        assert limits(self.PANELS[1])["y"] == pytest.approx((1e-9 * 10**-0.45, 10**0.45))
        assert limits(self.PANELS[6]) == {"x": (0.0, 1.0), "y": None}


class TestPng:
    @pytest.mark.parametrize(("count", "shape"), [(1, (960, 585)), (3, (1920, 1170))])
    def test_grid_in_two_columns(self, tmp_path: Path, count: int, shape: tuple[int, int]) -> None:
        panel = Panel("a", "y", [Series("s", [0, 1], [1.0, 2.0]), Series("t", [0, 1], [0.0, 1.0], dash="dot")])
        write_png(tmp_path / "new" / "p.png", [panel] * count)
        assert pixels(tmp_path / "new" / "p.png")[:2] == shape

    def test_a_curve_is_drawn(self, tmp_path: Path) -> None:
        curve = Series("s", np.arange(100.0), np.arange(1.0, 101.0))
        empty = Series("s", np.arange(100.0), np.full(100, np.nan))
        images = []
        for name, series in (("curve", curve), ("empty", empty)):
            panel = Panel("a", "y", [series], log=True, guides=[Guide(10.0, "level"), Guide(50.0, "instant", "x")])
            write_png(tmp_path / f"{name}.png", [panel], "title")
            images.append(pixels(tmp_path / f"{name}.png"))
        assert images[0][:2] == images[1][:2]
        assert images[0][2] != images[1][2]

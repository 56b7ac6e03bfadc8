"""The icon of an FMU: a sign for its kind, its name below."""

import io

import matplotlib as mpl
import numpy as np
from matplotlib import patches
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

COLOURS = {
    "guidance": "#7a4fb0",
    "plant": "#1f5fa8",
    "environment": "#2f7d4f",
    "sensor": "#b0651a",
    "observer": "#0f7c86",
    "controller": "#b23a48",
}
_PIXELS = 256


def draw(name: str, kind: str, form: str) -> bytes:
    """The icon as `form` "svg" or "png"; equal bytes each time."""
    with mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": "path", "font.family": "DejaVu Sans"}):
        figure = Figure(figsize=(2, 2), dpi=_PIXELS / 2)
        FigureCanvasAgg(figure)
        axes = figure.add_axes((0, 0, 1, 1), xlim=(-1, 1), ylim=(-1, 1), aspect="equal")
        axes.set_axis_off()
        colour = COLOURS[kind]
        frame = patches.FancyBboxPatch(
            (-0.9, -0.9),
            1.8,
            1.8,
            boxstyle="round,pad=0,rounding_size=0.2",
            facecolor="white",
            edgecolor=colour,
            linewidth=4,
        )
        axes.add_patch(frame)
        _SIGNS[kind](axes, colour)
        axes.text(0, -0.7, name, ha="center", va="center", color="#1c2430", fontsize=min(14, 185 / len(name)))
        buffer = io.BytesIO()
        metadata = {"Date": None} if form == "svg" else {"Software": None}
        figure.savefig(buffer, format=form, transparent=True, metadata=metadata)
    return buffer.getvalue() if form == "svg" else _in_few_colours(buffer)


def _in_few_colours(png: io.BytesIO) -> bytes:
    """Return the same picture in half the bytes: an icon has one colour, and shades of it at the edges."""
    smaller = io.BytesIO()
    Image.open(png).quantize(method=Image.Quantize.FASTOCTREE).save(smaller, "PNG", optimize=True)
    return smaller.getvalue()


def _spacecraft(axes: Axes, colour: str) -> None:
    for x in (-0.72, 0.3):
        axes.add_patch(patches.Rectangle((x, 0.02), 0.42, 0.36, fill=False, edgecolor=colour, linewidth=3))
        axes.plot([x + 0.21, x + 0.21], [0.02, 0.38], color=colour, linewidth=2)
    axes.add_patch(patches.Rectangle((-0.22, -0.12), 0.44, 0.64, facecolor=colour))
    axes.plot([-0.3, 0.3], [0.2, 0.2], color=colour, linewidth=3)


def _star_in_cone(axes: Axes, colour: str) -> None:
    axes.plot([-0.5, 0, 0.5], [0.35, -0.4, 0.35], color=colour, linewidth=4, solid_joinstyle="round")
    angle = np.pi / 2 + np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2, 0.1, 0.25)
    axes.fill(radius * np.cos(angle), 0.45 + radius * np.sin(angle), color=colour)


def _estimate(axes: Axes, colour: str) -> None:
    x = np.linspace(-0.7, 0.7, 100)
    truth = 0.1 + 0.25 * np.sin(4 * x)
    axes.plot(x, truth, color=colour, linewidth=4)
    axes.plot(x, truth + 0.5 * np.exp(-4 * (x + 0.7)), color=colour, linewidth=3, linestyle=(0, (2, 1)))


def _feedback(axes: Axes, colour: str) -> None:
    axes.add_patch(patches.Circle((-0.38, 0.22), 0.16, fill=False, edgecolor=colour, linewidth=4))
    _arrow(axes, (-0.8, 0.22), (-0.54, 0.22), colour)
    _arrow(axes, (-0.22, 0.22), (0.78, 0.22), colour)
    axes.plot([0.4, 0.4, -0.38], [0.22, -0.34, -0.34], color=colour, linewidth=3)
    _arrow(axes, (-0.38, -0.34), (-0.38, 0.06), colour)


def _target(axes: Axes, colour: str) -> None:
    for radius in (0.42, 0.22):
        axes.add_patch(patches.Circle((0.15, 0.15), radius, fill=False, edgecolor=colour, linewidth=4))
    _arrow(axes, (-0.65, -0.45), (0.17, 0.17), colour)


def _field(axes: Axes, colour: str) -> None:
    axes.add_patch(patches.Circle((0, 0.12), 0.2, facecolor=colour))
    for side in (-1, 1):
        for size in (0.3, 0.42):
            axes.add_patch(
                patches.Ellipse((side * size, 0.12), 2 * size, 1.6 * size, fill=False, edgecolor=colour, linewidth=3)
            )


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    style = {"arrowstyle": "-|>,head_width=0.3,head_length=0.5", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=style | {"color": colour, "linewidth": 3})


_SIGNS = {
    "guidance": _target,
    "plant": _spacecraft,
    "environment": _field,
    "sensor": _star_in_cone,
    "observer": _estimate,
    "controller": _feedback,
}

"""A system as a line and as a block diagram: everything is in it, nothing covers anything, the same every time."""

import itertools
import re
import xml.etree.ElementTree as ElementTree

import pytest

from adcs import System, systems

SVG = "{http://www.w3.org/2000/svg}"


def drawn(system):
    """The boxes of the diagram, (lines, x0, y0, x1, y1), and its arrows, (start x, row y, column x, end y)."""
    root = ElementTree.fromstring(re.search(r"<svg.*</svg>", system._repr_html_(), re.DOTALL)[0])
    boxes = []
    for group in root.iter(f"{SVG}g"):
        rect = group.find(f"{SVG}rect")
        x, y, width, height = (float(rect.get(key)) for key in ("x", "y", "width", "height"))
        lines = tuple(span.text for span in group.iter(f"{SVG}tspan"))
        boxes.append((lines, x, y, x + width, y + height))
    arrows = [
        tuple(map(float, re.match(r"M(\S+) (\S+)H([^V]+)V([^M]+)M", path.get("d")).groups()))
        for path in root.iter(f"{SVG}path")
    ]
    width, height = (float(root.get(key)) for key in ("width", "height"))
    assert min(min(box[1:3]) for box in boxes) > 0
    assert max(box[3] for box in boxes) < width and max(box[4] for box in boxes) < height
    return boxes, arrows


def test_a_system_in_a_line(chain):
    assert repr(System("empty")) == "<System empty: no components; 0 connections>"
    assert re.fullmatch(
        r"<System chain: integrator \(integrator\S*\.fmu\), gain \(gain\S*\.fmu\), source \(source\S*\.fmu\); "
        r"2 connections>",
        repr(chain()),
    )


def test_a_large_system_is_counted(mock):
    system = System("many")
    for i in range(41):
        system.add(f"c{i}", mock("gain"))
    system.connect("c0.y", "c1.u", factor=1.0)
    assert repr(system).endswith(" and 33 more; 1 connection>")
    assert system._repr_html_() == "<p><b>many</b><br>41 components, too many to be drawn; 1 connection</p>"
    assert System("empty", "a < b")._repr_html_() == ("<p><b>empty</b>: a &lt; b<br>no components; 0 connections</p>")


def test_blocks_follow_the_signals_and_feedback_returns(mock):
    system = System("loop")
    system.add("integrator", mock("integrator"), every=2)
    system.add("gain", mock("gain"))
    system.connect("gain.y", "integrator.u")
    system.connect("integrator.y[2]", "gain.u[1]", delay_steps=1)
    boxes, arrows = drawn(system)
    place = {lines[0]: ((x0 + x1) / 2, (y0 + y1) / 2) for lines, x0, y0, x1, y1 in boxes}
    assert {lines[0]: lines[2:] for lines, *_ in boxes}["integrator"] == ("every 2 steps",)
    assert set(place) == {"integrator", "gain", "y", "y[2] +1 step"}
    assert place["integrator"][1] < place["gain"][1]  # of equals the first
    assert place["y[2] +1 step"] == pytest.approx((place["gain"][0], place["integrator"][1]), abs=0.11)
    assert place["y"] == pytest.approx((place["integrator"][0], place["gain"][1]), abs=0.11)
    (_, row, column, end), (_, back_row, back_column, back_end) = arrows
    assert (column, row) == pytest.approx(place["y[2] +1 step"], abs=0.11) and row < end < place["gain"][1]
    assert (back_column, back_row) == pytest.approx(place["y"], abs=0.11)
    assert place["integrator"][1] < back_end < back_row


def test_what_a_component_gives_itself_stands_in_its_block(mock):
    system = System("self")
    system.add("integrator", mock("integrator"))
    system.connect("integrator.y", "integrator.u", factor=-1.0)
    boxes, arrows = drawn(system)
    assert boxes[0][0][2:] == ("y to itself",) and len(boxes) == 1 and not arrows


@pytest.mark.parametrize("name", ["observer-pd", "trigo-neso-mismatch", "velocity-free-tracking-uncertain", "six-dof"])
def test_nothing_covers_anything(name):
    system = systems()[name].build()
    assert system._repr_html_() == systems()[name].build()._repr_html_()
    boxes, arrows = drawn(system)
    assert len(boxes) == len(system.components) + len(arrows)
    for (one, x0, y0, x1, y1), (other, u0, v0, u1, v1) in itertools.combinations(boxes, 2):
        assert x1 < u0 or u1 < x0 or y1 < v0 or v1 < y0, (one, other)
    for _, row, column, end in arrows:
        for lines, x0, y0, x1, y1 in boxes:
            if x0 <= column <= x1 and max(y0, min(row, end)) <= min(y1, max(row, end)):
                assert (x0 + x1) / 2 == pytest.approx(column, abs=0.11), lines  # what goes to the same block
    carried = {line for lines, *_ in boxes for line in lines}
    assert {connection.source.partition(".")[2] for connection in system.connections} <= carried

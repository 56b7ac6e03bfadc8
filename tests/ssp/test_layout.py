"""The drawing: nothing overlaps, everything is on the canvas, wires begin and end at their connectors."""

from __future__ import annotations

from itertools import combinations, pairwise

import pytest
from test_round_trip import everything

from adcs.catalogue import SYSTEMS
from orchestration.ssp.layout import arrange
from orchestration.ssp.tree import make_tree


def drawn(system):
    tree = make_tree(system, {name: c.open("2.0") for name, c in system.components.items()})
    arrange(tree)
    return tree


@pytest.fixture(params=["observer-pd", "everything"])
def tree(request, fmus):
    return drawn(everything(fmus) if request.param == "everything" else SYSTEMS[request.param].build())


def systems(tree):
    return [box for box in tree.everything() if box.component is None]


def point(system, end):
    element, name = end
    holder = system if element is None else system.boxes[element]
    x1, y1, x2, y2 = system.canvas if element is None else holder.rectangle
    x, y = holder.places[name]
    return x1 + x * (x2 - x1), y1 + y * (y2 - y1)


def test_elements_are_on_the_canvas_and_apart(tree):
    for system in systems(tree):
        x1, y1, x2, y2 = system.canvas
        for box in system.boxes.values():
            left, bottom, right, top = box.rectangle
            assert x1 < left < right < x2
            assert y1 < bottom < top < y2
        for a, b in combinations([box.rectangle for box in system.boxes.values()], 2):
            assert a[2] < b[0] or b[2] < a[0] or a[3] < b[1] or b[3] < a[1]


def test_connectors_are_apart_inputs_left_and_outputs_right(tree):
    for box in tree.everything():
        assert len(set(box.places.values())) == len(box.pins)
        for name, (x, y) in box.places.items():
            assert x == (0.0 if box.pins[name].kind == "input" else 1.0)
            assert 0 < y < 1


def test_wires_are_at_right_angles_and_cross_no_element(tree):
    for system in systems(tree):
        for wire in system.wires:
            corners = [point(system, wire.start), *wire.points, point(system, wire.end)]
            for (xa, ya), (xb, yb) in pairwise(corners):
                assert abs(xa - xb) < 1e-2 or abs(ya - yb) < 1e-2
                for left, bottom, right, top in (box.rectangle for box in system.boxes.values()):
                    assert max(xa, xb) <= left or min(xa, xb) >= right or max(ya, yb) <= bottom or min(ya, yb) >= top


def test_the_flow_is_from_left_to_right():
    tree = drawn(SYSTEMS["observer-pd"].build())
    order = sorted(tree.boxes, key=lambda name: tree.boxes[name].rectangle[0])
    assert order == ["guidance", "controller", "plant", "tracker", "observer"]


def test_loops_and_long_chains_are_drawn(fmus):
    from adcs import System

    system = System("chain")
    for i in range(300):
        system.add(f"c{i}", fmus["sender"])
    tree = drawn(system)
    assert len({box.rectangle for box in tree.boxes.values()}) == 300

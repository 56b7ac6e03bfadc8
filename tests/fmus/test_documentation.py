import re

from lxml import etree

from fmus import catalog
from fmus.build import describe
from fmus.documentation import html, page


def test_formulas_become_mathml():
    text = html("With $a_1 < b$:\n\n$$\\dot q = \\tfrac12 q$$\n\nand `$not` this.")
    assert text.count("<math") == 2
    assert 'display="block"' in text
    assert "<code>$not</code>" in text
    etree.fromstring(f"<body>{text}</body>")


def test_underscores_and_stars_in_formulas_are_not_markdown():
    assert "<em>" not in html("$a_1 * b_2 * c_3$ and $d_4 * e$")


def test_pages_stand_alone_and_show_every_variable():
    for component in catalog.components():
        description = describe(component.name)
        text = page(component, description)
        assert not re.search(r"<script|<link|<img|@import|url\(|\bsrc=", text), component.name
        assert "$" not in text, component.name
        for v in description.variables:
            if v.causality != "independent":
                assert f"<code>{v.name}</code>" in text


def test_matrices_and_bounds_are_readable():
    text = page(catalog.find("RigidBody"), describe("RigidBody"))
    row = re.search(r"<tr><td><code>J_B</code>.*", text)[0]
    assert "<td>3 \u00d7 3</td><td>kg.m2</td>" in row
    assert re.search(r"<td>\[[^;]+; [^;]+; [^;]+\]</td>", row)
    assert "<td>0 … 1.5708</td>" in page(catalog.find("StarTracker"), describe("StarTracker"))

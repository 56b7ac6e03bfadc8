import io

import pytest
from lxml import etree
from PIL import Image

from fmus.catalog import KINDS
from fmus.icon import draw


@pytest.mark.parametrize("kind", KINDS.values())
def test_each_kind_has_its_own_icon_in_both_forms(kind):
    png = Image.open(io.BytesIO(draw("Name", kind, "png"))).convert("RGBA")
    assert png.size == (256, 256)
    assert png.getpixel((0, 0))[3] == 0  # transparent outside the frame
    assert len(png.getcolors(1 << 16)) > 10
    assert etree.fromstring(draw("Name", kind, "svg")).tag.endswith("svg")


def test_equal_bytes_each_time():
    for form in ("png", "svg"):
        assert draw("RigidBody", "plant", form) == draw("RigidBody", "plant", form)
    assert draw("RigidBody", "plant", "png") != draw("RigidBody", "sensor", "png")

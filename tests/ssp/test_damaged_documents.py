"""Damaged at random, a file is still read or refused in one line: nothing else ever comes out."""

from __future__ import annotations

import copy
import random
import zipfile

import pytest
from lxml import etree
from test_round_trip import everything, written

from adcs import AdcsError, read_ssp

TEXTS = ["", "x", "1", "-1", "1e400", "nan", "true", "u", "../x", "a.b", "bus", "9" * 20, "2.0", "input", "m", "w[1]"]


@pytest.mark.parametrize("versions", [("", ""), ("3", "3"), ("", "3")])
def test_damaged_documents(versions, fmus, tmp_path):
    path = written(everything(fmus, versions), tmp_path, stop_time=1.0, step=0.1)
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    rng = random.Random(7)
    refused = 0
    for _ in range(60):
        damaged = dict(files)
        for _ in range(rng.choice((1, 1, 2, 3))):
            name = rng.choice([n for n in files if not n.endswith(".fmu")])
            damaged[name] = damage(damaged[name], rng)
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in damaged.items():
                archive.writestr(name, content)
        try:
            read_ssp(path)
        except AdcsError as error:
            assert "\n" not in str(error)
            refused += 1
    assert 30 < refused < 60


def damage(content: bytes, rng: random.Random) -> bytes:
    """Change, drop, double or move something."""
    root = etree.fromstring(content)
    found = list(root.iter())
    element, other = rng.choice(found), rng.choice(found)
    values = TEXTS + [value for e in found for value in e.attrib.values()]
    what = rng.choice(["change", "change", "change", "forget", "drop", "double", "move"])
    if what == "change" and element.attrib:
        element.set(rng.choice(list(element.attrib)), rng.choice(values))
    elif what == "forget" and element.attrib:
        del element.attrib[rng.choice(list(element.attrib))]
    elif what == "drop" and element is not root:
        element.getparent().remove(element)
    elif what == "double" and element is not root:
        element.addnext(copy.deepcopy(element))
    elif what == "move":
        element.append(copy.deepcopy(other))
    return bytes(etree.tostring(root))

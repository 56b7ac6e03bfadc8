"""The tables name everything that the standards' schemas have, and nothing else; each line has a test that exists.

That something is without effect is shown here: it is put into, or taken out of, documents that have all elements, and
what comes of these is the same.
"""

from __future__ import annotations

import ast
import io
import zipfile
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree

import fmus
from adcs import read_ssp, run
from orchestration.fmu.file import open_fmu
from orchestration.fmu.ranges import declared_ranges
from orchestration.running.method import method_of
from orchestration.single import single
from orchestration.ssp import archive

from .__main__ import PAGE, page
from .schemas import ITSELF, STANDARDS, attributes
from .small import XML
from .table import DOES, HERE, rows
from .tried import TRIED

HERSELF = "standards/test_standards.py::test_without_effect"
DOCUMENTS = HERE / "documents"
MEMBERS = {
    "fmi2": {"fmi2.xml": XML},
    "fmi3": {
        "fmi3.xml": XML,
        "terminalsAndIcons.xml": "terminalsAndIcons/terminalsAndIcons.xml",
        "buildDescription.xml": "sources/buildDescription.xml",
    },
    **{
        f"ssp{n}": {
            f"ssp{n}.ssd": "SystemStructure.ssd",
            f"ssp{n}.ssv": "resources/values.ssv",
            f"ssp{n}.ssm": "resources/mapping.ssm",
            f"ssp{n}.ssb": "resources/signals.ssb",
        }
        for n in "12"
    },
}
"""The documents that have all elements of a standard, and where they stand in an FMU or a package."""

OTHER = {
    **dict.fromkeys(("needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess", "intermediateUpdate"), "true"),
    **dict.fromkeys(("canGetAndSetFMUstate", "canGetAndSetFMUState", "canNotUseMemoryManagementFunctions"), "true"),
    **dict.fromkeys(("canSerializeFMUstate", "canSerializeFMUState", "canInterpolateInputs"), "true"),
    **dict.fromkeys(("providesDirectionalDerivatives", "providesAdjointDerivatives"), "true"),
    **dict.fromkeys(("providesPerElementDependencies", "providesEvaluateDiscreteStates"), "true"),
    **dict.fromkeys(("canReturnEarlyAfterIntermediateUpdate", "canBeDeactivated", "unbounded", "reinit"), "true"),
    **dict.fromkeys(("optional", "external", "iconFlip", "iconFixedAspectRatio", "supportsFraction"), "true"),
    **dict.fromkeys(("maxOutputDerivativeOrder", "recommendedIntermediateInputSmoothness", "priority"), "3"),
    **dict.fromkeys(("resolution", "intervalCounter", "shiftCounter"), "3"),
    **dict.fromkeys(("tolerance", "x", "y", "x1", "y1", "x2", "y2", "rotation", "iconRotation"), "0.25"),
    **dict.fromkeys(("systemInnerX", "systemInnerY", "intervalDecimal", "shiftDecimal"), "0.25"),
    **dict.fromkeys(("suggestedScalingFactorTo_mm", "defaultConnectionStrokeSize"), "0.25"),
    **dict.fromkeys(("pointsX", "pointsY"), "1 3"),
    "defaultConnectionColor": "1 2 3",
    "generationDateAndTime": "2001-02-03T04:05:06Z",
    "dependenciesKind": "constant",
    "dependencies": "1",
    "previous": "1",
    "clocks": "16",
    "intervalVariability": "fixed",
    "variableKind": "inflow",
    "fmiVersion": "3.0.1",
    "version": "1.0-other",
    "sourceBase": "resource",
    "kind": "quality",
    "role": "suitability",
    "sizeConnector": "size",
}
"""A value of each attribute that is none that the documents have; of all others, any text will do."""

NOT_EVERYWHERE = (ITSELF, "previous", "clocks")
"""Elements, and attributes that not every variable may have."""


def existing(standard: str) -> set[tuple[str, str]]:
    return {(element, name) for element, names in attributes(standard).items() for name in names}


@pytest.mark.parametrize("standard", STANDARDS)
def test_the_table_has_every_element_and_attribute_once(standard):
    counted = Counter(pair for row in rows(standard) for pair in row.pairs)
    assert sorted(existing(standard) - set(counted)) == []
    assert sorted(set(counted) - existing(standard)) == []
    assert [pair for pair, number in counted.items() if number > 1] == []


@pytest.mark.parametrize("standard", STANDARDS)
def test_the_walk_finds_what_is_known_to_be_there(standard):
    """So that a walk that finds nothing cannot pass."""
    pairs = existing(standard)
    if standard == "fmi2":
        assert ("ScalarVariable/Real", "relativeQuantity") in pairs
        assert len(pairs) == 148
    elif standard == "fmi3":
        assert {("Enumeration", "declaredType"), ("Clock", "shiftCounter"), ("DisplayUnit", "inverse")} <= pairs
        assert len(pairs) == 533
    else:
        assert ("ssd:Connection", "suppressUnitConversion") in pairs
        assert (("ssd:Connection", "startIndices") in pairs) == (standard == "ssp2")
        assert len(pairs) == (216 if standard == "ssp1" else 291)


@cache
def functions(file: Path) -> set[str]:
    """The tests in a file, those of classes as `Class::test`."""
    found = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.ClassDef):
            found |= {f"{node.name}::{inner.name}" for inner in node.body if isinstance(inner, ast.FunctionDef)}
    return found


@pytest.mark.parametrize("standard", STANDARDS)
def test_every_line_has_a_word_a_reason_and_a_test(standard):
    for row in rows(standard):
        assert row.what in DOES, row
        file, _, name = row.test.partition("::")
        assert name in functions(HERE.parent / file), row
        assert (row.test == HERSELF) == (row.what == "without effect"), row
        assert row.why, row


def test_what_was_tried_has_tests():
    for what, test in TRIED:
        file, _, name = test.partition("::")
        assert name in functions(HERE.parent / file), what


def test_the_page_is_that_of_the_tables():
    assert PAGE.read_text(encoding="utf-8") == page(), "run python -m tests.standards"


WITHOUT = [
    (standard, element, name)
    for standard in STANDARDS
    for row in rows(standard)
    if row.what == "without effect"
    for element, name in row.pairs
]


@cache
def document(name: str) -> bytes:
    return (DOCUMENTS / name).read_bytes()


def place(root: etree._Element, name: str) -> etree._Element | None:
    """Find an element by its name in the tables."""
    wanted = name.split("/")
    known = {uri: f"{prefix}:" for prefix, uri in root.nsmap.items() if prefix}
    for element in root.iter(etree.Element):
        way = [element, *element.iterancestors()]
        tags = [f"{known.get(etree.QName(e).namespace, '')}{etree.QName(e).localname}" for e in way]
        if tags[: len(wanted)] == wanted[::-1]:
            return element
    return None


def changed(standard: str, *pairs: tuple[str, str]) -> dict[str, bytes]:
    """The documents of a standard with these attributes at other values, and without these elements."""
    roots = {member: etree.fromstring(document(file)) for file, member in MEMBERS[standard].items()}
    for element, name in pairs:
        member, there = next((m, found) for m, r in roots.items() if (found := place(r, element)) is not None)
        if name != ITSELF:
            value = OTHER.get(name, "other")
            assert there.get(name) != value
            there.set(name, value)
        elif there.getparent() is None:
            del roots[member]
        else:
            there.getparent().remove(there)
    return {member: etree.tostring(root) for member, root in roots.items()}


def packed(path: Path, standard: str, contents: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as zipped:
        for member, content in contents.items():
            zipped.writestr(member, content)
        if standard.startswith("ssp"):
            for name in ("fmi2", "fmi3"):
                zipped.writestr(f"resources/{name}.fmu", fmu_bytes(name))
    return path


@cache
def fmu_bytes(name: str) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as zipped:
        zipped.writestr(XML, document(f"{name}.xml"))
    return buffer.getvalue()


def facts(standard: str, path: Path) -> Any:
    """What is known of an FMU, or of a package, once it is opened."""
    if standard.startswith("ssp"):
        file = read_ssp(path)
        components = [(c.name, c.fmu.sha256, dict(c.start), c.every) for c in file.system.components.values()]
        return (
            *(file.version, file.start_time, file.stop_time, file.step, file.system.name, file.system.description),
            *(components, file.system.connections),
        )
    fmu = open_fmu(path)
    return (
        *(dict(fmu.ports), fmu.states, fmu.directional, fmu.clocks, dict(fmu.clocked), dict(fmu.display_units)),
        *(declared_ranges(fmu), {v.name: v.nominal for v in fmu.model.modelVariables}),
        {node: (sorted(fmu.feedthrough(node)), sorted(fmu.initial_feedthrough(node))) for node in fmu.nodes},
    )


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(archive, "CACHE", folder / "cache")
        yield {s: facts(s, packed(folder / f"{s}.zip", s, changed(s))) for s in STANDARDS}


def differing(
    standard: str, pairs: list[tuple[str, str]], expected: Any, folder: Path
) -> Iterator[tuple[str, str] | tuple[str, str, str]]:
    """Say which of the changes make a difference: all at once, and where they do, each half of them."""
    path = packed(
        folder / f"{len(pairs)}-{'-'.join(pairs[0])}.zip".replace("/", "-"), standard, changed(standard, *pairs)
    )
    try:
        if facts(standard, path) == expected:
            return
        more: tuple[str, ...] = ()
    except Exception as error:  # which is an effect, too
        more = (str(error),)
    if len(pairs) == 1:
        yield *pairs[0], *more  # type: ignore[misc]
        return
    middle = len(pairs) // 2
    for half in (pairs[:middle], pairs[middle:]):
        yield from differing(standard, half, expected, folder)


@pytest.mark.parametrize("standard", STANDARDS)
def test_without_effect(standard, reference, tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "CACHE", tmp_path / "cache")
    pairs = [(element, name) for other, element, name in WITHOUT if other == standard]
    set_, taken_out = ([p for p in pairs if (p[1] == ITSELF) == out] for out in (False, True))
    assert list(differing(standard, set_, reference[standard], tmp_path)) == []
    for pair in taken_out:  # one by one, as some are inside of others
        assert list(differing(standard, [pair], reference[standard], tmp_path)) == []


@pytest.mark.parametrize("standard", STANDARDS)
def test_the_documents_have_every_element_that_is_not_refused(standard):
    refused = {element for row in rows(standard) if row.what == "refused" for element in row.elements}
    roots = [etree.fromstring(document(file)) for file in MEMBERS[standard]]
    missing = [name for name in attributes(standard) if not any(place(root, name) is not None for root in roots)]
    assert set(missing) <= refused, missing


@pytest.mark.parametrize(
    ("standard", "element", "name"),
    [("fmi2", "ScalarVariable/Real", "unit"), ("fmi3", "Clock", "shiftDecimal"), ("ssp2", "ssv:Real", "value")],
)
def test_that_an_effect_would_be_seen(standard, element, name, reference, tmp_path, monkeypatch):
    monkeypatch.setattr(archive, "CACHE", tmp_path / "cache")
    other = {"unit": "degF", "value": "77"}.get(name, "0.25")
    monkeypatch.setitem(OTHER, name, other)
    path = packed(tmp_path / "x.zip", standard, changed(standard, (element, name)))
    assert facts(standard, path) != reference[standard]
    pairs = [("DisplayUnit", "name"), (element, name)] if standard == "fmi2" else [(element, name)]
    assert list(differing(standard, pairs, reference[standard], tmp_path)) == pairs


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("method", ["co-simulation", "model-exchange"])
def test_a_run_is_the_same_with_all_that_is_without_effect(version, method, tmp_path):
    """A built FMU, every element of whose description has all attributes without effect at once."""
    source = fmus.fmu_path("RigidBody", version)
    standard = "fmi2" if version == "2.0" else "fmi3"
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(tmp_path / source.name, "w") as new:
        for member in old.namelist():
            content = old.read(member)
            if member == XML:
                root = etree.fromstring(content)
                count = 0
                for _, element, name in (w for w in WITHOUT if w[0] == standard and w[2] not in NOT_EVERYWHERE):
                    there = place(root, element)
                    if there is not None:
                        known = len(there.get("dependencies", "").split())  # each has a kind
                        there.set(name, " ".join(["constant"] * known) if "Kind" in name else OTHER.get(name, "other"))
                        count += 1
                assert count > 15
                content = etree.tostring(root)
            new.writestr(member, content)
    one, other = (
        run(
            single(path),
            stop_time=0.3,
            step=0.1,
            method=method_of(method),
        )
        for path in (source, tmp_path / source.name)
    )
    assert np.array_equal(one.data, other.data)

"""FMUs and SSP files: damaged bytes, odd members, and documents that are not as they should be."""

from __future__ import annotations

import importlib
import io
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fmus
from adcs import System, read_ssp, write_ssp
from fmus.xml import parse
from orchestration.fmu.file import extracted, open_fmu
from orchestration.single import single
from orchestration.ssp import archive as ssp_archive

from .strategies import damaged, odd_archives, xml_damaged, zip_damaged
from .tries import attempt

pytestmark = pytest.mark.filterwarnings("ignore:Duplicate name")
VERSIONS = ("2.0", "3.0")
NAMES = ("RigidBody", "StarTracker")
XML = "modelDescription.xml"


def description(name: str, version: str) -> bytes:
    with zipfile.ZipFile(fmus.fmu_path(name, version)) as archive:
        return archive.read(XML)


def packed(members: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return buffer.getvalue()


MEMBERS = {XML: description("StarTracker", "2.0"), "binaries/linux64/StarTracker.so": b"\x7fELF" + bytes(500)}
FMU = packed(MEMBERS)
DESCRIPTIONS = [description(name, version) for name in NAMES for version in VERSIONS]


def taken(path: Path) -> None:
    """Do with an FMU what is done before it is run."""
    fmu = open_fmu(path)
    for node in fmu.nodes:
        list(fmu.feedthrough(node))
        list(fmu.initial_feedthrough(node))
    single(path)


def unpacked(path: Path) -> None:
    """And unpack it."""
    taken(path)
    with extracted(open_fmu(path), "co-simulation"):
        pass


@given(st.data())
def test_archives_with_damaged_bytes(place: Path, data: st.DataObject) -> None:
    content = data.draw(damaged(FMU) | zip_damaged(FMU))
    (place / "damaged.fmu").write_bytes(content)
    attempt("FMU: damaged archive", lambda: unpacked(place / "damaged.fmu"), len(content))


@given(st.data())
def test_archives_with_odd_members(place: Path, data: st.DataObject) -> None:
    content = data.draw(odd_archives(MEMBERS))
    (place / "odd.fmu").write_bytes(content)
    attempt("FMU: odd members", lambda: unpacked(place / "odd.fmu"), len(content))


@given(st.data())
def test_descriptions_that_are_not_as_they_should_be(place: Path, data: st.DataObject) -> None:
    xml = data.draw(st.sampled_from(DESCRIPTIONS).flatmap(xml_damaged))
    path = place / "described.fmu"
    path.write_bytes(packed({**MEMBERS, XML: xml}))
    attempt("FMU: modelDescription.xml", lambda: taken(path), len(xml))


@given(st.data())
def test_checks_of_anything(place: Path, data: st.DataObject) -> None:
    with pytest.MonkeyPatch.context() as patch:  # what it does when it is loaded has a process of its own
        patch.setattr(importlib.import_module("fmus.check"), "check_behaviour", lambda path: iter(()))
        xml = data.draw(st.sampled_from(DESCRIPTIONS).flatmap(xml_damaged))
        content = data.draw(
            st.just(packed({**MEMBERS, XML: xml})) | damaged(FMU) | zip_damaged(FMU) | odd_archives(MEMBERS)
        )
        (place / "checked.fmu").write_bytes(content)
        came, findings = attempt("adcs check", lambda: fmus.check(place / "checked.fmu"), len(content))
    assert came, "checks never refuse, they find"
    assert all("\n" not in finding.message for finding in findings)


@given(st.sampled_from(DESCRIPTIONS).flatmap(xml_damaged) | st.binary(max_size=200))
def test_documents(content: bytes) -> None:
    attempt("XML", lambda: parse(content, "x.xml"), len(content))


NAMESPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in (
        *(("ssc", "Common"), ("ssd", "Description")),
        *(("ssv", "ParameterValues"), ("ssm", "ParameterMapping")),
    )
)
SSV = (
    f'<ssv:ParameterSet {NAMESPACES} version="1.0" name="set"><ssv:Parameters>'
    '<ssv:Parameter name="wide"><ssv:Real value="3" unit="deg"/></ssv:Parameter>'
    '<ssv:Parameter name="seed"><ssv:Integer value="4"/></ssv:Parameter></ssv:Parameters>'
    '<ssv:Units><ssc:Unit name="deg"><ssc:BaseUnit rad="1" factor="0.017453292519943295"/></ssc:Unit></ssv:Units>'
    "</ssv:ParameterSet>"
).encode()
SSM = (
    f'<ssm:ParameterMapping {NAMESPACES} version="1.0"><ssm:MappingEntry source="wide" target="half_angle">'
    '<ssc:LinearTransformation factor="0.5" offset="0"/></ssm:MappingEntry>'
    '<ssm:MappingEntry source="seed" target="seed"/></ssm:ParameterMapping>'
).encode()


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The members of an `.ssp` with a file of parameters and one of a mapping; its FMUs have no binaries."""
    folder = tmp_path_factory.mktemp("package")
    for name in NAMES:
        (folder / f"{name}.fmu").write_bytes(packed({XML: description(name, "2.0")}))
    system = System("two", "a body and what sees it")
    system.add("plant", folder / "RigidBody.fmu", {"torque_B": [1.0, 2.0, 3.0], "torque_disturbance_B": [0.0] * 3})
    system.add("bus/tracker", folder / "StarTracker.fmu", every=2)
    for i in range(1, 5):
        system.connect(f"plant.q_BN[{i}]", f"bus/tracker.q_BN[{i}]")
    write_ssp(system, folder / "two.ssp", stop_time=1.0, step=0.1)
    with zipfile.ZipFile(folder / "two.ssp") as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    binding = (
        b'<ssd:ParameterBinding source="resources/x.ssv"><ssd:ParameterMapping source="resources/x.ssm"/>'
        b"</ssd:ParameterBinding></ssd:ParameterBindings>"
    )
    ssd = members["SystemStructure.ssd"]
    tracker = ssd.index(b'name="tracker"')
    bound = ssd.find(b"</ssd:ParameterBindings>", tracker)
    if bound < 0:
        geometry = ssd.index(b"<ssd:ElementGeometry", tracker)
        end = ssd.index(b">", geometry) + 1
        ssd = ssd[:end] + b"<ssd:ParameterBindings>" + binding + ssd[end:]
    else:
        ssd = ssd[:bound] + binding + ssd[bound + len(b"</ssd:ParameterBindings>") :]
    return {**members, "SystemStructure.ssd": ssd, "resources/x.ssv": SSV, "resources/x.ssm": SSM}


@pytest.fixture(autouse=True)
def cache(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ssp_archive, "CACHE", place / "cache")


def read(path: Path, members: dict[str, bytes], kind: str) -> Any:
    content = packed(members)
    path.write_bytes(content)
    return attempt(f"SSP: {kind}", lambda: read_ssp(path), len(content))


def test_the_package_is_read_as_long_as_it_is_whole(place: Path, package: dict[str, bytes]) -> None:
    came, file = read(place / "whole.ssp", package, "whole")
    assert came, file
    start = file.system.components["bus/tracker"].start
    assert start["half_angle"] == (3 * 0.017453292519943295 * 0.5,)
    assert start["seed"] == (4,)


@given(st.data())
@pytest.mark.parametrize("kind", ["ssd", "ssv", "ssm"])
def test_documents_of_ssp(place: Path, package: dict[str, bytes], kind: str, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from([name for name in package if name.endswith(kind)]))
    read(place / f"{kind}.ssp", {**package, name: data.draw(xml_damaged(package[name]))}, f".{kind}")


@given(st.data())
def test_archives_of_ssp(place: Path, package: dict[str, bytes], data: st.DataObject) -> None:
    content = data.draw(damaged(packed(package)) | zip_damaged(packed(package)) | odd_archives(package))
    (place / "archive.ssp").write_bytes(content)
    attempt("SSP: archive", lambda: read_ssp(place / "archive.ssp"), len(content))


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3), st.integers(0, 2**31 - 1))
def test_start_values_come_back_from_ssp_to_the_last_bit(place: Path, torque: list[float], seed: int) -> None:
    folder = place / "written"
    folder.mkdir(exist_ok=True)
    for name in NAMES:
        (folder / f"{name}.fmu").write_bytes(packed({XML: description(name, "2.0")}))
    system = System("back")
    system.add("plant", folder / "RigidBody.fmu", {"torque_B": torque, "torque_disturbance_B": torque})
    system.add("tracker", folder / "StarTracker.fmu", {"seed": seed, "q_BN": [1.0, 0.0, 0.0, 0.0]})
    write_ssp(system, folder / "back.ssp", force=True)
    found = read_ssp(folder / "back.ssp").system.components
    assert list(map(float.hex, found["plant"].start["torque_B"])) == list(map(float.hex, torque))
    assert found["tracker"].start["seed"] == (seed,)

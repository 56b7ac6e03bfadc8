"""Archives that are made to do harm, or only made badly: refused in one line, before anything is unpacked."""

from __future__ import annotations

import os
import re
import resource
import struct
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

import fmus
from adcs import AdcsError, System, run
from orchestration.fmu.file import open_fmu

XML = "modelDescription.xml"
BINARY = "binaries/linux64/gain.so"


@pytest.fixture
def content(mock: Callable[..., Path]) -> dict[str, bytes]:
    with zipfile.ZipFile(mock("gain")) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(path: Path, files: dict[str, bytes], *, how: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", how) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def refused(path: Path) -> str:
    """The one line, the same from `adcs check`, in no time and no memory."""
    began, before = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(AdcsError) as error:
        open_fmu(path)
    assert time.process_time() - began < 2
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # kB
    assert len(str(error.value).splitlines()) == 1
    findings = fmus.check(path)
    assert any(finding.severity == "fault" for finding in findings)
    return str(error.value)


def zeros(path: Path, files: dict[str, bytes], member: str, megabytes: int, head: bytes = b"") -> Path:
    """An archive with a member of so many zeros after `head`, a thousandth of it in size."""
    packed(path, {name: data for name, data in files.items() if name != member})
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open(member, "w", force_zip64=True) as file,
    ):
        file.write(head)
        for _ in range(megabytes):
            file.write(bytes(1 << 20))
    return path


def test_bombs(tmp_path: Path, content: dict[str, bytes]) -> None:
    path = zeros(tmp_path / "bomb.fmu", content, "resources/zeros", 600)
    size = path.stat().st_size
    assert size < 4e6
    expected = rf"bomb\.fmu has {size:,} bytes and would have 6\d\d,\d+,\d+ unpacked: refused, as a zip bomb is so$"
    assert re.search(expected, refused(path))
    path = zeros(tmp_path / "xml.fmu", content, XML, 80, content[XML])
    assert "xml.fmu: 'modelDescription.xml' has 83," in refused(path)


def test_what_only_packs_well_is_taken(tmp_path: Path, content: dict[str, bytes]) -> None:
    path = zeros(tmp_path / "table.fmu", content, "resources/table", 50)
    system = System("table")
    system.add("gain", path, {"u": [1.0, 2.0, 3.0], "k": 2.0})
    assert run(system, stop_time=1, step=1)["gain.y"][-1].tolist() == [2.0, 4.0, 6.0]


DOCTYPE = '<!DOCTYPE x [<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 12))
DOCUMENTS = {
    "entities": (lambda xml: xml.replace("?>", f"?>{DOCTYPE}]>", 1), "has a document type declaration, which FMI and"),
    "a file": (
        lambda xml: xml.replace("?>", '?><!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>', 1),
        "has a document type declaration",
    ),
    "hidden": (lambda xml: '<?xml version="1.0" encoding="UTF-7"?>+ADwAIQ-DOCTYPE x+AD4-', "is in utf-7, expected"),
    "deep": (
        lambda xml: xml.replace("<ModelVariables>", "<a>" * 100_000 + "<ModelVariables>"),
        "has elements nested more than",
    ),
    "nonsense": (lambda xml: "\0\1 nonsense", "is not well-formed XML"),
    "nothing": (lambda xml: "", "is not well-formed XML"),
    "not what it says": (lambda xml: xml.replace("UTF-8", "UTF-16"), "is not in UTF-16 as it says"),
    "an index beyond all": (
        lambda xml: re.sub(r'<Unknown index="\d+"', '<Unknown index="4000000000"', xml, count=1),
        "no variable has the index 4000000000",
    ),
    "a derivative of nothing": (
        lambda xml: xml.replace("</Outputs>", '</Outputs><Derivatives><Unknown index="1"/></Derivatives>'),
        "u[1] is said to be a derivative, but of none",
    ),
    "a name twice": (lambda xml: xml.replace('name="u[2]"', 'name="u[1]"'), "is not valid"),
    "a negative reference": (lambda xml: xml.replace('valueReference="1"', 'valueReference="-1"'), "is not valid"),
    "a number that is none": (lambda xml: re.sub(r' start="[^"]*"', ' start="x"', xml, count=1), "is not valid"),
}


@pytest.mark.parametrize("case", DOCUMENTS)
def test_documents(tmp_path: Path, content: dict[str, bytes], case: str) -> None:
    edit, message = DOCUMENTS[case]
    before = content[XML].decode()
    assert edit(before) != before
    path = packed(tmp_path / "document.fmu", {**content, XML: edit(before).encode()})
    assert message in refused(path)


def test_an_element_far_out_is_a_name_and_no_array(tmp_path: Path, content: dict[str, bytes]) -> None:
    xml = content[XML].replace(b'name="u[3]"', b'name="u[4000000000]"')
    ports = open_fmu(packed(tmp_path / "far.fmu", {**content, XML: xml})).ports
    assert [name for name in ports if name.startswith("u")] == ["u[1]", "u[2]", "u[4000000000]"]
    system = System("far")
    system.add("gain", packed(tmp_path / "gain.fmu", content))
    with pytest.raises(
        AdcsError, match=r"^gain\.u\[4000000000\] does not exist: gain\.u has 3 values, counted from 1$"
    ):
        system.end("gain.u[4000000000]")


def test_arrays_of_fmi_3_that_nothing_can_hold(tmp_path: Path, mock: Callable[..., Path]) -> None:
    with zipfile.ZipFile(mock("gain", "3.0")) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    xml = content[XML].replace(b'<Dimension start="3"/>', b'<Dimension start="4000000000"/>', 1)
    message = refused(packed(tmp_path / "wide.fmu", {**content, XML: xml}))
    assert message.endswith(" has 4,000,000,000 elements, more than 1,000,000: not supported")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "iso-8859-1"])
def test_other_encodings_are_read(tmp_path: Path, content: dict[str, bytes], encoding: str) -> None:
    declared = {"utf-8-sig": "UTF-8"}.get(encoding, encoding.upper())
    xml = content[XML].decode().replace("UTF-8", declared).replace('description="', 'description="ä ', 1)
    fmu = open_fmu(packed(tmp_path / "encoded.fmu", {**content, XML: xml.encode(encoding)}))
    assert "ä" in (fmu.model.description or "") + "".join(port.description for port in fmu.ports.values())


@pytest.mark.parametrize("name", ["../evil", "/evil", "a/../../evil", "..\\evil", "C:/evil", "resources/../../evil"])
def test_ways_out(tmp_path: Path, content: dict[str, bytes], name: str) -> None:
    path = packed(tmp_path / "slip.fmu", {**content, name: b"x"})
    assert f"slip.fmu holds the path {name!r} that leads outside the archive: refused" in refused(path)
    assert not (tmp_path.parent / "evil").exists()


def test_links(tmp_path: Path, content: dict[str, bytes]) -> None:
    path = packed(tmp_path / "link.fmu", content)
    with zipfile.ZipFile(path, "a") as archive:
        link = zipfile.ZipInfo("resources/link")
        link.external_attr = 0o120777 << 16
        archive.writestr(link, "/etc")
        archive.writestr("resources/link/evil", "x")
    assert "link.fmu: 'resources/link' is a link: pack what it leads to" in refused(path)


def test_a_member_that_is_there_twice(tmp_path: Path, content: dict[str, bytes]) -> None:
    path = packed(tmp_path / "twice.fmu", content)
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr(XML, b"<x/>")
    assert "twice.fmu holds 'modelDescription.xml' 2 times: pack it once" in refused(path)


@pytest.mark.parametrize(("how", "name"), [(zipfile.ZIP_BZIP2, "bzip2"), (zipfile.ZIP_LZMA, "lzma")])
def test_other_methods(tmp_path: Path, content: dict[str, bytes], how: int, name: str) -> None:
    path = packed(tmp_path / "method.fmu", content, how=how)
    assert f"is packed by {name}: only deflate is read, pack it so" in refused(path)


@pytest.mark.parametrize("flag", [0x1, 0x41, 0x2000])
def test_encryption(tmp_path: Path, content: dict[str, bytes], flag: int) -> None:
    path = packed(tmp_path / "secret.fmu", content)
    data = bytearray(path.read_bytes())
    struct.pack_into("<H", data, data.index(b"PK\1\2") + 8, flag)
    path.write_bytes(data)
    assert "is encrypted: pack it without" in refused(path)


def test_a_path_with_a_line_break(tmp_path: Path, content: dict[str, bytes]) -> None:
    assert "odd name.fmu holds the path '../x' that" in refused(
        packed(tmp_path / "odd\nname.fmu", {**content, "../x": b""})
    )


def test_what_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "folder.fmu").mkdir()
    os.mkfifo(tmp_path / "pipe.fmu")
    for name in ("folder", "pipe"):
        with pytest.raises(AdcsError, match=rf"^cannot open .*{name}\.fmu: it is no file$"):
            open_fmu(tmp_path / f"{name}.fmu")

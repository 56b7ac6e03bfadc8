"""Reading FMUs: one line says what is wrong with a file; variables come as arrays in both FMI versions."""

import zipfile
from pathlib import Path

import fmpy
import pytest

from adcs import AdcsError, System, run
from fmus.xml import parse
from orchestration.fmu.file import extracted, locate, open_fmu


def edited(source: Path, target: Path, *, drop: str = "", add: str = "", xml: tuple[str, str] | None = None) -> Path:
    """Copy an FMU without members that start with `drop`, with the member `add`, with a text replaced in the XML."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            if not (drop and name.startswith(drop)):
                content = old.read(name)
                if xml and name == "modelDescription.xml":
                    assert xml[0].encode() in content
                    content = content.replace(xml[0].encode(), xml[1].encode())
                new.writestr(name, content)
        if add:
            new.writestr(add, "")
    return target


def refused(path: Path) -> str:
    with pytest.raises(AdcsError) as error:
        open_fmu(path)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_missing_file(tmp_path):
    assert refused(tmp_path / "none.fmu") == f"cannot open {tmp_path / 'none.fmu'}: No such file or directory"


def test_not_a_zip_archive(tmp_path):
    path = tmp_path / "text.fmu"
    path.write_text("this is no archive")
    assert "text.fmu is not a readable zip archive (File is not a zip file)" in refused(path)


def test_truncated_archive(mock, tmp_path):
    path = tmp_path / "half.fmu"
    content = mock("gain").read_bytes()
    path.write_bytes(content[: len(content) // 2])
    assert "half.fmu is not a readable zip archive" in refused(path)


def test_corrupt_member(mock, tmp_path):
    path = tmp_path / "flipped.fmu"
    content = bytearray(mock("gain").read_bytes())
    with zipfile.ZipFile(mock("gain")) as archive:
        info = archive.getinfo(next(n for n in archive.namelist() if n.startswith("binaries/")))
    content[info.header_offset + 2000] ^= 0xFF
    path.write_bytes(content)
    system = System("flipped")
    system.add("gain", path, {"u": [0, 0, 0]})
    with pytest.raises(AdcsError, match=r"flipped\.fmu cannot be extracted \(Bad CRC-32 .*build or download it again"):
        run(system, stop_time=1, step=1)


def test_paths_outside_the_archive(mock, tmp_path):
    for i, name in enumerate(("../evil.txt", "/etc/evil", "a/../../evil", "C:/evil", "a\\evil")):
        path = edited(mock("gain"), tmp_path / f"{i}.fmu", add=name)
        assert f"holds the path {name!r} that leads outside the archive: refused" in refused(path)


def test_no_model_description(mock, tmp_path):
    path = edited(mock("gain"), tmp_path / "bare.fmu", drop="modelDescription.xml")
    assert refused(path) == f"{path} has no modelDescription.xml: it is no FMU"


def test_invalid_model_description(mock, tmp_path):
    path = edited(mock("gain"), tmp_path / "invalid.fmu", xml=('causality="input"', 'causality="inward"'))
    assert "invalid.fmu is not valid: " in refused(path)
    assert "inward" in refused(path)


def test_malformed_xml(mock, tmp_path):
    path = edited(mock("gain"), tmp_path / "malformed.fmu", xml=("</fmiModelDescription>", ""))
    assert f"modelDescription.xml of {path} is not well-formed XML" in refused(path)


@pytest.mark.parametrize(
    ("inside", "limit"),
    [
        ("<a>" * 300 + "</a>" * 300, "elements nested more than 256 deep"),
        (f"<a>{'x' * 10_100_000}</a>", "a text, name or attribute of more than 10 MB"),
        (f"<!--{'x' * 10_100_000}-->", "a comment, instruction or CDATA section of more than 10 MB"),
        (f"<{'a' * 60_000}/>", "a name of more than 50000 bytes"),
    ],
)
def test_xml_beyond_a_limit_of_its_parser(inside, limit):
    """The parser's own words advise an option that nobody can set here."""
    with pytest.raises(AdcsError) as error:
        parse(f"<r>{inside}</r>".encode(), "a.xml")
    assert str(error.value) == f"a.xml has {limit}: refused, make it smaller"


def test_no_binary_for_this_platform(mock, version, tmp_path):
    path = edited(
        mock("source", version), tmp_path / "foreign.fmu", drop="binaries/", add="binaries/vax-vms/source.exe"
    )
    system = System("foreign")
    system.add("source", path)
    with pytest.raises(AdcsError, match=r"foreign\.fmu has no binary for this platform .* it has: vax-vms\)"):
        run(system, stop_time=1, step=1)


def test_wrong_token(mock, version, tmp_path):
    path = edited(mock("source", version), tmp_path / "token.fmu", xml=("{mock}", "{other}"))
    system = System("token")
    system.add("source", path)
    with pytest.raises(AdcsError, match=r"source: cannot instantiate token\.fmu: the token is wrong"):
        run(system, stop_time=1, step=1)


def test_binary_without_fmi_functions(mock, tmp_path):
    path = edited(mock("source"), tmp_path / "hollow.fmu", drop="binaries/")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(f"binaries/{fmpy.platform}/source{fmpy.sharedLibraryExtension}", b"not a library")
    system = System("hollow")
    system.add("source", path)
    with pytest.raises(AdcsError, match=r"source: cannot instantiate hollow\.fmu: Failed to load shared library"):
        run(system, stop_time=1, step=1)


def test_missing_interface(mock, tmp_path):
    path = edited(
        mock("source"),
        tmp_path / "me.fmu",
        xml=('<CoSimulation modelIdentifier="source" canHandleVariableCommunicationStepSize="true"/>', ""),
    )
    system = System("me")
    system.add("source", path)
    with pytest.raises(
        AdcsError, match=r"me\.fmu has no co-simulation interface: run the system with method 'model-exch"
    ):
        run(system, stop_time=1, step=1)


def test_a_component_that_there_is_not():
    with pytest.raises(
        AdcsError, match=r"^no component is called Xyzzy: `adcs list` shows all, or give the path of an \.fmu$"
    ):
        locate("Xyzzy")


def test_a_component_that_is_misspelt():
    with pytest.raises(
        AdcsError, match=r"no component is called RigidBdy: did you mean RigidBody or OrbitingBody\? Or give"
    ):
        System("s").add("p", "RigidBdy")


def test_ports_are_the_same_arrays_in_both_versions(mock):
    two, three = (open_fmu(mock("typed", v)) for v in ("2.0", "3.0"))
    assert two.ports["matrix"].shape == three.ports["matrix"].shape == (2, 3)
    assert two.ports["matrix"].references == (2, 3, 4, 5, 6, 7)
    assert three.ports["matrix"].references == (2,)
    assert two.ports["matrix"].elements[:4] == ["matrix[1,1]", "matrix[1,2]", "matrix[1,3]", "matrix[2,1]"]
    assert two.ports["matrix"].start == three.ports["matrix"].start == (0.0,) * 6
    for name, kind in {"n": "Int32", "flag": "Boolean", "matrix": "Float64", "y": "Float64", "whole": "Int32"}.items():
        assert two.ports[name].type == three.ports[name].type == kind
    assert two.ports["flag"].start == three.ports["flag"].start == (False,)


def feedthrough(fmu):
    """The inputs on which some element of each output depends directly."""
    outputs = [port for port in fmu.ports.values() if port.causality == "output"]
    return {p.name: {fmu.nodes[i][0].name for node in fmu.nodes.of(p) for i in fmu.feedthrough(node)} for p in outputs}


def test_units_states_and_dependencies(mock, version):
    integrator = open_fmu(mock("integrator", version))
    assert integrator.ports["u"].unit == "m/s"
    assert integrator.ports["y"].description == "y of integrator"
    assert integrator.states == ("x[1]", "x[2]", "x[3]")
    assert feedthrough(integrator) == {"y": set()}
    gain = open_fmu(mock("gain", version))
    assert feedthrough(gain) == {"y": {"u"}, "doubled": {"u"}}
    assert list(gain.feedthrough("y[2]" if version == "2.0" else "y")) == ["u[2]" if version == "2.0" else "u"]
    assert gain.states == ()


def test_scalars_that_form_no_array_stay_scalars(mock, tmp_path):
    path = edited(mock("gain"), tmp_path / "odd.fmu", xml=('name="u[2]"', 'name="u[7]"'))
    ports = open_fmu(path).ports
    assert [n for n in ports if n.startswith("u")] == ["u[1]", "u[7]", "u[3]"]
    assert ports["u[7]"].shape == ()
    path = edited(mock("gain"), tmp_path / "taken.fmu", xml=('name="k"', 'name="u"'))
    assert [n for n in open_fmu(path).ports if n.startswith("u")] == ["u[1]", "u[2]", "u[3]", "u"]


def test_left_out_dependencies_mean_all_inputs(mock, tmp_path):
    path = edited(mock("integrator"), tmp_path / "silent.fmu", xml=(' dependencies="1"', ""))
    assert feedthrough(open_fmu(path)) == {"y": {"u"}}


def test_extracted_files_are_removed(mock):
    with extracted(open_fmu(mock("gain")), "co-simulation") as (folder, binary):
        assert binary.is_file()
        assert binary.is_relative_to(folder)
    assert not folder.exists()

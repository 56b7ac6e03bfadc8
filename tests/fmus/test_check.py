"""Each check is shown to catch an FMU that was broken on purpose."""

import importlib
import re
import zipfile

import lief
import pytest

import fmus
from fmus.checks.archive import check_archive
from fmus.checks.binary import check_binary, functions
from fmus.toolchain import TARGETS, compile_step, host, link_step, run_steps

XML = "modelDescription.xml"
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
BODY2, BODY3, TRACKER2, TRACKER3 = "RigidBody.fmu", "RigidBody.fmi3.fmu", "StarTracker.fmu", "StarTracker.fmi3.fmu"


def sub(pattern, replacement):
    return lambda content: re.sub(pattern.encode(), replacement.encode(), content, count=1, flags=re.DOTALL)


def attribute(variable, name, value):
    """Sets an attribute of an FMI 3 variable, or of the type element of an FMI 2 one; None removes it."""

    def edit(content):
        def inside(match):
            element = match[0]
            text = b"" if value is None else f' {name}="{value}"'.encode()
            if re.search(rf' {name}="'.encode(), element):
                return re.sub(rf' {name}="[^"]*"'.encode(), text, element)
            return re.sub(rb"(<(Real|Integer|Float64|Int32)\b[^>/]*)", rb"\1" + text, element)

        named = re.escape(f'name="{variable}"').encode()
        scalar = rb"<ScalarVariable [^>]*" + named + rb".*?</ScalarVariable>"
        array = rb"<(Float64|Int32) [^>]*" + named + rb"[^>]*>"
        return re.sub(scalar if b"<ScalarVariable" in content else array, inside, content, count=1, flags=re.DOTALL)

    return edit


def vr_of(fmu_path, name):
    with zipfile.ZipFile(fmu_path) as archive:
        text = archive.read(XML).decode()
    return re.search(rf'<Float64 name="{re.escape(name)}" valueReference="(\d+)"', text)[1]


def index_of(fmu_path, name):
    with zipfile.ZipFile(fmu_path) as archive:
        names = re.findall(r'<ScalarVariable name="([^"]*)"', archive.read(XML).decode())
    return str(names.index(name) + 1)


@pytest.fixture
def static(monkeypatch):
    """Leaves the FMU's execution out, which takes longest."""
    monkeypatch.setattr(importlib.import_module("fmus.check"), "check_behaviour", lambda path: iter(()))


def found(path, rule):
    return [finding.message for finding in fmus.check(path) if finding.rule == rule]


@pytest.mark.parametrize("fmu", [BODY2, BODY3, TRACKER2, TRACKER3])
def test_nothing_is_wrong_with_what_is_built(built, fmu):
    assert fmus.check(built / fmu) == []


@pytest.mark.parametrize(
    ("fmu", "edit", "message"),
    [
        (BODY2, attribute("q_BN[1]", "start", "nan"), "q_BN[1]: start nan is not finite"),
        (BODY2, attribute("max_internal_step", "start", "-1"), "max_internal_step: start -1 is below min 0.0"),
        (TRACKER2, attribute("half_angle", "start", "2"), "half_angle: start 2 is above max 1.5707963267948966"),
        (TRACKER2, attribute("half_angle", "start", None), "half_angle: start is missing, expected 1 value"),
        (TRACKER2, attribute("half_angle", "unit", "furlong"), "half_angle: unit furlong is not defined"),
        (
            TRACKER2,
            attribute("half_angle", "displayUnit", "gon"),
            "half_angle: display unit gon is not defined for rad",
        ),
        (BODY3, attribute("J_B", "start", "1 2 3"), "J_B: start has 3 values, expected 3 x 3 values"),
        (BODY3, attribute("q_BN", "start", "1 0 0 0 0"), "q_BN: start has 5 values, expected 4 values"),
        (BODY3, attribute("torque_B", "start", None), "torque_B: start is missing, expected 3 values"),
        (TRACKER3, attribute("seed", "start", "-4"), "seed: start -4 is below min 0"),
        (BODY3, attribute("J_B", "unit", "stone"), "J_B: unit stone is not defined"),
    ],
)
def test_starts_and_units(mutate, static, fmu, edit, message):
    assert message in found(mutate(fmu, {XML: edit}), "variables")


def test_one_start_value_for_a_whole_array_is_allowed(mutate, static):
    assert found(mutate(BODY3, {XML: attribute("torque_B", "start", "0")}), "variables") == []


@pytest.mark.parametrize(
    ("target", "what"), [("torque_B[1]", "continuous input"), ("J_B[1,1]", "parameter"), ("der(q_BN[1])", "")]
)
def test_fmi2_derivative_of_no_state(mutate, static, built, target, what):
    edit = attribute("der(q_BN[1])", "derivative", index_of(built / BODY2, target))
    (message,) = found(mutate(BODY2, {XML: edit}), "variables")
    assert message.startswith(f"der(q_BN[1]): is said to be the derivative of {target}, which is a ")
    assert what in message
    assert message.endswith("no continuous state")


def test_fmi3_derivative_of_an_input_and_of_another_shape(mutate, static, built):
    of_input = mutate(BODY3, {XML: attribute("der(q_BN)", "derivative", vr_of(built / BODY3, "torque_B"))})
    assert (
        "der(q_BN): is said to be the derivative of torque_B, which is a continuous input and no continuous state"
        in found(of_input, "variables")
    )
    of_rate = mutate(BODY3, {XML: attribute("der(q_BN)", "derivative", vr_of(built / BODY3, "omega_BN_B"))})
    assert found(of_rate, "variables") == [
        "der(q_BN): is said to be the derivative of omega_BN_B, which has 3 values, not 4 values",
        "omega_BN_B: several variables in the model structure are its derivative",
    ]


def test_fmpy_alone_misses_some_of_these(mutate, static, built):
    """The reason for own checks; if this fails one day, some of them can go."""
    for fmu, edit in (
        (BODY2, attribute("der(q_BN[1])", "derivative", index_of(built / BODY2, "torque_B[1]"))),
        (BODY3, attribute("J_B", "start", "1 2 3")),
        (TRACKER2, attribute("half_angle", "start", "2")),
    ):
        assert found(mutate(fmu, {XML: edit}), "standard") == []


def test_dependencies_on_what_is_not_known(mutate, static, built):
    calculated = index_of(built / BODY2, "der(q_BN[1])")
    output = sub(r'(<Outputs>.*?dependencies=")[^"]*', rf"\g<1>{calculated}")
    (message,) = found(mutate(BODY2, {XML: output}), "dependencies")
    assert "depends during the run on der(q_BN[1]), a local with initial calculated, which is not known then" in message

    at_start = sub(r'(<InitialUnknowns>.*?dependencies=")[^"]*', rf"\g<1>{calculated}")
    (message,) = found(mutate(BODY2, {XML: at_start}), "dependencies")
    assert "depends at the start on der(q_BN[1]), a local with initial calculated" in message


def test_a_parameter_in_a_list_of_dependencies_does_no_harm(mutate, static, built):
    parameter = index_of(built / BODY2, "J_B[1,1]")
    output = sub(r'(<Outputs>.*?dependencies=")[^"]*', rf"\g<1>{parameter}")
    assert found(mutate(BODY2, {XML: output}), "dependencies") == []


def test_a_missing_output_in_the_structure_is_found_by_fmpy(mutate, static):
    edit = sub(r"<Output [^>]*/>\s*", "")
    assert any("ModelStructure/Outputs" in message for message in found(mutate(BODY3, {XML: edit}), "standard"))


def test_the_schema_is_applied(mutate, static):
    edit = sub("<DefaultExperiment", '<DefaultExperiment cost="1"')
    assert any("cost" in message for message in found(mutate(BODY3, {XML: edit}), "standard"))
    edit = sub('matchingRule="plug"', "")
    assert any("matchingRule" in message for message in found(mutate(BODY2, {TERMINALS: edit}), "companions"))
    edit = sub('modelIdentifier="RigidBody"', "")
    path = mutate(BODY2, {"sources/buildDescription.xml": edit})
    assert any("modelIdentifier" in message for message in found(path, "companions"))


def test_a_terminal_of_a_variable_that_is_not_there(mutate, static):
    edit = sub('variableName="q_BN"', 'variableName="q_XX"')
    (message,) = found(mutate(BODY3, {TERMINALS: edit}), "companions")
    assert message.endswith("q_XX is no variable")


def test_xml_that_cannot_be_read(mutate, static):
    path = mutate(BODY2, {XML: lambda content: content[:100]})
    assert any("modelDescription.xml cannot be read" in message for message in found(path, "standard"))


@pytest.mark.parametrize(
    ("edits", "added", "message"),
    [
        ({"documentation/index.html": lambda _: None}, {}, "documentation/index.html is missing"),
        ({"documentation/licenses/license.txt": lambda _: None}, {}, "documentation/licenses/license.txt is missing"),
        ({"terminalsAndIcons/icon.png": lambda _: None}, {}, "terminalsAndIcons/icon.png is missing"),
        ({"sources/fmi/instance.cpp": lambda _: None}, {}, "sources/fmi/instance.cpp is to be compiled, but missing"),
        ({}, {"readme.md": b""}, "readme.md is no part of an FMU"),
        ({}, {"binaries/amiga/RigidBody.so": b""}, "binaries/amiga is no platform: known are "),
        ({}, {"binaries/win64/Other.dll": b""}, "binaries/win64/RigidBody.dll is missing"),
        ({}, {"binaries/win64/RigidBody.pdb": b""}, "binaries/win64/RigidBody.pdb is not expected there"),
    ],
)
def test_layout(mutate, static, edits, added, message):
    assert any(m.startswith(message) for m in found(mutate(BODY2, edits, added), "layout"))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("../evil", "../evil: path leads out of the FMU"),
        ("/etc/evil", "/etc/evil: path leads out of the FMU"),
        ("C:/evil", "C:/evil: path leads out of the FMU"),
        ("extra\\evil", "extra\\evil: path has a backslash"),
        ("extra/bös", "extra/bös: path has characters beyond ASCII"),
    ],
)
def test_unsafe_paths_are_found_and_not_unpacked(mutate, name, message):
    path = mutate(BODY2, added={name: b"evil"})
    findings = fmus.check(path)
    assert message in [finding.message for finding in findings if finding.rule == "archive"]
    assert "behaviour" not in {finding.rule for finding in findings}


def test_archives_that_tools_cannot_read(tmp_path):
    def messages(path):
        with zipfile.ZipFile(path) as archive:
            return list(check_archive(archive))

    twice = tmp_path / "twice.fmu"
    with zipfile.ZipFile(twice, "w") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr("a", "1")
        archive.writestr("a", "2")
    assert messages(twice) == ["a is contained 2 times"]

    packed = tmp_path / "packed.fmu"
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("a", "1")
    assert messages(packed) == ["a: compression method 14, expected 0 (stored) or 8 (deflated)"]

    linked = tmp_path / "linked.fmu"
    with zipfile.ZipFile(linked, "w") as archive:
        entry = zipfile.ZipInfo("a")
        entry.external_attr = 0o120777 << 16
        archive.writestr(entry, "/etc/passwd")
    assert messages(linked) == ["a is a symbolic link"]

    damaged = tmp_path / "damaged.fmu"
    with zipfile.ZipFile(damaged, "w") as archive:
        archive.writestr("a", "content")
    damaged.write_bytes(damaged.read_bytes().replace(b"content", b"c0ntent"))
    assert messages(damaged) == ["a is damaged: its checksum does not fit"]


@pytest.mark.parametrize("content", [b"", b"not a zip"])
def test_no_zip_at_all(tmp_path, content):
    path = tmp_path / "x.fmu"
    path.write_bytes(content)
    (finding,) = fmus.check(path)
    assert finding.rule == "archive"
    assert "is no readable ZIP file" in finding.message
    assert "no readable ZIP file" in fmus.check(tmp_path / "absent.fmu")[0].message


@pytest.mark.parametrize("fmu", [BODY2, BODY3])
def test_a_token_that_is_not_the_binarys(mutate, fmu):
    edit = sub(r'(guid|instantiationToken)="[^"]*"', r'\1="{other}"')
    messages = found(mutate(fmu, {XML: edit}), "behaviour")
    for interface in ("ModelExchange", "CoSimulation"):
        start = f"{interface} cannot be instantiated with the token of the XML, {{other}}"
        assert any(message.startswith(start) for message in messages)


def test_a_start_value_that_is_not_the_binarys(mutate):
    path = mutate(BODY3, {XML: attribute("torque_B", "start", "0 0 7")})
    assert "CoSimulation: torque_B starts at [0.0, 0.0, 0.0], but the XML says [0.0, 0.0, 7.0]" in found(
        path, "behaviour"
    )


def library(tmp_path, code, target=None, *flags):
    """A shared library of this C code, made without the export list of ours."""
    source = tmp_path / "library.c"
    source.write_text(code)
    target = target or host()
    output = tmp_path / f"library{target.suffix}"
    made = compile_step(source, tmp_path / "library.o", target, "-x", "c++", "-fvisibility=default", *flags)
    run_steps([made])
    plain = link_step([made.output], output, target)
    command = tuple(
        argument for argument in plain.command if not any(of in argument for of in ("version-script", "defs", "rtlib"))
    )
    run_steps([type(plain)(output, command, plain.inputs)])
    return output.read_bytes()


def all_functions(version):
    return "".join(f'extern "C" int {name}(void) {{ return 0; }}\n' for name in sorted(functions(version)))


def test_there_are_as_many_functions_as_in_the_standards():
    assert len(functions("2.0")) == 44
    assert len(functions("3.0")) == 75


def test_exports(tmp_path):
    name = f"binaries/{host().name}/x{host().suffix}"
    good = library(tmp_path, all_functions("2.0"))
    assert list(check_binary(name, good, "2.0")) == []

    more = library(tmp_path, all_functions("2.0") + 'extern "C" int helper(void) { return 0; }')
    assert list(check_binary(name, more, "2.0")) == [f"{name} exports helper, which are no FMI functions"]

    less = library(tmp_path, all_functions("2.0").replace("fmi2GetReal(", "fmi2Other("))
    assert f"{name} does not export fmi2GetReal" in list(check_binary(name, less, "2.0"))


@pytest.mark.skipif(host().suffix != ".so", reason="about ELF")
def test_a_newer_glibc_and_other_libraries(tmp_path):
    name = f"binaries/{host().name}/x.so"
    elf = lief.parse(library(tmp_path, '#include <math.h>\nextern "C" double f(double x) { return exp(x); }'))
    next(v for r in elf.symbols_version_requirement for v in r.get_auxiliary_symbols()).name = "GLIBC_2.29"
    elf.add_library("libstdc++.so.6")
    elf.write(str(tmp_path / "new.so"))
    messages = list(check_binary(name, (tmp_path / "new.so").read_bytes(), "2.0"))
    assert any("needs GLIBC_2.29 of " in m and "expected GLIBC_2.17 or older" in m for m in messages)
    assert f"{name} needs libstdc++.so.6, which may not be installed" in messages


def test_a_binary_for_another_machine(built):
    with zipfile.ZipFile(built / BODY3) as archive:
        content = archive.read(f"binaries/{host().name}/RigidBody{host().suffix}")
    other = next(t for t in TARGETS if t.suffix == host().suffix and t.name != host().name)
    (message,) = check_binary(f"binaries/{other.name}/RigidBody{host().suffix}", content, "3.0")
    assert " is for " in message
    assert list(check_binary("binaries/linux64/x.so", b"nothing", "2.0")) == [
        "binaries/linux64/x.so is no shared library"
    ]


@pytest.mark.parametrize("name", ["x86_64-darwin", "aarch64-darwin"])
def test_a_library_for_one_kind_of_mac(tmp_path, name):
    target = next(t for t in TARGETS if t.name == name)
    content = library(tmp_path, all_functions("2.0"), target)
    assert not [m for m in check_binary("binaries/darwin64/x.dylib", content, "2.0") if " is for " in m]


def test_a_library_of_another_system(tmp_path):
    windows = next(t for t in TARGETS if t.suffix == ".dll")
    content = library(tmp_path, all_functions("2.0"), windows)
    assert list(check_binary("binaries/linux64/x.so", content, "2.0")) == [
        "binaries/linux64/x.so is a library of the format PE, expected ELF"
    ]
    assert list(check_binary("binaries/x86_64-darwin/x.dylib", content, "3.0")) == [
        "binaries/x86_64-darwin/x.dylib is a library of the format PE, expected Mach-O"
    ]
    messages = list(check_binary("binaries/win32/x.dll", content, "2.0"))
    assert "binaries/win32/x.dll is for AMD64, expected I386 or X86" in messages


@pytest.mark.skipif(host().suffix != ".so", reason="about ELF")
def test_what_is_no_shared_library(tmp_path):
    content = library(tmp_path, all_functions("2.0"))
    executable = content[:16] + (2).to_bytes(2, "little") + content[18:]  # its header says so
    assert list(check_binary(f"binaries/{host().fmi2_folder}/x.so", executable, "2.0")) == [
        f"binaries/{host().fmi2_folder}/x.so is no shared library, but exec"
    ]


def test_a_build_description_of_another_model(mutate, static):
    edit = sub('modelIdentifier="RigidBody"', 'modelIdentifier="Rotor"')
    (message,) = found(mutate(BODY3, {"sources/buildDescription.xml": edit}), "companions")
    assert message.startswith("sources/buildDescription.xml, line ")
    assert message.endswith("modelIdentifier Rotor, expected RigidBody")
    edit = sub('fmiVersion="3[^"]*"', 'fmiVersion="3.1"')
    path = mutate(BODY3, {"sources/buildDescription.xml": edit})
    notes = [finding.message for finding in fmus.check(path) if finding.severity == "note"]
    assert notes == ["sources/buildDescription.xml: fmiVersion 3.1, that of the model is 3.0"]


def test_a_platform_of_fmi2_is_none_of_fmi3(mutate, static):
    added = {"binaries/win64/RigidBody.dll": b""}
    assert "binaries/win64 is a platform of FMI 2, expected x86_64-windows" in found(
        mutate(BODY3, added=added), "layout"
    )
    assert found(mutate(BODY2, added=added), "layout") == []

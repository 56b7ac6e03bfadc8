"""Components and systems of somebody else's, in folders and packages of their own."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import adcs
from adcs.cli import app
from fmus import catalog
from fmus.build import describe
from tests.invoking import invoke

ROOT = Path(__file__).parents[2]
LOOP = """
from adcs import System


def detumble() -> System:
    system = System("detumble", "a tumbling body", stop_time="2s", step="50ms")
    system.add("plant", "RigidBody", {"omega_BN_B": [0.1, -0.2, 0.3], "torque_disturbance_B": [0, 0, 0]})
    system.add("law", "HEADER", {"k": 2.0})
    system.connect("plant.omega_BN_B", "law.omega_BN_B")
    system.connect("law.torque_B", "plant.torque_B")
    return system
"""


def command(folder: Path, *arguments: str, path: str = "") -> subprocess.CompletedProcess[str]:
    places = os.pathsep.join([str(ROOT), *([path] if path else [])])
    return subprocess.run(
        [sys.executable, "-m", "adcs", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": places},
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `adcs new` writes, and a system with it."""
    folder = tmp_path_factory.mktemp("own project")  # a blank in its name
    ran = command(folder, "new", "controller", "rate_law")
    assert ran.returncode == 0, ran.stderr
    (folder / "loop.py").write_text(LOOP.replace("HEADER", "rate_law.hpp"))
    return folder


def test_what_is_written_builds_has_no_faults_and_passes_its_test(project: Path) -> None:
    assert json.loads(command(project, "build", "rate_law.hpp", "--json").stdout)[0]["path"].endswith("RateLaw.fmu")
    checked = json.loads(command(project, "check", "rate_law.hpp", "--json").stdout)
    assert [(Path(fmu["path"]).name, fmu["findings"]) for fmu in checked] == [
        ("RateLaw.fmu", []),
        ("RateLaw.fmi3.fmu", []),
    ]
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_rate_law.py"],
        cwd=project,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert "2 passed" in ran.stdout, ran.stdout + ran.stderr


def test_a_law_of_each_kind_is_written_that_builds_and_passes_its_test(tmp_path: Path) -> None:
    outputs = {
        "guidance": "q_RN", "plant": "q_BN", "environment": "torque_B", "sensor": "omega_BN_B_meas",
        "observer": "omega_BN_B_est", "controller": "torque_B",
    }  # fmt: skip
    assert set(outputs) == set(catalog.KINDS.values())
    for kind, output in outputs.items():
        written = command(tmp_path, "new", kind, f"my_{kind}")
        assert written.returncode == 0, written.stderr
        described = describe(str(tmp_path / f"my_{kind}.hpp"))
        assert next(v.name for v in described.variables[1:] if v.causality == "output") == output
    assert (
        (tmp_path / "README.md").read_text().startswith('# My guidance\n\nAn FMI component of the kind "guidance".\n')
    )
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert "12 passed" in ran.stdout, ran.stdout + ran.stderr  # that nothing is wrong, and the law again, of each


def test_progress_leaves_nothing_where_nobody_looks(project: Path, tmp_path: Path) -> None:
    shutil.copy(project / "rate_law.hpp", tmp_path)
    for _ in ("built", "there already"):
        assert command(tmp_path, "build", "rate_law.hpp").stderr == ""


def test_a_folder_is_checked_as_it_is_built(project: Path, tmp_path: Path) -> None:
    laws, given = tmp_path / "laws", tmp_path / "given"
    for folder in (laws, given):
        folder.mkdir()
    shutil.copy(project / "rate_law.hpp", laws)
    (laws / "bad.fmu").write_bytes(b"no zip")
    (given / "other.fmu").write_bytes(b"no zip")
    checked = command(tmp_path, "check", "laws", "given", "laws/rate_law.hpp", "--json")
    found = {Path(fmu["path"]).name: [each["rule"] for each in fmu["findings"]] for fmu in json.loads(checked.stdout)}
    assert found == {
        "RateLaw.fmu": [],
        "RateLaw.fmi3.fmu": [],
        "bad.fmu": ["archive", "run"],
        "other.fmu": ["archive", "run"],
    }
    assert [finding.rule for finding in adcs.check(given)] == ["archive", "run"]
    (tmp_path / "empty").mkdir()
    assert command(tmp_path, "check", "empty").stderr == (
        "adcs: empty has no header of a component: `adcs new controller my_law --to empty` writes one\n"
    )


def test_a_system_takes_a_header_and_both_fmi_versions_agree(project: Path) -> None:
    result = adcs.run(project / "loop.py")
    np.testing.assert_allclose(result["law.torque_B"], -2.0 * result["plant.omega_BN_B"], rtol=1e-15)
    assert adcs.run(project / "loop.py", fmi_version="3.0") == result
    again = adcs.rerun(json.loads(json.dumps(result.manifest)))
    assert (again.result == result, again.differences) == (True, ())
    alone = adcs.run(project / "rate_law.hpp", stop_time=1, step=1)
    assert list(alone) == ["RateLaw.torque_B"]


def test_a_changed_header_is_built_anew(project: Path) -> None:
    header = project / "rate_law.hpp"
    before, text = adcs.run(project / "loop.py"), header.read_text()
    header.write_text(text.replace("-k * omega_BN_B", "-2 * k * omega_BN_B"))
    try:
        after = adcs.run(project / "loop.py")
        assert np.array_equal(after["law.torque_B"][0], 2 * before["law.torque_B"][0])
        differences = adcs.rerun(before.manifest).differences
        assert differences[0].startswith("component law: RateLaw.fmu is another file than was run, sha256 ")
    finally:
        header.write_text(text)
    assert adcs.run(project / "loop.py") == before


def test_a_header_includes_what_is_beside_it_and_its_fmu_has_that_in_its_sources(project: Path) -> None:
    (project / "gain.hpp").write_text("#pragma once\nnamespace adcs { constexpr double gain = 3.0; }\n")
    text = (project / "rate_law.hpp").read_text()
    (project / "other_law.hpp").write_text(
        text.replace("RateLaw", "OtherLaw")
        .replace('"fmi/declaration.hpp"', '"fmi/declaration.hpp"\n#include "gain.hpp"')
        .replace("-k * omega_BN_B", "-gain * omega_BN_B")
    )
    system = adcs.System("alone")
    system.add("law", project / "other_law.hpp", {"omega_BN_B": [1.0, 2.0, 3.0]})
    assert adcs.run(system, stop_time=1, step=1)["law.torque_B"][0].tolist() == [-3.0, -6.0, -9.0]
    from zipfile import ZipFile

    with ZipFile(project / "OtherLaw.fmu") as fmu:
        assert {"sources/other_law.hpp", "sources/gain.hpp", "sources/fmi/declaration.hpp"} <= set(fmu.namelist())


def test_what_a_header_asks_for_may_appear_and_go(project: Path, tmp_path: Path) -> None:
    header, gain = tmp_path / "asking_law.hpp", tmp_path / "gain.hpp"
    header.write_text(
        (project / "rate_law.hpp")
        .read_text()
        .replace("RateLaw", "AskingLaw")
        .replace("#pragma once", '#pragma once\n#if __has_include("gain.hpp")\n#include "gain.hpp"\n#endif')
        .replace("-k * omega_BN_B;", "-k * omega_BN_B;\n#ifdef GAIN\n        torque_B *= GAIN;\n#endif\n   ")
    )
    system = adcs.System("alone")
    system.add("law", header, {"omega_BN_B": [1.0, 0.0, 0.0]})

    def torque() -> float:
        return float(adcs.run(system, stop_time=1, step=1)["law.torque_B"][0, 0])

    assert torque() == -1.0
    gain.write_text("#pragma once\n#define GAIN 4.0\n")
    assert torque() == -4.0
    gain.unlink()
    assert torque() == -1.0


def test_two_of_one_name_in_two_folders_are_two(project: Path, tmp_path: Path) -> None:
    text = (project / "rate_law.hpp").read_text()
    (tmp_path / "rate_law.hpp").write_text(text.replace("-k * omega_BN_B", "-10 * k * omega_BN_B"))
    torques = []
    for folder in (project, tmp_path, project):
        system = adcs.System("alone")
        system.add("law", folder / "rate_law.hpp", {"omega_BN_B": [1.0, 0.0, 0.0]})
        torques.append(adcs.run(system, stop_time=1, step=1)["law.torque_B"][0, 0])
    assert torques == [-1.0, -10.0, -1.0]


def test_a_copied_folder_is_not_judged_by_the_original(project: Path, tmp_path: Path) -> None:
    adcs.build([str(project / "rate_law.hpp")])
    copy = tmp_path / "copy"
    shutil.copytree(project, copy)
    header = copy / "rate_law.hpp"
    header.write_text(header.read_text().replace("-k * omega_BN_B", "-10 * k * omega_BN_B"))
    system = adcs.System("alone")
    system.add("law", header, {"omega_BN_B": [1.0, 0.0, 0.0]})
    assert adcs.run(system, stop_time=1, step=1)["law.torque_B"][0, 0] == -10.0


def test_a_copied_folder_needs_no_compiler(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The records that were copied with it are of headers in another folder."""
    adcs.build([str(project / "rate_law.hpp")])
    shutil.copytree(project, tmp_path / "copy")
    monkeypatch.setattr("fmus.toolchain.is_installed", lambda: False)
    assert adcs.run(tmp_path / "copy" / "rate_law.hpp", stop_time=1, step=1)["RateLaw.torque_B"].shape == (2, 3)


def test_what_it_has_is_shown_without_a_compiler(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    adcs.build([str(project / "rate_law.hpp")])
    monkeypatch.setattr("fmus.toolchain.is_installed", lambda: False)
    monkeypatch.setattr("adcs.cli.info.is_installed", lambda: False)
    ended = invoke(app.app, ["info", str(project / "rate_law.hpp"), "--json"])
    assert json.loads(ended.stdout)["name"] == "RateLaw"


def test_a_header_of_a_neighbouring_folder(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("laws", "missions"):
        (tmp_path / name).mkdir()
    shutil.copy(project / "rate_law.hpp", tmp_path / "laws")
    monkeypatch.chdir(tmp_path / "missions")
    built = adcs.build(["../laws/rate_law.hpp"])
    assert built == adcs.build([str(tmp_path / "laws" / "rate_law.hpp")])
    system = adcs.System("alone")
    system.add("law", "../laws/rate_law.hpp", {"omega_BN_B": [1.0, 0.0, 0.0]})
    assert adcs.run(system, stop_time=1, step=1)["law.torque_B"][0, 0] == -1.0


def test_the_fmu_of_a_changed_header_is_told_where_it_is_asked_for_by_its_own_path(
    project: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    shutil.copy(project / "rate_law.hpp", tmp_path)
    fmu, _ = adcs.build([str(tmp_path / "rate_law.hpp")])
    adcs.run(fmu, stop_time=1, step=1)
    assert not caplog.messages
    with (tmp_path / "rate_law.hpp").open("a") as header:
        header.write("// changed\n")
    adcs.run(fmu, stop_time=1, step=1)
    assert caplog.messages == [
        f"{fmu} was built from another {tmp_path / 'rate_law.hpp'}, and is taken as it is: rate_law.hpp in its place "
        "is built when it is asked for"
    ]


def test_the_fmus_of_a_deleted_header_go_when_its_folder_is_built(project: Path, tmp_path: Path) -> None:
    for name in ("one_law", "two_law"):
        text = (project / "rate_law.hpp").read_text().replace("RateLaw", catalog.struct_name(name))
        (tmp_path / f"{name}.hpp").write_text(text)
    adcs.build([str(tmp_path)])
    (tmp_path / "two_law.hpp").unlink()
    adcs.build([str(tmp_path)])
    assert sorted(path.name for path in tmp_path.glob("*.fmu")) == ["OneLaw.fmi3.fmu", "OneLaw.fmu"]


def test_what_is_included_from_elsewhere_is_refused(project: Path, tmp_path: Path) -> None:
    (tmp_path / "gain.hpp").write_text("#pragma once\n")
    (tmp_path / "laws").mkdir()
    header = tmp_path / "laws" / "rate_law.hpp"
    header.write_text(
        (project / "rate_law.hpp").read_text().replace("#pragma once", '#pragma once\n#include "../gain.hpp"')
    )
    with pytest.raises(
        adcs.AdcsError, match=r"rate_law\.hpp includes .*gain\.hpp, which its FMU's sources cannot hold"
    ):
        adcs.build([str(header)])


def test_no_fmu_of_another_tool_is_replaced(project: Path, tmp_path: Path) -> None:
    header = tmp_path / "rate_law.hpp"
    header.write_text((project / "rate_law.hpp").read_text())
    (tmp_path / "RateLaw.fmu").write_bytes(b"theirs")
    with pytest.raises(adcs.AdcsError, match=r"RateLaw\.fmu is there already, and not of this project's making: move"):
        adcs.run(header, stop_time=1, step=1)
    assert (tmp_path / "RateLaw.fmu").read_bytes() == b"theirs"


@pytest.mark.skipif(os.name != "posix", reason="dollars in names of folders")
def test_names_of_folders_may_have_signs_and_be_relative(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "a$b ü #1"
    folder.mkdir()
    (folder / "rate_law.hpp").write_text((project / "rate_law.hpp").read_text())
    monkeypatch.chdir(folder)
    system = adcs.System("alone")
    system.add("law", "rate_law.hpp", {"omega_BN_B": [1.0, 0.0, 0.0]})
    monkeypatch.chdir(tmp_path)
    assert adcs.run(system, stop_time=1, step=1)["law.torque_B"][0, 0] == -1.0


def test_where_nothing_can_be_written_fmus_go_to_the_cache(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    header = tmp_path / "rate_law.hpp"
    header.write_text((project / "rate_law.hpp").read_text())
    monkeypatch.setattr("fmus.catalog.os.access", lambda path, mode: False)
    monkeypatch.setattr("fmus.catalog.BUILD", tmp_path / "cache")
    assert adcs.run(header, stop_time=1, step=1)["RateLaw.torque_B"].shape == (2, 3)
    assert not (tmp_path / "RateLaw.fmu").exists() and list(tmp_path.glob("cache/outside/*/fmus/RateLaw.fmu"))


def test_a_folder_stands_for_its_headers(project: Path, tmp_path: Path) -> None:
    for name in ("one_law", "two_law"):
        assert command(tmp_path, "new", "controller", name).returncode == 0
    built = json.loads(command(tmp_path, "build", ".", "--json").stdout)
    assert [Path(fmu["path"]).name for fmu in built] == [
        "OneLaw.fmu", "OneLaw.fmi3.fmu", "TwoLaw.fmu", "TwoLaw.fmi3.fmu"
    ]  # fmt: skip
    (tmp_path / "empty").mkdir()
    assert command(tmp_path, "build", "empty").stderr == (
        "adcs: empty has no header of a component: `adcs new controller my_law --to empty` writes one\n"
    )


def test_the_kind_is_what_the_header_or_its_folder_says(project: Path, tmp_path: Path) -> None:
    text = (project / "rate_law.hpp").read_text()
    assert catalog.find(str(project / "rate_law.hpp")).kind == "controller"
    (tmp_path / "sensors").mkdir()
    header = tmp_path / "sensors" / "rate_law.hpp"
    header.write_text(text.replace('    static constexpr auto kind = "controller";\n', ""))
    assert catalog.find(str(header)).kind == "sensor"
    header.write_text(text.replace('kind = "controller"', 'kind = "wheel"'))
    with pytest.raises(
        adcs.AdcsError, match=r"rate_law\.hpp:14: kind = 'wheel' is unknown: use guidance or plant or environment or"
    ):
        catalog.find(str(header))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("build", "absent.hpp"), "absent.hpp is no file"),
        (("build", "empty.hpp"), "empty.hpp declares no component: `adcs new controller my_law` writes one"),
        (("build", "my__law.hpp"), "my__law.hpp: small letters, digits and underscores make the name of a header"),
        (
            ("build", "wrong.hpp"),
            "wrong.hpp:1: there is no `struct Wrong`, but Other; a component's struct has its file's name in",
        ),
        (("new", "controler", "x"), 'Did you mean "controller"?'),
        (("new", "controller", "MyLaw"), "'MyLaw' is no name for a file: small letters, digits and underscores"),
        (("new", "controller", "empty"), "empty.hpp is there already: take another name, or another folder by --to"),
    ],
)
def test_mistakes_are_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], said: str):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my__law.hpp").write_text("struct MyLaw { void declare(int) {} };\n")
    (tmp_path / "empty.hpp").write_text("#pragma once\n")
    (tmp_path / "wrong.hpp").write_text("struct Other { void declare(int) {} };\n")
    before = sorted(tmp_path.iterdir())
    ended = invoke(app.app, [*arguments])
    assert said in str(ended.exception) and "\n" not in str(ended.exception)
    assert sorted(tmp_path.iterdir()) == before


@pytest.fixture
def package(project: Path, tmp_path: Path) -> Path:
    """An installed package of somebody else's, with systems by entry points."""
    (tmp_path / "their_missions.py").write_text(
        LOOP.replace("HEADER", str(project / "rate_law.hpp"))
        + "\n\ndef broken():\n    return 1 / 0\n\n\ndef leave():\n    raise SystemExit(3)\n"
    )
    about = tmp_path / "their_missions-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their-missions\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[adcs.systems]\ntheir-detumble = their_missions:detumble\ntheir-broken = their_missions:broken\n"
        "RigidBody = their_missions:detumble\ntheir-exit = their_missions:leave\n"
    )
    return tmp_path


def test_systems_of_other_packages_are_found_by_name(package: Path) -> None:
    run = command(package, "run", "their-detumble", "--no-report", "--json", path=str(package))
    assert json.loads(run.stdout)["outcome"] == {"status": "complete", "rows": 41}, run.stderr
    slip = command(package, "run", "their-detumbl", path=str(package))
    assert slip.stderr.startswith("adcs: no system 'their-detumbl': did you mean their-detumble")
    broken = command(package, "run", "their-broken", path=str(package))
    assert broken.stderr == (
        "adcs: the system their-broken of the package their-missions cannot be loaded: ZeroDivisionError: division by "
        "zero\n"
    )
    listed = json.loads(command(package, "list", "--json", path=str(package)).stdout)
    about = {system["name"]: system["description"] for system in listed["systems"]}
    assert about["their-detumble"] == "their_missions:detumble, of the package their-missions"  # nothing was run
    assert about["their-exit"] == "their_missions:leave, of the package their-missions"
    left = command(package, "run", "their-exit", path=str(package))
    assert left.stderr == "adcs: the system their-exit of the package their-missions cannot be loaded: SystemExit: 3\n"
    alone = json.loads(
        command(package, "run", "RigidBody", "--no-report", "--json", "--stop", "1", path=str(package)).stdout
    )
    assert alone["system"] == "RigidBody"  # names of here come first


@pytest.fixture(scope="module")
def laws(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installed package with two headers, FMUs of one of them, and an FMU alone."""
    folder = tmp_path_factory.mktemp("site")
    package = folder / "their_laws"
    (package / "more").mkdir(parents=True)
    text = (project / "rate_law.hpp").read_text()
    (package / "__init__.py").write_text(
        "from pathlib import Path\n\nHEADERS = 'more/other_law.hpp'\n\n\n"
        "def several():\n    return [Path(__file__).parent / 'more' / 'rigid_body.hpp', 'alone.fmu']\n"
    )
    (package / "their_law.hpp").write_text(text.replace("RateLaw", "TheirLaw"))
    (package / "magnetometer.hpp").write_text(text.replace("RateLaw", "Magnetometer"))
    (package / "shared.hpp").write_text("#pragma once\n")
    (package / "more" / "other_law.hpp").write_text(text.replace("RateLaw", "OtherLaw").replace("-k *", "-2 * k *"))
    (package / "more" / "rigid_body.hpp").write_text(text.replace("RateLaw", "RigidBody"))
    built = adcs.build([str(package / "their_law.hpp"), str(package / "more" / "other_law.hpp")])
    shutil.copy(built[2], package / "alone.fmu")
    for path in built[2:]:
        path.unlink()
    shutil.rmtree(package / ".made")  # as in what is installed
    shutil.rmtree(package / "more" / ".made")
    about = folder / "their_laws-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their-laws\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[adcs.components]\nall = their_laws\none = their_laws:HEADERS\nmore = their_laws:several\n"
        "broken = their_laws.absent\n\n[adcs.systems]\nobserver-pd = their_laws:several\n"
    )
    return folder


def test_components_of_other_packages_are_found_by_name(laws: Path) -> None:
    ran = command(laws, "list", "--json", path=str(laws))
    listed = {c["name"]: c for c in json.loads(ran.stdout)["components"]}
    assert [*listed][-4:] == ["TheirLaw", "alone", "one", "more"]
    assert listed["TheirLaw"]["kind"] == "controller" and [*listed["TheirLaw"]["fmus"]] == ["2.0", "3.0"]
    assert [*listed["alone"]["fmus"]] == ["2.0"]
    assert listed["one"]["description"] == "more components: their_laws:HEADERS, of the package their-laws"
    told = " ".join(ran.stderr.split())
    where = laws / "their_laws" / "magnetometer.hpp"
    assert f"Magnetometer is a component of this project; that of the package their-laws, {where}, goes by its" in told
    assert "the components broken of the package their-laws cannot be found: there is no module their_laws.ab" in told
    assert "observer-pd is a system of this project; that of the package their-laws, their_laws:several, is not" in told
    info = command(laws, "info", "alone", path=str(laws))
    assert info.stdout.startswith("OtherLaw: Torque against the angular velocity") and "RigidBody" not in info.stderr
    clash = command(laws, "info", "RigidBody", path=str(laws))
    assert clash.stdout.startswith("RigidBody (plant)")
    assert json.loads(command(laws, "info", "OtherLaw", "--json", path=str(laws)).stdout)["name"] == "OtherLaw"
    slip = command(laws, "run", "ThierLaw", path=str(laws)).stderr
    assert "did you mean TheirLaw" in slip


LAWS_IN_A_SYSTEM = """
import sys
import adcs
from fmus import toolchain

torques = []
for name in sys.argv[1:]:
    system = adcs.System("alone")
    system.add("law", name, {"omega_BN_B": [1.0, 0.0, 0.0]})
    torques.append(adcs.run(system, stop_time=1, step=1)["law.torque_B"][0, 0])
print(*torques, adcs.check("alone"))
"""


def in_a_system(laws: Path, *names: str, compiler: bool = True) -> subprocess.CompletedProcess[str]:
    script = LAWS_IN_A_SYSTEM
    if not compiler:
        script = script.replace("torques = []", "torques = []\ntoolchain.is_installed = lambda: False", 1)
    return subprocess.run(
        [sys.executable, "-c", script, *names],
        cwd=laws,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(laws)])},
        capture_output=True,
        text=True,
    )


def test_what_a_package_brings_as_an_fmu_needs_no_compiler_and_a_header_is_built(laws: Path) -> None:
    without = in_a_system(laws, "TheirLaw", "alone", compiler=False)
    assert without.stdout == "-1.0 -2.0 []\n", without.stderr
    refused = in_a_system(laws, "OtherLaw", compiler=False)
    assert "OtherLaw.fmu is not built, and no compiler is installed to build it" in refused.stderr
    assert not (laws / "their_laws" / ".made").exists()
    assert in_a_system(laws, "OtherLaw").stdout == "-2.0 []\n"


def test_an_fmu_that_came_with_another_header_is_not_taken(laws: Path) -> None:
    header = laws / "their_laws" / "their_law.hpp"
    text = header.read_text()
    header.write_text(text.replace("-k *", "-3 * k *"))
    try:
        refused = in_a_system(laws, "TheirLaw", compiler=False)
        assert "TheirLaw.fmu is not as it was built, and no compiler is installed" in refused.stderr
        assert in_a_system(laws, "TheirLaw").stdout == "-3.0 []\n"
    finally:
        header.write_text(text)

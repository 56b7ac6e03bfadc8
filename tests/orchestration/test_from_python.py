"""Systems in Python files of anybody's, from anywhere."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import adcs
from adcs.catalogue import find_system
from fmus import fmu_path
from orchestration.results.error_angles import is_error_quaternion

LOOP = """
from adcs import System

def detumble() -> System:
    system = System("detumble", "a tumbling body", stop_time="2s", step="50ms")
    system.add("plant", "RigidBody", {"omega_BN_B": [0.1, 0.2, 0.3], "torque_B": RATE})
    system.set("plant.torque_disturbance_B", [0, 0, 0])
    return system
"""
NOT = "expected an adcs.System"


@pytest.fixture
def file(tmp_path, monkeypatch):
    """Writes mission.py in the present folder."""
    monkeypatch.chdir(tmp_path)

    def write(text: str) -> str:
        (tmp_path / "mission.py").write_text(text)
        return "mission.py"

    return write


def test_a_function_that_returns_a_system_is_enough(file):
    name = file("RATE = [0, 0, 0]\n" + LOOP)
    result = adcs.run(name)
    assert (result.system.name, len(result.time), result.time[-1]) == ("detumble", 41, 2.0)
    assert result == adcs.run(f"{name}:detumble") == adcs.run(Path(name).absolute())
    with adcs.Session(name) as session:
        assert session.step == 0.05


def test_it_is_read_again_when_it_has_changed(file):
    torques = []
    for torque in (0.25, 0.5, 0.75):  # within one second, and of one size
        text = LOOP.replace("RATE", f"[0.0, 0.0, {torque:.2f}]")
        torques.append(adcs.run(file(text)).system.components["plant"].start["torque_B"][2])
    assert torques == [0.25, 0.5, 0.75]


def test_what_is_beside_it_can_be_imported(file, tmp_path):
    (tmp_path / "beside_mission.py").write_text("RATE = [0.0, 0.0, 0.5]\n")
    path = sys.path.copy()
    system = adcs.run(file("from beside_mission import RATE\n" + LOOP)).system
    assert system.components["plant"].start["torque_B"] == (0.0, 0.0, 0.5)
    assert sys.path == path


def test_two_files_may_have_modules_of_one_name_beside_them(tmp_path):
    torques = []
    for folder, torque in (("a", 1.0), ("b", 2.0), ("a", 3.0)):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "rates_beside.py").write_text(f"RATE = [0.0, 0.0, {torque}]\n")
        (tmp_path / folder / "mission.py").write_text("from rates_beside import RATE\n" + LOOP)
        system = adcs.run(tmp_path / folder / "mission.py").system
        torques.append(system.components["plant"].start["torque_B"][2])
    assert torques == [1.0, 2.0, 3.0]


def test_results_stay_in_their_folder_whatever_a_system_is_called(file):
    entry = find_system(file('from adcs import System\n\ndef f() -> System:\n    return System("../../oops x/y")\n'))
    assert entry.name == "oops-x-y"


def test_a_system_by_itself_and_functions_that_say_nothing(file):
    made = "from adcs import System\ndef f(n=1):\n    return System('f', stop_time=1, step=1)\n"
    assert callable(adcs.linearize)  # imported before the file is
    for text, inside in ((made, "f"), (made + "s = f()\n", "s")):
        with pytest.raises(adcs.AdcsError, match="has no component"):
            adcs.run(file(text))
        with pytest.raises(adcs.AdcsError, match="has no component"):
            adcs.run(f"mission.py:{inside}")


@pytest.mark.parametrize(
    ("text", "name", "said"),
    [
        ("x = 1\n", "mission.py", "mission.py has no system: write a function without arguments that returns an"),
        ("def f(n): pass\n", "mission.py", "mission.py has no system: write a function without arguments that"),
        ("def f(): pass\ndef g(): pass\n", "mission.py", "several systems: give one, mission.py:f or mission.py:g"),
        ("def f(): pass\n", "mission.py", f"mission.py:f returned None: {NOT}"),
        ("def slew(): pass\n", "mission.py:slw", "mission.py has no system 'slw': did you mean slew?"),
        ("def slew(): pass\n", "mission.py:x", "mission.py has no system 'x': it has slew"),
        ("\nx = 1/0\n", "mission.py", "mission.py:2: ZeroDivisionError: division by zero"),
        ("def f(:\n", "mission.py", "mission.py:1: SyntaxError: invalid syntax"),
        ("import nothing_of_this_name\n", "mission.py", "mission.py:1: ModuleNotFoundError: No module named"),
        ("def f():\n    raise SystemExit(3)\n", "mission.py", "mission.py:2: SystemExit: 3"),
        (
            "import adcs\ndef f():\n    s = adcs.System('s')\n    s.add('p', 'RigidBdy')\n",
            "mission.py",
            "mission.py:4: ",
        ),
        ("", "misson.py", "misson.py is no file"),
        (
            "async def f(): pass\n",
            "mission.py:f",
            "mission.py:f is async, and nobody awaits it: write def, without async",
        ),
        (
            "import adcs\nasync def f() -> adcs.System: pass\n",
            "mission.py",
            "mission.py:f is async, and nobody awaits it: write def, without async",
        ),
        ("async def f(): pass\n", "mission.py", "mission.py has no system: write a function without arguments"),
        ("def f(n, m=1): pass\n", "mission.py:f", "mission.py:f needs n: write a function without arguments that"),
        ("def f(): pass\ndef g(): pass\n", "mission.py", ", or write -> System behind those that return one"),
        (
            "def f(): pass\ndef g(): pass\n",
            "mission.py:g",
            f"mission.py:g returned None: {NOT}; there is also mission.py:f",
        ),
        ("def f() -> int: return 1\nh = lambda: 1\n", "mission.py", "mission.py has no system: write a function"),
    ],
)
def test_what_is_wrong_is_one_line(file, text, name, said):
    file(text)
    with pytest.raises(adcs.AdcsError) as error:
        adcs.run(name)
    assert said in str(error.value) and "\n" not in str(error.value)


HELPED = """
import adcs

def gain(): return 2.0
def rate() -> float: return gain()
def scaled(x): return x
def _made(): return adcs.System("other")
"""


@pytest.mark.parametrize(
    "said", ["adcs.System", "'adcs.System'", "'System'", "adcs.System | None", "'System | None'", "Optional[System]"]
)
@pytest.mark.parametrize("later", ["", "from __future__ import annotations\n"])
def test_what_says_that_it_returns_a_system(file, said, later):
    imports = "import adcs\nfrom adcs import System\nfrom typing import Optional\n"
    makes = "adcs.System('mission', stop_time=1, step=1)"
    text = f"{later}{imports}def helper(): return 1\ndef mission() -> {said}: return {makes}\n"
    with pytest.raises(adcs.AdcsError, match=r"^system 'mission' has no component"):
        adcs.run(file(text))


@pytest.mark.parametrize("kind", ["->", "'->'", "one"])
def test_helpers_are_no_systems(file, kind):
    made = "    return adcs.System('mission', stop_time=1, step=1)\n"
    says = {"->": " -> adcs.System", "'->'": " -> 'adcs.System'", "one": ""}[kind]
    helped = HELPED.replace("def gain()", "def _gain()") if kind == "one" else HELPED
    with pytest.raises(adcs.AdcsError, match=r"^system 'mission' has no component"):
        adcs.run(file(f"{helped}def mission(){says}:\n{made}"))


def test_one_that_says_nothing_is_found_by_its_name_beside_one_that_does(file):
    made = "adcs.System('{}', stop_time=1, step=1)\n"
    text = f"import adcs\ndef a() -> adcs.System: return {made.format('a')}def b(): return {made.format('b')}"
    for name, meant in (("mission.py", "a"), ("mission.py:b", "b")):
        file(text)
        with pytest.raises(adcs.AdcsError, match=f"^system '{meant}' has no component"):
            adcs.run(name)


def test_relative_paths_are_of_the_folder_of_the_file_first(tmp_path, monkeypatch):
    body, wheel = (fmu_path(name) for name in ("RigidBody", "SpinningWheel"))
    for folder, fmu in (("missions", body), ("here", wheel)):
        (tmp_path / folder).mkdir()
        shutil.copy(fmu, tmp_path / folder / "part.fmu")
    shutil.copy(wheel, tmp_path / "here" / "wheel.fmu")
    (tmp_path / "missions" / "mission.py").write_text(
        "import adcs\n\ndef mission() -> adcs.System:\n    system = adcs.System('m', stop_time=1, step=1)\n"
        "    system.add('a', 'part.fmu')\n    system.add('b', 'wheel.fmu')\n    return system\n"
    )
    monkeypatch.chdir(tmp_path / "here")
    system = find_system("../missions/mission.py").build()
    names = {name: component.fmu.model.modelName for name, component in system.components.items()}
    assert names == {"a": "RigidBody", "b": "SpinningWheel"}
    outside = adcs.System("after")
    outside.add("a", "part.fmu")
    assert outside.components["a"].fmu.model.modelName == "SpinningWheel"


def test_every_command_that_takes_a_system_takes_the_file(file, tmp_path):
    file("RATE = [0, 0, 0]\n" + LOOP)

    def command(*arguments: str) -> str:
        environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
        ran = subprocess.run(
            [sys.executable, "-m", "adcs", *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert ran.returncode == 0, ran.stderr
        return ran.stdout

    run = json.loads(command("run", "mission.py", "--no-report", "--json", "--set", "plant.torque_B=0,0,1"))
    assert run["system"] == "detumble" and "results/detumble/result.csv" in run["files"]
    assert json.loads(command("rerun", "results/detumble", "--json"))["same"] is True
    assert json.loads(command("info", "mission.py", "--json"))
    assert "nothing wrong" in command("check", "mission.py:detumble")
    assert "1 component" in command("export", "mission.py", "--out", "m.ssp")
    assert "6 inputs" in command("linearize", "mission.py")
    assert "plant.omega_BN_B" in command("bridge", "mission.py", "--list")


def test_times_of_a_system_are_given_both_or_not_at_all():
    with pytest.raises(adcs.AdcsError, match=r"^step: give both times of a run, or none$"):
        adcs.System("x", stop_time=1.0)
    with pytest.raises(adcs.AdcsError, match=r"^stop_time: give both times of a run, or none$"):
        adcs.System("x", step=1.0)
    times = adcs.System("x", start_time="1s", stop_time="1min", step="10ms").times
    assert (times.start, times.stop, times.step) == (1.0, 60.0, 0.01)


def test_its_figures_are_a_panel_for_each_variable_with_angles_in_degrees(file):
    entry = find_system(file("RATE = [0, 0, 1]\n" + LOOP))
    result = adcs.run(entry.build())
    panels = {panel.title: panel for panel in entry.figures(result)}
    assert list(panels) == ["q_BN", "omega_BN_B", "H_N", "kinetic_energy"]
    assert {panel.group for panel in panels.values()} == {"plant"}
    rates = panels["omega_BN_B"]
    assert rates.y_label == "omega_BN_B [deg/s]"
    np.testing.assert_allclose(
        np.transpose([series.y for series in rates.series]), np.degrees(result["plant.omega_BN_B"]), rtol=1e-15
    )
    assert np.array_equal(panels["H_N"].series[2].y, result["plant.H_N"][:, 2])


ERROR = """
from adcs import System


def tracking() -> System:
    system = System("tracking", stop_time="2s", step="0.5s")
    system.add("law", "PdTracking", {"q_BN": QUATERNION, "omega_BN_B": [0, 0, 0]})
    for name, value in {"q_RN": [1, 0, 0, 0], "omega_RN_R": [0, 0, 0], "omegaDot_RN_R": [0, 0, 0]}.items():
        system.set(f"law.{name}", value)
    return system
"""


@pytest.mark.parametrize("sign", [1, -1])
def test_the_quaternion_of_an_attitude_error_is_drawn_as_an_angle_and_recorded_as_it_is(file, sign):
    half = np.radians(30.0) / 2
    q = [sign * float(np.cos(half)), 0.0, sign * float(np.sin(half)), 0.0]
    entry = find_system(file(ERROR.replace("QUATERNION", repr(q))))
    result = adcs.run(entry.build())
    (panel,) = (panel for panel in entry.figures(result) if panel.title.startswith("q_"))
    assert (panel.title, panel.y_label) == ("q_BR as an angle", "angle of q_BR [deg]")
    assert panel.note == (
        "attitude error, B relative to R (unit quaternion); drawn as the angle by which it turns (scalar part first)"
    )
    (curve,) = panel.series
    np.testing.assert_allclose(curve.y, 30.0, rtol=1e-14)
    np.testing.assert_allclose(result["law.q_BR"], np.tile(q, (len(result.time), 1)), rtol=1e-15)


UNIT = np.array([[0.5, 0.5, -0.5, 0.5], [1.0, 0.0, 0.0, 0.0]])


@pytest.mark.parametrize(
    ("variable", "unit", "values", "is_one"),
    [
        ("q_BR", "1", UNIT, True),
        ("q_EB", None, UNIT, True),
        ("q_BN", "1", UNIT, False),  # an attitude
        ("q_BO", "1", UNIT, False),
        ("q_BR", "rad", UNIT, False),
        ("q_BR", "1", 2 * UNIT, False),
        ("q_BR", "1", np.full((2, 4), np.nan), False),
        ("q_BR", "1", UNIT[:, :3], False),
        ("q_BR_est", "1", UNIT, False),
        ("quality", "1", UNIT, False),
        ("q_BR", "1", UNIT[:0], False),
    ],
)
def test_what_is_the_quaternion_of_an_attitude_error(variable, unit, values, is_one):
    assert is_error_quaternion(variable, unit, values) is is_one

"""What an FMU says of how it is to be used, and what is said where a system or a run does otherwise."""

import pytest

import adcs
import fmus
from adcs import AdcsError, CoSimulation, ModelExchange, System, run
from orchestration.fmu.file import open_fmu
from orchestration.running.hooks.changes import Changes
from orchestration.system import checked_value

from .small import changed, description3, packed

START = {"q_BN": [1, 0, 0, 0], "q_RN": [1, 0, 0, 0]}
START |= {"omega_RN_R": [0, 0, 0], "omegaDot_RN_R": [0, 0, 0], "J_B": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}


def controller(tmp_path, version, *changes):
    system = System("s")
    path = changed(fmus.fmu_path("PdTracking", version), tmp_path / "c.fmu", *changes)
    system.add("c", path, {**START, "k_p": 3.0})
    return system


def at_rest(system):
    system.set("c.omega_BN_B", [0, 0, 0])
    return system


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_start_value_outside_min_and_max_is_a_warning(tmp_path, version):
    tag = r'(<ScalarVariable name="k_p"[^>]*>\s*<Real)( )' if version == "2.0" else r'(<Float64 name="k_p")( )'
    changes = (r'(name="k_p"[^/]*?) min="0[.0]*"', r"\1"), (tag, r'\1 min="0.5" max="2"\2')
    system = at_rest(controller(tmp_path, version, *changes))
    manifest = run(system, stop_time=0.1, step=0.1).manifest
    assert manifest["warnings"] == ["c.k_p = 3 is outside of the range its FMU is made for, 0.5 to 2"]
    system.set("c.k_p", 2.0)
    assert run(system, stop_time=0.1, step=0.1).manifest["warnings"] == []


@pytest.mark.parametrize("way", ["changes", "inputs"])
def test_what_is_set_during_a_run_outside_min_and_max_is_a_warning(tmp_path, way):
    system = at_rest(controller(tmp_path, "3.0", (r'(<Float64 name="omega_BN_B")( )', r'\1 max="2"\2')))
    warning = "c.omega_BN_B[2] = 3 at 0.1 s is outside of the range its FMU is made for, -inf to 2"
    if way == "changes":
        settings = {
            "hooks": [Changes([(0.1, "c.omega_BN_B", [0.0, 3.0, 0.0]), (0.2, "c.omega_BN_B", [0.0, 2.0, 0.0])])]
        }
    else:
        table = tmp_path / "inputs.csv"
        names = ",".join(f"c.omega_BN_B[{i}]" for i in (1, 2, 3))
        table.write_text(f"time,{names}\n0,0,2,0\n0.1,0,3,0\n0.2,0,4,0\n")
        settings = {"hooks": [adcs.inputs(table)]}
    assert run(system, stop_time=0.2, step=0.1, **settings).manifest["warnings"] == [warning]


@pytest.mark.parametrize(
    ("internal", "step", "warned"),
    [(0.05, 0.1, False), (0.03, 0.1, True), (0.2, 0.1, True), ("1e-320", 0.1, False), ("INF", 0.1, False)],
)
def test_a_step_that_is_no_multiple_of_the_internal_one_is_a_warning(tmp_path, internal, step, warned):
    system = at_rest(
        controller(tmp_path, "3.0", ("<CoSimulation ", f'<CoSimulation fixedInternalStepSize="{internal}" '))
    )
    told = (
        f"c is stepped by {step:g} s, no multiple of its internal step of {float(internal):g} s: "
        "its values are those of another time"
    )
    assert run(system, stop_time=0.2, step=step).manifest["warnings"] == ([told] if warned else [])
    assert run(system, stop_time=0.2, step=step, method=ModelExchange()).manifest["warnings"] == []


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_no_loop_goes_through_an_input_that_is_set_once(tmp_path, version):
    once = (r' name="omega_BN_B', ' canHandleMultipleSetPerTimeInstant="false" name="omega_BN_B')
    system = controller(tmp_path, version, once)
    system.connect("c.torque_B", "c.omega_BN_B", factor=0.1)
    times = {"stop_time": 0.1, "step": 0.1}
    assert (
        len(run(system, **times, method=CoSimulation(loops="newton")).time) == 2
    )  # in co-simulation inputs may be set as often as one likes
    with pytest.raises(AdcsError) as error:
        run(system, **times, method=ModelExchange(loops="newton"))
    assert str(error.value).endswith(
        "cannot be solved: c.omega_BN_B may be set only once at an instant (canHandleMultipleSetPerTimeInstant), "
        "give a connection of it a delay"
    )


@pytest.mark.parametrize("where", ["variable", "type"])
def test_binary_values_are_no_longer_than_they_may_be(tmp_path, where):
    said = ('maxSize="2"', "") if where == "variable" else ("", 'maxSize="2"')
    variable = (
        f'<Binary name="b" valueReference="1" causality="parameter" variability="fixed" declaredType="T" {said[0]}>'
    )
    xml = description3(f'{variable}<Start value="00"/></Binary>', types=f'<BinaryType name="T" {said[1]}/>')
    port = open_fmu(packed(tmp_path / "c.fmu", xml)).ports["b"]
    assert checked_value("c.b", port, "00ff") == (b"\x00\xff",)
    with pytest.raises(AdcsError) as error:
        checked_value("c.b", port, b"\x00\xff\x10")
    assert str(error.value) == "c.b has 3 bytes: expected at most 2 (maxSize)"

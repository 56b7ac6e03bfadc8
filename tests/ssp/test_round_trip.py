"""What is written and read again is the same system, and runs to the same bits."""

from __future__ import annotations

import zipfile

import fmpy.ssp.ssd
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from lxml import etree

from adcs import AdcsError, System, read_ssp, run, write_ssp
from adcs.catalogue import SYSTEMS
from orchestration.ssp.schemas import schema

VERSIONS = ("2.0", "3.0")


def facts(system, fmi_version="2.0"):
    """Every field of a system; FMUs by their content, as they lie elsewhere after reading."""
    return {
        "name": system.name,
        "description": system.description,
        "components": [
            (c.name, c.open(fmi_version).sha256, list(c.start.items()), c.every) for c in system.components.values()
        ],
        "connections": system.connections,
    }


def written(system, tmp_path, **settings):
    path = tmp_path / "written.ssp"
    write_ssp(system, path, **settings, force=True)
    return path


def everything(fmus, versions=("", "")):
    """A system that uses all that a connection, a component and a start value can have."""
    sender, receiver = (fmus[f"{name}{v}"] for name, v in zip(("sender", "receiver"), versions, strict=True))
    system = System("all & <sundry>", 'it "has" everything, ä and 漢')
    system.add(
        "z",
        receiver,
        {"w": [1.0, 2.0, 3.0], "J": [[1.5, -0.0], [1e-300, 1 / 3]], "seed": -7, "plain": 0.25, "shade": 1},
    )
    system.add("bus/one", sender, {"bias": 0.125}, every=3)
    system.add("two", sender, every=2)
    values = {"label": "a\n\t<b> & \"c\" 'd'", "fast": True, "tint": 7, "angle": 0.5, "plain": 4.0}
    system.add("bus/deep/er", receiver, {**values, "n": 5, "light": 20, "shade": 2})
    system.add("a b", receiver, {"u": 1.0, "M": [[1, 2], [3, 4]], "plain": -1.0, "light": 10, "shade": 7})
    system.connect("bus/one.y", "z.u")
    system.connect("two.far", "bus/deep/er.u", delay_steps=3)
    system.connect("bus/one.v", "bus/deep/er.w", delay=0.02)
    system.connect("bus/one.angle", "z.angle", factor=2.0, offset=-0.5)
    system.connect("two.M", "z.M", factor=1.0)
    system.connect("two.yes", "z.on", mapping=[(0, 1), (1, 0)])
    system.connect("two.n", "z.n", mapping=[(3, -3)], delay_steps=1)
    system.connect("two.colour", "z.light", mapping=[(1, 20), (7, 10)])
    system.connect("two.yes", "bus/deep/er.on")
    system.connect("two.yes", "a b.n", mapping=[(0, 5), (1, 6)])
    system.connect("two.v[2]", "a b.w[1]")
    system.connect("bus/one.v[2]", "a b.w[3]", factor=3.0)
    system.connect("bus/one.M[1,2]", "a b.w[2]")
    system.connect("bus/one.v[1]", "a b.angle", factor=1.0)
    for i, j in ((1, 1), (1, 2), (2, 1), (2, 2)):  # all of them, and still elements
        system.connect(f"bus/one.M[{i},{j}]", f"bus/deep/er.M[{i},{j}]")
    system.connect("bus/one.yes", "a b.on")
    return system


@pytest.mark.parametrize("versions", [("", ""), ("3", "3"), ("", "3"), ("3", "")])
def test_everything_comes_back(fmus, tmp_path, versions):
    system = everything(fmus, versions)
    path = written(system, tmp_path, start_time=-1.0, stop_time=2.5, step=0.01)
    file = read_ssp(path)
    assert facts(file.system) == facts(system)
    assert (file.start_time, file.stop_time, file.step) == (-1.0, 2.5, 0.01)
    assert file.version == ("2.0" if "3" in versions else "1.0")
    again = tmp_path / "again.ssp"
    write_ssp(file.system, again, start_time=-1.0, stop_time=2.5, step=0.01)
    assert again.read_bytes() == path.read_bytes()


def test_a_name_kept_for_flat_systems_is_in_the_order_of_adding(fmus, tmp_path):
    system = System("flat")
    for name in ("c", "a", "b"):
        system.add(name, fmus["sender"])
    assert list(read_ssp(written(system, tmp_path)).system.components) == ["c", "a", "b"]


def test_ssp_2_with_components_of_fmi_2(fmus, tmp_path):
    system = everything(fmus)
    file = read_ssp(written(system, tmp_path, ssp_version="2.0"))
    assert file.version == "2.0"
    assert facts(file.system) == facts(system)


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_shipped_system_comes_back(name, tmp_path):
    entry = SYSTEMS[name]
    system = entry.build()
    file = read_ssp(written(system, tmp_path, stop_time=entry.stop_time, step=entry.step))
    assert facts(file.system) == facts(system)
    assert (file.stop_time, file.step) == (entry.stop_time, entry.step)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["observer-pd", "full-state-pd"])
def test_shipped_systems_run_to_the_same_bits(name, version, tmp_path):
    entry = SYSTEMS[name]
    system = entry.build()
    path = written(system, tmp_path, stop_time=entry.stop_time, step=entry.step, fmi_version=version)
    file = read_ssp(path)
    assert facts(file.system) == facts(system, version)
    assert (file.start_time, file.stop_time, file.step) == (0.0, entry.stop_time, entry.step)
    expected = run(system, stop_time=2.0, step=entry.step, fmi_version=version)
    found = run(file.system, stop_time=2.0, step=file.step)
    assert list(found.ports) == list(expected.ports)
    assert np.array_equal(found.data, expected.data)


def test_start_values_changed_in_the_file_count(tmp_path):
    """An edit of the parameters, as another tool would make it, is the same as one of the system."""
    system = SYSTEMS["observer-pd"].build()
    path = written(system, tmp_path)
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    changed = files["resources/controller.ssv"].replace(b'<ssv:Real value="5"', b'<ssv:Real value="6.5"')
    assert changed != files["resources/controller.ssv"]
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in {**files, "resources/controller.ssv": changed}.items():
            archive.writestr(name, content)
    system.set("controller.k_v", 6.5)
    expected, found = (run(s, stop_time=1.0, step=0.01).data for s in (system, read_ssp(path).system))
    assert np.array_equal(found, expected)


def test_the_same_system_gives_the_same_bytes(fmus, tmp_path):
    first, second = (written(everything(fmus), tmp_path, step=0.1).read_bytes() for _ in range(2))
    assert first == second
    with zipfile.ZipFile(tmp_path / "written.ssp") as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        # at most version 2.0 of zip and ASCII names, as SSP wants it
        assert all(info.extract_version <= 20 and info.filename.isascii() for info in archive.infolist())


def test_fmus_are_packed_once_and_different_ones_of_one_name_apart(fmus, tmp_path):
    other = tmp_path / "other" / "sender.fmu"
    other.parent.mkdir()
    other.write_bytes(fmus["receiver"].read_bytes())
    system = System("three")
    system.add("a", fmus["sender"])
    system.add("b", fmus["sender"])
    values = {
        "u": 0.0,
        "angle": 0.0,
        "plain": 0.0,
        "w": [0.0] * 3,
        "M": [[0.0] * 2] * 2,
        "on": False,
        "n": 0,
        "light": 10,
        "shade": 1,
    }
    system.add("c", other, values)
    path = written(system, tmp_path)
    with zipfile.ZipFile(path) as archive:
        members = [name for name in archive.namelist() if name.endswith(".fmu")]
    assert members == ["resources/sender.fmu", "resources/sender-2.fmu"]
    assert facts(read_ssp(path).system) == facts(system)


class TestOtherReaders:
    def test_fmpy_reads_it(self, tmp_path):
        system = SYSTEMS["observer-pd"].build()
        path = written(system, tmp_path, stop_time=100.0)
        structure = fmpy.ssp.ssd.read_ssd(str(path))
        names = [component.name for component in fmpy.ssp.ssd.find_components(structure.system)]
        assert names == list(system.components)
        links = {
            (f"{a.parent.name}.{a.name}", f"{b.parent.name}.{b.name}")
            for a, b in fmpy.ssp.ssd.get_connections(structure.system)
        }
        assert len(links) == 31
        assert ("observer.omega_BN_B_est[2]", "controller.omega_BN_B[2]") in links

    def test_fmpy_runs_it(self, tmp_path):
        """fmpy feeds zeros in the first step, delays every connection and applies no parameters: where these do not
        matter, its values are ours; its time labels are one step early."""
        system = System("wheel")
        system.add("guidance", "FixedAxisReference")
        system.add("plant", "RigidBody", {"torque_disturbance_B": (0.0, 0.0, 0.0)})
        system.connect("guidance.omega_RN_R", "plant.torque_B", factor=1.0)
        path = written(system, tmp_path)
        theirs = simulate_ssp(str(path), stop_time=0.05, step_size=0.01)
        ours = run(system, stop_time=0.05, step=0.01)
        assert np.allclose(theirs["guidance.angle"][:5], ours["guidance.angle"][1:6], rtol=1e-14, atol=0)
        assert np.abs(theirs["plant.omega_BN_B[1]"][-1]) > 0

    def test_it_is_valid_by_the_schemas_of_ssp(self, fmus, tmp_path):
        for versions in (("", ""), ("3", "3")):
            with zipfile.ZipFile(written(everything(fmus, versions), tmp_path, step=0.1)) as archive:
                for name in archive.namelist():
                    if not name.endswith(".fmu"):
                        root = etree.fromstring(archive.read(name))
                        schema(name[-3:], root.get("version")).assertValid(root)


class TestRefusals:
    def test_unconnected_inputs(self, fmus, tmp_path):
        system = System("open")
        system.add("b", fmus["receiver"])
        with pytest.raises(AdcsError, match=r"input b\.u is not connected"):
            written(system, tmp_path)
        assert not (tmp_path / "written.ssp").exists()

    def test_ssp_1_with_fmi_3(self, fmus, tmp_path):
        with pytest.raises(AdcsError, match=r"SSP 1\.0 has no arrays as FMI 3\.0 has: write SSP 2\.0"):
            written(everything(fmus, ("3", "3")), tmp_path, ssp_version="1.0")

    @pytest.mark.parametrize(("name", "value"), [("step", 0.0), ("step", -1.0), ("stop_time", np.inf)])
    def test_bad_times(self, fmus, tmp_path, name, value):
        with pytest.raises(AdcsError, match=f"{name} = .*: expected a"):
            written(everything(fmus), tmp_path, **{name: value})

    def test_characters_that_xml_cannot_hold(self, fmus, tmp_path):
        system = System("bad")
        system.add("a", fmus["sender"])
        system.description = "\x01"
        with pytest.raises(AdcsError, match="has characters that XML cannot hold"):
            written(system, tmp_path)

    def test_a_component_named_like_a_nested_system(self, fmus, tmp_path):
        for names in (("a", "a/b"), ("a/b", "a")):
            system = System("bad")
            for name in names:
                system.add(name, fmus["sender"])
            with pytest.raises(AdcsError, match="'a' is a component and a nested system: rename one of them"):
                written(system, tmp_path)

    def test_folders_that_cannot_be_written(self, fmus, tmp_path):
        (tmp_path / "file").write_text("")
        system = System("s")
        system.add("a", fmus["sender"])
        with pytest.raises(AdcsError, match="cannot write"):
            write_ssp(system, tmp_path / "file" / "x.ssp")

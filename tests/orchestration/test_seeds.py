"""Seeds that nobody chose follow from the names of the components, and travel with the system."""

import json
from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from test_command_line import adcs

from adcs import System, run
from fmus import fmu_path
from orchestration.fmu.file import Fmu, open_fmu
from orchestration.fmu.seeds import default_seed, seeds_of
from orchestration.results.manifest import make_manifest

GYRO = {"gyro_noise": 1.0, "period": 0.1, "omega_BN_B": (0, 0, 0), "specific_force_B": (0, 0, 0)}
SEEDS = {"port": 1983658957, "starboard": 901417892}
"""By SHA-256 of `port.seed` and `starboard.seed`, its first 31 bits."""


def gyros(**seeds: int) -> System:
    system = System("gyros")
    for name in SEEDS:
        system.add(name, "InertialMeasurementUnit", GYRO | ({"seed": seeds[name]} if name in seeds else {}))
    return system


def seeds(system: System) -> dict[str, int]:
    return {name: component.start["seed"][0] for name, component in system.components.items()}


def test_each_component_has_the_seed_of_its_name() -> None:
    """The same in every system, in any order, in every process."""
    assert seeds(gyros()) == SEEDS
    other = System("another")
    for name in reversed(SEEDS):
        other.add(name, "InertialMeasurementUnit", GYRO)
    assert seeds(other) == SEEDS


def test_a_seed_that_is_given_stays() -> None:
    assert seeds(gyros(port=1)) == SEEDS | {"port": 1}
    system = gyros()
    system.set("starboard.seed", 5)
    assert seeds(system) == SEEDS | {"starboard": 5}
    assert seeds(system.refined()) == SEEDS | {"starboard": 5}


def test_two_gyros_have_noise_of_their_own_unless_it_is_asked_for() -> None:
    n = 4000

    def correlation(system: System) -> float:
        result = run(system, stop_time=(n - 1) * 0.1, step=0.1)
        a, b = (result[f"{name}.omega_BN_B_meas"][:, 0] for name in SEEDS)
        return float(np.corrcoef(a, b)[0, 1])

    assert abs(correlation(gyros())) < 4 / sqrt(n)
    assert correlation(gyros(port=1, starboard=1)) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_manifest_says_them(version: str) -> None:
    manifest = make_manifest(gyros(), version, {})
    assert manifest["seeds"] == {f"{name}.seed": seed for name, seed in SEEDS.items()}
    assert {n: c["start"]["seed"] for n, c in manifest["system"]["components"].items()} == SEEDS


@pytest.mark.parametrize(("settings", "seed"), [((), 1), (("--set", "tracker.seed=7"), 7)])
def test_a_system_by_name_keeps_what_it_gives(settings: tuple[str, ...], seed: int, tmp_path: Path) -> None:
    command = ["run", "observer-pd", "--stop", "0.1", "--step", "0.1", "--no-report", "--out", str(tmp_path), *settings]
    assert adcs(*command) == 0
    assert json.loads((tmp_path / "manifest.json").read_text())["seeds"] == {"tracker.seed": seed}


@pytest.mark.parametrize(("settings", "seed"), [((), 2145599731), (("--set", "StarTracker.seed=7"), 7)])
def test_the_command_line_replaces_them(settings: tuple[str, ...], seed: int, tmp_path: Path) -> None:
    """A component that is run alone goes by its own name."""
    command = [
        "run",
        str(fmu_path("StarTracker", "2.0")),
        "--stop",
        "0.1",
        "--step",
        "0.1",
        "--no-report",
        "--out",
        str(tmp_path),
        *settings,
    ]
    assert adcs(*command) == 0
    assert json.loads((tmp_path / "manifest.json").read_text())["seeds"] == {"StarTracker.seed": seed}


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_seed_is_known_by_its_declared_type_and_not_by_its_name(version: str) -> None:
    fmu = open_fmu(fmu_path("Magnetometer", version))
    assert [port.name for port in seeds_of(fmu.ports.values())] == ["seed"]
    assert fmu.ports["seed"].start == (1,)
    assert seeds_of([replace(fmu.ports["seed"], name="whatever")])
    assert not seeds_of([replace(fmu.ports["seed"], declared_type=None)])
    assert not seeds_of([replace(fmu.ports["seed"], type="Float64")])
    assert not seeds_of([replace(fmu.ports["seed"], causality="input")])


def test_an_array_of_seeds_has_as_many_of_them() -> None:
    fmu: Fmu = open_fmu(fmu_path("Magnetometer", "2.0"))
    several = default_seed("a", replace(fmu.ports["seed"], shape=(3,)))
    assert len(set(several)) == 3
    assert several[0] == default_seed("a", replace(fmu.ports["seed"], name="seed[1]"))[0]


def test_seeds_of_many_names_differ_and_fit() -> None:
    port = open_fmu(fmu_path("Magnetometer", "2.0")).ports["seed"]
    found = {default_seed(f"ring/{i}/tracker", port)[0] for i in range(2000)}
    assert len(found) == 2000
    assert 0 <= min(found) < max(found) < 2**31


def test_the_same_seed_in_two_of_a_kind_is_a_warning() -> None:
    """Also where nobody gave it, as in an SSP file that leaves each FMU its own."""
    assert make_manifest(gyros(), "2.0", {})["warnings"] == []
    (warning,) = make_manifest(gyros(port=1, starboard=1), "2.0", {})["warnings"]
    assert warning == (
        "port and starboard (InertialMeasurementUnit) have the same seed = 1, and so the same noise: give them "
        "different ones, as in --set starboard.seed=2"
    )

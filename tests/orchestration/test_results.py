"""Results in memory and in files."""

import csv
import hashlib
import json

import numpy as np
import pytest
import scipy.io

from adcs import AdcsError, ModelExchange, Save, System, run
from orchestration.running.parts import parts


@pytest.fixture
def result(chain):
    return run(chain(), stop_time=1.0, step=0.1)


def test_access_by_name(result, mock):
    assert result.names == ["integrator.y", "gain.y", "gain.doubled", "source.y"]
    assert result["gain.y"].shape == (11, 3)
    assert result.unit("gain.y") == "m/s"
    assert result.description("gain.y") == "y of gain"
    with pytest.raises(AdcsError, match=r"'gain\.z' was not recorded: did you mean gain\.y"):
        result["gain.z"]
    system = System("typed")
    system.add("typed", mock("typed"))
    one = run(system, stop_time=1, step=0.5, save=Save(["typed.y", "typed.matrix"]))
    assert one["typed.y"].shape == (3,)
    assert one["typed.matrix"].shape == (3, 2, 3)
    assert one.unit("typed.y") is None


def test_select(result):
    some = result.select(["source.y", "gain.y"])
    assert some.names == ["source.y", "gain.y"]
    assert np.array_equal(some["gain.y"], result["gain.y"])
    assert some.data.shape == (11, 6)


def test_csv_keeps_every_digit(result, tmp_path):
    result.write_csv(tmp_path / "new" / "result.csv")
    with (tmp_path / "new" / "result.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0][:4] == ["time[s]", "integrator.y[1][m]", "integrator.y[2][m]", "integrator.y[3][m]"]
    assert len(rows[0]) == 13
    values = np.array([[float(cell) for cell in row] for row in rows[1:]])
    assert np.array_equal(values[:, 0], result.time)
    assert np.array_equal(values[:, 1:], result.data)


def test_csv_header_of_matrices_and_of_variables_without_unit(mock, tmp_path):
    system = System("typed")
    system.add("typed", mock("typed"))
    run(system, stop_time=1, step=1, save=Save(["typed.matrix", "typed.y"])).write_csv(tmp_path / "r.csv")
    with (tmp_path / "r.csv").open() as file:
        header = next(csv.reader(file))
    assert header[1:3] == ["typed.matrix[1,1][-]", "typed.matrix[1,2][-]"]
    assert header[-1] == "typed.y[-]"


def test_mat_has_one_struct_per_component(result, tmp_path):
    result.write_mat(tmp_path / "result.mat")
    file = scipy.io.loadmat(tmp_path / "result.mat", simplify_cells=True)
    assert np.array_equal(file["time"], result.time)
    assert np.array_equal(file["integrator"]["y"], result["integrator.y"])
    assert file["units"]["gain"] == {"y": "m/s", "doubled": "m"}


def test_mat_names_are_valid_and_distinct(mock, tmp_path):
    system = System("names")
    for name in ("time", "1st wheel", "1st-wheel", "_"):
        system.add(name, mock("oscillator"), {"u": 0.0, "a": 2.0})
    names = [f"{c}.{v}" for c in system.components for v in ("position", "der(a)")]
    run(system, stop_time=1, step=1, save=Save(names)).write_mat(tmp_path / "result.mat")
    file = scipy.io.loadmat(tmp_path / "result.mat", simplify_cells=True)
    assert {n for n in file if not n.startswith("__")} == {
        "time",
        "time_2",
        "x_1st_wheel",
        "x_1st_wheel_2",
        "x_",
        "units",
    }
    assert set(file["x_1st_wheel"]) == {"position", "der_a"}
    assert file["time"].tolist() == [0.0, 1.0]


def test_manifest_repeats_the_run(mock, chain, tmp_path):
    result = run(chain(), start_time=1.0, stop_time=2.0, step=0.1, method=ModelExchange(rtol=1e-9))
    result.write_manifest(tmp_path / "manifest.json")
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["system"]["name"] == "chain"
    assert manifest["system"]["connections"] == [["gain.y", "integrator.u"], ["source.y", "gain.u"]]
    gain = manifest["system"]["components"]["gain"]
    assert gain["file"] == "gain.fmu"
    assert gain["fmi_version"] == "2.0"
    assert gain["start"] == {"k": 2.0}
    assert gain["sha256"] == hashlib.sha256(mock("gain").read_bytes()).hexdigest()
    settings = {"start_time": 1.0, "stop_time": 2.0, "step": 0.1, "rtol": 1e-9, "atol": 1e-9 / 100}
    assert manifest["settings"] == {"method": "model-exchange", "fmi_version": "2.0", "solver": "DOP853", **settings}
    assert manifest["outcome"] == {"status": "complete", "rows": 11}
    assert manifest["timing"]["simulated_s"] == pytest.approx(1.0)
    assert manifest["timing"]["wall_s"] > 0
    assert set(manifest["versions"]) >= {"python", "fmpy", "numpy", "scipy", "platform"}
    again = System("again")
    for name, component in manifest["system"]["components"].items():
        again.add(name, component["fmu"], component["start"])
    for source, target in manifest["system"]["connections"]:
        again.connect(source, target)
    assert np.array_equal(run(again, **parts(manifest["settings"])[0]).data, result.data)

"""Result files: HDF5 as the run goes on, typed values, every n-th row; read back by others."""

import io
import json

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io

from adcs import AdcsError, CoSimulation, Save, System, run
from adcs.catalogue import SYSTEMS
from orchestration.results import hdf5

T5 = SYSTEMS["observer-pd"]


def test_rows_that_go_to_a_file_are_those_in_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(hdf5, "AT_ONCE", 1000)  # some 17 rows
    common = {"stop_time": 5, "step": 0.01}
    kept = run(T5.build(), **common)
    filed = run(T5.build(), **common, save=Save(to=tmp_path / "result.h5"))
    assert filed.names == kept.names
    assert np.array_equal(filed.time, kept.time)
    for name in kept.names:
        assert np.array_equal(filed[name], kept[name])
        assert filed[name].shape == kept[name].shape
        assert (filed.unit(name), filed.description(name)) == (kept.unit(name), kept.description(name))
    filed.write_csv(tmp_path / "filed.csv")
    kept.write_csv(tmp_path / "kept.csv")
    assert (tmp_path / "filed.csv").read_bytes() == (tmp_path / "kept.csv").read_bytes()
    some = filed.select(["plant.q_BN"])
    assert some.names == ["plant.q_BN"]
    assert np.array_equal(some["plant.q_BN"], kept["plant.q_BN"])
    with h5py.File(tmp_path / "result.h5") as file:
        assert np.array_equal(file["plant/q_BN"][:], kept["plant.q_BN"])
        assert file["plant/omega_BN_B"].attrs["unit"] == "rad/s"
        assert file["time"].attrs["unit"] == "s"
        assert json.loads(file["manifest"][()])["outcome"] == {"status": "complete", "rows": 501}


def test_a_result_in_memory_is_written_alike(tmp_path, monkeypatch):
    monkeypatch.setattr(hdf5, "AT_ONCE", 100)
    result = run(T5.build(), stop_time=1, step=0.1)
    result.write_hdf5(tmp_path / "result.h5")
    with h5py.File(tmp_path / "result.h5") as file:
        assert sorted(file) == ["controller", "guidance", "manifest", "observer", "plant", "time", "tracker"]
        for name in result.names:
            assert np.array_equal(file[name.replace(".", "/")][:], result[name])


def test_a_failing_run_keeps_its_file(faulty, tmp_path):
    with pytest.raises(AdcsError, match="3 rows are kept"):
        run(faulty("2.0", 1), stop_time=1, step=0.25, save=Save(to=tmp_path / "result.h5"))
    with h5py.File(tmp_path / "result.h5") as file:
        assert file["time"][:].tolist() == [0.0, 0.25, 0.5]
        assert file["source/y"][:, 0].tolist() == [0.0, 0.25, 0.5]


def test_a_file_that_cannot_be_written_is_refused(chain, tmp_path):
    (tmp_path / "folder").mkdir()
    with pytest.raises(AdcsError, match="cannot write"):
        run(chain(), stop_time=1, step=0.5, save=Save(to=tmp_path / "folder"))


@pytest.mark.parametrize("stepping", ["compiled", "python"])
def test_every_nth_row(chain, stepping):
    every = run(chain(), stop_time=10, step=0.01, method=CoSimulation(stepping=stepping))
    fourth = run(chain(), stop_time=10, step=0.01, method=CoSimulation(stepping=stepping), save=Save(every=4))
    assert np.array_equal(fourth.time, every.time[::4])
    assert np.array_equal(fourth.data, every.data[::4])
    third = run(chain(), stop_time=10, step=0.01, method=CoSimulation(stepping=stepping), save=Save(every=300))
    assert np.array_equal(third.time, every.time[::300])  # 0, 3, 6 and 9 s
    assert np.array_equal(third.data, every.data[::300])


def test_integers_and_booleans_stay_what_they_are(mock, version, tmp_path):
    system = System("typed")
    system.add("typed", mock("typed", version), {"n": 3, "flag": True})
    result = run(
        system, stop_time=1, step=0.5, fmi_version=version, save=Save(["typed.whole", "typed.flag", "typed.y"])
    )
    assert result["typed.whole"].dtype == np.int64
    assert result["typed.whole"].tolist() == [3, 3, 3]
    assert result["typed.flag"].dtype == np.bool_
    assert result["typed.flag"].tolist() == [True, True, True]
    result.write_csv(tmp_path / "result.csv")
    lines = (tmp_path / "result.csv").read_text().splitlines()
    assert lines[0] == "time[s],typed.whole[-],typed.flag[-],typed.y[-]"
    assert lines[1] == "0.0,3,1,3.5"
    result.write_hdf5(tmp_path / "result.h5")
    with h5py.File(tmp_path / "result.h5") as file:
        assert file["typed/whole"].dtype == np.int64
        assert file["typed/flag"].dtype == np.bool_
    result.write_mat(tmp_path / "result.mat")
    read = scipy.io.loadmat(tmp_path / "result.mat", squeeze_me=True, struct_as_record=False)
    assert read["typed"].whole.tolist() == [3, 3, 3]


def test_pandas_reads_the_csv_and_the_hdf5(tmp_path):
    result = run(T5.build(), stop_time=1, step=0.1)
    result.write_csv(tmp_path / "result.csv")
    table = pd.read_csv(tmp_path / "result.csv", index_col="time[s]")
    assert np.array_equal(table.index, result.time)
    assert np.array_equal(table["plant.omega_BN_B[2][rad/s]"], result["plant.omega_BN_B"][:, 1])
    result.write_hdf5(tmp_path / "result.h5")
    with h5py.File(tmp_path / "result.h5") as file:
        frame = pd.DataFrame(file["plant/omega_BN_B"][:], index=file["time"][:], columns=list("xyz"))
    assert np.array_equal(frame["y"], result["plant.omega_BN_B"][:, 1])
    assert pd.read_csv(io.StringIO(frame.to_csv())).shape == (11, 4)

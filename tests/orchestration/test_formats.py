"""Files that outlive a run say what they are, and are refused by name in another version."""

import io
import json
import re
import struct
from pathlib import Path

import h5py
import numpy as np
import pytest

import adcs
from adcs import AdcsError, Save, System, run
from adcs.cli.app import app
from hil_bridge.ground import security
from hil_bridge.ground.security import Keyring
from orchestration.isolation import journal
from orchestration.isolation.journal import Journal
from orchestration.results import hdf5, manifest
from orchestration.running import checkpoint
from tests.invoking import invoke

ROOT = Path(__file__).parents[2]
TIMES = {"stop_time": 1.0, "step": 0.5}


@pytest.fixture
def state(own, tmp_path):
    """A checkpoint."""
    path = tmp_path / "state.npz"
    run(own(), **TIMES, hooks=[adcs.checkpoint(path)])
    return path


@pytest.fixture
def own():
    """A system of one component that was built here."""

    def build():
        system = System("tumbling")
        system.add("body", "RigidBody", {"torque_B": [0.1, 0.0, 0.0], "torque_disturbance_B": [0.0, 0.0, 0.0]})
        return system

    return build


def rewritten(path, change):
    """Change the arrays of a checkpoint."""
    arrays = dict(np.load(io.BytesIO(path.read_bytes())))
    change(arrays)
    with path.open("wb") as file:
        np.savez(file, **arrays)


def with_about(path, **changes):
    def change(arrays):
        about = json.loads(arrays["about"].tobytes()) | changes
        arrays["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)

    rewritten(path, change)


def test_a_manifest_says_its_version_first(chain, tmp_path):
    run(chain(), **TIMES).write_manifest(tmp_path / "manifest.json")
    content = json.loads((tmp_path / "manifest.json").read_text())
    assert next(iter(content.items())) == ("format", "adcs-manifest-2")


def test_what_has_no_version_says_what_is_in_it(chain, tmp_path):
    result = run(chain(), **TIMES, save=Save(["gain.y"]))
    result.write_csv(tmp_path / "result.csv")
    result.write_mat(tmp_path / "result.mat")
    header = (tmp_path / "result.csv").read_text().splitlines()[0]
    assert header == "time[s],gain.y[1][m/s],gain.y[2][m/s],gain.y[3][m/s]"
    assert (tmp_path / "result.mat").read_bytes().startswith(b"MATLAB 5.0 MAT-file")


@pytest.mark.parametrize("as_it_goes", [True, False])
def test_results_in_hdf5_say_their_version(chain, tmp_path, as_it_goes):
    path = tmp_path / "result.h5"
    result = run(chain(), **TIMES, save=Save(to=path if as_it_goes else None))
    if not as_it_goes:
        result.write_hdf5(path)
    with h5py.File(path) as file:
        assert file.attrs["format"] == "adcs-results-1"
        assert json.loads(file["manifest"][()])["format"] == "adcs-manifest-2"


def test_a_checkpoint_of_another_version_is_refused_by_name(own, state):
    assert json.loads(np.load(state)["about"].tobytes())["format"] == "adcs-checkpoint-1"
    assert len(run(own(), stop_time=2.0, step=0.5, resume=state).time) == 3
    with_about(state, format="adcs-checkpoint-9", k={"point": 2})
    with pytest.raises(AdcsError) as error:
        run(own(), stop_time=2.0, step=0.5, resume=state)
    assert str(error.value) == (
        f"{state} is a checkpoint of another version, adcs-checkpoint-9: this program reads adcs-checkpoint-1; "
        "run from the start, or go on with the adcs-fmus that wrote it"
    )


@pytest.mark.parametrize("said", ["adcs-results-1", "adcs-checkpoint-", "adcs-checkpoint-x", "", None, 1])
def test_what_says_no_version_of_a_checkpoint_is_none(own, state, said):
    with_about(state, format=said)
    with pytest.raises(AdcsError) as error:
        run(own(), stop_time=2.0, step=0.5, resume=state)
    assert str(error.value) == (
        f"{state} is not a checkpoint of this program: give a file that `checkpoint` has written"
    )


def test_a_component_s_state_of_another_version_is_refused_by_name(own, state):
    def change(arrays):
        content = bytearray(arrays["state_0"].tobytes())
        at = content.index(b"ADCS") + 4
        assert content[at : at + 4] == struct.pack("<I", 3)
        content[at : at + 4] = struct.pack("<I", 9)
        arrays["state_0"] = np.frombuffer(bytes(content), np.uint8)

    rewritten(state, change)
    with pytest.raises(AdcsError, match=r"^body: .*the saved state has format 9, expected 3: it comes from another"):
        run(own(), stop_time=2.0, step=0.5, resume=state)


def test_a_journal_of_another_version_is_refused_by_name_and_stays(chain, tmp_path):
    path = tmp_path / "run.journal"
    kept = Journal(path)
    run(chain(), **TIMES, save=Save(to=kept))
    kept.close()
    content = path.read_bytes()
    assert content[:16] == b"adcs-journal-2\n\0"
    for number in (1, 9, 10):
        other = f"adcs-journal-{number}\n".encode().ljust(16, b"\0") + content[16:]
        path.write_bytes(other)
        assert str(invoke(app, ["recover", str(tmp_path)]).exception) == (
            f"{path} is a journal of another version, adcs-journal-{number}: this program reads adcs-journal-2; "
            "recover it with the adcs-fmus that wrote it"
        )
        assert path.read_bytes() == other
    path.write_bytes(b"\0" * len(content))
    with pytest.raises(AdcsError, match=r"is no journal of a run, or of one that had not begun$"):
        journal.read(path)


def test_times_of_signed_messages_of_another_version_are_refused_by_name(tmp_path):
    path, key = tmp_path / "key.times", bytes(32)
    first = Keyring(key, path)
    sent = first.now()
    first.save()
    content = json.loads(path.read_text())
    assert content == {"format": "adcs-signing-1", "sent": sent, "seen": []}
    assert Keyring(key, path).now() > sent
    path.write_text(json.dumps(content | {"format": "adcs-signing-9"}))
    with pytest.raises(AdcsError) as error:
        Keyring(key, path)
    assert str(error.value) == (
        f"{path} is a record of signed messages of another version, adcs-signing-9: this program reads "
        "adcs-signing-1; remove it"
    )
    for other in ({"sent": 1, "seen": []}, [], 1, content | {"format": "x"}):
        path.write_text(json.dumps(other))
        with pytest.raises(AdcsError, match=r"does not hold the times of signed messages: .*; remove it$"):
            Keyring(key, path)


def test_the_versions_are_those_of_the_documentation():
    said = (ROOT / "docs/formats.md").read_text(encoding="utf-8")
    header = (ROOT / "src/fmi/saved_state.hpp").read_text(encoding="utf-8")
    states = re.search(r"its_version = (\d+);", header)
    assert states and f"| {states[1]}: the second number" in said
    ours = {manifest.FORMAT, hdf5.FORMAT, checkpoint._FORMAT, journal._FORMAT, security._FORMAT}
    assert set(re.findall(r"`(adcs-\w+-\d+)`", said)) == ours

"""The notebooks of the documentation run, and show what is stored in them."""

from pathlib import Path

import pytest
from notebooks import NOTEBOOKS, Json, code_cells, outputs, read


def without_pictures(output: Json) -> Json:
    """What has to be the same everywhere; a picture depends on Matplotlib and its fonts."""
    data = output.get("data", {})
    return output | {"data": {kind: content for kind, content in data.items() if kind != "image/png"}}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_cells_show_what_is_stored(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run `python -m tests.docs.notebooks` if what they show is meant to change."""
    monkeypatch.chdir(tmp_path)
    notebook = read(path)
    found = outputs(notebook, path.name)
    pictures = 0
    for cell, shown in zip(code_cells(notebook), found, strict=True):
        assert [*map(without_pictures, cell["outputs"])] == [*map(without_pictures, shown)], "".join(cell["source"])
        stored = ["image/png" in output.get("data", {}) for output in cell["outputs"]]
        assert stored == ["image/png" in output.get("data", {}) for output in shown]
        pictures += sum(stored)
    assert pictures > 0
    assert path.stat().st_size < 200_000


def test_there_is_one() -> None:
    assert [path.name for path in NOTEBOOKS] == ["first-steps.ipynb"]

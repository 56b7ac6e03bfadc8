from __future__ import annotations

import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from packages import make_fmu, receiver, sender

from orchestration.ssp import archive

sys.path.append(str(Path(__file__).parents[1] / "orchestration"))  # whose mocks are used
import foreign_fmus

Package = Callable[..., Path]


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """`sender`, `receiver` of FMI 2, `sender3`, `receiver3` of FMI 3."""
    folder = tmp_path_factory.mktemp("fmus")
    made = {}
    for name, variables in (("sender", sender()), ("receiver", receiver())):
        made[name] = make_fmu(folder / f"{name}.fmu", variables)
        made[f"{name}3"] = make_fmu(folder / f"{name}3.fmu", variables, "3.0")
    return made


@pytest.fixture(scope="session")
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def common_cache(cache_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """FMUs taken out of `.ssp` files go to a folder of the tests."""
    monkeypatch.setattr(archive, "CACHE", cache_folder)


@pytest.fixture
def own_cache(common_cache: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """They go to a folder of this test."""
    monkeypatch.setattr(archive, "CACHE", tmp_path / "cache")
    return tmp_path / "cache"


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """foreign("sizes") -> path of an FMU of FMI 3.0 that runs."""
    folder = tmp_path_factory.mktemp("foreign")
    return lambda model, **settings: foreign_fmus.build(model, folder, "3.0", **settings)


@pytest.fixture
def package(tmp_path: Path, fmus: dict[str, Path]) -> Package:
    """package(ssd, {"resources/a.fmu": "sender"}, {"resources/x.ssv": text}) -> path of an `.ssp`.

    The FMUs are those of `fmus`, or paths of others.
    """

    def make(
        ssd: str | bytes | None, parts: dict[str, str | Path] | None = None, files: dict[str, str | bytes] | None = None
    ) -> Path:
        path = tmp_path / "test.ssp"
        with zipfile.ZipFile(path, "w") as zipped:
            if ssd is not None:
                zipped.writestr("SystemStructure.ssd", ssd)
            for member, name in (parts or {"resources/a.fmu": "sender", "resources/b.fmu": "receiver"}).items():
                zipped.writestr(member, fmus.get(str(name), Path(name)).read_bytes())
            for member, content in (files or {}).items():
                zipped.writestr(member, content)
        return path

    return make

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import foreign_fmus
import mocks
import pytest

from adcs import System

Mock = Callable[..., Path]


@pytest.fixture(scope="session")
def mock_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mocks")


@pytest.fixture(scope="session")
def mock(mock_folder: Path) -> Mock:
    """mock("gain", "3.0") -> path of the FMU."""
    return lambda model, version="2.0", **settings: mocks.build(model, mock_folder, version, **settings)


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Mock:
    """foreign("sizes", "3.0") -> path of the FMU; one with other settings needs a `name` of its own."""
    folder = tmp_path_factory.mktemp("foreign")
    made: dict[Path, object] = {}

    def make(model: str, version: str = "3.0", **settings: Any) -> Path:
        path = foreign_fmus.build(model, folder, version, **settings)
        assert made.setdefault(path, settings) == settings
        return path

    return make


@pytest.fixture(params=["2.0", "3.0"])
def version(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def chain(mock: Mock) -> Callable[..., System]:
    """source -> gain -> integrator, three wide: y = offset + t, doubled by the gain, integrated from x = (0, 0, 10)."""

    def build(version: str = "2.0") -> System:
        system = System("chain", "source, gain and integrator")
        system.add(
            "integrator", mock("integrator", version), {"x": [0.0, 0.0, 10.0]}
        )  # order of adding must not matter
        system.add("gain", mock("gain", version), {"k": 2.0})
        system.add("source", mock("source", version), {"offset": [1.0, 2.0, 3.0]})
        system.connect("gain.y", "integrator.u")
        system.connect("source.y", "gain.u")
        return system

    return build


@pytest.fixture
def faulty(mock: Mock) -> Callable[..., System]:
    """A fine component, and one that fails as its mode says."""

    def build(version: str, mode: int, at: float = 0.5) -> System:
        system = System("faulty")
        system.add("source", mock("source", version))
        system.add("wheel", mock("faulty", version), {"mode": mode, "from": at})
        return system

    return build

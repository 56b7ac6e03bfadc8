from __future__ import annotations

import numpy as np
import pytest

from hil_bridge.ground.settings import Settings

from .ground import ROLES, Ground, Station, columns, parameter


@pytest.fixture
def ground() -> Ground:
    return Ground()


@pytest.fixture
def settings() -> Settings:
    return Settings("test", columns(ROLES), 0.01, parameters=[parameter("CTRL_K_P", "controller.k_p")])


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


@pytest.fixture
def station(settings: Settings) -> Station:
    return Station(settings)

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from .tries import counts, summary

FIXED = 40  # tries at each reader in every run of the tests: always the same ones
LONG = os.environ.get("ADCS_ATTACK")

settings.register_profile(
    "attack",
    max_examples=int(LONG or FIXED),
    derandomize=not LONG,
    database=None,
    deadline=None,  # `attempt` has its own, in CPU time
    print_blob=True,
    suppress_health_check=list(HealthCheck),
)
settings.load_profile("attack")  # now, as tests take their settings when they are defined


@pytest.fixture(scope="session")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for files that are written over and over."""
    return tmp_path_factory.mktemp("attack")


def pytest_sessionfinish(session: pytest.Session) -> None:
    if hasattr(session.config, "workeroutput"):  # a worker of pytest-xdist
        session.config.workeroutput["attack"] = dict(counts)


def pytest_testnodedown(node: Any) -> None:
    for reader, (read, refused) in getattr(node, "workeroutput", {}).get("attack", {}).items():
        counts[reader][0] += read
        counts[reader][1] += refused


def pytest_terminal_summary(terminalreporter: Any) -> None:
    if counts:
        terminalreporter.section("attacks")
        for line in summary(counts):
            terminalreporter.line(line)

"""The engine as a file for each platform, as a wheel carries it."""

import pytest

from fmus.paths import BUILD
from fmus.toolchain import TARGETS
from orchestration.engine import library_for


@pytest.mark.parametrize("target", [t for t in TARGETS if t.suffix != ".dll"], ids=lambda t: t.name)  # takes minutes
def test_it_does_not_know_where_it_was_made(target):
    content = library_for(target).read_bytes()
    assert b"adcs_steps" in content
    assert str(BUILD).encode() not in content

"""A variable that refers to a variable or type that is not there is refused, by what refers to what."""

from pathlib import Path

import foreign_fmus
import pytest

from adcs import AdcsError
from orchestration.fmu.file import open_fmu


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("references")


@pytest.mark.parametrize(
    ("model", "version", "old", "new", "message"),
    [
        ("counter", "3.0", 'clocks="0"', 'clocks="0 77"', "count (line 2): clocks refers to the value reference 77"),
        ("counter", "3.0", 'name="held"', 'name="held" previous="77"', "previous refers to the value reference 77"),
        (
            "sizes",
            "3.0",
            '<Dimension valueReference="0"',
            '<Dimension valueReference="77"',
            "u (line 2): Dimension refers",
        ),
        (
            "sizes",
            "3.0",
            'name="y"',
            'name="y" derivative="77"',
            "y (line 2): derivative refers to the value reference 77",
        ),
        (
            "picky",
            "2.0",
            "<Real />",
            '<Real derivative="77"/>',
            "x (line 2): derivative refers to the index 77, which no",
        ),
        (
            "types",
            "3.0",
            'declaredType="Phase"',
            'declaredType="Phases"',
            "declaredType refers to 'Phases', which Type",
        ),
        (
            "types",
            "2.0",
            'declaredType="Phase"',
            'declaredType="Phases"',
            "phase (line 2): declaredType refers to 'Phases'",
        ),
    ],
)
def test_what_is_not_there_is_named(folder, tmp_path, model, version, old, new, message):
    fmu = foreign_fmus.build(model, folder, version)
    open_fmu(fmu)
    broken = foreign_fmus.changed(fmu, tmp_path / "broken.fmu", old, new)
    with pytest.raises(AdcsError) as error:
        open_fmu(broken)
    assert message in str(error.value)
    assert str(error.value).startswith(f"{broken} is not valid: ")
    assert "download" not in str(error.value)

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

import fmus
from fmus.describe import Description, parse

Edit = Callable[[bytes], bytes | None]


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the FMUs of two components: one with states and a matrix, one sampled with an integer."""
    folder = tmp_path_factory.mktemp("dist")
    fmus.build(["RigidBody", "StarTracker"], dist=folder)
    return folder


@pytest.fixture
def mutate(built: Path, tmp_path: Path) -> Callable[..., Path]:
    """Copies an FMU with some files edited (None: left out) and some added."""

    def mutate(fmu: str, edits: dict[str, Edit] | None = None, added: dict[str, bytes] | None = None) -> Path:
        path = tmp_path / fmu
        with zipfile.ZipFile(built / fmu) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                content = old.read(name)
                changed = (edits or {}).get(name, lambda same: same)(content)
                if edits and name in edits:
                    assert changed != content, f"the edit of {name} changed nothing"
                if changed is not None:
                    new.writestr(name, changed)
            for name, content in (added or {}).items():
                new.writestr(name, content)
        return path

    return mutate


@pytest.fixture
def spinner() -> Description:
    """A made-up component with everything that the XML has to express."""

    def variable(name: str, vr: int, shape: list[int], causality: str, **more: object) -> dict[str, object]:
        return {
            "name": name,
            "vr": vr,
            "shape": shape,
            "type": "Float64",
            "causality": causality,
            "variability": "continuous",
            "initial": None,
            "unit": "rad/s",
            "display_unit": None,
            "start": None,
            "min": None,
            "max": None,
            "nominal": None,
            "description": f"the {name}",
            "derivative_of": None,
            "dependencies": None,
            "initial_dependencies": None,
        } | more

    parameter = {"variability": "tunable", "initial": "exact"}
    return parse(
        {
            "name": "Spinner",
            "description": "spins",
            "reference": "A. Author, Sec. 1",
            "token": "{token}",
            "differentiable": True,
            "sampled": False,
            "states": 2,
            "log_categories": [{"name": "logStatusError", "description": "errors"}],
            "units": [
                {"name": "s", "exponents": {"s": 1}, "factor": 1.0, "offset": 0.0, "display": []},
                {
                    "name": "rad/s",
                    "exponents": {"rad": 1, "s": -1},
                    "factor": 1.0,
                    "offset": 0.0,
                    "display": [{"name": "deg/s", "factor": 57.29577951308232}],
                },
            ],
            "variables": [
                variable("time", 0, [], "independent", unit="s"),
                variable("u", 1, [2], "input", start=[0.5, -0.5], display_unit="deg/s"),
                variable("M", 3, [2, 3], "parameter", start=[1, 2, 3, 4, 5, 6.25], min=0.0, **parameter),
                variable("mode", 9, [], "parameter", start=[7], type="Int32", unit=None, max=9, **parameter),
                variable("x", 10, [2], "output", start=[1, 0], initial="exact", nominal=0.1, dependencies=[[10], [11]]),
                variable(
                    "der(x)",
                    12,
                    [2],
                    "local",
                    initial="calculated",
                    derivative_of=10,
                    dependencies=[[1, 11], [2]],
                    initial_dependencies=[[1, 3, 11], [2, 9]],
                ),
                variable(
                    "y", 14, [], "output", initial="calculated", dependencies=[[0, 2]], initial_dependencies=[[0, 2, 8]]
                ),
            ],
        }
    )

"""What a user's type checker sees of `import adcs`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROGRAM = """
import adcs

system = adcs.systems()["observer-pd"].build()
result = adcs.run(system, stop_time=1.0, step=0.01)
reveal_type(result)
reveal_type(adcs.run("observer-pd"))
reveal_type(system)
reveal_type(adcs.linearize(system).eigenvalues)
with adcs.Session(system, step=0.01) as session:
    reveal_type(session.time)
adcs.run(system, stop_time=[1], step=0.01)
reveal_type(adcs.at("20s", {"controller.k_p": 3}))
reveal_type(adcs.until("time > 1"))
adcs.run(system, method=adcs.ModelExchange("CVode", rtol=1e-9), save=adcs.Save(every=2), hooks=[adcs.pace(1)])
adcs.run(system, method="model-exchange")
with adcs.Session("observer-pd") as session, adcs.CoupledModel("observer-pd") as model:
    reveal_type(session)
    reveal_type(model)
reveal_type(adcs.write_ssp("observer-pd", "x.ssp"))
adcs.Session(3)
adcs.nothing
"""
SEEN = [
    'note: Revealed type is "orchestration.results.result.Result"',
    'note: Revealed type is "orchestration.results.result.Result"',
    'note: Revealed type is "orchestration.system.System"',
    'note: Revealed type is "numpy.ndarray[',
    'note: Revealed type is "float"',
    'error: Argument "stop_time" has incompatible type "list[int]"; expected "float | str | None"',
    'note: Revealed type is "orchestration.running.hooks.changes.Changes"',
    'note: Revealed type is "orchestration.running.hooks.until.Until"',
    'error: Argument "method" has incompatible type "str"; expected "Method"',
    'note: Revealed type is "orchestration.running.session.Session"',
    'note: Revealed type is "orchestration.coupled.model.CoupledModel"',
    'note: Revealed type is "None"',
    'error: Argument 1 to "Session" has incompatible type "int"; expected "System | str | Path"',
    'error: Module has no attribute "nothing"',
]


def test_a_type_checker_sees_real_types(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--follow-imports=silent", "--cache-dir", str(tmp_path / "cache"), "program.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    lines = [line.partition(": ")[2] for line in checked.stdout.splitlines()[:-1] if "program.py" in line]
    assert len(lines) == len(SEEN), checked.stdout + checked.stderr
    for line, seen in zip(lines, SEEN, strict=True):
        assert seen in line.replace("builtins.", "")


def test_every_name_is_there_and_nothing_large_is_loaded_before() -> None:
    code = (
        "import sys, adcs; before = [m for m in ('numpy', 'fmpy', 'scipy') if m in sys.modules];"
        "print(before, [name for name in dir(adcs) if getattr(adcs, name) is None])"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "[] []\n"

"""Arguments of one version ago, and what stands for them now: whoever gives the old one is told."""

from __future__ import annotations

from collections.abc import Iterable

from fmus.errors import AdcsError

_INTEGRATOR = dict.fromkeys(("solver", "rtol", "atol"), 'method=adcs.ModelExchange("DOP853", rtol=1e-10, atol=1e-12)')
_ARGUMENTS = {
    "run": {
        **_INTEGRATOR,
        "record": "save=adcs.Save([names])",
        "record_every": "save=adcs.Save(every=n)",
        "hdf5": "save=adcs.Save(to=path)",
        "stepping": "method=adcs.CoSimulation(stepping=...)",
        "adaptive": "method=adcs.CoSimulation(adaptive=tolerance)",
        "solve_loops": "method=adcs.CoSimulation(loops=...)",
        "timeout": "method=adcs.CoSimulation(timeout=seconds)",
        "changes": "hooks=[adcs.at(time, {name: value})]",
        "inputs": "hooks=[adcs.inputs(path)]",
        "until": "hooks=[adcs.until(condition)]",
        "real_time": "hooks=[adcs.pace(speed)]",
        "checkpoint": "hooks=[adcs.checkpoint(path)]",
        "checkpoint_every": "hooks=[adcs.checkpoint(path, every=seconds)]",
        "watchers": "hooks=[...]",
        "journal": "save=adcs.Save(to=journal)",
    },
    "linearize": {**_INTEGRATOR, "loops": "method=adcs.ModelExchange(loops=...)"},
}


def refuse_old(function: str, given: Iterable[str]) -> None:
    """Refuse arguments of a function that have another name now."""
    for name in given:
        if new := _ARGUMENTS.get(function, {}).get(name):
            raise AdcsError(f"{name}: {function}() has no such argument any more: write {new}")

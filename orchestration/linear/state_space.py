"""A linear state space with names: what linearising gives."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError
from fmus.spelling import hint
from orchestration.plan.lowering import Floats
from orchestration.process.writing import replacing


@dataclass(frozen=True)
class Mode:
    """An eigenvalue (1/s), or the half of a conjugate pair with positive imaginary part.

    `frequency` is its magnitude (rad/s), `damping` is -Re/|.| (nan for zero), `time_constant` is -1/Re (s, inf for an
    undamped one, negative for a growing one). `note` says what it belongs to, where that is known.
    """

    eigenvalue: complex
    frequency: float
    damping: float
    time_constant: float
    note: str


@dataclass(frozen=True)
class StateSpace:
    """dx/dt = dx0 + A (x - x0) + B (u - u0), y = y0 + C (x - x0) + D (u - u0), near a point at a time.

    `A` (n, n), `B` (n, m), `C` (p, n), `D` (p, m); `states`, `inputs` and `outputs` name rows and columns; `x` (n,),
    `u` (m,), `y` (p,) and `dx` (n,) are the operating point and its rate. `notes` say what to know about it all.
    """

    system: str
    time: float
    A: Floats
    B: Floats
    C: Floats
    D: Floats
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    x: Floats
    u: Floats
    y: Floats
    dx: Floats
    notes: tuple[str, ...] = ()
    belongs: tuple[tuple[complex, str], ...] = ()

    @property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Of A, (n,), by magnitude; of a conjugate pair the one with positive imaginary part first."""
        values = np.linalg.eigvals(self.A).astype(np.complex128)
        return values[np.lexsort((-values.imag, np.round(np.abs(values), 12)))]

    @property
    def modes(self) -> list[Mode]:
        """The eigenvalues with frequency and damping, a conjugate pair as one."""
        values = self.eigenvalues
        notes = _assigned(values, self.belongs)
        floor = 1e-12 * float(np.linalg.norm(self.A))
        return [_mode(v, floor, note) for v, note in zip(values, notes, strict=True) if v.imag >= 0]

    def select(self, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None) -> StateSpace:
        """Return the system from these inputs to these outputs only, by the names of their elements."""
        i = _places("input", self.inputs, inputs)
        o = _places("output", self.outputs, outputs)
        changed: dict[str, Any] = {
            "B": self.B[:, i],
            "C": self.C[o],
            "D": self.D[np.ix_(o, i)],
            "inputs": tuple(self.inputs[k] for k in i),
            "outputs": tuple(self.outputs[k] for k in o),
            "u": self.u[i],
            "y": self.y[o],
        }
        return StateSpace(**{**self.__dict__, **changed})

    def to_scipy(self) -> Any:
        """Return it as `scipy.signal.StateSpace`."""
        import scipy.signal  # here, for it takes long to load

        return scipy.signal.StateSpace(self.A, self.B, self.C, self.D)

    def transfer(self, s: complex) -> NDArray[np.complex128]:
        """Return the transfer matrix C (s - A)^-1 B + D at s, (p, m)."""
        shifted = s * np.eye(len(self.A)) - self.A
        return np.asarray(self.C @ np.linalg.solve(shifted, self.B) + self.D, np.complex128)

    def as_dict(self) -> dict[str, Any]:
        """Return all of it in lists and numbers, for JSON."""
        return {
            "system": self.system,
            "time": self.time,
            **{name: getattr(self, name).tolist() for name in "ABCD"},
            "states": list(self.states),
            "inputs": list(self.inputs),
            "outputs": list(self.outputs),
            **{name: getattr(self, name).tolist() for name in ("x", "u", "y", "dx")},
            "eigenvalues": [[v.real, v.imag] for v in self.eigenvalues.tolist()],
            "modes": [
                {
                    "eigenvalue": [m.eigenvalue.real, m.eigenvalue.imag],
                    "frequency": m.frequency,
                    "damping": None if np.isnan(m.damping) else m.damping,
                    "time_constant": m.time_constant if np.isfinite(m.time_constant) else None,
                    "note": m.note,
                }
                for m in self.modes
            ],
            "notes": list(self.notes),
        }

    def write(self, path: str | Path) -> None:
        """Write a `.mat` file for MATLAB or Octave, or a `.json` file.

        In MATLAB: `m = load("file.mat"); sys = ss(m.A, m.B, m.C, m.D, "StateName", m.states, "InputName", m.inputs,
        "OutputName", m.outputs)`.
        """
        path = Path(path)
        if path.suffix not in (".mat", ".json"):
            raise AdcsError(f"cannot write {path}: give a name that ends in .mat or .json")
        if path.suffix == ".json":
            with replacing(path) as to:
                to.write_text(json.dumps(self.as_dict(), indent=2) + "\n", encoding="utf-8")
            return
        import scipy.io

        content = {name: getattr(self, name) for name in ("A", "B", "C", "D", "x", "u", "y", "dx", "time", "system")}
        for name in ("states", "inputs", "outputs", "notes"):
            content[name] = np.array(getattr(self, name), dtype=object).reshape(-1, 1)  # a cell array
        with replacing(path) as to:
            scipy.io.savemat(to, {**content, "eigenvalues": self.eigenvalues}, oned_as="column")


def _places(kind: str, known: Sequence[str], wanted: Sequence[str] | None) -> list[int]:
    if wanted is None:
        return list(range(len(known)))
    for name in wanted:
        if name not in known:
            raise AdcsError(f"{name!r} is no {kind} of the linear system: {hint(name, known)}")
    return [known.index(name) for name in wanted]


def _assigned(values: NDArray[np.complex128], belongs: Sequence[tuple[complex, str]]) -> list[str]:
    """Give each of what is known to belong to an eigenvalue to the nearest one that is still free."""
    notes = [""] * len(values)
    for value, note in belongs:
        free = [i for i in range(len(values)) if not notes[i]]
        notes[min(free, key=lambda i: abs(values[i] - value))] = note
    return notes


def _mode(value: complex, floor: float, note: str) -> Mode:
    size = abs(value)
    if size <= floor:
        return Mode(complex(value), 0.0, nan, inf, note)
    return Mode(complex(value), size, -value.real / size, inf if value.real == 0 else -1.0 / value.real, note)

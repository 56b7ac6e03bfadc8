"""The program that solves a system with the engine, and what it has of the system: the plans that Python makes."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import digest_program

from fmus.files import write_atomically
from fmus.paths import FMI_HEADERS
from fmus.toolchain import Step, Target, run_steps
from orchestration import engine
from orchestration.coupled import CoupledModel
from orchestration.engine import Engine
from orchestration.grid import SNAP
from orchestration.plan.lowering import make_plan
from orchestration.plan.schedule import split
from orchestration.system import System

STEP, ROWS, RTOL = 0.01, 1001, 1e-12
"""s between two of so many rows, and the relative tolerance."""


def program(system: System, target: Target) -> Path:
    """The program for a system and a target; what is up to date stays."""
    folder = digest_program.WORK / target.name / system.name
    header, here = folder / "system.h", Path(engine.__file__).parent
    text = "\n".join(_lines(system))
    if not header.is_file() or header.read_text(encoding="utf-8") != text:
        write_atomically(header, text.encode())
    sources = (digest_program.HERE / "solve.c", here / "engine.c")
    flags = [flag for flag in engine._FLAGS if flag not in ("-shared", "-fvisibility=hidden")]
    output = folder / f"solve{'.exe' if target.suffix == '.dll' else ''}"
    includes = [f"-I{folder}", f"-I{here}", f"-isystem{FMI_HEADERS}"]
    command = ("cc", "-target", target.triple, *flags, *includes, *map(str, sources), "-o", str(output))
    inputs = (*sources, header, *(here / name for name in ("walk.c", "engine.h", "dop853.h")))
    run_steps([Step(output, command, inputs)])
    return output


def _lines(system: System) -> Iterator[str]:
    with CoupledModel(system) as model:
        assert model.next_event == inf
        assert model.n_indicators == 0
        fmus = {name: instance.fmu for name, instance in model.instances.items()}
        starts = {c.name: c.start for c in system.components.values()}
        yield f"enum {{ N_PARTS = {len(fmus)}, N_STATES = {len(model.x0)} }};"
        yield f"enum {{ N_ROWS = {ROWS}, ROW_SIZE = {sum(port.size for port in model.ports.values())} }};"
        numbers = {"STEP": STEP, "END": (ROWS - 1) * STEP, "INSTANT": SNAP * STEP, "LONGEST": 100 * STEP}
        for name, value in (numbers | {"RELATIVE": RTOL, "ABSOLUTE": RTOL / 100}).items():
            yield f"#define {name} {value.hex()}"
        for i, (name, fmu) in enumerate(fmus.items()):
            ports = [(fmu.ports[variable], values) for variable, values in starts[name].items()]
            for k, (port, values) in enumerate(ports):
                yield _array("Reference", f"references_{i}_{k}", port.references)
                yield _array("double" if port.type == "Float64" else "int32_t", f"values_{i}_{k}", values)
            types = {"Float64": "FLOAT64", "Int32": "INT32", "Boolean": "BOOL32"}
            given = [
                f"{{{types[port.type]}, references_{i}_{k}, {port.size}, values_{i}_{k}}}"
                for k, (port, _) in enumerate(ports)
            ]
            yield f"static const Start starts_{i}[] = {{{', '.join(given or ['{0}'])}}};"
        parts = [
            f'{{"{name}", "{fmu.model.guid}", {len(fmu.states)}, {len(starts[name])}, starts_{i}}}'
            for i, (name, fmu) in enumerate(fmus.items())
        ]
        yield f"static const Part parts[] = {{{', '.join(parts)}}};"
        lower = partial(make_plan, fmus, system.connections, starts=starts)
        plans = {"initial": lower(initial=True), "flow": lower(), "rows": lower([split(n) for n in system.outputs()])}
        for name, plan in plans.items():
            yield from _plan(name, plan.signals.tolist(), Engine(plan, model.instances).raw)


def _plan(name: str, signals: Sequence[float], plan: Any) -> Iterator[str]:
    yield f"static double {name}_signals[] = {{{', '.join(x.hex() for x in signals)}}};"
    calls = []
    for i, call in enumerate(plan.calls[: plan.n_calls]):
        yield _array("Reference", f"{name}_references_{i}", call.references[: call.n_references])
        yield _pieces(f"{name}_pieces_{i}", call.pieces[: call.n_pieces])
        yield f"static double {name}_values_{i}[{call.n_values}], {name}_raw_{i}[{call.n_values}];"
        fields = {
            "references": f"{name}_references_{i}",
            "n_references": call.n_references,
            "values": f"{name}_values_{i}" if call.kind else f"{name}_signals + {(call.values - plan.signals) // 8}",
            "n_values": call.n_values,
            "raw": f"{name}_raw_{i}" if call.raw else "NULL",
            "pieces": f"{name}_pieces_{i}",
            "n_pieces": call.n_pieces,
        }
        fields |= {f: int(getattr(call, f)) for f in ("kind", "type", "component", "every", "plain")}
        calls.append("{" + ", ".join(f".{f} = {value}" for f, value in fields.items()) + "}")
    yield f"static Call {name}_calls[] = {{{', '.join(calls)}}};"
    yield _pieces(f"{name}_record", plan.record[: plan.n_record])
    yield (
        f"static Plan {name} = {{.n_calls = {plan.n_calls}, .signals = {name}_signals, .record = {name}_record, "
        f".n_record = {plan.n_record}, .record_every = 1}};"
    )


def _pieces(name: str, pieces: Sequence[Any]) -> str:
    assert not any(piece.n_mapping for piece in pieces)
    made = [
        f"{{{p.start}, {p.n}, {p.factor.hex()}, {p.offset.hex()}, NULL, 0, {p.plain:d}, {p.whole:d}}}" for p in pieces
    ]
    return f"static const Piece {name}[] = {{{', '.join(made or ['{0}'])}}};"


def _array(kind: str, name: str, values: Sequence[Any]) -> str:
    numbers = [float(x).hex() if kind == "double" else str(int(x)) for x in values]
    return f"static const {kind} {name}[] = {{{', '.join(numbers)}}};"

"""`python -m benchmarks.memory`: what one instance of each component takes of memory. Needs glibc, which tells."""

from __future__ import annotations

import ctypes
import gc
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import cyclopts
from cyclopts import Parameter
from rich.console import Console
from rich.progress import track
from rich.table import Table

from adcs import AdcsError
from fmus.catalog import components
from orchestration.plan.opening import initialised
from orchestration.single import single

INSTANCES = 100  # at once


class _Info(ctypes.Structure):
    """`struct mallinfo2` of glibc: bytes in blocks of their own, and in others."""

    _fields_ = (
        ("before", ctypes.c_size_t * 4),
        ("hblkhd", ctypes.c_size_t),
        ("between", ctypes.c_size_t * 2),
        ("uordblks", ctypes.c_size_t),
        ("after", ctypes.c_size_t * 2),
    )


@dataclass(frozen=True)
class Taken:
    """Bytes that one instance allocates, and that its first directional derivative allocates besides."""

    component: str
    instance: float
    derivatives: float


def measure(name: str) -> Taken:
    """Instantiate many, and ask one for a derivative of an output by an input; not every component has both."""
    with initialised(single(name), "model-exchange", 0.0, 1.0) as instances:
        instance = instances[name]
        handle: Any = instance.handle
        few = [
            [port.references[0] for port in instance.fmu.ports.values() if (port.causality, port.type) == kind][:1]
            for kind in (("output", "Float64"), ("input", "Float64"))
        ]
        unknown, known = ((ctypes.c_uint32 * len(one))(*one) for one in few)
        seed, found = (ctypes.c_double * 1)(1.0), (ctypes.c_double * 1)()
        arguments = (b"one", 0, handle.guid.encode(), None, handle.callbacks, 0, 0)
        gc.collect()
        before = _allocated()
        more = [handle.fmi2Instantiate(*arguments) for _ in range(INSTANCES)]
        each = (_allocated() - before) / INSTANCES
        for component in more:
            handle.fmi2FreeInstance(component)
        gc.collect()
        before = _allocated()
        handle.fmi2GetDirectionalDerivative(handle.component, unknown, len(unknown), known, len(known), seed, found)
        return Taken(name, each, _allocated() - before if len(unknown) and len(known) else 0)


def _allocated() -> int:
    libc = ctypes.CDLL(None)
    try:
        libc.mallinfo2.restype = _Info
    except AttributeError as error:
        raise AdcsError("benchmarks.memory needs mallinfo2, of glibc 2.33 or newer") from error
    info = libc.mallinfo2()
    return int(info.uordblks + info.hblkhd)


def main(output: Annotated[Path, Parameter(help="Folder for the results.")] = Path("results/benchmarks")) -> None:
    """Bytes of an instance, smallest to largest component, and of its derivatives once they are asked for."""
    console = Console()
    try:
        taken = [measure(c.name) for c in track(components(), "measuring", console=console, transient=True)]
    except AdcsError as failed:
        Console(stderr=True).print(f"[red]error:[/red] {failed}")
        raise SystemExit(1) from failed
    taken.sort(key=lambda t: t.instance)
    table = Table("component", title=f"{len(taken)} components: kB of an instance, smallest to largest")
    for column in ("instance", "with derivatives"):
        table.add_column(column, justify="right")
    for each in taken:
        table.add_row(each.component, *(f"{n / 1e3:.1f}" for n in (each.instance, each.instance + each.derivatives)))
    console.print(table)
    output.mkdir(parents=True, exist_ok=True)
    (output / "memory.json").write_text(json.dumps([asdict(t) for t in taken], indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    cyclopts.run(main)

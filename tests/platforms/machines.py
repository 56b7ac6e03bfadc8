"""The machines that must agree, and how to run the digest program on each of them from x86-64 Linux.

Debian has what is needed: apt-get install wine64 qemu-user libc6-arm64-cross nodejs g++
"""

import os
import platform
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import digest_program

from fmus.toolchain import TARGETS

TARGET = {target.name: target for target in (*TARGETS, digest_program.WASM)}
HASWELL = ("fma", "avx2", "bmi2")  # what -march=haswell needs of the processor, as /proc/cpuinfo names it

_NODE = """
const { readFileSync } = require("fs");
const { WASI } = require("wasi");
const wasi = new WASI({ version: "preview1", args: process.argv.slice(1) });
const made = WebAssembly.instantiate(readFileSync(process.argv[1]), wasi.getImportObject());
made.then(({ instance }) => wasi.start(instance));
"""


@dataclass(frozen=True)
class Machine:
    """A processor with an operating system, or what stands for one."""

    name: str
    made: Callable[[Path], Path]
    """Makes the program, in a folder of its own if it is not the toolchain's."""
    command: tuple[str, ...] = ()
    """What runs the program here."""
    needs: tuple[str, ...] = ()
    """Programs and files without which it does not run."""
    features: tuple[str, ...] = ()
    """What it needs of this machine's processor."""
    environment: Mapping[str, str] = field(default_factory=dict)
    target: str = ""
    """The platform of FMUs whose binaries run there; none: of none."""

    @property
    def missing(self) -> str:
        """Why it cannot run here; empty if it can."""
        if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
            return "the machines are run from x86_64 Linux"
        absent = [need for need in self.needs if found(need) is None]
        absent += [f"{feature} of the processor" for feature in self.features if feature not in processor_features()]
        return f"not here: {', '.join(absent)}" if absent else ""

    def run(self, made: Path, *arguments: str) -> str:
        """What the program prints."""
        command = (found(self.command[0]), *self.command[1:]) if self.command else ()
        done = subprocess.run(
            [*command, made, *arguments],
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
            env=os.environ | {"WINEDEBUG": "-all"} | dict(self.environment),
        )
        assert done.returncode == 0, f"{self.name}: {done.stderr}"
        return done.stdout


def found(name: str) -> str | None:
    """Where a program or file is."""
    for path in (name, f"/usr/lib/wine/{name}"):
        if path.startswith("/") and Path(path).exists():
            return path
    return shutil.which(name)


def processor_features() -> set[str]:
    """What the processor of this machine can, in the words of /proc/cpuinfo."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    return next((set(line.split()) for line in lines if line.startswith("flags")), set())


def toolchain(target: str) -> Callable[[Path], Path]:
    """Made as the FMUs are."""
    return lambda _folder: digest_program.made_by_toolchain(TARGET[target])


def gcc(*flags: str) -> Callable[[Path], Path]:
    """Made by the system's compiler, with nothing said about contraction: what a user may well do."""
    return lambda folder: digest_program.made_by(("g++", *flags), folder)


FMA_HIDDEN = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable,-FMA_Usable"}
"""The C library then takes its functions for processors without fused multiply and add."""

HERE = Machine("x86-64", toolchain("x86_64-linux"), target="x86_64-linux")
MACHINES = [
    Machine("x86-64 without FMA", toolchain("x86_64-linux"), environment=FMA_HIDDEN, target="x86_64-linux"),
    Machine(
        "aarch64",
        toolchain("aarch64-linux"),
        ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"),
        ("qemu-aarch64", "/usr/aarch64-linux-gnu/lib"),
        target="aarch64-linux",
    ),
    Machine("Windows", toolchain("x86_64-windows"), ("wine64",), ("wine64",), target="x86_64-windows"),
    Machine("WebAssembly", toolchain("wasm32-wasi"), ("node", "--no-warnings", "-e", _NODE), ("node",)),
    Machine("gcc", gcc("-O2"), needs=("g++",)),
    Machine("gcc for processors with FMA", gcc("-O3", "-march=haswell"), needs=("g++",), features=HASWELL),
]

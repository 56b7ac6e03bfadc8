"""The digest program: all components in one binary, made with the flags of the FMUs or by a C++ compiler."""

import subprocess
import zipfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path

from fmus import catalog, fmu_path
from fmus.build import ADAPTOR
from fmus.catalog import Component
from fmus.files import write_atomically
from fmus.paths import BUILD, FMI_HEADERS, SOURCES
from fmus.toolchain import Target, compile_step, host, program_step, run_steps

HERE = Path(__file__).parent
WORK = BUILD / "digest"
PARTS = 8  # translation units that share the components: few, because each reads Eigen; not one, because of processors

EVERY_FUNCTION = HERE / "every_function.hpp"
"""A component that calls what the project's own call, and what they do not."""

WASM = Target("wasm32-wasi", "wasm32-wasi", "", ".wasm")


def driven() -> list[Component]:
    """The components of the program."""
    return [*catalog.components(), catalog.find(str(EVERY_FUNCTION))]


def sources(folder: Path) -> list[Path]:
    """The C++ files of the program; those that depend on the list of components are written into the folder."""
    components = driven()
    texts = {f"part_{i}.cpp": _part(components[i::PARTS]) for i in range(PARTS)}
    texts["components.cpp"] = _list(components)
    for name, text in texts.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            write_atomically(path, text.encode())
    adaptor = [SOURCES / "fmi" / f"{name}.cpp" for name in ADAPTOR if name != "fmi3"]
    return [*(folder / name for name in texts), HERE / "digest.cpp", *adaptor]


def made_by_toolchain(target: Target) -> Path:
    """The program for a target, compiled like the FMUs; what is up to date stays."""
    return _made("digest", sources(WORK / "sources"), target)


def small_program(source: Path) -> Path:
    """A program of one file, for this machine."""
    return _made(source.stem, [source], host())


def _made(name: str, files: Sequence[Path], target: Target) -> Path:
    folder = WORK / target.name
    steps = [compile_step(file, folder / f"{file.stem}.o", target, f"-I{HERE}") for file in files]
    run_steps(steps)
    suffix = {"x86_64-windows": ".exe", WASM.name: ".wasm"}.get(target.name, "")
    program = program_step([step.output for step in steps], folder / f"{name}{suffix}", target)
    run_steps([program])
    return program.output


def made_by(compiler: Sequence[str], folder: Path) -> Path:
    """The program, made by another compiler of those headers of Eigen that an FMU has."""
    with zipfile.ZipFile(fmu_path("RigidBody")) as fmu:
        fmu.extractall(folder, [name for name in fmu.namelist() if name.startswith("sources/Eigen/")])
    eigen = folder / "sources"

    def compiled(source: Path) -> Path:
        output = folder / f"{source.stem}.o"
        flags = ["-std=c++17", f"-I{SOURCES}", f"-I{HERE}", f"-isystem{eigen}", f"-isystem{FMI_HEADERS}"]
        subprocess.run([*compiler, *flags, "-c", source, "-o", output], check=True)
        return output

    with ThreadPoolExecutor(cpu_count()) as pool:
        objects = list(pool.map(compiled, sources(folder)))
    program = folder / "digest"
    subprocess.run([*compiler, *objects, "-o", program, "-ldl"], check=True)
    return program


def _part(components: Sequence[Component]) -> str:
    includes = "".join(f'#include "{c.include}"\n' for c in components)
    makers = "".join(
        f'adcs::Model* make_{c.name}() {{ return make<adcs::{c.name}>("{c.name}"); }}\n' for c in components
    )
    return f'#include "components.hpp"\n{includes}\n{makers}'


def _list(components: Sequence[Component]) -> str:
    makers = "".join(f"adcs::Model* make_{c.name}();\n" for c in components)
    entries = "".join(f'    {{"{c.name}", make_{c.name}}},\n' for c in components)
    table = f"const Component components[] = {{\n{entries}    {{nullptr, nullptr}}}};\n"
    return f'#include "components.hpp"\n\n{makers}\n{table}'

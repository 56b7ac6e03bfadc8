"""Compiles and links with the zig compiler from PyPI, for every platform, and only what changed."""

import json
import os
import platform
import re
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import metadata, util
from pathlib import Path

from fmus.errors import AdcsError
from fmus.files import digest, write_atomically
from fmus.paths import BUILD, CARRIED, CHECKOUT, EIGEN, FMI_HEADERS, SOURCES

INSTALL = "pip install 'adcs-fmus[build]'"
"""The command that brings what is needed to compile."""


@dataclass(frozen=True)
class Target:
    """A platform that binaries are made for."""

    name: str
    """The platform tuple of FMI 3.0."""
    triple: str
    fmi2_folder: str
    """FMI 2.0 has own names for Linux, Windows and macOS, the last for both processors, and takes the tuple for others
    (since 2.0.4)."""
    suffix: str


TARGETS = (
    Target("x86_64-linux", "x86_64-linux-gnu.2.17", "linux64", ".so"),
    Target("aarch64-linux", "aarch64-linux-gnu.2.17", "aarch64-linux", ".so"),
    Target("x86_64-windows", "x86_64-windows-gnu", "win64", ".dll"),
    Target("x86_64-darwin", "x86_64-macos.11.0", "darwin64", ".dylib"),
    Target("aarch64-darwin", "aarch64-macos.11.0", "darwin64", ".dylib"),
)

COMPILE_FLAGS = (
    *("-std=c++17", "-DNDEBUG"),
    "-g0",  # zig adds debug information with absolute paths by itself
    *("-fno-exceptions", "-fno-rtti"),
    "-ffp-contract=off",  # same digits on every platform
    "-fno-math-errno",  # nobody reads it; a square root is one instruction then
    *("-fvisibility=hidden", "-fvisibility-inlines-hidden", "-fvisibility-global-new-delete=force-hidden"),
    *("-ffunction-sections", "-fdata-sections"),
    *("-Wall", "-Wextra"),
    *(f"-I{SOURCES}", f"-isystem{EIGEN}", f"-isystem{FMI_HEADERS}"),
)
SMALL = ("-Os",)  # the adaptor: 30 kB of an FMU for all platforms less than as laws are, 4 to 5 % of a step
INLINED = (
    "-O2",  # zig makes the same of -O3
    *("-mllvm", "-inline-threshold=1000"),  # whole laws in one function: a third faster, and no larger. Clang's alone
)
UNOPTIMISED = ("-O0", "-fno-sanitize=undefined")  # of which zig inserts traps otherwise
LINK_FLAGS = {
    ".so": (f"-Wl,--version-script={SOURCES / 'fmi' / 'exports.map'}", "-Wl,-z,defs", "-Wl,--gc-sections"),
    # the compiler's run-time library is as large as a component, and src/fmi/runtime.cpp has what is needed of it;
    # a digest in place of the time
    ".dll": ("-rtlib=none", "-Wl,--gc-sections", "-Wl,-Brepro"),
    ".dylib": ("-Wl,-dead_strip",),
}


def without() -> str:
    """Say what helps where this project's components cannot be compiled; one installed from its sources has a wheel."""
    bare = CHECKOUT is None and not CARRIED.is_dir()
    return f"{INSTALL}, or install the wheel, which carries this project's components compiled" if bare else INSTALL


def is_installed() -> bool:
    """Whether there is the compiler, and the library that components use."""
    try:
        _find()
    except ModuleNotFoundError:
        return False
    return EIGEN.is_dir()


@cache
def _find() -> None:
    """Find the compiler's package, which is not loaded: that takes a search of the whole path, until it is there."""
    if util.find_spec("ziglang") is None:
        raise ModuleNotFoundError


def zig() -> Path:
    """The compiler; AdcsError if it is not installed."""
    if not is_installed():
        raise AdcsError(f"no compiler is installed: {without()}")
    import ziglang

    return Path(ziglang.__file__).parent / ("zig.exe" if os.name == "nt" else "zig")


def compiler() -> str:
    """What compiles, and what it compiles in, with versions; empty if it is not installed."""
    return _versions() if is_installed() else ""


@cache
def _versions() -> str:
    packages = {"zig": "ziglang", "Eigen": "cmeel-eigen", "fmpy": "fmpy"}  # the last has the FMI headers
    return ", ".join(f"{name} {metadata.version(package)}" for name, package in packages.items())


def host() -> Target:
    """The target this machine runs; AdcsError if there is none."""
    system = platform.system().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    name = f"{machine}-{system}"
    for target in TARGETS:
        if target.name == name:
            return target
    raise AdcsError(f"no binaries can be made for this machine, {name}: known are {', '.join(t.name for t in TARGETS)}")


@dataclass(frozen=True)
class Step:
    """A command that makes `output` out of `inputs` and of the files it includes."""

    output: Path
    command: tuple[str, ...]
    inputs: tuple[Path, ...]
    includes: bool = False
    """The command writes what it included to the depfile."""

    @property
    def depfile(self) -> Path:
        """Where the compiler writes what it included."""
        return _beside(self.output, ".d")

    @property
    def record(self) -> Path:
        """Where is kept what the output was made of."""
        return _beside(self.output, ".json")

    @property
    def log(self) -> Path:
        """Where is kept what the compiler said when it refused."""
        return _beside(self.output, ".log")


class NotCompiled(AdcsError):
    """What the compiler or linker has refused, with all that it says."""

    def __init__(self, step: Step, output: str) -> None:
        super().__init__(f"making {step.output.name} failed:\n{output}")
        self.step = step
        self.output = output


def compile_step(
    source: Path,
    output: Path,
    target: Target,
    *flags: str,
    header: Step | None = None,
    level: Sequence[str] = INLINED,
) -> Step:
    """Compiles one C++ file to an object file, starting from a precompiled header if there is one."""
    begin = () if header is None else ("-include-pch", str(header.output))
    return _compile(target, (*level, *flags, *begin, "-c"), source, output)


def header_step(source: Path, output: Path, target: Target, *flags: str, level: Sequence[str] = INLINED) -> Step:
    """Precompiles a header; with the same flags, it saves half the time of compiling a component."""
    begin = (*level, *flags)
    return _compile(target, (*begin, "-Wno-pragma-once-outside-header", "-x", "c++-header"), source, output)


def link_step(objects: Sequence[Path], output: Path, target: Target) -> Step:
    """Links a shared library that exports what the export list says."""
    flags = ("-shared", *LINK_FLAGS[target.suffix], *own_name(output, target))
    exports = (SOURCES / "fmi" / "exports.map",) if target.suffix == ".so" else ()
    return _link(objects, output, target, flags, exports)


def own_name(output: Path, target: Target) -> tuple[str, ...]:
    """The flags that keep the path on this machine out of a library."""
    return (f"-Wl,-install_name,@rpath/{output.name}",) if target.suffix == ".dylib" else ()


def program_step(objects: Sequence[Path], output: Path, target: Target) -> Step:
    """Links a program that runs during the build."""
    return _link(objects, output, target)


def run_steps(steps: Iterable[Step], done: Callable[[Step], None] = lambda _: None) -> None:
    """Runs the steps that are out of date, as many at a time as there are processors; they must not need each other."""

    def bring_up_to_date(step: Step) -> Step:
        if not is_up_to_date(step):
            _run(step)
        return step

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for step in pool.map(bring_up_to_date, steps):
            done(step)


def is_up_to_date(step: Step) -> bool:
    """Whether the output was made by this command and compiler from inputs with this content."""
    if not step.output.is_file():
        return False
    record = _Record.read(step.record)
    return record.command == _signature(step) and all(
        _state(step, Path(path)) == known for path, known in record.inputs.items()
    )


def _state(step: Step, path: Path) -> str:
    """What must stay of an input: its content; for a precompiled header its time, too, as the compiler asks."""
    if step.output.suffix != ".pch" or not path.is_file():
        return digest(path)
    return f"{digest(path)} {path.stat().st_mtime_ns}"


def included_files(step: Step) -> list[Path]:
    """The files that went into an up-to-date step, those of the compiler itself excepted.

    With them are those that it would include if they were there.
    """
    record = _Record.read(step.record)
    if not record.command:
        raise AdcsError(f"{step.output.name}: a source file changed while it was being compiled: build again")
    return [Path(path) for path in record.inputs]


def universal_binary(slices: Sequence[bytes]) -> bytes:
    """A macOS library for several processors out of one library for each."""
    alignment = 14  # 2^14, the page size of arm64
    header = bytearray(0xCAFEBABE.to_bytes(4) + len(slices).to_bytes(4))
    body = bytearray()
    start = 1 << alignment
    for content in slices:
        processor = [int.from_bytes(content[at : at + 4], "little") for at in (4, 8)]
        for number in (*processor, start + len(body), len(content), alignment):
            header += number.to_bytes(4)
        body += content + bytes(-len(content) % start)
    return bytes(header.ljust(start, b"\0") + body)


def _compile(target: Target, flags: Sequence[str], source: Path, output: Path) -> Step:
    command = ("c++", "-target", target.triple, *COMPILE_FLAGS, *flags, str(source), "-o", str(output))
    depfile = ("-MD", "-MF", str(_beside(output, ".d")))
    return Step(output, command + depfile, (source,), includes=True)


def _link(
    objects: Sequence[Path], output: Path, target: Target, flags: Sequence[str] = (), more_inputs: Sequence[Path] = ()
) -> Step:
    # as C and without sanitizer: the objects need no C++ or sanitizer runtime, which take zig two minutes to build
    command = ("cc", "-target", target.triple, "-fno-sanitize=undefined", "-s", *flags, *map(str, objects))
    command += ("-o", str(output))
    return Step(output, command, (*objects, *more_inputs))


def _run(step: Step) -> None:
    step.output.parent.mkdir(parents=True, exist_ok=True)
    started = time.time_ns()
    zig_cache = str(BUILD / "zig")
    environment = os.environ | {"ZIG_GLOBAL_CACHE_DIR": zig_cache, "ZIG_LOCAL_CACHE_DIR": zig_cache}
    result = subprocess.run(
        [zig(), *step.command],
        capture_output=True,
        text=True,
        encoding="utf-8",
        errors="replace",
        env=environment,
        check=False,
    )
    for stray in (".lib", ".pdb"):
        step.output.with_suffix(stray).unlink(missing_ok=True)
    if result.returncode != 0:
        step.output.unlink(missing_ok=True)
        write_atomically(step.log, result.stderr.encode())
        raise NotCompiled(step, result.stderr.strip())
    inputs = _dependencies(step.depfile) if step.includes else step.inputs
    if any(path.stat().st_mtime_ns > started for path in inputs):  # edited meanwhile: who knows what was read
        step.record.unlink(missing_ok=True)
        return
    made_of = [*inputs, *(_awaited(inputs, step.command) if step.includes else ())]
    record = _Record(_signature(step), {str(path): _state(step, path) for path in made_of})
    write_atomically(step.record, json.dumps(asdict(record), indent=1).encode())


def _dependencies(depfile: Path) -> list[Path]:
    text = depfile.read_text(encoding="utf-8").replace("\\\n", " ").split(": ", 1)[1]
    names = (re.sub(r"\\([ #])", r"\1", part).replace("$$", "$") for part in re.split(r"(?<!\\)\s+", text) if part)
    # zig writes some names relative to where it is called
    paths = {Path(os.path.normpath(Path.cwd() / name)) for name in names}
    return sorted(path for path in paths if not path.is_relative_to(zig().parent))  # those stand and fall with zig


_ASKED_FOR = re.compile(r'__has_include\s*\(\s*["<]([^">]+)[">]')


def _awaited(inputs: Iterable[Path], command: Sequence[str]) -> Iterator[Path]:
    """Yield what headers ask for by `__has_include` and what is not there: what is made changes with it."""
    folders = [Path(word.removeprefix("-I")) for word in command if word.startswith("-I")]
    for path in inputs:
        if path.is_relative_to(EIGEN):
            continue
        for name in _ASKED_FOR.findall(path.read_text(encoding="utf-8", errors="replace")):
            places = (Path(os.path.normpath(folder / name)) for folder in (path.parent, *folders))
            yield from (place for place in places if not place.exists())


def _signature(step: Step) -> str:
    return " ".join((f"zig {metadata.version('ziglang')}", *step.command))


@dataclass(frozen=True)
class _Record:
    """What an output was made of: the command, and the digest of each file, empty for one that is not there."""

    command: str = ""
    inputs: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def read(path: Path) -> "_Record":
        try:
            return _Record(**json.loads(path.read_bytes()))
        except (FileNotFoundError, ValueError, TypeError):
            return _Record()


def _beside(path: Path, suffix: str) -> Path:
    return path.with_name(path.name + suffix)

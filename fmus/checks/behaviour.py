"""What an FMU does when it is loaded on this machine; in a process of its own, since it might crash."""

from __future__ import annotations

import math
import os
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fmus.archive import LARGEST_XML, Archive
from fmus.checks import Failure, Note
from fmus.paths import PACKAGE
from fmus.process_end import how
from fmus.readable import read_model
from fmus.xml import parse

if TYPE_CHECKING:
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave
    from fmpy.model_description import ModelDescription

_MARKS = {"finding: ": str, "note: ": Note}
_DOING = "from here on: "
_SECONDS = 60
_END = "all was looked at"
_FATAL = 4  # of fmi2Status and fmi3Status
_EVENTS = {"eventModeUsed": True, "earlyReturnAllowed": True}


def check_behaviour(path: Path, module: str = __name__) -> Iterator[str]:
    """Instantiates and initialises each interface with the values of the XML; nothing if this platform is not in it.

    `module` is what is run, with the path as its argument: it prints by `report`.
    """
    command = [sys.executable, "-m", module, str(path)]
    code: int | None = None
    try:
        result = subprocess.run(
            command,
            capture_output=True,
            env=os.environ | {"PYTHONPATH": str(PACKAGE.parent)},
            timeout=_SECONDS,
            check=False,
        )
        output, errors, code = result.stdout, result.stderr, result.returncode
    except subprocess.TimeoutExpired as error:
        output, errors = error.stdout or b"", b""
    said, doing, all_seen = "", "loading", False
    for line in output.decode(errors="replace").splitlines():
        for mark, kind in _MARKS.items():
            if line.startswith(mark):
                yield kind(line.removeprefix(mark) + (f" ({said})" if said else ""))
                said = ""
                break
        else:
            _, is_ours, next_ = line.partition(_DOING)  # after what the FMU has printed without a line break
            if is_ours:
                said, doing, all_seen = "", next_, next_ == _END
            else:
                said = line  # the FMU's own last message explains what follows
    if code is None:
        yield f"{doing} does not end within {_SECONDS} s"
    elif not all_seen or code != 0:  # 0 too, by an FMU that ends the process
        last_words = errors.decode(errors="replace").strip().splitlines()[-1:] or ([said] if said else [])
        doing = "ending the process in which it was looked at" if all_seen else doing
        yield ": ".join([f"{doing} ended the process: {how(code)}", *last_words])


def doing(what: str) -> None:
    """Say what the process of its own does next, so that its end can be told by it."""
    print(_DOING + what, flush=True)


def report(findings: Iterator[str]) -> None:
    """Print what is found, in the process of its own."""
    for finding in findings:
        print(("note: " if isinstance(finding, Note) else "finding: ") + " ".join(finding.split()), flush=True)
    doing(_END)


def initialised(path: Path) -> Iterator[str]:
    """Do it in this process."""
    import fmpy
    from fmpy.fmi2 import FMU2Model, FMU2Slave
    from fmpy.fmi3 import FMU3Model, FMU3Slave

    with Archive(path) as archive:
        content = archive.read("modelDescription.xml", LARGEST_XML)
    root = parse(content, "modelDescription.xml")
    texts = _texts(root)
    model = read_model(content, root, validate=False)
    is_fmi2 = model.fmiMajorVersion == 2
    folders = [fmpy.platform_tuple]  # in FMI 2 since 2.0.4
    if is_fmi2 and fmpy.platform_tuple != "aarch64-linux":  # which is not FMI 2's linux64
        folders.insert(0, fmpy.platform)
    experiment = model.defaultExperiment
    start = float(experiment.startTime or 0.0) if experiment else 0.0
    interfaces = {
        "ModelExchange": (model.modelExchange, FMU2Model if is_fmi2 else FMU3Model),
        "CoSimulation": (model.coSimulation, FMU2Slave if is_fmi2 else FMU3Slave),
    }
    with tempfile.TemporaryDirectory() as unzipped:
        fmpy.extract(str(path), unzipped)
        for name, (interface, fmu_class) in interfaces.items():
            if interface is None:
                continue
            file = interface.modelIdentifier + fmpy.sharedLibraryExtension
            libraries = [path for f in folders if (path := Path(unzipped, "binaries", f, file)).is_file()]
            if not libraries:
                continue
            where = {"libraryPath": str(libraries[0])} if is_fmi2 else {}

            def instance(token: str, interface=interface, fmu_class=fmu_class, where=where, **settings):  # type: ignore[no-untyped-def]
                with chdir("."):  # which fmpy changes, and leaves so if loading fails
                    fmu = fmu_class(
                        guid=token,
                        modelIdentifier=interface.modelIdentifier,
                        unzipDirectory=unzipped,
                        instanceName="check",
                        **where,
                    )
                    fmu.instantiate(**settings)
                return fmu

            events: dict[str, bool] = {}
            if (
                name == "CoSimulation"
                and interface.hasEventMode
                and any(v.type == "Clock" for v in model.modelVariables)
            ):
                events = _EVENTS
            doing(f"{name}: instantiating")
            try:
                try:
                    fmu = instance(model.guid, **events)
                except Exception:
                    if is_fmi2 or name != "CoSimulation" or not interface.hasEventMode or events:
                        raise
                    events = _EVENTS  # which some need
                    doing(f"{name}: instantiating with events")
                    fmu = instance(model.guid, **events)
            except Exception as error:
                text = f"{name} cannot be instantiated with the token of the XML, {model.guid}"
                text += "" if "instantiate" in str(error) else f": {error}"  # but cannot even be loaded
                yield Note(f"{text}: it needs the tool that made it") if interface.needsExecutionTool else Failure(text)
                continue
            doing(f"{name}: initialising")
            try:
                if is_fmi2:
                    fmu.setupExperiment(startTime=start)
                    fmu.enterInitializationMode()
                else:
                    fmu.enterInitializationMode(startTime=start)
                yield from (f"{name}: {problem}" for problem in _check_starts(fmu, model, texts))
                fmu.exitInitializationMode()
            except Exception as error:
                yield Failure(f"{name} cannot be initialised with the start values of the XML: {error}")
                if getattr(error, "status", None) == _FATAL:  # after which nothing may be called
                    continue
            else:
                doing(f"{name}: terminating")
                try:
                    fmu.terminate()
                except Exception as error:
                    yield Note(f"{name} cannot be terminated after initialisation: {error}")
            doing(f"{name}: freeing")
            fmu.freeInstance()
            if interface.canBeInstantiatedOnlyOncePerProcess:
                continue
            doing(f"{name}: instantiating with a wrong token")
            try:
                instance("not the token", **events)
            except Exception:
                doing("ending the check")  # of which the refusal is no cause
                continue
            yield Note(f"{name} can be instantiated with a wrong token")


def _texts(root: Any) -> dict[str, list[str]]:
    """Return the start values of String and Binary variables of FMI 3, which are elements, by name."""
    found = {}
    for element in root.iterfind("ModelVariables/*"):
        if starts := element.findall("Start"):
            found[element.get("name")] = [start.get("value", "") for start in starts]
    return found


def _check_starts(fmu: FMU2Slave | FMU3Slave, model: ModelDescription, texts: dict[str, list[str]]) -> Iterator[str]:
    is_fmi2 = model.fmiMajorVersion == 2
    for v in model.modelVariables:
        # what is only a guess is another value by now; an alias has the value of what it stands for
        if v.start is None or v.initial != "exact" or v.type == "Clock" or v.clocks or v.alias is not None:
            continue
        integer = "Integer" if is_fmi2 else "Int64"
        kind = integer if v.type == "Enumeration" else v.type
        words = texts.get(v.name) or ([v.start] if v.type in ("String", "Binary") else str(v.start).split())
        declared = [_value(kind, word) for word in words]
        size = {} if is_fmi2 else {"nValues": math.prod(v.shape)}
        if kind == "Float32" and any(map(math.isinf, declared)):  # of which `check_variables` tells
            continue
        try:
            read = getattr(fmu, f"get{kind}")([v.valueReference], **size)
        except Exception as error:
            yield f"the start value of {v.name} cannot be read: {error}"
            continue
        actual = [_value(kind, value) for value in read]
        if declared != actual and declared * len(actual) != actual:  # FMI 3: one value may stand for all
            yield f"{v.name} starts at {actual}, but the XML says {declared}"


def _value(kind: str, given: Any) -> Any:
    """Return a value as it can be compared, from what the XML says or the FMU answers."""
    match kind:
        case "String":
            return given.decode("utf-8", "replace") if isinstance(given, bytes) else given or ""
        case "Binary":
            return given.lower() if isinstance(given, str) else (given or b"").hex()
        case "Boolean":
            return given in ("true", "1") if isinstance(given, str) else bool(given)
        case "Float32":
            return struct.unpack("f", struct.pack("f", float(given)))[0]
        case "Real" | "Float64":
            return float(given)
    return int(given)


if __name__ == "__main__":
    report(initialised(Path(sys.argv[1])))

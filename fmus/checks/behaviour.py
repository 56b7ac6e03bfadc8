"""What an FMU does when it is loaded on this machine; in a process of its own, since it might crash."""

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription

from fmus.checks import Note
from fmus.paths import PACKAGE

_MARKS = {"finding: ": str, "note: ": Note}
_SECONDS = 60


def check_behaviour(path: Path) -> Iterator[str]:
    """Instantiates and initialises each interface with the values of the XML; nothing if this platform is not in it."""
    command = [sys.executable, "-m", __name__, str(path)]
    try:
        result = subprocess.run(
            command,
            capture_output=True,
            text=True,
            env=os.environ | {"PYTHONPATH": str(PACKAGE.parent)},
            timeout=_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        yield f"instantiating does not end within {_SECONDS} s"
        return
    said = ""
    for line in result.stdout.splitlines():
        for mark, kind in _MARKS.items():
            if line.startswith(mark):
                yield kind(line.removeprefix(mark) + (f" ({said})" if said else ""))
                said = ""
                break
        else:
            said = line  # the FMU's own last message explains what follows
    if result.returncode != 0:
        last_words = result.stderr.strip().splitlines()[-1:] or [said]
        yield f"instantiating ends with exit code {result.returncode}: {last_words[0]}"


def _try(path: Path) -> Iterator[str]:
    model = fmpy.read_model_description(str(path), validate=False)
    is_fmi2 = model.fmiMajorVersion == 2
    folder = fmpy.platform if is_fmi2 else fmpy.platform_tuple
    interfaces = {
        "ModelExchange": (model.modelExchange, FMU2Model if is_fmi2 else FMU3Model),
        "CoSimulation": (model.coSimulation, FMU2Slave if is_fmi2 else FMU3Slave),
    }
    with tempfile.TemporaryDirectory() as unzipped:
        fmpy.extract(str(path), unzipped)
        for name, (interface, fmu_class) in interfaces.items():
            if interface is None:
                continue
            library = Path(unzipped, "binaries", folder, interface.modelIdentifier + fmpy.sharedLibraryExtension)
            if not library.is_file():
                continue

            def instance(token: str, interface=interface, fmu_class=fmu_class, **settings):  # type: ignore[no-untyped-def]
                fmu = fmu_class(
                    guid=token, modelIdentifier=interface.modelIdentifier, unzipDirectory=unzipped, instanceName="check"
                )
                fmu.instantiate(**settings)
                return fmu

            events: dict[str, bool] = {}
            try:
                try:
                    fmu = instance(model.guid)
                except Exception:
                    if is_fmi2 or name != "CoSimulation" or not interface.hasEventMode:
                        raise
                    events = {"eventModeUsed": True, "earlyReturnAllowed": True}  # which some need
                    fmu = instance(model.guid, **events)
                    print()
            except Exception:
                text = f"{name} cannot be instantiated with the token of the XML, {model.guid}"
                yield Note(f"{text}: it needs the tool that made it") if interface.needsExecutionTool else text
                continue
            try:
                if is_fmi2:
                    fmu.setupExperiment(startTime=0.0)
                fmu.enterInitializationMode()
                yield from (f"{name}: {problem}" for problem in _check_starts(fmu, model))
                fmu.exitInitializationMode()
                fmu.terminate()
                fmu.freeInstance()
            except Exception as error:
                yield f"{name} cannot be initialised with the start values of the XML: {error}"
            try:
                instance("not the token", **events)
            except Exception:
                print()  # so that the refusal is not taken for the cause of a later finding
                continue
            yield Note(f"{name} can be instantiated with a wrong token")


def _check_starts(fmu: FMU2Slave | FMU3Slave, model: ModelDescription) -> Iterator[str]:
    for v in model.modelVariables:
        if v.start is None or v.type in ("String", "Binary", "Boolean", "Enumeration", "Clock") or v.clocks:
            continue
        declared = [float(x) for x in str(v.start).split()]
        size = {"nValues": math.prod(v.shape)} if model.fmiMajorVersion == 3 else {}
        actual = [float(x) for x in getattr(fmu, f"get{v.type}")([v.valueReference], **size)]
        if declared != actual and declared * len(actual) != actual:  # FMI 3: one value may stand for all
            yield f"{v.name} starts at {actual}, but the XML says {declared}"


if __name__ == "__main__":
    for finding in _try(Path(sys.argv[1])):
        print(("note: " if isinstance(finding, Note) else "finding: ") + finding, flush=True)

"""Start time, stop time and exchange step, as far as a file has them."""

from __future__ import annotations

from math import isfinite

from lxml import etree

from fmus.errors import AdcsError
from orchestration.ssp.documents import OMS, OMS_ANNOTATION, notes, number, tag


def read_experiment(document: etree._Element) -> tuple[float | None, float | None, float | None]:
    """Return start time, stop time and exchange step."""
    experiment = document.find(tag("ssd", "DefaultExperiment"))
    times: dict[str, float | None] = {"startTime": None, "stopTime": None, "step": None}
    if experiment is not None:
        for name in ("startTime", "stopTime"):
            times[name] = _optional(experiment.get(name), f"DefaultExperiment: {name}")
        times["step"] = _optional(notes(experiment, "Experiment").get("step"), "DefaultExperiment: step")
    if times["step"] is None:
        times["step"] = _oms_step(document)
    for name, value in times.items():
        if value is not None and not (isfinite(value) and (value > 0 or name != "step")):
            raise AdcsError(f"{name} = {value}: expected a {'positive number' if name == 'step' else 'number'}")
    return times["startTime"], times["stopTime"], times["step"]


def _oms_step(document: etree._Element) -> float | None:
    """Return the step that OMSimulator (version 2 or 3) has noted."""
    path = f"{tag('ssd', 'System')}/{tag('ssd', 'Annotations')}/{tag('ssc', 'Annotation')}"
    for annotation in document.iterfind(path):
        for element in annotation.iter() if annotation.get("type") == OMS_ANNOTATION else ():
            for name, key in (("FixedStepMaster", "stepSize"), ("SimulationInformation", "fixedStepSize")):
                if element.tag == f"{{{OMS}}}{name}" and element.get(key) is not None:
                    return number(element.get(key), f"{name}: {key}")
    return None


def _optional(text: str | None, where: str) -> float | None:
    return None if text is None else number(text, where)

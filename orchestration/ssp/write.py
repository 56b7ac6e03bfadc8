"""A system as an `.ssp` file that any tool for SSP can read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any
from urllib.parse import quote

from lxml import etree

from fmus.errors import AdcsError, Failed
from fmus.xml import serialised
from orchestration import expected
from orchestration.fmu.file import FmiVersion, Fmu, Port
from orchestration.process.writing import make_folder
from orchestration.ssp.archive import packed, write_whole
from orchestration.ssp.building import add, add_texts, annotate, annotations_of, root_element, set_attribute, text
from orchestration.ssp.definitions import UsedEnumerations, UsedUnits
from orchestration.ssp.documents import OMS, OMS_ANNOTATION, check, tag
from orchestration.ssp.layout import arrange
from orchestration.ssp.names import STRUCTURE
from orchestration.ssp.schemas import Version
from orchestration.ssp.tree import Box, Pin, Wire, make_tree
from orchestration.system import Component, System, check_system

_FMI2_TYPES = {"Float64": "Real", "Int32": "Integer"}


def write_ssp(
    system: System,
    path: str | Path,
    *,
    stop_time: float | None = None,
    step: float | None = None,
    start_time: float | None = None,
    fmi_version: FmiVersion = "2.0",
    ssp_version: Version | None = None,
    force: bool = False,
) -> None:
    """Write a system with its FMUs; the same system gives the same bytes.

    `stop_time` and exchange `step` (s) are for who runs it; the system's own times count where none are given.
    `fmi_version` says which file of a component known by name is taken. `ssp_version` None: 1.0, or 2.0 if an FMU is of
    FMI 3.0, whose arrays and types SSP 1.0 does not know. Connection delays, components that communicate at every n-th
    step and the exchange step stand in annotations, which other tools ignore (the step is also where OMSimulator looks
    for it). A file that is there already is replaced by `force` only. Raises AdcsError.
    """
    check_system(system)
    expected.path("path", path)
    path = Path(path)
    if path.is_file() and not force:
        raise AdcsError(f"{path} is there already: give another name, or force=True to replace it")
    system.check()
    if (own := system.times) is not None:
        start_time = own.start if start_time is None else start_time
        stop_time = own.stop if stop_time is None and "stop_time" not in own.assumed else stop_time
        step = own.step if step is None and "step" not in own.assumed else step
    start_time = start_time or 0.0
    for name, value in (("start_time", start_time), ("stop_time", stop_time), ("step", step)):
        if value is not None and not (isfinite(value) and (value > 0 or name != "step")):
            raise AdcsError(f"{name} = {value}: expected a {'positive ' if name == 'step' else ''}number")
    fmus = {name: component.open(fmi_version) for name, component in system.components.items()}
    needed: Version = "2.0" if any(fmu.major_version == 3 for fmu in fmus.values()) else "1.0"
    if ssp_version == "1.0" and needed == "2.0":
        raise AdcsError("SSP 1.0 has no arrays as FMI 3.0 has: write SSP 2.0, or take components of FMI 2.0")
    writer = _Writer(system, fmus, ssp_version or needed)
    content = packed(writer.files(start_time, stop_time, step))
    make_folder(path.parent, f"cannot write {path}")
    try:
        write_whole(path, content)
    except OSError as error:
        raise Failed(f"cannot write {path}: {error.strerror or error}") from error


class _Writer:
    def __init__(self, system: System, fmus: dict[str, Fmu], version: Version) -> None:
        self.system = system
        self.fmus = fmus
        self.version = version
        self.members = _members(fmus)
        self.units = UsedUnits(fmus.values())
        self.enumerations = UsedEnumerations()

    def files(self, start_time: float, stop_time: float | None, step: float | None) -> dict[str, bytes]:
        """All files of the archive."""
        tree = make_tree(self.system, self.fmus)
        arrange(tree)
        files: dict[str, bytes] = {}
        sources = _file_names(self.system.components, ".ssv")
        for name, component in self.system.components.items():
            if component.start:
                root = self._parameter_set(component)
                check(root, sources[name], "ssv")
                files[f"resources/{sources[name]}"] = serialised(root)
        root = self._structure(tree, sources, (start_time, stop_time, step))
        check(root, STRUCTURE, "ssd")
        fmus = {f"resources/{self.members[n]}": fmu.path.read_bytes() for n, fmu in self.fmus.items()}
        return {STRUCTURE: serialised(root), **files, **fmus}

    def _structure(
        self, tree: Box, sources: Mapping[str, str], times: tuple[float, float | None, float | None]
    ) -> etree._Element:
        start_time, stop_time, step = times
        root = root_element("ssd", "SystemStructureDescription", self.version, self.system.name)
        self.nested = any(box.component is None for box in tree.boxes.values())
        element = self._system(root, tree, sources)
        if self.system.description:
            set_attribute(element, "description", self.system.description)
        if step is not None:
            # first, because some readers look no further than the first annotation
            _add_oms_step(element, step)
        self.enumerations.add_to(root, "ssd")
        self.units.add_to(root, "ssd")
        experiment = add(root, "ssd", "DefaultExperiment", startTime=start_time, stopTime=stop_time)
        if step is not None:
            annotate(experiment, "Experiment", step=step)
        return root

    def _system(self, parent: etree._Element, box: Box, sources: Mapping[str, str]) -> etree._Element:
        element = add(parent, "ssd", "System", name=box.name)
        self._common(element, box, parent.tag == tag("ssd", "Elements"))
        if box.boxes:
            elements = add(element, "ssd", "Elements")
            for child in box.boxes.values():
                if child.component is None:
                    self._system(elements, child, sources)
                else:
                    self._component(elements, child, child.component, sources[child.component.name])
        if box.wires:
            connections = add(element, "ssd", "Connections")
            for wire in box.wires:
                self._connection(connections, wire)
        add(element, "ssd", "SystemGeometry", **dict(zip(("x1", "y1", "x2", "y2"), box.canvas, strict=True)))
        return element

    def _component(self, parent: etree._Element, box: Box, component: Component, source: str) -> None:
        element = add(
            parent,
            "ssd",
            "Component",
            name=box.name,
            type="application/x-fmu-sharedlibrary",
            source=quote(f"resources/{self.members[component.name]}"),
        )
        self._common(element, box, True)
        if component.start:
            bindings = add(element, "ssd", "ParameterBindings")
            add(bindings, "ssd", "ParameterBinding", source=quote(f"resources/{source}"))
        order = box.order if self.nested else None
        if component.every != 1 or order is not None:
            annotate(element, "Component", every=component.every if component.every != 1 else None, order=order)

    def _common(self, element: etree._Element, box: Box, with_geometry: bool) -> None:
        if box.pins:
            connectors = add(element, "ssd", "Connectors")
            for pin in box.pins.values():
                self._connector(connectors, pin, box.places[pin.name])
        if with_geometry:
            add(element, "ssd", "ElementGeometry", **dict(zip(("x1", "y1", "x2", "y2"), box.rectangle, strict=True)))

    def _connector(self, parent: etree._Element, pin: Pin, place: tuple[float, float]) -> None:
        element = add(parent, "ssd", "Connector", name=pin.name, kind=pin.kind)
        kind, name = self._type(pin.fmu, pin.port)
        unit = self.units.use(pin.fmu, pin.port, "ssd") if kind in ("Real", "Float64", "Float32") else None
        clock = next((clock.kind for clock in pin.fmu.clocks if clock.reference == pin.port.references[0]), None)
        add(element, "ssc", kind, unit=unit, name=name, intervalVariability=clock)
        for n in pin.shape:
            add(element, "ssc", "Dimension", size=n)
        add(element, "ssd", "ConnectorGeometry", x=place[0], y=place[1])

    def _connection(self, parent: etree._Element, wire: Wire) -> None:
        by = wire.by
        element = add(
            parent,
            "ssd",
            "Connection",
            startElement=wire.start[0],
            startConnector=wire.start[1],
            startIndices=" ".join(map(str, wire.start_indices)) or None,
            endElement=wire.end[0],
            endConnector=wire.end[1],
            endIndices=" ".join(map(str, wire.end_indices)) or None,
            suppressUnitConversion="true" if by is not None and by.given and not by.mapping else None,
        )
        if by is not None and by.mapping:
            self._mapping(element, by.source, by.target, by.mapping)
        elif by is not None and by.given:
            add(element, "ssc", "LinearTransformation", factor=by.factor, offset=by.offset)
        if wire.points:
            xs, ys = zip(*wire.points, strict=True)
            points = {"pointsX": " ".join(map(text, xs)), "pointsY": " ".join(map(text, ys))}
            add(element, "ssd", "ConnectionGeometry", **points)
        remarks = {
            "order": wire.order if self.nested and by is not None else None,
            "element": "true" if wire.element else None,
            # in SSP values that a table does not name stay as they are; ours end the run
            "others": "refused" if by is not None and by.mapping else None,
            "delaySteps": by.delay_steps if by is not None and by.delay_steps else None,
            "delay": by.delay if by is not None and by.delay else None,
        }
        if any(value is not None for value in remarks.values()):
            annotate(element, "Connection", **remarks)

    def _mapping(self, element: etree._Element, source: str, target: str, pairs: Iterable[tuple[float, float]]) -> None:
        ports = [self.system.port(source)[1], self.system.port(target)[1]]
        names = [{number: name for name, number in port.items} for port in ports]
        pairs = list(pairs)
        if all(port.type == "Boolean" for port in ports):
            kind, texts = "Boolean", [(text(bool(a)), text(bool(b))) for a, b in pairs]
        elif all(names) and all(a in names[0] and b in names[1] for a, b in pairs):
            kind, texts = "Enumeration", [(names[0][int(a)], names[1][int(b)]) for a, b in pairs]
        else:
            if not all(v == round(v) for pair in pairs for v in pair):
                raise AdcsError(
                    f"the mapping of {source} to {target} has fractions, which SSP cannot hold: use factors"
                )
            kind, texts = "Integer", [(str(int(a)), str(int(b))) for a, b in pairs]
        table = add(element, "ssc", f"{kind}MappingTransformation")
        for from_, to in texts:
            add(table, "ssc", "MapEntry", source=from_, target=to)

    def _parameter_set(self, component: Component) -> etree._Element:
        fmu = self.fmus[component.name]
        root = root_element("ssv", "ParameterSet", self.version, component.name)
        parameters = add(root, "ssv", "Parameters")
        self.units.reset("ssv")
        enumerations = UsedEnumerations()
        clocks = {clock.reference for clock in fmu.clocks}
        # those that give others their sizes first, as a system that is read has them
        start = sorted(component.start.items(), key=lambda item: fmu.ports[item[0]].causality != "structuralParameter")
        for name, values in start:
            port = fmu.ports[name]
            if port.references[0] in clocks:
                continue  # a clock has no value; this one never ticks, as it is not connected
            names = port.elements if fmu.major_version == 2 else [port.name]
            groups = [(v,) for v in values] if fmu.major_version == 2 else [values]
            for element, group in zip(names, groups, strict=True):
                parameter = add(parameters, "ssv", "Parameter", name=element)
                self._value(parameter, fmu, port, group, enumerations)
                for n in port.shape if fmu.major_version == 3 else ():
                    add(parameter, "ssc", "Dimension", size=n)
        enumerations.add_to(root, "ssv")
        self.units.add_to(root, "ssv")
        return root

    def _value(
        self, parameter: etree._Element, fmu: Fmu, port: Port, values: tuple[Any, ...], enumerations: UsedEnumerations
    ) -> None:
        kind = _FMI2_TYPES.get(port.type, port.type) if fmu.major_version == 2 else port.type
        if port.items:
            names = {number: name for name, number in port.items}
            if all(value in names for value in values):
                texts = [names[value] for value in values]
                add_texts(parameter, "Enumeration", texts, name=enumerations.use(fmu, port))
                return
            raise AdcsError(f"{parameter.get('name')} = {values} is no item of its enumeration: choose {names}")
        if port.type in ("String", "Binary"):
            texts = [value.hex() if isinstance(value, bytes) else value for value in values]
            add_texts(parameter, port.type, texts)
            return
        unit = self.units.use(fmu, port, "ssv") if port.type.startswith("Float") else None
        add(parameter, "ssv", kind, value=" ".join(map(text, values)), unit=unit)

    def _type(self, fmu: Fmu, port: Port) -> tuple[str, str | None]:
        """Return the SSP type of a variable and the name of its enumeration."""
        if port.items:
            return "Enumeration", self.enumerations.use(fmu, port)
        if port.references[0] in {clock.reference for clock in fmu.clocks}:
            return "Clock", None
        return (_FMI2_TYPES.get(port.type, port.type) if fmu.major_version == 2 else port.type), None


def _members(fmus: Mapping[str, Fmu]) -> dict[str, str]:
    """Names of the FMUs in the archive: that of the file, numbered where two differ; equal files are one."""
    members: dict[str, str] = {}
    contents: dict[str, str] = {}
    for component, fmu in fmus.items():
        number = 1
        name = fmu.path.name
        # file systems may not tell upper from lower case
        while contents.setdefault(name.lower(), fmu.sha256) != fmu.sha256:
            number += 1
            name = f"{fmu.path.stem}-{number}{fmu.path.suffix}"
        members[component] = name
    return members


def _file_names(names: Iterable[str], suffix: str) -> dict[str, str]:
    """A file name for each component, of characters that every archive and file system can hold."""
    found: dict[str, str] = {}
    taken: set[str] = set()  # in lower case, as file systems may not tell upper from lower
    for name in names:
        base = re.sub(r"[^A-Za-z0-9_-]", "_", name)
        number = 1
        file = f"{base}{suffix}"
        while file.lower() in taken:
            number += 1
            file = f"{base}-{number}{suffix}"
        taken.add(file.lower())
        found[name] = file
    return found


def _add_oms_step(system: etree._Element, step: float) -> None:
    """Tell OMSimulator the step: version 2 reads the element, version 3 the attributes of its default solver."""
    annotation = add(annotations_of(system), "ssc", "Annotation", type=OMS_ANNOTATION)
    oms = etree.SubElement(annotation, f"{{{OMS}}}Annotations", nsmap={"oms": OMS})
    solver = {"name": "oms_ma_default", "method": "oms_ma", "fixedStepSize": text(step)}
    information = etree.SubElement(oms, f"{{{OMS}}}SimulationInformation", solver)
    etree.SubElement(information, f"{{{OMS}}}FixedStepMaster", description="oms-ma", stepSize=text(step))

"""FMUs of which the description matters and the rest does not: made of XML, or of a built one whose XML is changed."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

XML = "modelDescription.xml"


def packed(path: Path, xml: str) -> Path:
    """Write an FMU that consists of a description."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(XML, xml)
    return path


def changed(source: Path, path: Path, *changes: tuple[str, str]) -> Path:
    """Copy an FMU with regular expressions replaced in its description, each of which must be there."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == XML:
                text = content.decode()
                for pattern, replacement in changes:
                    text, count = re.subn(pattern, replacement, text)
                    assert count, pattern
                content = text.encode()
            new.writestr(name, content)
    return path


def description2(variables: str, types: str = "", units: str = "", version: str = "2.0", structure: str = "") -> str:
    return (
        f'<fmiModelDescription fmiVersion="{version}" modelName="m" guid="g">'
        f'<CoSimulation modelIdentifier="m"/><UnitDefinitions>{units}<Unit name="1"/></UnitDefinitions>'
        f'<TypeDefinitions>{types}<SimpleType name="none"><Boolean/></SimpleType></TypeDefinitions>'
        '<ModelVariables><ScalarVariable name="time" valueReference="0" causality="independent">'
        f"<Real/></ScalarVariable>{variables}</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def description3(variables: str, types: str = "", units: str = "", version: str = "3.0", structure: str = "") -> str:
    return (
        f'<fmiModelDescription fmiVersion="{version}" modelName="m" instantiationToken="g">'
        f'<CoSimulation modelIdentifier="m" hasEventMode="true"/>'
        f'<UnitDefinitions>{units}<Unit name="1"/></UnitDefinitions>'
        f'<TypeDefinitions>{types}<BooleanType name="none"/></TypeDefinitions>'
        '<ModelVariables><Float64 name="time" valueReference="0" causality="independent"/>'
        f"{variables}</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )

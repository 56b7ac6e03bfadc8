"""terminalsAndIcons.xml: vectors as single plugs, so that tools draw one wire instead of three or four."""

from lxml import etree

from fmus.describe import Description
from fmus.xml import serialised


def terminals_and_icons(description: Description, fmi_version: str) -> bytes:
    """Every vector input and output is a terminal whose members are its variables."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    drawing = etree.SubElement(root, "GraphicalRepresentation")
    box = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    etree.SubElement(drawing, "CoordinateSystem", box, suggestedScalingFactorTo_mm="0.1")
    etree.SubElement(drawing, "Icon", box)
    signals = [v for v in description.variables if v.causality in ("input", "output") and v.shape]
    if signals:
        terminals = etree.SubElement(root, "Terminals")
        for v in signals:
            terminal = etree.SubElement(
                terminals, "Terminal", name=v.name, matchingRule="plug", description=v.description
            )
            names = [v.name] if fmi_version == "3.0" else v.element_names
            for i, name in enumerate(names, 1):  # members carry numbers, not names, so that q_BN fits q_BN_meas
                etree.SubElement(
                    terminal, "TerminalMemberVariable", variableName=name, memberName=str(i), variableKind="signal"
                )
    return serialised(root)

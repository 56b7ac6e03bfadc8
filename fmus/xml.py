"""XML documents as they go into an FMU."""

from lxml import etree


def serialised(root: etree._Element) -> bytes:
    """The document with this root element."""
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))

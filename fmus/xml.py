"""XML documents: written as they go into an FMU, and read from files that anyone may have made."""

from __future__ import annotations

import re
from typing import Any

from lxml import etree

from fmus.errors import AdcsError

_ENCODINGS = {
    "utf-8": "utf-8-sig",
    "utf-16": "utf-16",
    "us-ascii": "ascii",
    "iso-8859-1": "iso-8859-1",
    "windows-1252": "cp1252",
}
"""Names in an XML declaration -> codecs. Others could hide a document type declaration."""
_LIMITS = {
    "Excessive depth": "elements nested more than 256 deep",
    "Name too long": "a name of more than 50000 bytes",
    "too big": "a comment, instruction or CDATA section of more than 10 MB",
    "Resource limit exceeded": "a text, name or attribute of more than 10 MB",
}
"""What the messages of libxml2 hold -> the limit that it has. Its own words advise an option that users have not."""
_DECLARED = re.compile(rb"""<\?xml[^>]{0,100}?\bencoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


def serialised(root: etree._Element) -> bytes:
    """The document with this root element."""
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def parse(content: bytes, name: str, *, utf8_only: bool = False, bare: bool = False) -> Any:
    """Return the root element of a document that is well-formed and expands nothing; AdcsError names the file `name`.

    Entities are defined in a document type declaration, which none of the documents of FMI and SSP has: with one it is
    refused, so nothing can be fetched or grow. `bare` leaves out comments, processing instructions and blank text.
    """
    text = _decoded(content, name, utf8_only)
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise AdcsError(f"{name} has a document type declaration, which FMI and SSP do not use: refused, take it out")
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        remove_blank_text=bare,
        remove_comments=bare,
        remove_pis=bare,
    )
    try:
        return etree.fromstring(text.encode(), parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        line = " ".join(str(error).split())
        beyond = next((what for sign, what in _LIMITS.items() if sign in line), None)
        if beyond is not None:
            raise AdcsError(f"{name} has {beyond}: refused, make it smaller") from None
        raise AdcsError(f"{name} is not well-formed XML ({line}): correct it") from None


def _decoded(content: bytes, name: str, utf8_only: bool) -> str:
    declared = _DECLARED.match(content.lstrip()[:200])
    encoding = declared[1].decode().lower() if declared else "utf-8"
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encoding = "utf-16"
    elif content[:3] == b"\xef\xbb\xbf":
        encoding = "utf-8"
    elif encoding == "utf-16":
        raise AdcsError(f"{name} is not in UTF-16 as it says (it has no byte order mark): save it in UTF-8")
    if encoding not in _ENCODINGS or (utf8_only and encoding not in ("utf-8", "us-ascii")):
        raise AdcsError(f"{name} is in {encoding}, expected UTF-8: save it so")
    try:
        return content.decode(_ENCODINGS[encoding])
    except UnicodeDecodeError as error:
        raise AdcsError(f"{name} is not in {encoding.upper()} as it says ({error.reason}): save it in UTF-8") from None

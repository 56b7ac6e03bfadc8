"""What fmpy can read of a modelDescription.xml."""

from __future__ import annotations

import io
import zipfile
from typing import Any

from lxml import etree


def for_fmpy(content: bytes, root: Any) -> io.BytesIO:
    """Return an archive of what fmpy can read of a description: without what it stumbles over though it is valid.

    That is a declared type of a clock, and more than one space between the entries of a list.
    """
    cleaned = False
    for element in root.iter("Clock"):
        cleaned = element.attrib.pop("declaredType", None) is not None or cleaned
    for element in root.iter():
        for name in ("dependencies", "dependenciesKind", "clocks"):
            text = element.get(name)
            if text is not None and text != " ".join(text.split()):
                element.set(name, " ".join(text.split()))
                cleaned = True
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as writer:
        writer.writestr("modelDescription.xml", etree.tostring(root) if cleaned else content)
    archive.seek(0)
    return archive

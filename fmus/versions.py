"""Which version of FMI a description is of, and as which it is read.

From FMI 3.0 on the versions are semantic: a patch (3.0.1) changes the standard's text only, a minor version (3.1) adds
only what may be ignored. So all of them are read as 3.0.
"""

from __future__ import annotations

import re

_FMI3 = re.compile(r"3[.](?P<minor>0|[1-9][0-9]*)([.](0|[1-9][0-9]*))?")
_PRE_RELEASE = re.compile(r"[0-9.]+-.+")


def major_version(text: str | None) -> int:
    """Return 2 or 3; ValueError, which goes on a line that begins with the file, if it is none that can be read."""
    if text == "2.0":
        return 2
    if _FMI3.fullmatch(text or ""):
        return 3
    what = f"{text}, a pre-release" if _PRE_RELEASE.fullmatch(text or "") else text
    raise ValueError(f"is FMI {what}: only 2.0 and 3.0 are supported")


def newer_minor(text: str) -> str | None:
    """Return the warning that a version has more than 3.0, None if it has not."""
    match = _FMI3.fullmatch(text)
    if match is None or match["minor"] == "0":
        return None
    return f"is FMI {text}: it is read as 3.0, to which a minor version adds only what may be ignored"

"""What readers are given: valid files with something wrong in them, and texts made of the right words in any order."""

from __future__ import annotations

import copy
import io
import struct
import zipfile
from collections.abc import Mapping, Sequence

from hypothesis import strategies as st
from lxml import etree

ODD = ["", "x", "0", "1", "-1", "2", "1e400", "nan", "INF", "true", "../x", "a.b", "u[1]", "u[4000000000]", "9" * 20]
ODD += [
    "9" * 5000,
    "1 2 3",
    "1 " * 50,
    "{}",
    "\t",
    "é漢\U0001f600",
    "A" * 3000,
    "input",
    "output",
    "parameter",
    "exact",
]
ODD += ["continuous", "tunable", "der(x)", "2.0", "3.0", "3.1", "%s%n", "&amp;", "-0", "+1", "0x10", "1.5", "1_0"]
EXTREMES = [0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF]
DOCTYPE = b'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]>'
PATHS = [
    "../evil",
    "/etc/evil",
    "a/../../b",
    "C:/evil",
    "a\\b",
    "a",
    "a/",
    "a/b",
    "modelDescription.xml",
    "é",
    "x" * 300,
]
PATHS += ["binaries", "binaries/linux64", "resources/./x", "con", "", " ", "a\nb", "\x01"]
METHODS = [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]


@st.composite
def damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes with some changed, cut off, put in, or repeated."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(data) - 1, 0)))
        match draw(st.sampled_from(["flip", "field", "cut", "put in", "repeat", "nul", "begin"])):
            case "flip" if data:
                data[at] ^= 1 << draw(st.integers(0, 7))
            case "field":
                width, code = draw(st.sampled_from([(1, "B"), (2, "H"), (4, "I")]))
                value = draw(st.sampled_from(EXTREMES)) & (256**width - 1)
                data[at : at + width] = struct.pack(f"<{code}", value)
            case "cut":
                del data[at:]
            case "put in":
                data[at:at] = draw(st.binary(min_size=1, max_size=40))
            case "repeat":
                end = draw(st.integers(at, min(at + 2000, len(data))))
                data[at:at] = data[at:end] * draw(st.integers(1, 50))
            case "nul":
                data[at : at + 4] = b"\0" * 4
            case "begin":
                data[:0] = draw(
                    st.sampled_from([b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff", b"\0", b"PK\3\4", b"\x1f\x8b"])
                )
    return bytes(data)


@st.composite
def zip_damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """A zip archive with a field of one of its headers changed: the place, lengths, methods, flags, sizes."""
    signatures = {b"PK\3\4": range(4, 30), b"PK\1\2": range(4, 46), b"PK\5\6": range(4, 22)}
    signature = draw(st.sampled_from(sorted(signatures)))
    places = [i for i in range(len(content)) if content.startswith(signature, i)]
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.sampled_from(places)) + draw(st.sampled_from(signatures[signature]))
        width, code = draw(st.sampled_from([(1, "B"), (2, "H"), (4, "I")]))
        data[at : at + width] = struct.pack(f"<{code}", draw(st.sampled_from(EXTREMES)) & (256**width - 1))
    return bytes(data)


@st.composite
def odd_archives(draw: st.DrawFn, members: Mapping[str, bytes]) -> bytes:
    """An archive of good members and others: paths that lead outside, twins, links, other methods, file and folder."""
    buffer = io.BytesIO()
    extra = draw(st.lists(st.tuples(st.sampled_from(PATHS), st.sampled_from(METHODS), st.booleans()), max_size=3))
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            if draw(st.integers(0, 9)):
                archive.writestr(name, content)
        for name, method, link in extra:
            info = zipfile.ZipInfo(name)
            info.compress_type = method
            info.external_attr = (0o120777 if link else 0o100644) << 16
            archive.writestr(info, b"/etc/passwd")
    return buffer.getvalue()


@st.composite
def xml_damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """A document with attributes changed or left out, elements dropped, doubled, moved; sometimes only its bytes."""
    if not draw(st.integers(0, 9)):
        return draw(damaged(content))
    root = etree.fromstring(content)
    for _ in range(draw(st.sampled_from([1, 1, 1, 2, 3]))):
        found = [element for element in root.iter() if isinstance(element.tag, str)]
        element, other = draw(st.sampled_from(found)), draw(st.sampled_from(found))
        values = st.sampled_from(ODD) | st.sampled_from(sorted({v for e in found for v in e.attrib.values()} or {""}))
        match draw(
            st.sampled_from(["change", "change", "change", "change", "forget", "drop", "double", "move", "name"])
        ):
            case "change" if element.attrib:
                element.set(draw(st.sampled_from(sorted(element.attrib))), draw(values))
            case "forget" if element.attrib:
                del element.attrib[draw(st.sampled_from(sorted(element.attrib)))]
            case "drop" if element is not root:
                element.getparent().remove(element)
            case "double" if element is not root:
                for _ in range(draw(st.sampled_from([1, 1, 30]))):
                    element.addnext(copy.deepcopy(element))
            case "move" if len(found) < 5000:
                element.append(copy.deepcopy(other))
            case "name":
                element.set(draw(st.sampled_from(["name", "start", "derivative", "unit", "clocks"])), draw(values))
    encoding = draw(st.sampled_from(["UTF-8"] * 30 + ["UTF-16", "ISO-8859-1", "US-ASCII", "UTF-7"]))
    try:
        text = etree.tostring(root, encoding=encoding, xml_declaration=True)
    except (LookupError, ValueError):
        text = etree.tostring(root, encoding="UTF-8", xml_declaration=True).replace(b"UTF-8", encoding.encode())
    if not draw(st.integers(0, 24)):
        text = text.replace(b"?>", b"?>" + DOCTYPE, 1)
    return bytes(text)


def of_words(words: Sequence[str], most: int = 8) -> st.SearchStrategy[str]:
    """Text of these words in any order, with others among them."""
    word = st.sampled_from(list(words)) | st.sampled_from(ODD) | st.text(max_size=5) | st.floats().map(repr)
    return st.lists(word, max_size=most).map("".join) | st.text(max_size=60)

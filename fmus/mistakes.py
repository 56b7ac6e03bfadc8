"""A mistake in a component's header as one line: where it is, what is wrong, the way out."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from fmus.code import Place, code_lines, line_of
from fmus.describe import NOT_PRINTED
from fmus.errors import shown
from fmus.paths import BUILD, EIGEN, FMI_HEADERS, SOURCES
from fmus.wording import LONGEST, Error, in_words

_LINE = re.compile(
    r"(?P<path>.+?):(?P<line>\d+):(?P<column>\d+): (?P<level>(?:fatal )?error|note|warning): (?P<text>.*)"
)
_ASSERTED = re.compile(r"static assertion failed(?: due to requirement '.*')?: (?P<words>.+)")
_CAME_OF = re.compile("requested here|while substituting|^to match this")
_OF_THE_LIBRARY = re.compile(
    r"std::(?:\w*string|vector|map|set|list|deque|function|shared_ptr|unique_ptr|cout|cerr|clog|cin)\b|\bnew\b"
)
"""What in a header needs more than headers of the C++ library."""


def from_compiler(output: str, header: Path, component: str) -> str:
    """Return the first mistake in what a compiler or linker has printed about the header of a component."""
    errors = list(_errors(output))
    if not errors:
        return _not_linked(output, header, component)
    error = next((e for e in errors if _of_the_user(e) or _is_ours(e)), errors[0])  # others may be its consequences
    error = min((e for e in errors if (e.place.path, e.text) == (error.place.path, error.text)), key=lambda e: e.place)
    asserted = _ASSERTED.fullmatch(error.text)  # the same may be missed again before it is where it was missed first
    place = _of_the_user(error)
    if place is None:
        about = re.match(r"\w+(?:\(|(?= is missing))", asserted["words"]) if asserted else None
        place = line_of(header, about[0] if about else "") or _struct(header, component)
        code = "\n".join(line for _, line in code_lines(header))
        if not re.search(rf"template\s*<[^>]*>\s*struct\s+{component}\b", code):
            return f"{place}: {component} is no template of its scalar type (template <class T> struct {component})"
    if asserted and _is_ours(error):
        return f"{place}: {asserted['words']}"
    return f"{place}: {in_words(error, place, component)}"


def from_declaration(told: str, header: Path, component: str) -> str:
    """Return what a describe program refused: a text by which its line is found, a tab, and words."""
    text, _, words = told.strip("\n").partition("\t")
    return f"{line_of(header, text) or _struct(header, component)}: {words}"


_QUOTIENT = re.compile(r"(?:[=(,+\-{<>?:]|\breturn)\s*((\d+)\s*/\s*(\d+))(?![\w.'])")


def truncated(header: Path) -> str | None:
    """Return where a header divides whole numbers that do not divide, which no compiler tells: 1 / 2 is 0."""
    for number, line in code_lines(header):
        for whole, above, below in _QUOTIENT.findall(re.sub(r'"[^"]*"', "", line)):
            if int(below) == 0 or int(above) % int(below):
                return f"{Place(header, number)}: {whole} is a whole number in C++ (write {above}.0 / {below}.0)"
    return None


def _struct(header: Path, component: str) -> Place:
    return line_of(header, f"struct {component}") or Place(header, 1)


def _errors(output: str) -> Iterator[Error]:
    """Yield the errors, each with its notes."""
    error: Error | None = None
    for line in output.splitlines():
        if (found := _LINE.fullmatch(line)) is None:
            continue
        place = Place(Path(os.path.normpath(found["path"])), int(found["line"]), int(found["column"]))
        if found["level"] == "note":
            if error is not None:
                error.notes.append((place, _simple(found["text"])))
            continue
        if error is not None:
            yield error
        is_warning = found["level"] == "warning" and not found["text"].startswith("missing terminating")
        error = None if is_warning else Error(place, _simple(found["text"]))
    if error is not None:
        yield error


def _simple(text: str) -> str:
    """Return a compiler's words with the types called as headers call them."""
    text = re.sub(r" \(aka '[^']*'\)| \[-W\S+\]$", "", text).replace("adcs::detail::", "").replace("adcs::", "")
    text = re.sub(r"Lifted<(?:double|Bits)>|\b(?:Real)?Scalar\b", "T", text)
    for size, name in {"3, 1": "Vec3", "4, 1": "Quat", "3, 3": "Mat3"}.items():
        text = re.sub(rf"Eigen::Matrix<(\w+), {size}(?:, [^<>]*)?>", rf"{name}<\1>", text)
    return text


def _of_the_user(error: Error) -> Place | None:
    """Return where a file of the user's is concerned: the error itself, or what it came of."""
    chain = [place for place, text in error.notes if _CAME_OF.search(text)]
    return next((place for place in (error.place, *chain) if not _is_machinery(place.path)), None)


def _is_machinery(path: Path) -> bool:
    return any(path.is_relative_to(place) for place in _machinery())


@cache
def _machinery() -> tuple[Path, ...]:
    """Folders whose files are right: the adaptor, libraries, the compiler's own, and what is written to be compiled."""
    spec = find_spec("ziglang")
    own = [Path(place) for place in (spec.submodule_search_locations or ())] if spec else []
    return (*(SOURCES / folder for folder in ("fmi", "math", "attitude")), EIGEN, FMI_HEADERS, BUILD, *own)


def _is_ours(error: Error) -> bool:
    """Whether it is an assertion of the adaptor's, which has words of its own."""
    return bool(_ASSERTED.fullmatch(error.text)) and error.place.path.is_relative_to(SOURCES)


def _not_linked(output: str, header: Path, component: str) -> str:
    missing = [_as_written(name) for name in re.findall(r"undefined (?:hidden )?symbol: (.+)", output)]
    if not missing:
        return f"{header.name}: {shown(output.strip(), LONGEST)}"
    own = next((found for each in missing if (found := re.match(rf"adcs::{component}<.*>::(\w+)(\()?", each))), None)
    lines = [number for number, line in code_lines(header) if _OF_THE_LIBRARY.search(line)]
    place = Place(header, lines[0]) if lines else _struct(header, component)
    if own is not None:
        first = next((n for n, line in code_lines(header) if re.search(rf"\b{own[1]}\b", line)), place.line)
        return f"{Place(header, first)}: {own[1]} {_WITHOUT_A_BODY if own[2] else _WITHOUT_A_VALUE}"
    if any(
        re.match(r"std::.*(?:stream|std::c(?:out|err|log|in)$)|std::c(?:out|err|log|in)$", each) for each in missing
    ):
        return f"{place}: {NOT_PRINTED}"
    name = next((each for each in missing if "__" not in each), missing[0])  # two underscores: the library's insides
    return (
        f"{place}: it needs {shown(name, 80)}, which FMUs do without "
        "(no std::string or std::vector: arrays have a fixed size, as Eigen::Matrix<T, 5, 1>)"
    )


_WITHOUT_A_BODY = "is a function that does nothing yet (write its body, { ... }, where it is declared)"
_WITHOUT_A_VALUE = "is static, and all instances of a component would share it (leave `static` out)"


def _as_written(symbol: str) -> str:
    """Return a linker's name of something of the C++ library as headers have it."""
    string = "std::basic_string<char, std::char_traits<char>, std::allocator<char>>"
    return symbol.replace("std::__1::", "std::").replace(string, "std::string")

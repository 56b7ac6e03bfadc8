"""Single places of a header's text, changed as a slip of the pen would."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Mutant:
    """A header with one change."""

    kind: str
    header: Path
    line: int
    before: str
    after: str
    text: str


Change = tuple[int, int, str]
"""From where to where in a text, and what stands there instead."""


def blanked(text: str) -> str:
    """The text with all that is no law made blank: comments, strings, directives, what is declared and validated."""

    def blank(found: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", found[0])

    for pattern in (r"//[^\n]*", r'"(?:\\.|[^"\\\n])*"', r"^#.*$", r"^.*static_assert.*$", r"^template.*$"):
        text = re.sub(pattern, blank, text, flags=re.MULTILINE)
    for found in list(re.finditer(r"\b(declare\w*|validate|\w*fault)\([^;{]*\{", text)):
        end = closing(text, found.end() - 1)
        text = text[: found.start()] + re.sub(r"[^\n]", " ", text[found.start() : end]) + text[end:]
    # outside of functions there are types and start values, which the points of a test replace
    inside = np.zeros(len(text), bool)
    for found in re.finditer(r"\)[^;{}()]*(?::[^;{}]*(?:\{[^{}]*\}|\([^{};]*\)))?[^;{}()]*\{", text):
        inside[found.start() : closing(text, found.end() - 1)] = True
    return "".join(c if keep or c == "\n" else " " for c, keep in zip(text, inside, strict=True))


def closing(text: str, start: int) -> int:
    """The place after the bracket that closes the one at `start`."""
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] in "({[") - (text[i] in ")}]")
        if depth == 0:
            return i + 1
    return len(text)


def end_of_term(text: str, start: int) -> int:
    """Where a term ends that is added or taken away."""
    i = start
    while i < len(text) and text[i] not in ";,)}]?:":
        if text[i] in "({[":
            i = closing(text, i)
        elif text[i : i + 3] in (" + ", " - ", " < ", " > ", " ? "):
            break
        else:
            i += 1
    return i


def assigned(text: str) -> Iterator[tuple[int, int]]:
    """Where values stand that are assigned."""
    for found in re.finditer(r"(?<![=!<>+\-*/])= (?=[^=;{]+;)", text):
        end = text.index(";", found.end())
        if not text[found.end() : end].isdigit():  # where a loop begins
            yield found.end(), end


def signs(text: str) -> Iterator[Change]:
    for start, end in assigned(text):
        yield start, end, f"-({text[start:end]})"
    for found in re.finditer(r" ([+-])(=?) ", text):
        yield found.start(1), found.end(1), "-" if found[1] == "+" else "+"
    for found in re.finditer(r"(?:[=(,*?:] |return |[({])(-)(?=[\w(])", text):
        yield found.start(1), found.end(1), ""


def dropped_terms(text: str) -> Iterator[Change]:
    for found in re.finditer(r" [+-] ", text):
        yield found.start(), end_of_term(text, found.end()), ""


def transposes(text: str) -> Iterator[Change]:
    for found in re.finditer(r"\.transpose\(\)", text):
        yield found.start(), found.end(), ""
    for found in re.finditer(r"\b(?:dcm|skew|dcm_mrp)(?=\()", text):
        end = closing(text, found.end())
        if not text.startswith(".transpose()", end):
            yield end, end, ".transpose()"


def factors(text: str) -> Iterator[Change]:
    for found in re.finditer(r"(?<![\w.])(\d+\.\d+(?:e-?\d+)?)(?![\w.])", text):
        if float(found[1]):
            yield found.start(1), found.end(1), repr(float(found[1]) * 1.01)
    for start, end in assigned(text):
        yield start, end, f"1.01 * ({text[start:end]})"


def crosses(text: str) -> Iterator[Change]:
    for found in re.finditer(r"\b(\w+)\.cross\(", text):
        end = closing(text, found.end() - 1)
        yield found.start(), end, f"Vec3<T>({text[found.end() : end - 1]}).cross({found[1]})"


def indices(text: str) -> Iterator[Change]:
    for found in re.finditer(r"(?<=\w)([\[(])(\d)([\])])", text):
        other = {"0": "1", "1": "2", "2": "0", "3": "2"}.get(found[2])
        if other is not None:
            yield found.start(2), found.end(2), other
    for found in re.finditer(r"\((\w), (\w)\)", text):
        if found[1] != found[2]:
            yield found.start(), found.end(), f"({found[2]}, {found[1]})"
    for found in re.finditer(r"\.(row|col)\(", text):
        yield found.start(1), found.end(1), "col" if found[1] == "row" else "row"


def comparisons(text: str) -> Iterator[Change]:
    for found in re.finditer(r" ([<>])(=?) ", text):
        yield found.start(1), found.end(1), ">" if found[1] == "<" else "<"


def samples(text: str) -> Iterator[Change]:
    for found in re.finditer(r"\b(s|sample)\.k\b", text):
        yield found.start(), found.end(), f"{found[0]} + 1"
    for found in re.finditer(r"\b(s|sample)\.first\b", text):
        yield found.start(), found.end(), f"!{found[0]}"


def other_variables(text: str, whole: str) -> Iterator[Change]:
    """A member's name in place of one that is declared before or after it, and of the same type."""
    of_type: dict[str, list[str]] = {}
    for found in re.finditer(r"^    (\w+(?:<\w+>)?) (\w+(?:\{| =|,).*);$", whole, re.MULTILINE):
        of_type.setdefault(found[1], []).extend(re.findall(r"(?:^|, )([A-Za-z]\w*)(?=\{| =|,|$)", found[2]))
    others: dict[str, list[str]] = {}
    for names in of_type.values():
        for before, name, after in zip(names[-1:] + names[:-1], names, names[1:] + names[:1], strict=True):
            others[name] = sorted({before, after} - {name})
    for found in re.finditer(r"\b[A-Za-z]\w*\b(?!\()", text):
        if not re.match(r"\s*=[^=]", text[found.end() :]):
            yield from ((found.start(), found.end(), other) for other in others.get(found[0], ()))


KINDS: dict[str, Callable[[str, str], Iterator[Change]]] = {
    "sign": lambda law, _: signs(law),
    "dropped term": lambda law, _: dropped_terms(law),
    "transpose": lambda law, _: transposes(law),
    "factor": lambda law, _: factors(law),
    "cross product": lambda law, _: crosses(law),
    "index": lambda law, _: indices(law),
    "comparison": lambda law, _: comparisons(law),
    "sample": lambda law, _: samples(law),
    "other variable": other_variables,
}


def mutants_of(header: Path, kind: str) -> list[Mutant]:
    """All of one kind."""
    text = header.read_text(encoding="utf-8")
    made = []
    for start, end, instead in KINDS[kind](blanked(text), text):
        first, last = text.rfind("\n", 0, start) + 1, text.find("\n", end)
        after = text[:start] + instead + text[end:]
        shown = after[first : len(after) - (len(text) - last)]
        made.append(
            Mutant(kind, header, text.count("\n", 0, start) + 1, text[first:last].strip(), shown.strip(), after)
        )
    return made


def chosen(headers: list[Path], n: int) -> list[Mutant]:
    """At most n, of all kinds in turn, from all over the headers; the same in every run."""
    rng = np.random.default_rng(1)
    by_kind = [[m for header in headers for m in mutants_of(header, kind)] for kind in KINDS]
    shuffled = [[mutants[i] for i in rng.permutation(len(mutants))] for mutants in by_kind]
    return [m for turn in zip_longest(*shuffled) for m in turn if m is not None][:n]


def unchanged(header: Path) -> Mutant:
    """No mutant at all, to compare with."""
    return Mutant("", header, 0, "", "", header.read_text(encoding="utf-8"))

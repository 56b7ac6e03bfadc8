"""Takes the text of a condition apart: names and numbers, and the words and signs between them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import isfinite

from fmus.errors import AdcsError, shown
from fmus.spelling import close
from orchestration.system import End, System
from orchestration.times import UNITS, no_unit

FUNCTIONS = ("norm", "max", "min")
"""Those of a recorded variable."""

WORDS = (*FUNCTIONS, "abs", "time", "and", "or", "not")
"""What has a meaning besides names and numbers."""

EXAMPLE = "write it as in norm(plant.omega_BN_B) < 1e-3 and time > 20s"
"""The end of each refusal."""

_MOST = 1000
_BLANK = re.compile(r"\s+")
_DIGITS = r"(?P<number>(?:\d[\d_]*(?:\.[\d_]*)?|\.\d[\d_]*)(?:[eE][+-]?\d[\d_]*)?)"
_NUMBER = re.compile(rf"{_DIGITS}(?:\s*(?P<unit>{'|'.join(UNITS)}))?(?![\w.])")
_OTHER_UNIT = re.compile(_DIGITS + r"(?P<unit>[^\W\d_]+)(?![\w.])")
_PLAIN = re.compile(r"\w+(?![\w.])")
_SIGN = re.compile(r"<=|>=|[<>()+\-*/,]")
_INDEX = re.compile(r"\[(?: |[^\s\[\]])*\]")
_WORD = re.compile(r"(?:[^\s()<>=+\-*/,.\[\]]+/)*[^\s()<>=+\-*/,\[\]]+(?: *" + _INDEX.pattern + ")?")


class Seconds(float):
    """A number that was given a unit of time, in s."""


@dataclass(frozen=True)
class Words:
    """A text, and the same with as many `_` in place of each name and number, so that all else is ASCII.

    `found` has by their places what the names and numbers are.
    """

    text: str
    code: str
    found: dict[int, End | float] = field(default_factory=dict)


def looks_like_a_name(text: str) -> bool:
    """Whether it can only be meant as the name of a variable, be there one or not."""
    return bool(_WORD.fullmatch(text)) and re.split(r"\W", text, maxsplit=1)[0] not in WORDS


def wrong(part: str, at: int, why: str) -> AdcsError:
    """Say what is wrong with a part of a condition, and where it is."""
    return AdcsError(f"{shown(repr(part), 40)} at character {at + 1} {why}; {EXAMPLE}")


def unreadable(text: str, at: int) -> AdcsError:
    """Say where what cannot be read begins."""
    return wrong(text[at:], at, "is not readable")


def taken_apart(text: str, system: System) -> Words:
    """Find the names and numbers. AdcsError for what is none, and no word or sign of a condition either.

    What can be read as a name is one, whatever signs are in it.
    """
    text = text.strip()
    code, found, at, count = "", {}, 0, 0
    while at < len(text):
        if count == _MOST:
            raise AdcsError(f"it has more than {_MOST} names, numbers, words and signs")
        if blank := _BLANK.match(text, at):
            code += " " * len(blank[0])
            at = blank.end()
            continue
        end, value = _name(system, text, at) or _number(text, at) or (at, None)
        if value is not None:
            found[at] = value
            word = "_" * (end - at)
        else:
            word = _known(system, text, at)
        if re.fullmatch(r"\w\w", code[-1:] + word[:1]):
            raise unreadable(text, at)
        code += word
        at, count = at + len(word), count + 1
    return Words(text, code, found)


def _name(system: System, text: str, at: int) -> tuple[int, End] | None:
    """Return where the longest name ends that begins here, and what it names."""
    ends = []
    for component in system.components.values():
        if text.startswith(f"{component.name}.", at):
            variable = at + len(component.name) + 1
            ends += [variable + len(port) for port in component.fmu.ports if text.startswith(port, variable)]
    ends = [end for end in ends if not re.match(r"[\w.]", text[end : end + 1])]
    if not ends:
        return None
    index = _INDEX.match(text, max(ends))
    end = index.end() if index else max(ends)
    return end, system.end(text[at:end])


def _number(text: str, at: int) -> tuple[int, float] | None:
    match = _NUMBER.match(text, at)
    if match is None:
        return None
    try:
        value = float(match["number"])
    except ValueError:  # an underscore where none may be
        return None
    if not isfinite(value * float(UNITS.get(match["unit"], "1"))):
        raise wrong(match[0], at, "is beyond what a number can hold")
    return match.end(), Seconds(value * float(UNITS[match["unit"]])) if match["unit"] else value


def _known(system: System, text: str, at: int) -> str:
    """Return the word or sign here; AdcsError if it has no meaning."""
    for kind in (_SIGN, _PLAIN):
        if (found := kind.match(text, at)) and (kind is _SIGN or found[0] in WORDS):
            return found[0]
    if other := _OTHER_UNIT.match(text, at):
        raise wrong(other[0], at, f"is no number: {no_unit(other['unit'])}")
    match = _WORD.match(text, at)
    word = match[0] if match else text[at]
    if "." in word and not word[0].isdigit():
        system.end(word)  # says what there is instead
    names = [*WORDS, *(f"{c.name}.{port}" for c in system.components.values() for port in c.fmu.ports)]
    meant = close(word, names) if len(word) > 1 else ""
    raise wrong(word, at, f"has no meaning{f' (did you mean {meant}?)' if meant else ''}")

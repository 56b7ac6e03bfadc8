"""What a compiler says of a component's header, in the words of whoever wrote it, with the way out."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache

from fmus.checks.functions import FUNCTIONS, advice
from fmus.code import Place, code_lines
from fmus.errors import shown
from fmus.paths import SOURCES
from fmus.spelling import close

LONGEST = 240  # characters of what a compiler says


@dataclass
class Error:
    """An error with its notes; types are called as headers call them."""

    place: Place
    text: str
    notes: list[tuple[Place, str]] = field(default_factory=list)


@dataclass(frozen=True)
class _About:
    """What a rule looks at."""

    notes: tuple[str, ...]
    place: Place
    component: str


def in_words(error: Error, place: Place, component: str) -> str:
    """Return what is wrong at a place of a user's file; what no rule knows is said as the compiler says it."""
    about = _About(tuple(text for _, text in error.notes), place, component)
    for pattern, words in _RULES:
        if found := re.search(pattern, error.text):
            said = found.expand(words) if isinstance(words, str) else words(found, about)
            if said:
                return said
    return shown(error.text, LONGEST)


def _meant(name: str, known: Iterable[str], prefix: str = "", otherwise: str = "") -> str:
    if names := close(name, [other for other in known if other != name], 0.6):
        return f" (did you mean {' or '.join(prefix + each for each in names.split(' or '))}?)"
    return f" ({otherwise})" if otherwise else ""


@cache
def _offered(file: str, pattern: str) -> tuple[str, ...]:
    """Return what a header of this project's offers."""
    return tuple(dict.fromkeys(re.findall(pattern, (SOURCES / file).read_text(encoding="utf-8"))))


def _unknown(found: re.Match[str], about: _About) -> str:
    name = found["name"]
    if name in ("unit", "Vec3", "Mat3", "Quat", "Sample"):
        return f"{name} is not known here (namespace adcs {{ ... }} has to be around the struct)"
    if name in FUNCTIONS:
        return f"there is no {name} for T: {advice(f'std::{name}')}"
    own = {word for _, line in code_lines(about.place.path) for word in re.findall(r"[A-Za-z_]\w+", _bare(line))}
    return f"there is no {name}{_meant(name, own - _WORDS, otherwise='is it a variable of the struct?')}"


def _bare(line: str) -> str:
    return re.sub(r'"[^"]*"', "", line)


def _no_member(found: re.Match[str], about: _About) -> str:
    name, of = found["name"], found["of"]
    if of == "unit":
        units = _offered("fmi/units.hpp", r"constexpr Unit (\w+)")
        return f"there is no unit::{name}{_meant(name, units, 'unit::', 'src/fmi/units.hpp has all')}"
    if name == about.component:
        return f"struct {name} is not in the project's namespace (namespace adcs {{ ... }} around it)"
    if re.match(r"Declare\b|SetTime\b|EachState\b|Ignore$", of):
        verbs = _offered(
            "fmi/declaration.hpp", r"(?:Refine|void) (time|sampled|input|output|parameter|seed|state|held)\("
        )
        return f"a declaration has no v.{name}{_meant(name, verbs, 'v.', 'it has v.' + ', v.'.join(verbs))}"
    if re.match(r"(?:Ignore::)?Refine\b", of):
        more = _offered("fmi/declaration.hpp", r"Refine& (\w+)\(")
        return f"a declaration has no .{name}(){_meant(name, more, '.', 'it has .' + ', .'.join(more))}"
    return ""


def _call(found: re.Match[str], _about: _About) -> str:
    name = found["name"]
    if name in FUNCTIONS:
        return f"a number of type T is handed to {advice(f'std::{name}')}"
    return f"{name}() does not take these arguments"


_UNIT = "variable, unit::... unless it is a bool or a std::int32_t"
_TAKEN = {
    "input": _UNIT,
    "output": _UNIT,
    "held": _UNIT,
    "parameter": _UNIT,
    "sampled": "a period, and an offset if there is one",
    "seed": "a std::int32_t",
    "state": "variable, its derivative of the same type, unit::...",
}


def _member_call(found: re.Match[str], _about: _About) -> str:
    name = found["name"]
    if name not in _TAKEN:
        return f"{name}() does not take these arguments"
    return f'v.{name} does not take these arguments (it takes "name", {_TAKEN[name]}, "description")'


def _word(_found: re.Match[str], about: _About) -> str:
    """Tell of a word that cannot be a name, at the place or before it."""
    before, after = about.place.source[: about.place.column - 1], about.place.source[about.place.column - 1 :]
    for word in (*re.findall(r"^\w+", after), *re.findall(r"(\w+)\s*$", before)):
        if word in _WORDS:
            return f"{word} is a word of C++ (take another name)"
    macro = next((found[1] for note in about.notes if (found := re.match(r"expanded from macro '(\w+)'", note))), None)
    return f"{macro} is a macro of the C library (take another name)" if macro else ""


def _assigned(_found: re.Match[str], about: _About) -> str:
    if any("not marked const" in note for note in about.notes):
        return "a variable is set in a function that is const (leave `const` out)"
    return "the two sides of = are of different kinds (Vec3<T>::Constant(x) makes a vector of a number)"


def _not_found(found: re.Match[str], about: _About) -> str:
    name, beside = found["name"], about.place.path.parent
    there = [path.relative_to(root).as_posix() for root in (beside, SOURCES) for path in root.rglob("*.hpp")]
    return f"there is no {name} to include{_meant(name, there, otherwise='it is looked for beside the header')}"


_RULES: tuple[tuple[str, str | Callable[[re.Match[str], _About], str]], ...] = (
    (
        r"no viable conversion from '(?:const )?T' to '(\w+)'",
        r"a number of type T is put into \1, which carries no derivatives "
        "(write T; value_of(x) is the plain number, for decisions)",
    ),
    (r"contextually convertible to 'bool'", "a number of type T is no condition (compare it, as in x > 0.0)"),
    (r"(?:undeclared identifier|no template named|unknown type name) '(?P<name>\w+)'$", _unknown),
    (r"no member named '(?P<name>\w+)' in (?:namespace )?'(?P<of>[^']*)'", _no_member),
    (r"no matching function for call to '(?P<name>\w+)'", _call),
    (r"no matching member function for call to '(?P<name>\w+)'", _member_call),
    (r"reference to type 'std::int32_t' cannot bind", "a seed is a whole number (write std::int32_t)"),
    (
        r"reference to type '(?:Declare|SetTime|EachState)\b",
        "declare() takes visitors of one type only (template <class V> void declare(V& v))",
    ),
    (
        r"assigning to '(?:double|T)' from incompatible type '(.*)'",
        r"a \1 is assigned to a single number (take one of it: x(0), x.norm() or x.dot(y))",
    ),
    (r"no viable overloaded '[-+*/]?='", _assigned),
    (r"within const member function '(\w+)'", r"\1() sets a variable, so it is not const (leave `const` out)"),
    (
        r"YOU_MIXED_MATRICES_OF_DIFFERENT_SIZES|INVALID_MATRIX_PRODUCT$",
        "vectors or matrices of sizes that do not fit are put together (their types say how many elements they have)",
    ),
    (
        r"INVALID_VECTOR_VECTOR_PRODUCT",
        "two vectors are multiplied by * (write a.dot(b), a.cross(b) or a.cwiseProduct(b))",
    ),
    (
        r"FLOATING_POINT_ARGUMENT_PASSED|VECTORS_OF_A_SPECIFIC_SIZE",
        "a vector has another number of elements than is given or asked for (Vec3<T> has three, Quat<T> four)",
    ),
    (
        r"YOU_MIXED_DIFFERENT_NUMERIC_TYPES",
        "vectors or matrices of different types of numbers are put together (write T)",
    ),
    (r"static assertion failed.*: ([A-Z][A-Z0-9_]+)$", lambda found, _: found[1].replace("_", " ").lower()),
    (r"expected (?:member name|unqualified-id|a type|expression)", _word),
    (r"expected ';' after struct", "expected ';' after the struct, or a '}' inside it"),
    (r"'auto' not allowed in non-static", "auto is for what is static (write static constexpr auto, or the type)"),
    (r"void function '(\w+)' should not return", r"\1() returns nothing (it sets the variables that are declared)"),
    (r"duplicate member '(\w+)'", r"\1 is there twice (take another name for one of them)"),
    (r"with exceptions disabled", "exceptions are not possible in an FMU (validate() refuses values)"),
    (r"'(?P<name>[^']+)' file not found", _not_found),
)
"""What a compiler says, and how it is said here: a template of the match, or what makes a text; empty for none."""

_CPP = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t class compl
const const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit export
extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr
operator or or_eq private protected public register reinterpret_cast return short signed sizeof static
static_assert static_cast struct switch template this thread_local throw true try typedef typeid typename
union unsigned using virtual void volatile wchar_t while xor xor_eq
"""
_WORDS = frozenset(_CPP.split())

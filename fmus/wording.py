"""What a compiler says of a component's header, in the words of whoever wrote it, with the way out."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from fmus.checks.functions import FUNCTIONS, advice, offered, usage
from fmus.code import Place, code_lines
from fmus.describe import NOT_PRINTED
from fmus.errors import shown
from fmus.known_names import MEMBERS, TYPES, WORDS, WRITTEN, refinements, units, verbs
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


def _unknown(found: re.Match[str], about: _About) -> str:
    name = found["name"]
    if name == "T":
        return f"T is not known here (template <class T> before struct {about.component})"
    if name in ("unit", *TYPES, "Sample", "Events", "Words", "never", "once"):
        return f"{name} is not known here (namespace adcs {{ ... }} has to be around the struct)"
    if name in FUNCTIONS:
        return f"there is no {name} for T: {advice(f'std::{name}')}"
    if name == "V":
        return "V is not known here (template <class V> before void declare(V& v))"
    if name in verbs():
        return f"there is no {name} by itself (write v.{name})"
    if name in units():
        return f"there is no {name} (write unit::{name})"
    if name in MEMBERS:
        return f"there is no {name}() by itself (a vector or matrix has it: x.{name}())"
    if name in WRITTEN:
        return f"there is no {name} ({WRITTEN[name]})"
    own = {word for _, line in code_lines(about.place.path) for word in re.findall(r"[A-Za-z_]\w+", _bare(line))}
    return f"there is no {name}{_meant(name, own - WORDS | {*TYPES}, otherwise=f'T {name} = ...; makes a variable')}"


def _bare(line: str) -> str:
    return re.sub(r'"[^"]*"', "", line)


def _no_member(found: re.Match[str], about: _About) -> str:
    name, of = found["name"], found["of"]
    if of == "unit":
        return f"there is no unit::{name}{_meant(name, units(), 'unit::', 'src/fmi/units.hpp has all')}"
    if of == "std":
        printing = name in ("cout", "cerr", "clog", "endl", "printf", "puts", "print", "format")
        return NOT_PRINTED if printing else f"there is no std::{name} here (does the header include what has it?)"
    if re.match(r"(?:const )?(?:Vec3|Mat3|Quat|Eigen::)", of):
        return f"a vector or matrix has no .{name}{_meant(name, MEMBERS, '.', 'Eigen has e.g. .dot(y) and .norm()')}"
    if name == about.component:
        return f"struct {name} is not in the project's namespace (namespace adcs {{ ... }} around it)"
    if re.match(r"Declare\b|SetTime\b|EachState\b|Ignore$", of):
        return f"a declaration has no v.{name}{_meant(name, verbs(), 'v.', 'it has v.' + ', v.'.join(verbs()))}"
    if re.match(r"(?:Ignore::)?Refine\b", of):
        name = {"min": "at_least", "max": "at_most"}.get(name, name)
        more = refinements()
        if name in more:
            return f"a declaration has no .{found['name']}() (write .{name}())"
        return f"a declaration has no .{name}(){_meant(name, more, '.', 'it has .' + ', .'.join(more))}"
    return ""


def _call(found: re.Match[str], about: _About) -> str:
    name = found["name"]
    if name in offered() and f"std::{name}" not in about.place.source:
        return f"{name}() does not take these arguments (write {usage(name)}, of numbers; an element of v is v(0))"
    if name in offered() and name not in FUNCTIONS:
        return f"std::{name} knows nothing of numbers of type T (write {usage(name)})"
    if name in FUNCTIONS:
        return f"a number of type T is handed to {advice(f'std::{name}')}"
    if name in WRITTEN:
        return f"{name}() does not take these arguments ({WRITTEN[name]})"
    return f"{name}() does not take these arguments"


_UNIT = "variable, unit::... unless it is a bool or a std::int32_t"
_TAKEN = {
    "input": _UNIT,
    "output": _UNIT,
    "held": _UNIT,
    "parameter": _UNIT,
    "event": "variable, unit::...",
    "sampled": "a period, and an offset if there is one",
    "seed": "a std::int32_t",
    "state": "variable, its derivative of the same type, unit::...",
}


def _member_call(found: re.Match[str], about: _About) -> str:
    name = found["name"]
    if any("has type 'const Declare" in note for note in about.notes):
        return "declare() takes whoever asks as what is not const (template <class V> void declare(V& v))"
    if name not in _TAKEN:
        return f"{name}() does not take these arguments"
    return f'v.{name} does not take these arguments (it takes "name", {_TAKEN[name]}, "description")'


def _word(_found: re.Match[str], about: _About) -> str:
    """Tell of a word that cannot be a name, at the place or before it."""
    before, after = about.place.before, about.place.after
    for word in (*re.findall(r"^\w+", after), *re.findall(r"(\w+)\s*$", before)):
        if word in WORDS:
            return f"{word} is a word of C++ (take another name)"
    if re.search(r"\d,\d*$", before):
        return "a number has a point and no comma (1.0)"
    macro = next((found[1] for note in about.notes if (found := re.match(r"expanded from macro '(\w+)'", note))), None)
    if macro is not None:
        return f"{macro} is a macro of the C library (take another name)"
    return f"something is missing here, or too much{_behind(before)}"


def _behind(before: str) -> str:
    last = re.search(r'("[^"]*"|[\w.]+|[^\w\s]+)\s*$', before)
    return f" behind {last[1]}" if last else ""


def _missing(found: re.Match[str], about: _About) -> str:
    """Tell of a sign that is missing, by what stands before it; of a bracket, by what opens it if that is the place."""
    before, after = about.place.before, about.place.after
    if after[:1] in ("{", "(", "["):
        return f"this '{after[0]}' is closed nowhere (a '{found[1]}' is missing)"
    also = " or a ','" if found[1] == ")" else ""
    more = ""
    if after.lstrip().startswith("#"):
        more = " (a comment begins with //)"
    elif after.startswith("}"):
        more = ", or one '}' there is too many"
    return f"a '{found[1]}'{also} is missing{_behind(before) or ' before this'}{more}"


def _operands(found: re.Match[str], about: _About) -> str:
    """Tell of an operator between what it is not for."""
    if "stream" in found[0]:
        return NOT_PRINTED
    if about.place.after.startswith("^"):
        return "^ is no power in C++ (write x * x)"
    return (
        "an operator stands between what it is not for, such as a vector and a number "
        "(Vec3<T>::Constant(x) is a vector of a number; x(0) is a number of a vector)"
    )


def _assigned(_found: re.Match[str], about: _About) -> str:
    if any("not marked const" in note for note in about.notes):
        return "a variable is set in a function that is const (leave `const` out)"
    return "the two sides of = are of different kinds (Vec3<T>::Constant(x) makes a vector of a number)"


def _constant(found: re.Match[str], about: _About) -> str:
    if not any("is_not_made_of_known_symbols" in note for note in about.notes):
        return ""
    return (
        f"the name of the unit {found['name']} is made of symbols that units.hpp has not (as in kg.m2/s or W/(m2.K); "
        f'Unit {found["name"]}{{"...", Dimension{{kg, m, s, A, K, rad}}}} says the exponents beside a name of your own)'
    )


def _not_found(found: re.Match[str], about: _About) -> str:
    name, beside = found["name"], about.place.path.parent
    there = [path.relative_to(root).as_posix() for root in (beside, SOURCES) for path in root.rglob("*.hpp")]
    return f"there is no {name} to include{_meant(name, there, otherwise='it is looked for beside the header')}"


_TEXT = "a text stands where a number belongs (leave the quotes out)"
_RULES: tuple[tuple[str, str | Callable[[re.Match[str], _About], str]], ...] = (
    (
        r"no viable conversion from '(?:const )?T' to '(\w+)'",
        r"a number of type T is put into \1, which carries no derivatives "
        "(write T; value_of(x) is the plain number, for decisions)",
    ),
    (r"(?:no viable conversion from|with an? [lr]value of type) '(?:const )?(?:char\[\d+\]|char \*)", _TEXT),
    (r"assigning to '(?:double|T)' from .*'const char", _TEXT),
    (r"contextually convertible to 'bool'", "a number of type T is no condition (compare it: x > 0.0, x == y)"),
    (
        r"no viable conversion from '(?:const )?((?:Vec3|Mat3|Quat|Eigen::).*)' to '(?:double|T|int|float)'",
        r"a \1 is put into a single number (take one of it: x(0), x.norm() or x.dot(y))",
    ),
    (
        r"no viable conversion from '(?:const )?(?:double|int|T)' to '(?:const )?(Vec3|Mat3|Quat)<",
        r"a single number is put into a \1<T> (write \1<T>::Constant(x), or all of them, as in {x, y, z})",
    ),
    (r"no viable conversion from '[^']*' to '(Vec3|Mat3|Quat)<", r"what is put into a \1<T> is no \1<T>"),
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
        r"assigning to 'double' from incompatible type '(?:const )?T'",
        "numbers of type T are put into double, which carries no derivatives (write T)",
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
    (r"missing terminating '(.)'", r"a text has no end (a \1 is missing)"),
    (r"unexpected namespace name '(\w+)'", r"\1 is a namespace (two colons, as in \1::name)"),
    (r"lambda capture list", "[...] makes no vector in C++ (write {x, y, z})"),
    (r"expected (?:member name|unqualified-id|a type|expression)", _word),
    (r"expected ';' after struct", "expected ';' after the struct, or a '}' inside it"),
    (r"expected '\(' after '(\w+)'", r"the condition stands in brackets, as in \1 (x > 0.0)"),
    (r"expected '([;(){}\]])'", _missing),
    (r"member reference type '.*' is not a pointer", "-> is for pointers (write a point)"),
    (r"invalid preprocessing directive", "no such word stands behind # (#pragma once, #include)"),
    (r'expected "FILENAME"', 'the name of what is included stands in quotes (#include "fmi/declaration.hpp")'),
    (
        r"format specifies type|more '%' conversions than|argument not used by format|invalid conversion specifier",
        "a text with % takes other values than it is given (%g for a number, %s for a text, as many as there are)",
    ),
    (r"array index (-?\d+) is (?:past|before)", r"an array has no element \1 (they are counted from 0)"),
    (r"function definition is not allowed here", "a '}' is missing before this function"),
    (r"type specifier is required", "a type is missing (void before a function; T or Vec3<T> before a variable)"),
    (r"unexpected character <U\+(\w+)>", lambda found, _: f'C++ has no {chr(int(found[1], 16))} (quotes are ")'),
    (r"indirection requires pointer", "* stands before what is no pointer (** is no power in C++: write x * x)"),
    (r"invalid operands to binary expression.*", _operands),
    (
        r"incompatible operand types",
        "what stands before and behind : is of different types (Vec3<T>::Zero() is a vector of 0)",
    ),
    (r"use of (?:alias|class) template '(\w+)' requires template arguments", r"\1 is a template (write \1<T>)"),
    (r"reference to non-static member function must", "a function is named and not called (brackets, as in x.norm())"),
    (
        r"function cannot return function type",
        "a function is used as a number (the time is a variable: T time = 0.0; and v.time(time) in declare())",
    ),
    (r"member reference base type '\w+<T> \*'", "this is a pointer (leave `this.` out)"),
    (
        r"no matching constructor for initialization of '(\w+)<(?:double|T)>'",
        r"\1 has a constructor of its own (leave it out: the values behind the variables are the start values)",
    ),
    (r"variable '(\w+)' is uninitialized", r"\1 has no value where it is used (give it one: T \1 = 0.0;)"),
    (r"non-void function does not return", "a function that returns something ends without it (write return ...;)"),
    (r"(?:equality|inequality|relational) comparison result unused", "a comparison sets nothing (one = does)"),
    (r"division by zero is undefined", "a whole number is divided by 0 (1.0 is a number with a point)"),
    (
        r"'auto' not allowed in function prototype",
        "auto is no type of an argument (template <class V> before the function, and V for auto)",
    ),
    (r"'auto' not allowed in non-static", "auto is for what is static (write static constexpr auto, or the type)"),
    (r"void function '(\w+)' should not return", r"\1() returns nothing (it sets the variables that are declared)"),
    (r"declaration of '(\w+)' shadows template parameter", r"\1 is what the template calls a type (take another name)"),
    (r"redefinition of '(\w+)'", r"\1 is there already, in the header or in one of the project (take another name)"),
    (r"(?:class member cannot be redeclared|redeclaration of)", "it is there twice (leave one of them out)"),
    (r"duplicate member '(\w+)'", r"\1 is there twice (take another name for one of them)"),
    (r"constexpr variable '(?P<name>\w+)' must be initialized by a constant", _constant),
    (r"with exceptions disabled", "exceptions are not possible in an FMU (validate() refuses values)"),
    (r"'(?P<name>[^']+)' file not found", _not_found),
)
"""What a compiler says, and how it is said here: a template of the match, or what makes a text; empty for none."""

"""How a command and its options are declared: `command` and `group`, and the types that options share.

A group is a class whose fields are its options: `step` is `--step`, and the text below a field is its help. A command
has the group as a parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, fields
from datetime import datetime
from typing import Annotated, Any, TypeVar, dataclass_transform, get_type_hints

from cyclopts import App, Group, Parameter, Token

from fmus.errors import AdcsError
from orchestration import times

_Class = TypeVar("_Class")
_titles: dict[str, int] = {}  # and where they stand in the help


def command(name: str, *examples: str, takes: str = "") -> App:
    """Return the command `adcs NAME`, whose help ends with examples; its function is what `.default` decorates.

    `takes` are its arguments as the usage names them, where some may be left out.
    """
    style = Parameter(negative=(), allow_repeating=True, show_default=_default)
    lines = "  \n".join(["Examples:", *(f"`{example}`" for example in examples)])  # blanks at an end break a line
    return App(
        name=name,
        default_parameter=style,
        help_format="markdown",
        help_epilogue=lines if examples else None,
        usage=f"adcs {name} [OPTIONS] {takes}" if takes else None,
        exit_on_error=False,
        print_error=False,
        result_action="return_value",
    )


def _default(value: Any) -> str | None:
    if value is None or value is False or value in ((), ""):
        return None
    return value.isoformat() if isinstance(value, datetime) else str(value)


@dataclass_transform(kw_only_default=True, frozen_default=True)
def group(title: str) -> Callable[[type[_Class]], type[_Class]]:
    """Make a class a group of options with this title in the help, in the order in which they are made."""
    place = _titles.setdefault(title, len(_titles) + 1)

    def made(cls: type[_Class]) -> type[_Class]:
        options = dataclass(frozen=True, kw_only=True)(cls)
        for name, field in (own := options.__dataclass_fields__).items():  # type: ignore[attr-defined]
            own[name] = copy(field)
            own[name].kw_only = True  # also what is inherited: options have names
        hints = get_type_hints(options, include_extras=True)  # each in the module where it stands
        written = {name: _WRITTEN.get(hints[name], hints[name]) for name in own}
        options.__annotations__ = options.__annotations__ | written
        options.__init__.__annotations__ |= written
        return Parameter(name="*", group=Group(title, sort_key=place))(options)

    return made


def given(options: Any) -> dict[str, str]:
    """Return the options of a group that are not as they are by default, as they are written, and their fields."""
    changed = (f.name for f in fields(options) if getattr(options, f.name) != f.default)
    return {f"--{name.replace('_', '-')}": name for name in changed}


@contextmanager
def at_work() -> Iterator[None]:
    """What is refused within has failed: what was asked for was right."""
    try:
        yield
    except AdcsError as error:
        error.failed = True
        raise


def _seconds(kind: Any, tokens: tuple[Token, ...]) -> float:
    return times.seconds(tokens[0].value)


Time = Annotated[
    float,
    Parameter(
        converter=_seconds,
        metavar="TIME",
        allow_leading_hyphen=True,
        show_default=lambda value: None if value is None else f"{value:g}s",
    ),
]
"""A time [s], which is written with a unit, 10ms, or as a plain number of seconds."""


def _whole(kind: Any, tokens: tuple[Token, ...]) -> int:
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"{tokens[0].value!r} is no whole number") from None


Whole = Annotated[int, Parameter(converter=_whole, metavar="N", allow_leading_hyphen=True)]
"""A whole number; 1.5 is refused, not rounded."""

Speed = Annotated[float, Parameter(metavar="SPEED", show_default=lambda value: None if value is None else f"{value:g}")]
"""How many simulated seconds go by in one on the clock."""


def _moment(kind: Any, tokens: tuple[Token, ...]) -> datetime:
    try:
        return datetime.fromisoformat(tokens[0].value)
    except ValueError:
        raise ValueError(f"{tokens[0].value!r} is no date, write 2026-03-21 or 2026-03-21T12:00:00") from None


Epoch = Annotated[datetime, Parameter(converter=_moment, metavar="UTC")]
"""The moment of t = 0: a date with or without a time, UTC where it has no time zone."""

_WRITTEN: dict[Any, Any] = {
    times.Seconds: Time,
    times.Seconds | None: Time | None,
    int: Whole,
    int | None: Whole | None,
}
"""How what classes of the core are given is written on a command line, where it is not as Python writes it."""

"""Where a run is: the point, the call that goes on and its component, in memory that may outlive the process."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from contextlib import suppress
from enum import IntEnum
from functools import lru_cache
from typing import Any


class Action(IntEnum):
    """The calls that the engine makes, with its numbers for them (engine.c); the text is for people."""

    def __new__(cls, number: int, text: str) -> Action:
        """Give each number its text."""
        action = int.__new__(cls, number)
        action._value_, action.text = number, text
        return action

    text: str

    GET = 0, "get"
    SET = 1, "set"
    SOLVE = 2, "solving an algebraic loop"
    DO_STEP = 3, "doStep"
    SET_TIME = 4, "setTime"
    SET_STATES = 5, "setContinuousStates"
    GET_DERIVATIVES = 6, "getDerivatives"
    DISCARDED = 7, "doStep"  # what follows a step that was discarded belongs to it
    GET_INDICATORS = 8, "getEventIndicators"


ACTIONS = tuple(Action)

_IDLE, _FROM_PYTHON = -1, -2  # what is done instead of a call of the engine
_TEXT = 256

Doing = tuple[int, str, str]
"""Point, component and action that is going on; both names are empty where no component is at work."""


class Place(ctypes.Structure):
    """The memory; its first five fields are the engine's `Where`."""

    _fields_ = (
        ("k", ctypes.c_int64),
        ("rows", ctypes.c_int64),
        ("count", ctypes.c_int64),
        ("doing", ctypes.c_int32),
        ("component", ctypes.c_int32),
        ("finished", ctypes.c_int32),
        ("started", ctypes.c_int32),
        ("text", ctypes.c_char * _TEXT),
    )


@lru_cache(maxsize=1000)  # the same few calls are made over and over
def _text(component: str, action: str) -> bytes:
    return f"{component}\t{action}".encode()[: _TEXT - 1]


class Where:
    """Notes where a run is; read from another thread, or from another process after this one has died.

    `rows` is how many rows are complete. `finished` says that the last one is there, and the components are only to be
    terminated and freed; `started`, that initialisation is over.
    """

    def __init__(self, place: Any = None, names: Sequence[str] = ()) -> None:
        """`place` is a `Place`; `names` are the components in the engine's order."""
        self.place = Place(doing=_IDLE) if place is None else place
        self.names = list(names)
        self.at_finish: Callable[[], None] | None = None

    def finish(self) -> None:
        """Note that the last row is there."""
        self.place.finished = 1
        if self.at_finish is not None:
            self.at_finish()

    def idle(self) -> None:
        """Note that no component is at work, where a call was given up."""
        self.place.doing = _IDLE

    def move(self, place: Any) -> None:
        """Go on in another memory."""
        ctypes.memmove(ctypes.addressof(place), ctypes.addressof(self.place), ctypes.sizeof(Place))
        self.place = place

    @property
    def now(self) -> Doing:
        """What is going on."""
        place = self.place
        k, doing = int(place.k), int(place.doing)
        if doing == _FROM_PYTHON:
            component, _, action = place.text.decode("utf-8", "replace").partition("\t")
            return k, component, action
        if not 0 <= doing < len(ACTIONS):
            return k, "", ""
        name = ""
        if doing != Action.SOLVE:
            with suppress(IndexError):
                name = self.names[place.component]
        return k, name, ACTIONS[doing].text

    @property
    def busy(self) -> tuple[Any, ...] | None:
        """The call that is going on, another value for each; None between two calls."""
        return None if self.place.doing == _IDLE else self.pulse

    @property
    def pulse(self) -> tuple[Any, ...]:
        """What changes as long as the run goes on."""
        return (*self.now, int(self.place.count), int(self.place.rows))


class Calling:
    """What surrounds every call of a component that is made from Python; `with calling("doStep"):` ...

    It is noted before it is made; when it has returned, or failed, no component is at work, and `after` is told whose
    call it was, to look at what it has changed.
    """

    __slots__ = ("_after", "_component", "_text", "_where")

    def __init__(self, where: Where, component: str, after: Callable[[str], None] | None = None) -> None:
        self._where, self._component, self._after = where, component, after
        self._text = b""

    def __call__(self, action: str) -> Calling:
        """Say what is done in what follows."""
        self._text = _text(self._component, action)
        return self

    def __enter__(self) -> None:
        place = self._where.place
        place.text = self._text
        place.count += 1
        place.doing = _FROM_PYTHON

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        self._where.place.doing = _IDLE
        if self._after is not None:
            self._after(self._component)

"""What is looked at in an FMU, one module for each aspect; each yields what is wrong as plain sentences."""


class Note(str):
    """A sentence about what no standard forbids, but what some machine or tool cannot do with."""

    __slots__ = ()


class Failure(str):
    """A sentence about an interface that cannot be initialised: what comes of running it is said with it."""

    __slots__ = ()

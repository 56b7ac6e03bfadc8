"""What is looked at in an FMU, one module for each aspect; each yields what is wrong as plain sentences."""


class Note(str):
    """A sentence about what no standard forbids, but what some machine or tool cannot do with."""

    __slots__ = ()

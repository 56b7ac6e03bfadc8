"""What was measured, beside what is aimed at: tests assert sizes; times depend on the machine and are only told."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Row:
    what: str
    value: float
    unit: str
    """`MB`, `kB`, `s`, or none for a count."""
    aim: float | None = None
    """The most that it should be."""

    @property
    def cells(self) -> tuple[str, str, str, str]:
        met = "" if self.aim is None else "met" if self.value <= self.aim else "missed"
        return self.what, self._with_unit(self.value), "" if self.aim is None else self._with_unit(self.aim), met

    def _with_unit(self, value: float) -> str:
        return f"{value:.3g}" + f" {self.unit}".rstrip() if value < 1000 else f"{value:.0f} {self.unit}"


@dataclass
class Table:
    rows: list[Row] = field(default_factory=list)

    def add(self, what: str, value: float, unit: str = "", aim: float | None = None) -> None:
        self.rows.append(Row(what, value, unit, aim))

    def __str__(self) -> str:
        cells = [("measured", "value", "aim", ""), *(row.cells for row in self.rows)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        what, value, aim, _ = widths
        return "\n".join(f"{a:{what}}  {b:>{value}}  {c:>{aim}}  {d}".rstrip() for a, b, c, d in cells)

"""Tables of numbers in CSV files, read line by line; what is wrong with one is said with its line."""

from __future__ import annotations

import csv
from array import array
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.errors import AdcsError, shown
from fmus.nearby import not_opened
from orchestration.plan.lowering import Floats


def read_table(path: Path, *, header: bool) -> tuple[list[str], Floats]:
    """Return the cells of the first line, if it is a `header`, and the numbers of the others, (lines, columns).

    Empty lines are left out; all others have as many cells as the first. The numbers may be NaN or infinite. Raises
    AdcsError.
    """
    names: list[str] = []
    width: int | None = None
    numbers = array("d")
    line = 0
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            for row in reader:
                line = reader.line_num
                if not row:
                    continue
                if width is None:
                    width = len(row)
                    if ";" in row[0]:
                        raise AdcsError(f"{path} is separated by semicolons: separate it by commas, as in 0.5,1.25")
                    if header:
                        names = row
                        continue
                if len(row) != width:
                    raise AdcsError(
                        f"{path}, line {line}: {len(row)} values, the first line has {width}"
                        + " names, of arrays NAME[1],NAME[2],..." * header
                    )
                numbers.extend(map(float, row))
    except OSError as error:
        raise not_opened(path, error) from error
    except UnicodeDecodeError:
        raise AdcsError(f"{path} is not a text file in UTF-8: save it so") from None
    except csv.Error as error:  # a cell without end, mostly because of a lost quotation mark
        raise AdcsError(f"{path}, line {line + 1}: {error}") from None
    except ValueError:
        cell = next((cell for cell in row if not _is_number(cell)), "")
        raise AdcsError(f"{path}, line {line}: {shown(repr(cell))} is not a number") from None
    table: Floats = np.array(numbers, float).reshape(-1, width or 1)
    return names, table


_DIGITS = 25  # of the integers that are kept: more than any type of FMI has


def whole_column(path: Path, column: int) -> NDArray[Any]:
    """Return one column of a table that `read_table` has read, with integers as they are, not rounded to doubles."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        cells = [Decimal(row[column].strip()) for row in list(filter(None, csv.reader(file)))[1:]]
    return np.array(
        [
            int(cell) if cell.is_finite() and cell.adjusted() < _DIGITS and cell == int(cell) else float(cell)
            for cell in cells
        ]
    )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True

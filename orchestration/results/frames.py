"""Results as tables and arrays of pandas and xarray, which are loaded only here, and need not be installed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.errors import AdcsError
from orchestration.fmu.file import element_names

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from orchestration.results.result import Result


def to_pandas(result: Result) -> DataFrame:
    """Return a table with a row for each time [s] and a column for each element; `attrs["units"]` has the units."""
    pandas = _installed("pandas")
    columns: dict[str, Any] = {}
    units: dict[str, str] = {}
    for name, port in result.ports.items():
        elements = element_names(name, port.shape)
        values = result[name].reshape(len(result.time), len(elements))
        columns |= {element: values[:, i] for i, element in enumerate(elements)}
        units |= dict.fromkeys(elements, port.unit or "")
    frame = pandas.DataFrame(columns, index=pandas.Index(result.time, name="time [s]"))
    frame.attrs["units"] = units
    return frame


def to_xarray(result: Result) -> Dataset:
    """Return a data set with an array for each variable over `time`; elements are counted from 1 along the others."""
    xarray = _installed("xarray")
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", result.time, {"units": "s"})}
    for name, port in result.ports.items():
        along = {f"{name}_dim_{i}": np.arange(1, n + 1) for i, n in enumerate(port.shape, 1)}
        about = {"units": port.unit or "", "description": port.description}
        variables[name] = (("time", *along), result[name], about)
        coordinates |= along
    data: Dataset = xarray.Dataset(variables, coordinates, {"system": result.system.name})
    return data


def _installed(package: str) -> Any:
    try:
        return import_module(package)
    except ImportError:
        raise AdcsError(f"{package} is not installed: python -m pip install {package}") from None

"""modelDescription.xml of FMI 2.0 (scalars) and FMI 3.0 (arrays) from one description."""

import os
import tomllib
from collections.abc import Callable, Iterable, Mapping
from datetime import UTC, datetime
from importlib import metadata

from lxml import etree

from fmus.describe import Description, Unit, Variable
from fmus.errors import AdcsError
from fmus.paths import CHECKOUT
from fmus.xml import serialised

SEED_TYPE = "adcs.Seed"
"""The declared type of a seed: it says, to any tool, that components of a kind need different values."""

_SEED = (
    "Seed of random draws. Components of the same kind with equal seeds have equal noise; other kinds are independent."
)

_FMI2_TYPES = {"Float64": "Real", "Int32": "Integer"}
"""What FMI 2.0 calls the types that it has other names for."""

DEFAULT_EXPERIMENT = {"startTime": "0", "stopTime": "100", "tolerance": "1e-8", "stepSize": "0.01"}


def version() -> str:
    """Version of this package."""
    if CHECKOUT is None:
        return metadata.version("adcs-fmus")
    return str(tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"])


def fmi2(d: Description, source_files: Iterable[str] = ()) -> bytes:
    """FMI 2.0: one ScalarVariable for each element; the model structure counts them from 1."""
    root = _root(d, "2.0", {"guid": d.token, "numberOfEventIndicators": sum(v.size for v in d.variables if v.is_event)})
    flags = {
        "modelIdentifier": d.name,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": d.differentiable,
        "canNotUseMemoryManagementFunctions": True,
    }
    for interface, more in (
        ("ModelExchange", {"completedIntegratorStepNotNeeded": True}),
        ("CoSimulation", {"canHandleVariableCommunicationStepSize": True, "maxOutputDerivativeOrder": 0}),
    ):
        element = _add(root, interface, flags | more)
        if source_files:
            files = _add(element, "SourceFiles")
            for name in source_files:
                _add(files, "File", {"name": name})
    _add_common(root, d, lambda types, kind, name: _add(_add(types, "SimpleType", name), _FMI2_TYPES.get(kind, kind)))
    declared = _declared_types(d)

    scalars = [(v, i) for v in d.variables for i in range(v.size)]
    index = {v.vr + i: position for position, (v, i) in enumerate(scalars, 1)}

    variables = _add(root, "ModelVariables")
    for v, i in scalars:
        scalar = _add(
            variables,
            "ScalarVariable",
            {
                "name": v.element_names[i],
                "valueReference": v.vr + i,
                "description": _description(v),
                "causality": v.causality,
                "variability": v.variability,
                "initial": v.initial,
            },
        )
        _add(
            scalar,
            _FMI2_TYPES.get(v.type, v.type),
            {"declaredType": declared.get(v.vr)}
            | _number_attributes(v)
            | {
                "start": None if v.start is None else _literal(v, v.start[i]),
                "derivative": None if v.derivative_of is None else index[v.derivative_of + i],
            },
        )

    structure = _add(root, "ModelStructure")
    unknowns = {
        "Outputs": _dependencies(d.variables, _is_output),
        "Derivatives": _dependencies(d.variables, _is_derivative),
        "InitialUnknowns": _dependencies(d.variables, _is_initial_unknown, at_start=True),
    }
    for name, rows in unknowns.items():
        if rows:
            group = _add(structure, name)
            for vr, knowns in rows.items():
                if name != "InitialUnknowns":  # FMI 3.0 counts parameters among what is known during a run, FMI 2.0 not
                    knowns = tuple(k for k in knowns if d.at(k).causality != "parameter")
                attributes = {"index": index[vr], "dependencies": _join(sorted(index[k] for k in knowns))}
                _add(group, "Unknown", attributes)
    return serialised(root)


def fmi3(d: Description) -> bytes:
    """FMI 3.0: arrays; a dependency stands for any of its elements."""
    root = _root(d, "3.0", {"instantiationToken": d.token})
    flags = {
        "modelIdentifier": d.name,
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": d.differentiable,
        "providesAdjointDerivatives": d.differentiable,
    }
    _add(root, "ModelExchange", flags)
    _add(root, "CoSimulation", flags | {"canHandleVariableCommunicationStepSize": True, "hasEventMode": False})
    _add_common(root, d, lambda types, kind, name: _add(types, f"{kind}Type", name))
    declared = _declared_types(d)

    variables = _add(root, "ModelVariables")
    for v in d.variables:
        attributes = {
            "name": v.name,
            "valueReference": v.vr,
            "description": _description(v),
            "causality": v.causality,
            "variability": v.variability,
            "initial": v.initial,
        }
        element = _add(
            variables,
            v.type,
            attributes
            | {"declaredType": declared.get(v.vr)}
            | _number_attributes(v)
            | {
                "start": None if v.start is None else _join(_literal(v, x) for x in v.start),
                "derivative": v.derivative_of,
            },
        )
        for extent in v.shape:
            _add(element, "Dimension", {"start": extent})

    structure = _add(root, "ModelStructure")
    unknowns = {
        "Output": _dependencies(d.variables, _is_output),
        "ContinuousStateDerivative": _dependencies(d.variables, _is_derivative),
        "InitialUnknown": _dependencies(d.variables, _is_initial_unknown, at_start=True),
        "EventIndicator": _dependencies(d.variables, lambda v: v.is_event),
    }
    for name, rows in unknowns.items():
        whole: dict[int, set[int]] = {}
        for vr, knowns in rows.items():
            whole.setdefault(d.at(vr).vr, set()).update(d.at(k).vr for k in knowns)
        for vr, known_arrays in whole.items():
            _add(structure, name, {"valueReference": vr, "dependencies": _join(sorted(known_arrays))})
    return serialised(root)


def _is_output(v: Variable) -> bool:
    return v.causality == "output"


def _is_derivative(v: Variable) -> bool:
    return v.derivative_of is not None


def _is_initial_unknown(v: Variable) -> bool:
    return v.initial != "exact" and (_is_output(v) or _is_derivative(v) or v.causality == "calculatedParameter")


def _dependencies(
    variables: Iterable[Variable], wanted: Callable[[Variable], bool], at_start: bool = False
) -> dict[int, tuple[int, ...]]:
    """Scalar value reference of each element of the wanted variables -> scalar value references it depends on."""
    rows: dict[int, tuple[int, ...]] = {}
    for v in filter(wanted, variables):
        per_element = v.initial_dependencies if at_start else v.dependencies
        if per_element is None or len(per_element) != v.size:
            when = "initial " if at_start else ""
            raise AdcsError(f"{v.name}: {when}dependencies are {per_element}, expected {v.size} rows")
        rows |= {v.vr + i: row for i, row in enumerate(per_element)}
    return rows


def _root(d: Description, fmi_version: str, attributes: Mapping[str, object]) -> etree._Element:
    root = etree.Element("fmiModelDescription")
    epoch = os.environ.get("SOURCE_DATE_EPOCH")  # without it no date: the same sources give the same file
    date = datetime.fromtimestamp(int(epoch), UTC).strftime("%Y-%m-%dT%H:%M:%SZ") if epoch else None
    about = {
        "fmiVersion": fmi_version,
        "modelName": d.name,
        "description": d.description,
        "version": version(),
        "license": "BSD-3-Clause",
        "generationTool": f"adcs-fmus {version()}",
        "generationDateAndTime": date,
        "variableNamingConvention": "structured",
    }
    _set(root, about | dict(attributes))
    return root


def _declared_types(d: Description) -> dict[int, str]:
    """Value reference of each variable that has a declared type -> the type's name.

    Enumerations of the same items are of one type, which has the name of the first, with a dot that no variable has.
    """
    of_items: dict[tuple[str, ...], str] = {}
    found = {v.vr: SEED_TYPE for v in d.variables if v.is_seed}
    for v in d.variables:
        if v.items:
            found[v.vr] = of_items.setdefault(v.items, f"{d.name}.{v.name}")
    return found


def _add_common(
    root: etree._Element,
    d: Description,
    add_type: Callable[[etree._Element, str, dict[str, str]], etree._Element],
) -> None:
    units = _add(root, "UnitDefinitions")
    for unit in d.units:
        _add_unit(units, unit)
    names = _declared_types(d)
    declared = {names[v.vr]: v for v in reversed(d.variables) if v.vr in names}
    types = _add(root, "TypeDefinitions") if declared else root
    for name, v in reversed(declared.items()):
        about = {"description": _SEED} if v.is_seed else {}
        element = add_type(types, v.type, {"name": name} | about)
        for number, item in enumerate(v.items):
            _add(element, "Item", {"name": item, "value": number})
    categories = _add(root, "LogCategories")
    for category in d.log_categories:
        _add(categories, "Category", {"name": category.name, "description": category.description})
    _add(root, "DefaultExperiment", DEFAULT_EXPERIMENT)


def _add_unit(units: etree._Element, unit: Unit) -> None:
    element = _add(units, "Unit", {"name": unit.name})
    _add(
        element,
        "BaseUnit",
        unit.exponents
        | {"factor": None if unit.factor == 1 else unit.factor, "offset": None if unit.offset == 0 else unit.offset},
    )
    for display in unit.display:
        _add(element, "DisplayUnit", {"name": display.name, "factor": display.factor})


def _description(v: Variable) -> str:
    """With what no attribute can say."""
    return v.description if v.condition is None else f"{v.description} ({v.condition})"


def _number_attributes(v: Variable) -> dict[str, object]:
    return {
        "unit": v.unit,
        "displayUnit": v.display_unit,
        "min": None if v.min is None else _literal(v, v.min),
        "max": None if v.max is None else _literal(v, v.max),
        "nominal": v.nominal,
    }


def _literal(v: Variable, x: float) -> str:
    if v.type == "Boolean":
        return str(bool(x)).lower()
    return repr(float(x)) if v.type == "Float64" else str(int(x))


def _join(items: Iterable[object]) -> str:
    return " ".join(map(str, items))


def _add(parent: etree._Element, tag: str, attributes: Mapping[str, object] | None = None) -> etree._Element:
    element = etree.SubElement(parent, tag)
    _set(element, attributes or {})
    return element


def _set(element: etree._Element, attributes: Mapping[str, object]) -> None:
    """Attributes that are None are left out."""
    for name, value in attributes.items():
        if value is not None:
            element.set(name, str(value).lower() if isinstance(value, bool) else str(value))

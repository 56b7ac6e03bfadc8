"""`python -m tests.standards`: write docs/standards.md, what of the standards is supported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from .schemas import ITSELF
from .table import DOES, HERE, Row, rows
from .tried import TRIED

PAGE = Path(__file__).parents[2] / "docs" / "standards.md"
TITLES = {
    "fmi2": ("FMI 2.0", "modelDescription.xml"),
    "fmi3": ("FMI 3.0", "modelDescription.xml, terminalsAndIcons.xml and buildDescription.xml"),
    "ssp1": ("SSP 1.0", ".ssd, .ssv, .ssm and .ssb documents"),
    "ssp2": ("SSP 2.0", ".ssd, .ssv, .ssm and .ssb documents"),
}


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    print(f"{PAGE.name} is written")


def page() -> str:
    """Return the page that the tables make."""
    parts = [(HERE / "head.md").read_text(encoding="utf-8").replace("WORDS", _words())]
    parts += [f"| {what} | {_link(test)} |\n" for what, test in TRIED]
    for standard, (title, documents) in TITLES.items():
        counts = {what: sum(len(row.pairs) for row in rows(standard) if row.what == what) for what in DOES}
        said = ", ".join(f"{number} {what}" for what, number in counts.items())
        parts.append(f"\n## {title}\n\nElements and attributes of {documents}: {said}.\n\n")
        parts.append("| element | attributes | | why |\n|---|---|---|---|\n")
        parts += [
            f"| {_elements(row)} | {_attributes(row)} | {row.what} | {row.why} |\n" for row in _readable(standard)
        ]
    return "".join(parts)


def _readable(standard: str) -> list[Row]:
    """The lines in the order of the table, "as above" written out, neighbours that differ by attributes in one."""
    found: list[Row] = []
    for row in rows(standard):
        why = found[-1].why if row.why == "as above" else row.why
        last = found[-1] if found else None
        if last is not None and (last.elements, last.what, last.why) == (row.elements, row.what, why):
            found[-1] = replace(last, attributes=(*last.attributes, *row.attributes))
        else:
            found.append(replace(row, why=why))
    return found


def _words() -> str:
    return "\n".join(f"| {word} | {meaning} |" for word, meaning in DOES.items())


def _elements(row: Row) -> str:
    return ", ".join(f"`{name}`" for name in row.elements)


def _attributes(row: Row) -> str:
    return ", ".join("itself" if name == ITSELF else f"`{name}`" for name in row.attributes)


def _link(test: str) -> str:
    file, *_, name = test.split("::")
    return f"[{name.removeprefix('test_').replace('_', ' ')}](../tests/{file})"


if __name__ == "__main__":
    main()

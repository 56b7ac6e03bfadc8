"""What became of the mutants: kept as JSON, shown as docs/mutants.md."""

import json
from pathlib import Path
from typing import TypedDict

from fmus import catalog

from .explained import reason

KEPT = Path(__file__).with_name("report.json")
PAGE = Path(__file__).parents[2] / "docs" / "mutants.md"
HEAD = """# Mistakes that the tests would see

`make mutants` changes the headers of the components in one place at a time, as a slip of the pen would: a sign, a
dropped term, a transpose, a factor of 1.01, the order of a cross product, an index, a comparison, a sample too late,
a variable's name for its neighbour's. Each is compiled and given to the test of that law
([`tests/laws/test_every_law.py`](../tests/laws/test_every_law.py)), and if that does not see it, to the other tests
of `tests/laws` that name the component. Declarations and refusals are not changed; headers that components of one
folder share are. `make mutants COMPONENTS="RigidBody Quest"` tries some, `MUTANTS=30` more of each; this page and its
[JSON](../tests/mutants/report.json) are written anew.

"""


class Survivor(TypedDict):
    """A mutant that no test saw."""

    kind: str
    where: str
    before: str
    after: str


class Outcome(TypedDict):
    """Of a component."""

    killed: int
    by_other_tests: int
    not_compiled: int
    seconds: float
    survivors: list[Survivor]


def read() -> dict[str, Outcome]:
    found: dict[str, Outcome] = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.is_file() else {}
    return found


def write(outcomes: dict[str, Outcome]) -> None:
    KEPT.write_text(json.dumps(dict(sorted(outcomes.items())), indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(HEAD + table(outcomes) + survivors(outcomes), encoding="utf-8")


def table(outcomes: dict[str, Outcome]) -> str:
    lines = ["| component | mutants | seen by the law's test | by others | survived, for a reason | survived |"]
    lines.append("|---|---|---|---|---|---|")
    totals = [0] * 5
    for name, each in outcomes.items():
        known = sum(bool(reason(s["before"], s["after"])) for s in each["survivors"])
        others, left = each["by_other_tests"], len(each["survivors"]) - known
        row = [each["killed"] + others + known + left, each["killed"], others, known, left]
        totals = [a + b for a, b in zip(totals, row, strict=True)]
        lines.append(f"| {name} | {' | '.join(str(n) for n in row)} |")
    lines.append(f"| all | {' | '.join(str(n) for n in totals)} |")
    missing = [c.name for c in catalog.components() if c.name not in outcomes]
    return "\n".join(lines) + "\n\n" + (f"Not tried: {', '.join(missing)}.\n\n" if missing else "")


def survivors(outcomes: dict[str, Outcome]) -> str:
    lines = ["## Survivors", "", "| where | was | became | why nothing sees it |", "|---|---|---|---|"]
    rows = {}
    for each in outcomes.values():
        for s in each["survivors"]:
            before, after = (" ".join(s[key].split()).replace("|", "\\|") for key in ("before", "after"))
            why = reason(s["before"], s["after"]) or "**not explained**"
            rows[s["where"], after] = f"| `{s['where']}` | `{before}` | `{after}` | {why} |"
    return "\n".join([*lines, *(rows[key] for key in sorted(rows))]) + "\n"

"""`make conformance SOURCES=DIR`: build, run and check the Reference-FMUs; print the table and keep it for the docs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import get_args

from fmus.paths import BUILD
from orchestration.checking import check
from orchestration.fmu.file import Kind

from .sources import build, commit
from .trial import CLOSE, ONE_INTERNAL_STEP, Trial, trial

RIGHT = {"Roberts.fmu": "modelIdentifier BouncingBall, expected Roberts"} | {
    "StateSpace.fmu": "modelIdentifier LinearTransform, expected StateSpace"
}
"""Findings that are as they should be: build descriptions that name another model."""

PAGE = Path(__file__).parents[2] / "docs" / "conformance.md"

HEAD = """# Conformance

The FMI project publishes example FMUs with their source, the Reference-FMUs. `make conformance SOURCES=DIR`
builds those of FMI 2.0 and 3.0 from a folder of that source with this project's compiler, runs each by both methods
here and by fmpy, and checks it with `adcs check`. Inputs have a constant value that is not their start value. It
writes this page.

Source: {commit}. The rows have to be the same. Co-simulation has to agree to {cs:g} of each output's largest
value, model exchange to {me:g}: there two integrators differ, and events add to it. {model} counts its own internal
steps of a fixed size: fmpy asks for the next point less the last, whose last bit varies, and so once for a step
more or less than with a constant step; it has to agree to {one:g}. Stair ends its simulation; where an event does
so, fmpy has no row after it, and the last one is not compared. The build descriptions of Roberts and StateSpace name
other models, BouncingBall and LinearTransform: so there is a finding, and rightly.
"""


def row(result: Trial, findings: int) -> str:
    """A line of the table."""
    shown = result.remark or f"{result.difference:.1e}"
    verdict = "agrees" if result.good else "differs"
    cells = (
        result.model,
        f"{result.version}.0",
        result.kind,
        str(result.rows),
        shown,
        verdict,
        str(findings or "none"),
    )
    return f"| {' | '.join(cells)} |"


def main(arguments: list[str]) -> int:
    """Return 0 if everything agrees and nothing is found, or where there is nothing to build."""
    source = Path(arguments[0]) if arguments else Path()
    if not arguments or not (source / "src" / "fmi3Functions.c").is_file():
        print("skipped: SOURCES names no folder with the source of the Reference-FMUs")
        return 0
    (model, one), *_ = ONE_INTERNAL_STEP.items()
    lines = [
        HEAD.format(commit=commit(source), cs=CLOSE["co-simulation"], me=CLOSE["model-exchange"], model=model, one=one),
        "| model | FMI | method | rows | largest difference to fmpy | | findings of `adcs check` |",
        "|---|---|---|---:|---:|---|---|",
    ]
    good = True
    for fmu in build(source, BUILD / "conformance"):
        findings = check(fmu)
        for finding in findings:
            print(f"{fmu.name}: {finding}")
        for kind in get_args(Kind):
            result = trial(fmu, kind)
            if result is not None:
                lines.append(row(result, len(findings)))
                print(lines[-1], flush=True)
                false = [f for f in findings if not f.message.endswith(RIGHT.get(fmu.name, "\n"))]
                good = good and result.good and not false
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{PAGE.name} is written" + ("" if good else "; not everything agrees"))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

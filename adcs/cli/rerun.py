"""`adcs rerun`: a run again, from its manifest, and whether the result is the same."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from adcs.cli.command import Time, at_work, command
from adcs.cli.showing import RESULT_FILES, run_progress, write_files
from fmus.errors import AdcsError
from fmus.nearby import instead
from orchestration.isolation.folder import MANIFEST, new_results
from orchestration.process import endings
from orchestration.results.result import RunInterrupted
from orchestration.running.rerun import Rerun
from orchestration.running.rerun import rerun as run_again

app = command("rerun", "adcs rerun results/observer-pd", "adcs rerun theirs/manifest.json --out results/again")


@app.default
def rerun(
    manifest: Annotated[Path, Parameter(help="The manifest.json of a run, or the folder it is in.")],
    /,
    *,
    out: Path | None = None,
    force: bool = False,
    timeout: Time = 120.0,
    in_process: bool = False,
    json_: Annotated[bool, Parameter(name="--json")] = False,
) -> None:
    """Repeat a run from its manifest, and compare: say what is not as it was, and whether the result is the same.

    Args:
        out: Folder of the results; one that holds some already gets the next number. [default: that of the manifest]
        force: Replace the results that the folder holds.
        timeout: Give up when one call of a component takes longer.
        in_process: Do without a process of its own for the run.
        json_: Print what came of it as JSON.
    """
    beside = manifest if manifest.is_dir() else manifest.parent
    if not (beside / MANIFEST).is_file() and not manifest.is_file():
        raise AdcsError(f"{manifest}: there is no {MANIFEST}{instead(manifest)}: give that of a run, or its folder")
    with new_results(out or beside, force) as results, endings.heard(), run_progress() as bar:
        task = bar.add_task(str(manifest), total=1.0)
        try:
            again = run_again(
                manifest,
                timeout=timeout,
                progress=lambda part: bar.update(task, completed=part),
                isolated=not in_process,
            )
        except RunInterrupted as error:
            print(f"adcs: {error}; nothing is written", file=sys.stderr)
            sys.exit(128 + endings.last)
        formats = [kind for kind, name in RESULT_FILES.items() if (beside / name).is_file()] or ["csv", "mat"]
        results.clear()
        with at_work():
            written = write_files(again.result, results.path, formats)
        results.forget()
        files = [results.given / path.name for path in written]
    if json_:
        content = {
            "system": again.result.system.name,
            "outcome": again.result.manifest["outcome"],
            "same": again.same,
            "verdict": _verdict(again),
            "differences": again.differences,
            "files": [str(file) for file in files],
        }
        print(json.dumps(content, indent=2))
    else:
        console = Console()
        for line in (*(f"not as it was: {text}" for text in again.differences), _verdict(again), *map(str, files)):
            console.print(line, soft_wrap=True, highlight=False, markup=False)
    if again.same is False:
        sys.exit(1)


def _verdict(again: Rerun) -> str:
    if again.compared is None:
        return "there is no result beside the manifest to compare with"
    if again.deviation is None:
        return f"the same as {again.compared.name} beside the manifest, to the last bit"
    return f"not the same as {again.compared.name} beside the manifest: {again.deviation}"

"""`adcs recover`: makes the files that a run was asked for from the rows that it left when its process ended."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from adcs.catalogue import find_system
from adcs.cli.command import at_work, command
from adcs.cli.run_files import kept_in
from adcs.cli.showing import as_json, show, write_files, write_report
from fmus.errors import AdcsError, Failed
from fmus.nearby import instead
from orchestration.isolation import journal
from orchestration.isolation.death import Found, found
from orchestration.isolation.folder import MANIFEST, ResultsFolder

app = command("recover", "adcs recover results/observer-pd")


@app.default
def recover(
    folder: Annotated[Path, Parameter(help="Folder of the results, where run.journal is.")],
    /,
    *,
    ended_with: Annotated[int | None, Parameter(show=False)] = None,
    hung: Annotated[float | None, Parameter(show=False)] = None,
) -> None:
    """Make the files of a run whose process was killed, from the rows in its journal; they go up to the last step.

    Args:
        ended_with: The code that the process ended with, as its starter knows it.
        hung: It was ended, since a call had not returned for so long [s].
    """
    if folder.is_file():
        raise AdcsError(f"{folder} is a file: give the folder of the results, {folder.parent}")
    if not folder.exists():
        raise AdcsError(f"there is no folder {folder}{instead(folder)}")
    with ResultsFolder(folder) as results, nullcontext() if ended_with is None else at_work():
        if not results.journal.exists():
            raise AdcsError(
                f"{folder} has no {journal.NAME}: its run was not killed, or nothing is left of it; give the folder of "
                "the results"
            )
        left = found(results.journal, ended_with, hung)
        about = left.about
        result = left.result
        written = result if about["record"] in (None, result.names) else result.select(about["record"])
        try:
            if len(result.time):
                files = write_files(written, results.path, about["formats"])
            else:
                written.write_manifest(results.path / MANIFEST)
                files = [results.path / MANIFEST]
        except AdcsError as error:
            raise Failed(f"{error}; {kept_in(folder, len(result.time))}") from error
        results.journal.unlink()
        numbers: list[Any] = []
        if left.failed is None:
            results.forget()
            numbers, more = _rest(left, results.path)
            files += more
    files = [Path(about["folder"]) / file.name if ended_with is not None else folder / file.name for file in files]
    if about["json"]:
        print(as_json(result, numbers, files))
    else:
        show(result, numbers, None, files)
    if left.failed is not None:
        print(f"adcs: {left.message}", file=sys.stderr)
        if ended_with is not None:
            sys.exit(1)


def _rest(left: Found, folder: Path) -> tuple[list[Any], list[Path]]:
    """Return key numbers and report of a run that is complete, where they can be had."""
    about, result = left.about, left.result
    if about["record"] is not None and not about["report"]:
        return [], []
    try:
        entry = find_system(about["system"])
        numbers = list(entry.key_numbers(result))
        if not about["report"]:
            return numbers, []
        files = write_report(entry, result, numbers, None, folder, about["command"], png=about.get("png", False))
    except AdcsError as error:
        print(f"adcs: {error}", file=sys.stderr)
        return [], []
    return numbers, files

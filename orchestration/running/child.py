"""The other side of `apart`: runs what a folder asks for, and leaves the answer there."""

from __future__ import annotations

import pickle
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from fmus.errors import AdcsError
from fmus.files import write_atomically
from orchestration.isolation import apart
from orchestration.isolation.journal import NAME, Journal
from orchestration.process import orphan
from orchestration.results.result import Result, RunFailed, RunInterrupted
from orchestration.running.run import run


def main(folder: Path) -> None:
    """Run; an answer is written whatever comes of it, unless the process dies."""
    journal = Journal(folder / NAME)
    orphan.end_with_parent(lambda: journal.where.busy)
    asked: dict[str, Any] = pickle.loads((folder / apart.ASKED).read_bytes())
    answer: dict[str, Any] = {"failed": None, "interrupted": False}
    result: Result | None = None
    try:
        result = run(**{**asked, "save": replace(asked["save"], to=journal)})
    except RunFailed as error:
        answer["failed"], result = str(error), error.result
    except RunInterrupted as error:
        answer["interrupted"], result = True, error.result
    except AdcsError as error:
        answer["refused"] = error
    if result is not None:
        answer |= {"rows": len(result.time), "manifest": result.manifest}
        answer |= {"states": result.states, "state_names": result.state_names}
    with suppress(OSError):  # without room for an answer the journal is one
        write_atomically(folder / apart.ANSWER, pickle.dumps(answer))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

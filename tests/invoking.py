"""A command of the command line in this process: what it prints, and how it ends."""

from __future__ import annotations

import io
from collections.abc import Iterable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from cyclopts import App


@dataclass
class Ended:
    stdout: str
    stderr: str
    exit_code: int
    exception: BaseException | None

    @property
    def output(self) -> str:
        return self.stdout + self.stderr


def invoke(app: App, arguments: Iterable[str]) -> Ended:
    """Call it with these words; an exception that ends it is kept, and counts as exit code 1."""
    out, err = io.StringIO(), io.StringIO()
    code = 0
    raised: BaseException | None = None
    with redirect_stdout(out), redirect_stderr(err):
        try:
            app(list(arguments))
        except SystemExit as end:
            code, raised = int(end.code or 0), end
        except Exception as error:
            code, raised = 1, error
    return Ended(out.getvalue(), err.getvalue(), code, raised)

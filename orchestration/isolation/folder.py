"""The folder of a run's results: of one run at a time, and never with files of two."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from types import TracebackType

from fmus.errors import AdcsError, Failed
from fmus.lock import Lock
from orchestration.isolation import journal
from orchestration.process.writing import make_folder

MANIFEST = "manifest.json"
RESULTS = ("result.csv", "result.mat", "result.h5", MANIFEST, "report.html", "report.png", journal.NAME)
"""What a run may leave in its folder."""

STUDY = ("index.html", "rows.csv", "rows.json", "runs.json")
"""What a study leaves in its folder, beside pictures."""

PREVIOUS = "previous"
"""Where the files of the run before are until this one is complete."""

_LOCK = "run.lock"


class _Busy(Failed):
    """The folder belongs to a run that goes on."""


class ResultsFolder:
    """A context manager. AdcsError where the folder cannot be written, or belongs to another run that goes on."""

    def __init__(self, path: Path, asked: str | None = None) -> None:
        """`asked` says what it was asked by, should something be in its way."""
        self.given = path
        self.path = path.absolute()  # a component may change the working directory
        self._asked = asked or f"cannot write to {self.path}"
        self._lock = Lock(self.path / _LOCK)
        self._made = False

    def __enter__(self) -> ResultsFolder:
        self._made = not self.path.exists()
        make_folder(self.given, self._asked)
        try:
            taken = self._lock.take()
        except OSError as error:
            raise AdcsError(f"cannot write to {self.path}: {error.strerror}") from error
        if not taken:
            holder = f" (process {self._lock.holder})" if self._lock.holder else ""
            raise _Busy(
                f"{self.path} belongs to a run that goes on{holder}: wait for its end, or give another folder by --out"
            )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()
        if self._made:  # and nothing was written to it
            with suppress(OSError):
                self.path.rmdir()

    @property
    def occupied(self) -> bool:
        """Whether a run or a study has left something in it, be it the journal of one that died."""
        return any(os.path.lexists(self.path / name) for name in (*RESULTS, *STUDY, PREVIOUS))

    @property
    def journal(self) -> Path:
        """Where rows go while the run goes on."""
        return self.path / journal.NAME

    def clear(self) -> None:
        """Put aside what an earlier run left; files are moved, links are not followed."""
        present = [self.path / name for name in RESULTS if os.path.lexists(self.path / name)]
        if not present:
            return
        aside = self.path / PREVIOUS
        if aside.is_symlink() or (aside.exists() and not aside.is_dir()):
            aside.unlink()
        if (aside / journal.NAME).exists():  # rows that nobody has made files of: they are kept, too
            number = next(n for n in range(1, 10**6) if not (self.path / f"{PREVIOUS}-{n}").exists())
            aside.rename(self.path / f"{PREVIOUS}-{number}")
        elif aside.exists():
            shutil.rmtree(aside)
        aside.mkdir()
        for file in present:
            file.replace(aside / file.name)

    def restore(self) -> None:
        """Bring back what `clear` has put aside: the run that was to replace it has not begun."""
        aside = self.path / PREVIOUS
        if aside.is_dir() and not aside.is_symlink():
            for file in list(aside.iterdir()):
                file.replace(self.path / file.name)
            aside.rmdir()

    def forget(self) -> None:
        """This run is complete: remove what was put aside, unless it holds rows that are nowhere else."""
        aside = self.path / PREVIOUS
        if aside.is_dir() and not aside.is_symlink() and not (aside / journal.NAME).exists():
            with suppress(OSError):
                shutil.rmtree(aside)


@contextmanager
def new_results(folder: Path, replace: bool) -> Iterator[ResultsFolder]:
    """Take a folder for new results: this one if it holds none or they may be replaced, else FOLDER-2, FOLDER-3, ...

    Of two that want the same one at once, one gets the next number.
    """
    results = ResultsFolder(folder, f"--out {folder}").__enter__() if replace else _free(folder)
    try:
        yield results
    finally:
        results.__exit__(None, None, None)


def _free(folder: Path) -> ResultsFolder:
    for number in count(1):
        if number > 1 and folder.name in ("", ".."):
            raise AdcsError(
                f"{folder} holds the results of another run, and has no name to put a number to: give another folder "
                "by --out, or --force to replace them"
            )
        numbered = folder if number == 1 else folder.with_name(f"{folder.name}-{number}")
        results = ResultsFolder(numbered, f"--out {folder}")
        if results.occupied:
            continue
        with suppress(_Busy):
            results.__enter__()
            if not results.occupied:  # now that nobody else can write to it
                return results
            results.__exit__(None, None, None)
    raise AssertionError

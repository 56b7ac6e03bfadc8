"""The folder of a run's results: of one run at a time, and never with files of two."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from fmus.errors import AdcsError
from orchestration.isolation import journal
from orchestration.process.lock import Lock
from orchestration.process.writing import make_folder

MANIFEST = "manifest.json"
RESULTS = ("result.csv", "result.mat", "result.h5", MANIFEST, "report.html", "report.png", journal.NAME)
"""What a run may leave in its folder."""

PREVIOUS = "previous"
"""Where the files of the run before are until this one is complete."""

_LOCK = "run.lock"


class ResultsFolder:
    """A context manager. AdcsError where the folder cannot be written, or belongs to another run that goes on."""

    def __init__(self, path: Path) -> None:
        self.path = path.absolute()  # a component may change the working directory
        self._lock = Lock(self.path / _LOCK)

    def __enter__(self) -> ResultsFolder:
        make_folder(self.path, f"cannot write to {self.path}")
        try:
            taken = self._lock.take()
        except OSError as error:
            raise AdcsError(f"cannot write to {self.path}: {error.strerror}") from error
        if not taken:
            holder = f" (process {self._lock.holder})" if self._lock.holder else ""
            raise AdcsError(
                f"{self.path} belongs to a run that goes on{holder}: wait for its end, or give another folder by --out"
            )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

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

    def forget(self) -> None:
        """This run is complete: remove what was put aside, unless it holds rows that are nowhere else."""
        aside = self.path / PREVIOUS
        if aside.is_dir() and not aside.is_symlink() and not (aside / journal.NAME).exists():
            with suppress(OSError):
                shutil.rmtree(aside)

"""The files of one run of the command line: its folder, its journal, and what is made of them at its end."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from adcs.cli.showing import Format, write_files
from fmus.errors import AdcsError
from orchestration.isolation import supervised
from orchestration.isolation.death import reason
from orchestration.isolation.folder import MANIFEST, ResultsFolder
from orchestration.isolation.journal import Journal
from orchestration.process import endings
from orchestration.process.guard import explained, is_of_this_process
from orchestration.results import hdf5
from orchestration.results.result import Result


class RunFiles:
    """A context manager around a run in a folder that is this run's alone, and locked; `journal` is for `run`.

    From when the run begins, the folder holds a manifest with the status `running`, and the files of the run before are
    in `previous/`; these go when this run is complete.
    """

    def __init__(
        self,
        results: ResultsFolder,
        formats: Sequence[Format],
        about: Mapping[str, Any],
        timeout: float,
        printed: Callable[[], bool] | None = None,
    ) -> None:
        self._results = results
        self.folder = results.path
        self._formats, self._timeout = formats, timeout
        self._manifest: dict[str, Any] | None = None
        self._written = False
        about = {**about, "folder": str(results.given), "formats": list(formats)}
        self.journal = Journal(self._results.journal, about, self._begin, printed)

    def __enter__(self) -> RunFiles:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._manifest is not None and isinstance(error, AdcsError):
            error.failed |= bool(self.journal.where.place.started)
            if not error.failed:  # a part of the run refused it, and nothing has happened
                self.journal.close(remove=True)
                (self.folder / MANIFEST).unlink(missing_ok=True)
                self._results.restore()
                return
        if self._manifest is not None and not self._written and isinstance(error, AdcsError):
            rows = 0 if self.journal.recording is None else self.journal.recording.filled
            told = self._manifest.get("outcome", {})
            outcome = {"status": "failed", "message": str(error), "rows": rows}
            if told.get("status") == "failed":  # the run itself, and why it did matters more than what came of that
                outcome = told
            ended = self._result_of({**self._manifest, "outcome": outcome})
            try:
                ended.write_manifest(self.folder / MANIFEST)
            except AdcsError:  # the one there says that the run goes on: its room may be enough
                (self.folder / MANIFEST).unlink(missing_ok=True)
                with suppress(AdcsError):
                    ended.write_manifest(self.folder / MANIFEST)
            self.journal.close(remove=rows == 0)

    def write(self, result: Result, stopped: bool) -> list[Path]:
        """Write the files; should one of them fail, AdcsError says where the rows are, and why the run ended before."""
        try:
            with endings.patient():
                files = write_files(result, self.folder, self._formats)
        except KeyboardInterrupt as error:
            kept = f"{len(result.time)} rows are kept in {self.folder}: `adcs recover {self.folder}` writes them"
            raise AdcsError(f"interrupted while the files were written; {kept}") from error
        except AdcsError as error:
            outcome = result.manifest["outcome"]
            why = f"{reason(outcome)}; " if outcome["status"] == "failed" else ""
            text = explained(error, result.manifest["warnings"])
            if supervised.present() and is_of_this_process(error):
                kept = f"{len(result.time)} rows are kept, and another process makes them into files"
            else:
                kept = kept_in(self.folder, len(result.time))
            raise AdcsError(f"{why}{text}; {kept}") from error
        self._written = True
        self.journal.close(remove=True)
        if not stopped:
            self._results.forget()
        return files

    def _begin(self, manifest: dict[str, Any]) -> None:
        assert self.journal.recording is not None
        if "hdf5" in self._formats:
            hdf5.check(self.folder / "result.h5", self.journal.recording.ports)
        self._results.clear()
        self._manifest = manifest
        running = {**manifest, "outcome": {"status": "running", "pid": os.getpid()}}
        self._result_of(running).write_manifest(self.folder / MANIFEST)
        supervised.watch(self.journal.path, self.journal.where, self._timeout)

    def _result_of(self, manifest: dict[str, Any]) -> Result:
        return Result(None, [], [], {}, manifest)  # type: ignore[arg-type]


def kept_in(folder: Path, rows: int) -> str:
    """Say what can be done about files that could not be written."""
    return f"{rows} rows are kept in {folder}: make room, then `adcs recover {folder}`"

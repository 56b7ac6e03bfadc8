"""Telemetry logs: frames with the time in front, as ground stations write and read them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from pymavlink.dialects.v20 import common as mavlink

from fmus.errors import AdcsError
from fmus.nearby import instead
from hil_bridge.wire import microseconds
from orchestration.process.writing import make_folder

_MAGIC = {0xFE: (6, 2), 0xFD: (10, 2)}  # header and checksum
_SIGNED, _SIGNATURE = 0x01, 13


class TlogWriter:
    """Writes a log. What is written is in the file after each `flush`.

    A file that cannot be opened is refused. A disk that is full later on ends the log, not the run: one line says so
    on stderr, and `trouble` why.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.trouble = path, ""
        make_folder(path.parent, f"cannot write {path}")
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise AdcsError(f"cannot write {path}: {error.strerror}") from None
        self._last = 0
        self.frames = 0

    def write(self, unix_time: float, frame: bytes) -> None:
        """Add a frame; times never go back."""
        self._last = max(self._last, microseconds(unix_time))
        if self.trouble:
            return
        with self._lenient():
            self._file.write(self._last.to_bytes(8, "big") + frame)
            self.frames += 1

    def flush(self) -> None:
        """Hand all to the file."""
        if not self.trouble:
            with self._lenient():
                self._file.flush()

    def close(self) -> None:
        """Close the file."""
        with self._lenient():
            self._file.close()

    @contextmanager
    def _lenient(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if not self.trouble:
                self.trouble = f"{self.path}: {error.strerror or error}"
                print(f"adcs: the telemetry log ends here, the run goes on: {self.trouble}", file=sys.stderr)

    def __enter__(self) -> TlogWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def read(path: Path) -> Iterator[tuple[float, bytes]]:
    """Yield (UNIX time [s], frame) of a log; a frame that is cut off at its end, as by a crash, ends it."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise AdcsError(f"cannot read {path}: {error.strerror}{instead(path)}") from None
    place = 0
    while place + 8 + 12 <= len(data):
        start = place + 8
        magic = data[start]
        if magic not in _MAGIC:
            raise AdcsError(f"{path} is no telemetry log: byte {start} is 0x{magic:02x}, not the start of a frame")
        header, checksum = _MAGIC[magic]
        size = header + data[start + 1] + checksum
        if magic == mavlink.PROTOCOL_MARKER_V2 and data[start + 2] & _SIGNED:
            size += _SIGNATURE
        if start + size > len(data):
            return
        yield int.from_bytes(data[place:start], "big") * 1e-6, data[start : start + size]
        place = start + size


def sender(frame: bytes) -> tuple[int, int]:
    """Return system and component that sent a frame."""
    return (frame[3], frame[4]) if frame[0] == 0xFE else (frame[5], frame[6])

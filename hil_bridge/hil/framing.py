"""MAVLink messages out of a stream of bytes in which anything may stand between them."""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import common as mavlink

_HEADER = {0xFE: 6, 0xFD: 10}  # bytes before the payload, by first byte: MAVLink 1 and 2
_CHECKSUM, _SIGNATURE = 2, 13  # bytes after it
_SIGNED = 0x01


class Frames:
    """Finds the messages in a stream.

    A frame counts if its length and checksum fit its first bytes, and any byte may be a first one. So what only looks
    like the beginning of a frame, and announces 255 bytes that never come, swallows no message after it.
    """

    def __init__(self) -> None:
        self.messages = 0
        self.garbage = 0
        """Bytes that belonged to no message."""
        self._rest = b""
        self._codec = mavlink.MAVLink(None)

    def feed(self, data: bytes) -> list[Any]:
        """Return the messages that are complete now; what may still become one is kept, less than 280 bytes."""
        buffer = self._rest + data
        found = []
        taken = at = 0
        waits: int | None = None  # the first place where a frame may have begun that is not complete
        while at < len(buffer):
            end = _end(buffer, at)
            if end is None:
                at += 1
            elif end > len(buffer):
                waits = at if waits is None else waits
                at += 1
            elif (message := self._decoded(buffer[at:end])) is not None:
                found.append(message)
                self.garbage += at - taken
                taken = at = end
                waits = None
            else:
                at += 1
        keep = len(buffer) if waits is None else waits
        self.garbage += keep - taken
        self._rest = buffer[keep:]
        self.messages += len(found)
        return found

    def _decoded(self, frame: bytes) -> Any:
        try:
            message = self._codec.decode(bytearray(frame))
        except Exception:  # whatever pymavlink makes of bytes that are not a message
            return None
        return None if isinstance(message, mavlink.MAVLink_unknown) else message  # whose checksum nobody can tell


def _end(buffer: bytes, at: int) -> int | None:
    """Where a frame that begins here ends, perhaps after the buffer; None if none begins here."""
    header = _HEADER.get(buffer[at])
    if header is None:
        return None
    if len(buffer) < at + 3:
        return len(buffer) + 1
    signature = _SIGNATURE if header == 10 and buffer[at + 2] & _SIGNED else 0
    return at + header + buffer[at + 1] + _CHECKSUM + signature

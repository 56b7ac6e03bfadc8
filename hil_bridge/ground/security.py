"""What keeps strangers out: a rate limit for each source, and signed messages whose time must go on."""

from __future__ import annotations

import hashlib
import hmac
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from time import time
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from fmus.errors import AdcsError
from fmus.nearby import instead
from orchestration.process.format import refuse_other_version

_FORMAT = "adcs-signing-1"  # of the file where times are kept
_ZERO = 1420070400  # s, 2015-01-01: signing counts 10 us since then
_TICKS = 100_000  # per second
_AHEAD = 60 * _TICKS  # how far the clock of a partner may be ahead of ours, or behind
_BLOCK = 13  # bytes: link, time, signature
_RESERVE = _TICKS  # how far the times in the file are ahead of those that were used: a second
_MOST_SENDERS = 256
_MOST_PARSED = 4096  # bytes of a stream that are kept though they are parsed


@dataclass
class Bucket:
    """Lets `rate` things per second pass, and `burst` at once."""

    rate: float
    burst: float
    _level: float = field(init=False)
    _since: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self._level = self.burst

    def take(self, now: float, amount: float = 1.0) -> bool:
        """Whether one more may pass at a time [s]."""
        self._level = min(self.burst, self._level + self.rate * max(0.0, now - self._since))
        self._since = now
        if self._level < amount:
            return False
        self._level -= amount
        return True

    def spend(self, amount: float) -> None:
        """Take what it cost, known afterwards; at most as much again as passes at once is owed."""
        self._level = max(-self.burst, self._level - amount)


class Keyring:
    """The key of a link, and the newest time seen of each sender, kept in a file so that a restart forgets nothing.

    The file is ahead of what was seen: before a time is accepted that is later than those in it, a time one second
    later still is written. So whatever kills the program, nothing that it accepted is accepted again; the sender may
    have to wait for that second. The same holds for the times of what is sent.
    """

    def __init__(self, key: bytes, path: Path | None = None, clock: Callable[[], float] = time) -> None:
        """`key` has 32 bytes; `path` is where times are kept; `clock` gives UNIX time [s]."""
        self.key, self._path, self._clock = key, path, clock
        self.seen: dict[tuple[int, int, int], int] = {}
        self._sent = 0
        self.trouble = ""
        """Why the file cannot be written; nothing is accepted then."""
        if path is not None and path.exists():
            try:
                content = json.loads(path.read_text())
                refuse_other_version(path, "a record of signed messages", content.get("format"), _FORMAT, "remove it")
                if content["format"] != _FORMAT:
                    raise ValueError(f"expected the format {_FORMAT}")
                self.seen = {(a, b, c): t for a, b, c, t in content["seen"]}
                self._sent = int(content["sent"])
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                raise AdcsError(f"{path} does not hold the times of signed messages: {error}; remove it") from None
        self._written, self._sent_written = dict(self.seen), self._sent

    @classmethod
    def open(cls, path: Path, state: Path | None = None) -> Keyring:
        """Read a key: a file with 64 hexadecimal digits, or any other text, of which the SHA-256 is the key."""
        try:
            text = path.read_text(encoding="utf-8").strip()
        except OSError as error:
            raise AdcsError(f"cannot read the signing key {path}: {error.strerror}{instead(path)}") from None
        except UnicodeDecodeError:
            raise AdcsError(f"the signing key {path} is no text: expected 64 hexadecimal digits, or any text") from None
        if not text:
            raise AdcsError(f"the signing key {path} is empty")
        try:
            key = bytes.fromhex(text)
        except ValueError:
            key = b""
        return cls(key if len(key) == 32 else hashlib.sha256(text.encode()).digest(), state)

    def now(self) -> int:
        """The time for the next message that is sent: later than all before, also those before a restart."""
        self._sent = max(self._sent + 1, self._ticks())
        if self._sent > self._sent_written:
            self._reserve()
        return self._sent

    def accepts(self, frame: bytes, system: int, component: int) -> bool:
        """Whether a frame has the right signature, and a time that is new and near our own."""
        signature = hashlib.sha256(self.key + frame[:-6]).digest()[:6]
        if not hmac.compare_digest(signature, bytes(frame[-6:])):  # before anything is remembered
            return False
        sender = (frame[-_BLOCK], system, component)
        ticks = int.from_bytes(frame[-12:-6], "little")
        own = self._ticks()
        if not own - _AHEAD <= ticks <= own + _AHEAD or ticks <= self.seen.get(sender, 0):
            return False
        if sender not in self.seen and len(self.seen) >= _MOST_SENDERS:
            return False
        if ticks > self._written.get(sender, 0) and not self._reserve(sender, ticks):
            return False
        self.seen[sender] = ticks
        return True

    def save(self) -> None:
        """Write the times as they are, at an end that was planned; AdcsError if that cannot be done."""
        self._written, self._sent_written = dict(self.seen), self._sent
        if not self._write():
            raise AdcsError(f"cannot write the times of signed messages: {self.trouble}")

    def _reserve(self, sender: tuple[int, int, int] | None = None, ticks: int = 0) -> bool:
        """Write times that lie ahead, before they are used; whether that was possible."""
        if sender is not None:
            self._written[sender] = ticks + _RESERVE
        self._sent_written = max(self._sent_written, self._sent + _RESERVE)
        if self._write():
            return True
        if sender is not None:
            del self._written[sender]
        return False

    def _write(self) -> bool:
        """Replace the file, whole or not at all."""
        if self._path is None:
            return True
        new = self._path.with_suffix(".new")
        try:
            seen = [[*key, t] for key, t in self._written.items()]
            new.write_text(json.dumps({"format": _FORMAT, "sent": self._sent_written, "seen": seen}))
            new.replace(self._path)
        except OSError as error:
            self.trouble = f"{self._path}: {error.strerror or error}"
            return False
        return True

    def _ticks(self) -> int:
        return int((self._clock() - _ZERO) * _TICKS)


class Codec(mavlink.MAVLink):  # type: ignore[misc]  # which has no types
    """Packs what goes to one partner and parses what comes from it; a parser is never shared."""

    def __init__(self, system: int, component: int, keyring: Keyring | None = None) -> None:
        super().__init__(None, srcSystem=system, srcComponent=component)
        self.seq: int = 0
        self.robust_parsing = True
        self.keyring = keyring
        if keyring is not None:
            self.signing.secret_key = keyring.key
            self.signing.sign_outgoing = True

    def packed(self, message: Any) -> bytes:
        """Return the bytes of a message, and count it."""
        if self.keyring is not None:
            self.signing.timestamp = self.keyring.now()
        data: bytes = message.pack(self)
        self.seq = (self.seq + 1) % 256
        return data

    def parsed(self, data: bytes, whole: bool) -> tuple[list[Any], int]:
        """Return the messages in some bytes, and how many pieces were none.

        A datagram is `whole`: what a broken one left must not spoil the next.
        """
        if whole:
            self.buf, self.buf_index, self.expected_length = bytearray(), 0, mavlink.HEADER_LEN_V1 + 2
        good, bad = [], 0
        for message in self.parse_buffer(data) or []:
            if message.get_type() == "BAD_DATA":
                bad += 1
            else:
                good.append(message)
        if self.buf_index > _MOST_PARSED:  # pymavlink frees nothing as long as a frame is not complete
            self.buf, self.buf_index = self.buf[self.buf_index :], 0
        return good, bad + (whole and self.buf_len() > 0)

    def check_signature(self, msgbuf: bytearray, srcSystem: int, srcComponent: int) -> bool:
        """Whether the keyring takes it; instead of pymavlink's check, which remembers times before it checks."""
        return self.keyring is not None and self.keyring.accepts(bytes(msgbuf), srcSystem, srcComponent)

    def decode(self, msgbuf: bytearray) -> Any:
        """Decode one frame; unknown messages are not signed as far as pymavlink looks, and are refused with a key."""
        message = super().decode(msgbuf)
        if self.keyring is not None and message.get_type().startswith("UNKNOWN"):
            raise mavlink.MAVError("unknown message")
        return message

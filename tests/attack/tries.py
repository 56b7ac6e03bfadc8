"""What a reader may do with what it is given, and the count of what it did."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from time import process_time
from typing import Any

from adcs import AdcsError

LONGEST = 2.0  # s of CPU time for a small input
LONGEST_PER_MB = 2.0  # s more for each

counts: defaultdict[str, list[int]] = defaultdict(lambda: [0, 0])
"""By reader, how many tries were read and how many were refused."""


def attempt(reader: str, read: Callable[[], Any], size: int = 0) -> Any:
    """Read: return (True, the value), or (False, the line); every other outcome is an error, and so is a long wait."""
    began = process_time()
    try:
        outcome = True, read()
    except AdcsError as error:
        text = str(error)
        assert text.strip(), "a refusal says something"
        assert len(text.splitlines()) == 1, f"a refusal is one line: {text!r}"
        assert len(text) < 4000 + 2 * size, f"a line can be read: {len(text)} characters"
        outcome = False, text
    took = process_time() - began
    assert took < LONGEST + LONGEST_PER_MB * size * 1e-6, f"{reader} took {took:.1f} s for {size} bytes"
    counts[reader][0 if outcome[0] else 1] += 1
    return outcome


def summary(found: dict[str, list[int]]) -> list[str]:
    """A line for each reader, and one for all."""
    lines = [
        f"{reader}: {read + refused} tries, {read} read, {refused} refused"
        for reader, (read, refused) in sorted(found.items())
    ]
    total, refused = sum(map(sum, found.values())), sum(each[1] for each in found.values())
    return [*lines, f"all readers: {total} tries, {total - refused} read, {refused} refused in one line, 0 otherwise"]

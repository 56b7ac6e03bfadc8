"""The one exception that users are meant to see."""


class AdcsError(Exception):
    """A refusal in one line: what is wrong, with its value, and the way out."""

    failed = False
    """Whether it came of what was done, not of what was asked for: the command line ends with 1 then, else with 2."""


class Failed(AdcsError):
    """What was asked for is right, and could not be done."""

    failed = True


class Unsupported(AdcsError):
    """A refusal of what no standard forbids, but what is not done here, or not on this machine."""


def shown(text: str, most: int = 200) -> str:
    """Return a text that a user wrote as it may stand in a line: without breaks, and not endless."""
    line = "".join(c if c.isprintable() else " " for c in text)
    return line if len(line) <= most else f"{line[:most]}..."

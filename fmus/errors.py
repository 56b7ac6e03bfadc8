"""The one exception that users are meant to see."""


class AdcsError(Exception):
    """A refusal in one line: what is wrong, with its value, and the way out."""

"""How a process ended, in words."""

import signal

_SIGNALS = {
    "SIGSEGV": "a segmentation fault",
    "SIGBUS": "a bus error, as a library that is cut off makes it",
    "SIGABRT": "abort, as a failed assertion or an exception that nobody catches calls it",
    "SIGFPE": "an arithmetic trap",
    "SIGILL": "an illegal instruction",
    "SIGKILL": "from outside, as for lack of memory",
    "SIGXFSZ": "a file beyond its limit",
}
_EXCEPTIONS = {0xC0000005: "an access violation", 0xC00000FD: "a stack overflow", 0xC0000409: "abort"}  # of Windows


def how(code: int | None) -> str:
    """Say how a process ended that `subprocess` reports with this code; None if that is not known."""
    if code is None:
        return "it is not known how"
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        return f"{name}, {_SIGNALS[name]}" if name in _SIGNALS else name
    if code >= 0x80000000:
        return f"exception 0x{code:08X}" + (f", {_EXCEPTIONS[code]}" if code in _EXCEPTIONS else "")
    return f"exit code {code}"

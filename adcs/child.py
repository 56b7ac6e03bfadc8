"""The process of a run, started by `adcs.supervisor`."""

from __future__ import annotations

import signal
import sys

if __name__ == "__main__":
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # there is nothing to be kept yet
    from adcs.cli.app import main
    from orchestration.isolation import supervised

    sys.argv[0] = "adcs"
    supervised.begin()
    code = 1
    try:
        main()
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
        if isinstance(ended.code, str):
            print(ended.code, file=sys.stderr)
    finally:
        supervised.end(code)
    sys.exit(code)

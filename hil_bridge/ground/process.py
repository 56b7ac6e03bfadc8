"""The bridge as a process of its own, `python -m hil_bridge.ground.process`, which a run starts; settings on stdin."""

from __future__ import annotations

import json
import os
import signal
import sys
from contextlib import suppress
from threading import Thread

from fmus.errors import AdcsError
from hil_bridge.ground.link import Link
from hil_bridge.ground.server import Server
from hil_bridge.ground.settings import Settings


def main() -> None:
    """Serve until the run ends; stdin ends with the run, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the run, which says when it is over
    start = json.loads(sys.stdin.readline())
    try:
        settings = Settings.loaded(start["settings"])
        link = Link(bytes.fromhex(start["token"]), start["port"])
        server = Server(settings, link)
    except AdcsError as error:
        print(json.dumps({"error": str(error)}), flush=True)
        return
    print(json.dumps({"endpoints": [str(endpoint.place) for endpoint in server.endpoints]}), flush=True)

    def wait_for_end() -> None:
        sys.stdin.read()
        server.stop_soon()

    Thread(target=wait_for_end, daemon=True).start()
    server.serve()
    with suppress(OSError):  # the run may be gone
        os.write(1, (json.dumps(server.report()) + "\n").encode())


if __name__ == "__main__":
    main()

"""`adcs`: a run goes into a process of its own, everything else happens here. Nothing large is imported before."""

from __future__ import annotations

import os
import sys

import adcs.supervisor as supervisor  # not `from adcs`, which asks adcs/__init__.py first, and that loads more


def main() -> None:
    """Run the command line."""
    arguments = sys.argv[1:]
    if supervisor.wanted(arguments, os.environ):
        sys.exit(supervisor.supervise(arguments))
    from adcs.cli.app import main as here

    here()


if __name__ == "__main__":
    main()

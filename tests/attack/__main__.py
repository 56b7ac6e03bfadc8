"""`python -m tests.attack [N]`: N tries (1000) at each reader, other ones each time, and what came of them."""

import os
import sys
from pathlib import Path

import pytest

if __name__ == "__main__":
    os.environ["ADCS_ATTACK"] = (sys.argv[1:] or ["1000"])[0]
    sys.exit(pytest.main(["-q", str(Path(__file__).parent), *sys.argv[2:]]))

"""`python -m tests.mutants RigidBody Quest`; `MUTANTS=30` for more of each."""

import sys

from .trial import main

sys.exit(main())

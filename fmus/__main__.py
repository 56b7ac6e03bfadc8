"""`python -m fmus`: the commands that concern FMUs."""

from fmus.cli import main

main()

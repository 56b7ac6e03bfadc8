"""`adcs fmus`: the components as files for other tools."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from adcs.cli.command import command
from adcs.cli.printing import ERR, OUT, Json, print_json
from fmus.built import fmus_of
from fmus.catalog import components, find
from orchestration.process.writing import make_folder, replacing

app = command("fmus", "adcs fmus --to fmus", "adcs fmus RigidBody PdTracking --to ~/models", takes="[NAMES...]")


@app.default
def fmus_command(
    *names: Annotated[str, Parameter(help="Components; all if left out.")],
    to: Annotated[Path, Parameter(help="The folder that they are copied to.")],
    as_json: Json = False,
) -> None:
    """Copy the FMUs of components into a folder, for other tools: NAME.fmu (FMI 2.0) and NAME.fmi3.fmu (FMI 3.0)."""
    wanted = [find(name) for name in names] or components()
    make_folder(to, f"--to {to}")
    copied = []
    with ERR.status("copying ...") as status:
        for component in wanted:
            status.update(f"copying {component.name}")
            for fmu in fmus_of(component):
                with replacing(to / fmu.name) as path:
                    shutil.copyfile(fmu, path)
                copied.append(to / fmu.name)
    if as_json:
        print_json([str(path) for path in copied])
    else:
        OUT.print(f"{len(copied)} FMUs are in {to}", markup=False, highlight=False, soft_wrap=True)

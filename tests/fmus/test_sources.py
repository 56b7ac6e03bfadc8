"""The sources in an FMU make a working binary, with nothing but cmake and a compiler."""

import os
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary

from fmus.paths import BUILD
from fmus.toolchain import host, zig


def compiler(folder, language):
    """A command for cmake: zig, without building the C++ and sanitizer runtimes, which takes minutes."""
    script = folder / language
    script.write_text(
        f"""#!/bin/sh
case " $* " in *" -c "*) mode={language};; *) mode=cc;; esac
exec {zig()} $mode -fno-exceptions -fno-rtti -fno-sanitize=undefined "$@"
"""
    )
    script.chmod(0o755)
    return str(script)


@pytest.mark.parametrize("fmu", ["RigidBody.fmu", "RigidBody.fmi3.fmu"])
def test_compiled_from_its_sources_an_fmu_computes_the_same(built, tmp_path, monkeypatch, fmu):
    scripts = Path(sys.executable).parent  # cmake and ninja from PyPI
    for name, value in {
        "PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}",
        "CC": compiler(tmp_path, "cc"),
        "CXX": compiler(tmp_path, "c++"),
        "CMAKE_GENERATOR": "Ninja",
        "ZIG_GLOBAL_CACHE_DIR": str(BUILD / "zig"),
        "ZIG_LOCAL_CACHE_DIR": str(BUILD / "zig"),
    }.items():
        monkeypatch.setenv(name, value)
    unzipped = tmp_path / "fmu"
    fmpy.extract(str(built / fmu), str(unzipped))
    folder = host().fmi2_folder if fmu.count(".") == 1 else host().name
    library = unzipped / "binaries" / folder / f"RigidBody{host().suffix}"
    library.unlink()

    build_platform_binary(unzipped)

    assert library.is_file()
    first = "omega_BN_B" if "fmi3" in fmu else "omega_BN_B[1]"
    start = {first: [0.1, 0.2, -0.3] if "fmi3" in fmu else 0.1}
    settings = {"fmi_type": "CoSimulation", "stop_time": 1.0, "output_interval": 0.1, "start_values": start}
    ours = fmpy.simulate_fmu(str(built / fmu), **settings)
    theirs = fmpy.simulate_fmu(str(unzipped), **settings)
    assert ours.dtype == theirs.dtype
    for name in ours.dtype.names:
        np.testing.assert_allclose(theirs[name], ours[name], rtol=1e-14, atol=1e-15)
    assert np.ptp(ours[ours.dtype.names[1]]) > 0  # it moves

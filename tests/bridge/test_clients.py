"""Real ground tools at a running bridge: MAVSDK, MAVProxy, node-mavlink.

A test is skipped where its tool is not installed. ADCS_GROUND_TOOLS names Python interpreters that have some of them
(separated as in PATH), NODE_PATH the folder of Node's packages.
"""

import json
import os
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import adcs
from adcs import run
from adcs.catalogue import SYSTEMS
from adcs.cli.ground_tools import attached
from adcs.cli.options import GroundTools

from .live import Over, Udp

CLIENTS = Path(__file__).with_name("clients")


def interpreter(module, below=None):
    """A Python that has a package, of a major version below a limit; skip if there is none."""
    for candidate in (*filter(None, os.environ.get("ADCS_GROUND_TOOLS", "").split(os.pathsep)), sys.executable):
        probe = f"import importlib.metadata as m; print(m.version('{module}').split('.')[0])"
        done = subprocess.run([candidate, "-c", probe], capture_output=True, text=True, check=False)
        if done.returncode == 0 and (below is None or int(done.stdout) in below):
            return candidate
    return pytest.skip(f"{module} is not installed (pip install {module}, or name a Python by ADCS_GROUND_TOOLS)")


def free_port():
    return Udp().port


class Tool(Thread):
    """A client that runs beside the simulation."""

    def __init__(self, command, **more):
        super().__init__(daemon=True)
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
        self.out = self.err = ""
        self.start()

    def run(self):
        self.out, self.err = self.process.communicate()

    def wait(self):
        self.join(20.0)
        if self.is_alive():
            self.process.kill()
            self.join(5.0)
        return self.out


def flown(tool, port, name="full-state-pd", allow="arm,param,attitude", **more):
    """A run in real time until the tool is done; what was recorded."""
    from adcs import RunInterrupted

    entry = SYSTEMS[name]
    system = entry.build()
    options = GroundTools(to=(f"udpout:127.0.0.1:{port}",), allow=allow, **more)
    with attached(system, options, step=0.01) as watcher:
        try:
            result = run(system, stop_time=60.0, step=0.01, hooks=[adcs.pace(1.0), watcher, Over(tool)])
        except RunInterrupted as error:
            result = error.result
    return result


def test_mavsdk_sees_what_the_simulation_has_and_slews_it():
    python, port = interpreter("mavsdk", below=(4,)), free_port()
    script = str(CLIENTS / "watch_with_mavsdk.py")
    tool = Tool([python, script, f"udpin://127.0.0.1:{port}"])
    result = flown(tool, port, position="48.5,11.25,500km")
    lines = tool.wait().strip().splitlines()
    assert lines, tool.err[-2000:]
    seen = json.loads(lines[-1])

    q = result["tracker.q_BN_meas"]
    assert len(seen["quaternions"]) > 30
    for each in seen["quaternions"]:
        row = round(each["timestamp_us"] / 1e4)
        found = np.array([each[k] for k in "wxyz"])
        assert np.allclose(found, q[row] * np.sign(q[row, 0]), rtol=0, atol=6e-8)
    for each in seen["eulers"]:
        row = round(each["timestamp_us"] / 1e4)
        found = Rotation.from_euler("ZYX", [each["yaw_deg"], each["pitch_deg"], each["roll_deg"]], degrees=True)
        expected = Rotation.from_quat(q[row], scalar_first=True)
        assert (found * expected.inv()).magnitude() < 2e-6
    rates = result["plant.omega_BN_B"].astype(np.float32)
    for each in seen["rates"]:
        found = np.array([each["roll_rad_s"], each["pitch_rad_s"], each["yaw_rad_s"]], np.float32)
        assert (found == rates).all(axis=1).any()
    for each in seen["positions"]:
        assert (each["latitude_deg"], each["longitude_deg"]) == (48.5, 11.25)
        assert each["absolute_altitude_m"] == pytest.approx(500e3, rel=1e-7)
    assert seen["armed"] and seen["disarmed"]
    assert 17 <= seen["at_10_hz"] <= 23
    assert (seen["before"], seen["after"], seen["refused"]) == (1.5, 2.5, True)
    assert seen["offboard"]
    commands = result.manifest["commands"]
    target = next(c for c in commands if c[1] == "commanded_reference.q_CN")
    expected = Rotation.from_euler("ZYX", [30, 20, 10], degrees=True).as_quat(scalar_first=True)
    assert np.allclose(target[2], expected, rtol=0, atol=1e-6)
    assert [c[2] for c in commands if c[1] == "commanded_reference.engaged"] == [1, 0]
    start, end = (round(c[0] / 0.01) for c in commands if c[1] == "commanded_reference.engaged")
    error = [abs(result["plant.q_BN"][row] @ expected) for row in (start, end - 1)]
    assert error[1] > error[0]  # it is on its way


def test_mavsdk_3():
    python, port = interpreter("mavsdk", below=(1, 2, 3)), free_port()
    tool = Tool([python, str(CLIENTS / "watch_with_mavsdk3.py"), str(port)])
    result = flown(tool, port)
    lines = tool.wait().strip().splitlines()
    assert lines, tool.err[-2000:]
    seen = json.loads(lines[-1])
    q = result["tracker.q_BN_meas"]
    row = round(seen["timestamp_us"] / 1e4)
    assert np.allclose(seen["q"], q[row] * np.sign(q[row, 0]), rtol=0, atol=6e-8)
    assert seen["gain"] == 1.5


class MavProxy(Thread):
    """MAVProxy in a terminal, with lines typed at given times."""

    def __init__(self, python, port, folder, lines):
        import pty

        super().__init__(daemon=True)
        self._lines, self.text, self._seen = list(lines), "", 0
        self.at = {}
        self._main, side = pty.openpty()
        script = Path(python).with_name("mavproxy.py")
        command = [python, str(script), f"--master=udpin:127.0.0.1:{port}", f"--state-basedir={folder}"]
        command += ["--logfile=mp.tlog", "--default-modules=log,param,arm,misc,mode"]
        self.process = subprocess.Popen(
            command, stdin=side, stdout=side, stderr=side, cwd=folder, env={**os.environ, "TERM": "dumb"}
        )
        os.close(side)
        self.start()

    def run(self):
        began = time.monotonic()
        while self._lines and time.monotonic() - began < 25.0:
            readable, _, _ = select.select([self._main], [], [], 0.05)
            if readable:
                self.text += os.read(self._main, 65536).decode(errors="replace")
            wanted, line = self._lines[0]
            place = self.text.find(wanted, self._seen)
            if place >= 0:
                self._seen = place + len(wanted)
                self.at[wanted] = time.monotonic() - began
                os.write(self._main, f"{line}\n".encode())
                self._lines.pop(0)
        self.process.kill()
        self.process.wait()
        os.close(self._main)


def test_mavproxy_in_a_terminal(tmp_path):
    """Each line is typed when the text before it has come; the telemetry log that it wrote is read back."""
    python, port = interpreter("MAVProxy"), free_port()
    if not hasattr(os, "fork"):
        pytest.skip("MAVProxy is driven through a pseudo terminal, which this platform has not")
    tool = MavProxy(
        python,
        port,
        tmp_path,
        [
            ("online system 1", ""),
            ("Received 28 parameters", "param show CTRL_K_P"),
            ("CTRL_K_P         1.5", "status ATTITUDE"),
            ("ATTITUDE {time_boot_ms", "param set CTRL_K_P 2.5"),
            ("controller.k_p = 2.5 N.m", "disarm"),
            ("DISARMED", "arm throttle"),
            ("Armed: control loop closed", ""),
        ],
    )
    result = flown(tool, port)
    assert not tool._lines, f"waits for {tool._lines[:1]}:\n{tool.text}"
    assert "fence breach" not in tool.text
    assert tool.at["Received 28 parameters"] - tool.at["online system 1"] < 5.0
    assert [c[1:3] for c in result.manifest["commands"]] == [
        ["controller.k_p", 2.5],
        ["torque_switch.enabled", 0],
        ["torque_switch.enabled", 1],
    ]
    from hil_bridge.ground.tlog import read

    logs = list(tmp_path.rglob("mp.tlog"))
    assert logs and len(list(read(logs[0]))) > 100


def test_node_mavlink_knows_every_message():
    node = shutil.which("node")
    modules = os.environ.get("NODE_PATH", "")
    if node is None or not (Path(modules) / "node-mavlink").is_dir():
        pytest.skip("node-mavlink is not installed (npm install node-mavlink mavlink-mappings, NODE_PATH=node_modules)")
    port = free_port()
    tool = Tool([node, str(CLIENTS / "decode_with_node.cjs"), str(port), "3"])
    flown(tool, port, name="observer-pd")
    counts = json.loads(tool.wait().strip().splitlines()[-1])
    assert counts["unknown"] == 0
    assert {"Attitude", "AttitudeQuaternion", "AttitudeTarget", "GlobalPositionInt", "DebugVect"} <= set(counts)
    assert counts["AttitudeQuaternion"] > 50

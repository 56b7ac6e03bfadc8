"""The same with MAVSDK 3 and its server: one attitude, one parameter. Prints them as JSON."""

import asyncio
import json
import sys

from mavsdk import System


async def main(port: str) -> dict[str, object]:
    system = System()
    await system.connect(system_address=f"udpin://127.0.0.1:{port}")
    async for state in system.core.connection_state():
        if state.is_connected:
            break
    q = await anext(system.telemetry.attitude_quaternion())
    gain = await system.param.get_param_float("CTRL_K_P")
    return {"q": [q.w, q.x, q.y, q.z], "timestamp_us": q.timestamp_us, "gain": gain}


if __name__ == "__main__":
    print(json.dumps(asyncio.run(main(sys.argv[1]))))

"""A MAVSDK 4 program of everyday kind: watches, sets a rate and a parameter, slews. Prints what it saw as JSON."""

import asyncio
import json
import sys
from contextlib import suppress
from typing import Any

from mavsdk import ComponentType
from mavsdk.asyncio import Configuration, Mavsdk
from mavsdk.asyncio.plugins.action import ActionAsync as Action
from mavsdk.asyncio.plugins.offboard import OffboardAsync as Offboard
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry
from mavsdk.plugins.offboard import Attitude


async def some(generator: Any, seconds: float) -> list[Any]:
    """What a subscription yields in a time."""
    seen: list[Any] = []

    async def collect() -> None:
        async for each in generator:
            seen.append(each)  # noqa: PERF401

    with suppress(TimeoutError):
        await asyncio.wait_for(collect(), seconds)
    return seen


def fields(each: Any) -> dict[str, Any]:
    return {k: v for k, v in vars(each).items() if isinstance(v, int | float)}


async def main(url: str) -> dict[str, Any]:
    seen: dict[str, Any] = {}
    async with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        await sdk.add_any_connection(url)
        system = await sdk.first_autopilot(10.0)
        assert system is not None, "no autopilot"
        telemetry, param = Telemetry(system), Param(system)
        q, euler, rate, position, velocity = await asyncio.gather(
            some(telemetry.subscribe_attitude_quaternion(), 1.5),
            some(telemetry.subscribe_attitude_euler(), 1.5),
            some(telemetry.subscribe_attitude_angular_velocity_body(), 1.5),
            some(telemetry.subscribe_position(), 1.5),
            some(telemetry.subscribe_velocity_ned(), 1.5),
        )
        seen["quaternions"] = [fields(each) for each in q]
        seen["eulers"] = [fields(each) for each in euler]
        seen["rates"] = [fields(each) for each in rate]
        seen["positions"] = [fields(each) for each in position]
        seen["velocities"] = [fields(each) for each in velocity]
        seen["armed"] = await telemetry.armed()
        await telemetry.set_rate_attitude_quaternion(10.0)
        seen["at_10_hz"] = len(await some(telemetry.subscribe_attitude_quaternion(), 2.0))
        seen["before"] = await param.get_param_float("CTRL_K_P")
        await param.set_param_float("CTRL_K_P", 2.5)
        seen["after"] = await param.get_param_float("CTRL_K_P")
        try:
            await param.set_param_float("CTRL_K_P", -1.0)
            seen["refused"] = False
        except Exception:
            seen["refused"] = True
        offboard = Offboard(system)
        await offboard.set_attitude(Attitude(10.0, 20.0, 30.0, 0.0))
        await asyncio.sleep(0.2)
        await offboard.start()
        await asyncio.sleep(3.0)
        seen["offboard"] = await offboard.is_active()
        seen["mode"] = str(await telemetry.flight_mode())
        await offboard.stop()
        await Action(system).disarm()
        await asyncio.sleep(1.2)
        seen["disarmed"] = not await telemetry.armed()
    return seen


if __name__ == "__main__":
    print(json.dumps(asyncio.run(main(sys.argv[1]))))

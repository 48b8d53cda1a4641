#!/usr/bin/env python3
"""Fly two planes at once with asyncio, 40 m above one another: take-off, to a circle, return.

Usage: vencejo sim --planes 2, then python two_planes.py [LINK]
"""

import asyncio
import sys

from vencejo import Station, Telemetry, aio
from vencejo.geodesy import destination, distance_m


async def fly(plane: aio.AsyncVehicle, alt_rel_home_m: float) -> None:
    def is_high(now: Telemetry) -> bool:
        return now.position is not None and (now.position.alt_rel_home_m or 0.0) > alt_rel_home_m - 10.0

    home = (await plane.wait_until(lambda now: now.home, timeout_s=60, what="having a home")).home
    assert home is not None
    there = destination(home.point, bearing_deg=0.0, distance_m=600.0)

    def is_there(now: Telemetry) -> bool:
        here = now.position.point if now.position else None
        return here is not None and distance_m(here, there) < 150.0

    await plane.prepare_flight()
    await plane.wait_until(lambda now: now.sys_status and now.sys_status.is_ready_to_arm, timeout_s=60)
    await plane.takeoff(alt_rel_home_m=alt_rel_home_m)  # mode TAKEOFF: an ArduPlane rolls when it is armed
    await plane.arm()
    await plane.wait_until(is_high, timeout_s=120, what="the climb")
    print(f"plane {plane.system_id} is up")
    await plane.goto(there.lat_deg, there.lon_deg, alt_rel_home_m=alt_rel_home_m, loiter_radius_m=80.0)
    await plane.wait_until(is_there, timeout_s=300, what="the arrival")
    print(f"plane {plane.system_id} circles")
    await plane.return_to_launch()


async def main(link: str) -> None:
    with Station(link) as station:
        planes = [await aio.wait_vehicle(station, system_id) for system_id in (1, 2)]
        await asyncio.gather(*(fly(plane, 60.0 + 40.0 * number) for number, plane in enumerate(planes)))


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1] if len(sys.argv) > 1 else "tcp:127.0.0.1:5760"))

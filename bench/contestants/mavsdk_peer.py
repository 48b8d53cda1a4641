"""The benchmark tasks with the ``mavsdk`` 4 package, in the style of its own examples.

Usage: ``mavsdk_peer.py TASK NAME=VALUE…``; ends with one line of JSON. See bench/README.md.
"""

from __future__ import annotations

import json
import math
import os
import sys
import threading
import time
from array import array
from collections.abc import Callable
from typing import Any

import mavsdk


def connect(link: str, timeout_s: float = 20.0) -> tuple[Any, Any]:
    """Open a link and wait for the autopilot."""
    library = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION))
    result = library.add_any_connection(link)
    if result != mavsdk.ConnectionResult.SUCCESS:
        raise RuntimeError(f"{link}: {result.name}")
    print("READY", flush=True)
    system = library.first_autopilot(timeout_s)
    if system is None:
        raise TimeoutError(f"{link}: no autopilot within {timeout_s} s")
    return library, system


def follow(port: str, seconds: str, warm_up: str = "2", systems: str = "1") -> dict[str, Any]:
    """Subscribe to what a ground station displays; record the age of each RAW_IMU in its callback."""
    from mavsdk.plugins.telemetry import Telemetry

    library, _system = connect(f"udpin://127.0.0.1:{port}")
    give_up_at = time.monotonic() + float(warm_up)
    while library.system_count() < int(systems) and time.monotonic() < give_up_at:
        time.sleep(0.01)
    ages_us = array("q")
    callbacks = 0
    counts_from = time.monotonic() + float(warm_up)

    def on_imu(imu: Any, _: Any) -> None:
        nonlocal callbacks
        age_us = time.monotonic_ns() // 1000 - imu.timestamp_us
        if time.monotonic() >= counts_from:
            callbacks += 1
            ages_us.append(age_us)

    def on_other(_value: Any, _: Any) -> None:
        nonlocal callbacks
        if time.monotonic() >= counts_from:
            callbacks += 1

    plugins = [Telemetry(system) for system in library.get_systems()]
    for telemetry in plugins:
        telemetry.subscribe_raw_imu(on_imu)
        telemetry.subscribe_position(on_other)
        telemetry.subscribe_attitude_euler(on_other)
        telemetry.subscribe_fixedwing_metrics(on_other)
        telemetry.subscribe_gps_info(on_other)
        telemetry.subscribe_battery(on_other)
        telemetry.subscribe_scaled_pressure(on_other)
        telemetry.subscribe_wind(on_other)
        telemetry.subscribe_flight_mode(on_other)
    time.sleep(float(warm_up) + float(seconds))
    return {"messages": callbacks, "systems": len(plugins), "ages_us": ages_us.tolist()}


def snapshots(port: str, seconds: str, warm_up: str = "2", systems: str = "1") -> dict[str, Any]:
    """Read the plane's values ten times a second."""
    from mavsdk.plugins.telemetry import Telemetry

    del systems
    _library, system = connect(f"udpin://127.0.0.1:{port}")
    telemetry = Telemetry(system)
    looks = 0
    time.sleep(float(warm_up))
    until = time.monotonic() + float(seconds)
    while time.monotonic() < until:
        position, attitude = telemetry.position(), telemetry.attitude_euler()
        looks += math.isfinite(position.latitude_deg) and math.isfinite(attitude.roll_deg)
        time.sleep(0.1)
    return {"messages": looks}


def first_position(port: str) -> dict[str, Any]:
    """Wait for the first position, then end."""
    from mavsdk.plugins.telemetry import Telemetry

    _library, system = connect(f"udpin://127.0.0.1:{port}")
    telemetry = Telemetry(system)
    arrived = threading.Event()
    telemetry.subscribe_position(lambda _position, _: arrived.set())
    arrived.wait()
    return {"arrived": True}


def mission(link: str, items: str, verify: str = "no", settle: str = "0") -> dict[str, Any]:
    """Upload a mission; optionally read it back."""
    from mavsdk.plugins.mission_raw import MissionItem, MissionRaw

    _library, system = connect(link)
    plugin = MissionRaw(system)
    waypoints = []
    for seq in range(int(items)):
        lat_deg, lon_deg = place(seq)
        waypoints.append(
            MissionItem(
                seq=seq,
                frame=6,
                command=16,
                current=int(seq == 0),
                autocontinue=1,
                x=round(lat_deg * 1e7),
                y=round(lon_deg * 1e7),
                z=100.0,
                mission_type=0,
            )
        )
    time.sleep(float(settle))
    began = time.perf_counter()
    plugin.upload_mission(waypoints)
    sent = time.perf_counter() - began
    if verify == "no":
        return {"seconds": sent, "verified": False}
    back = plugin.download_mission()
    items_back = back[1] if isinstance(back, tuple) else back
    if len(items_back) != len(waypoints):
        raise RuntimeError(f"mission read-back: {len(items_back)} items")
    return {"seconds": time.perf_counter() - began, "verified": True}


def place(seq: int) -> tuple[float, float]:
    """Return the position of item ``seq`` of the long mission: a spiral around the usual home."""
    angle_rad = seq * 0.2
    radius_deg = 0.002 + 0.00002 * seq
    return (
        40.3332 + radius_deg * math.cos(angle_rad),
        -3.7978 + radius_deg * math.sin(angle_rad),
    )


def params(link: str, settle: str = "0") -> dict[str, Any]:
    """Read every parameter."""
    from mavsdk.plugins.param import Param

    _library, system = connect(link)
    plugin = Param(system)
    time.sleep(float(settle))
    began = time.perf_counter()
    found = plugin.get_all_params()
    seconds = time.perf_counter() - began
    count = len(found.int_params) + len(found.float_params)
    if count == 0:
        raise RuntimeError("parameters: none came")
    return {"seconds": seconds, "count": count}


TASKS: dict[str, Callable[..., dict[str, Any]]] = {
    "follow": follow,
    "snapshots": snapshots,
    "first_position": first_position,
    "mission": mission,
    "params": params,
}

if __name__ == "__main__":
    result = TASKS[sys.argv[1]](**dict(part.split("=", 1) for part in sys.argv[2:]))
    print(json.dumps(result), flush=True)
    # Its own shutdown is not measured, and it may wait for its threads.
    os._exit(0)

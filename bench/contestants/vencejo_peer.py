"""The benchmark tasks with Vencejo, in the style of its own examples.

Usage: ``vencejo_peer.py TASK NAME=VALUE…``; ends with one line of JSON. See bench/README.md.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from array import array
from collections.abc import Callable
from typing import Any

import vencejo

#: Remote aircraft with message callbacks: each has a thread of its own.
FAR_FOLLOWED = 50


def follow(port: str, seconds: str, warm_up: str = "2", systems: str = "1") -> dict[str, Any]:
    """Receive every message of every vehicle in callbacks; record the age of each RAW_IMU."""
    ages_us = array("q")
    messages = 0
    counts_from = math.inf

    def on_message(message: vencejo.MavlinkMessage) -> None:
        nonlocal messages
        now_us = time.monotonic_ns() // 1000
        if now_us < counts_from * 1e6:
            return
        messages += 1
        if message.name == "RAW_IMU":
            ages_us.append(now_us - message.fields["time_usec"])

    with vencejo.Station(f"udpin:127.0.0.1:{port}", record=False) as station:
        print("READY", flush=True)
        station.wait_vehicle(timeout_s=20)
        give_up_at = time.monotonic() + float(warm_up)
        while len(station.vehicles) < int(systems) and time.monotonic() < give_up_at:
            time.sleep(0.01)
        counts_from = time.monotonic() + float(warm_up)
        with station.on_message(on_message) as subscription:
            time.sleep(float(warm_up) + float(seconds))
            dropped = subscription.dropped
        lost = sum(link.frames_lost for link in station.links)
    return {"messages": messages, "ages_us": ages_us.tolist(), "dropped": dropped, "lost": lost}


def snapshots(port: str, seconds: str, warm_up: str = "2", systems: str = "1") -> dict[str, Any]:
    """Read the plane's values ten times a second."""
    del systems
    looks = 0
    with vencejo.Station(f"udpin:127.0.0.1:{port}", record=False) as station:
        print("READY", flush=True)
        plane = station.wait_vehicle(timeout_s=20)
        counts_from = time.monotonic() + float(warm_up)
        for telemetry in plane.stream(rate_hz=10):
            now = time.monotonic()
            if now >= counts_from + float(seconds):
                break
            is_whole = telemetry.position is not None and telemetry.attitude is not None
            looks += now >= counts_from and is_whole
    return {"messages": looks}


def far(port: str, org: str, aircraft: str, seconds: str) -> dict[str, Any]:
    """Run a ground station and router, with attitude callbacks for some of the aircraft; record the age of each.

    Their ATTITUDE contains UTC in µs, modulo 2^32, in place of the time since boot.
    """
    from vencejo.fleet import Fleet

    ages_us = array("q")
    counts_from = math.inf

    def on_attitude(message: vencejo.MavlinkMessage) -> None:
        now_us = time.time_ns() // 1000
        if now_us >= counts_from:
            ages_us.append((now_us - message.fields["time_boot_ms"]) % (1 << 32))

    with (
        vencejo.Station(record=False) as station,
        Fleet(station, org=org, listen=f"tcp/127.0.0.1:{port}", history=False),
    ):
        print("READY", flush=True)
        while len(station.vehicles) < int(aircraft):
            time.sleep(0.1)
        for plane in station.vehicles[:FAR_FOLLOWED]:
            plane.on_message(on_attitude, names=["ATTITUDE"])
        time.sleep(2.0)
        print("ALL", flush=True)
        counts_from = time.time_ns() / 1e3
        time.sleep(float(seconds))
        counted = ages_us.tolist()
    return {"messages": len(counted), "ages_us": counted}


def first_position(port: str) -> dict[str, Any]:
    """Wait for the first position, then end."""
    with vencejo.connect(f"udpin:127.0.0.1:{port}", record=False) as plane:
        arrived = threading.Event()
        plane.on_message(lambda _: arrived.set(), names=["GLOBAL_POSITION_INT"])
        arrived.wait()
        print(json.dumps({"arrived": True}), flush=True)
    return {"arrived": True}


def mission(link: str, items: str, verify: str = "yes", settle: str = "0") -> dict[str, Any]:
    """Upload a mission; it is always read back and compared."""
    del verify
    spiral = [
        vencejo.MissionItem.waypoint(*place(seq), alt_rel_home_m=100.0)
        for seq in range(1, int(items))  # item 0 is home, which the plan stores separately
    ]
    with vencejo.connect(link, record=False) as plane:
        time.sleep(float(settle))
        began = time.perf_counter()
        plane.upload(vencejo.Plan(items=tuple(spiral)), check=False)
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
    with vencejo.connect(link, record=False) as plane:
        time.sleep(float(settle))
        began = time.perf_counter()
        found = plane.params.all()
        return {"seconds": time.perf_counter() - began, "count": len(found)}


TASKS: dict[str, Callable[..., dict[str, Any]]] = {
    "follow": follow,
    "snapshots": snapshots,
    "far": far,
    "first_position": first_position,
    "mission": mission,
    "params": params,
}

if __name__ == "__main__":
    result = TASKS[sys.argv[1]](**dict(part.split("=", 1) for part in sys.argv[2:]))
    print(json.dumps(result), flush=True)

"""The benchmark tasks with pymavlink, in the style of its own examples.

Usage: ``pymavlink_peer.py TASK NAME=VALUE…``; ends with one line of JSON. See bench/README.md.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from array import array
from collections.abc import Callable
from typing import Any

os.environ["MAVLINK20"] = "1"


def decode(file: str, laps: str = "1") -> dict[str, Any]:
    """Decode a recorded stream as fast as possible."""
    from pymavlink.dialects.v20 import ardupilotmega

    with open(file, "rb") as stream:  # noqa: PTH123 (no pathlib in the timed part)
        data = stream.read()
    messages = 0
    began = time.perf_counter()
    for _ in range(int(laps)):
        parser: Any = ardupilotmega.MAVLink(None)
        parser.robust_parsing = True
        messages += len(parser.parse_buffer(data))
    return {"messages": messages, "seconds": time.perf_counter() - began}


def connect(link: str) -> Any:
    """Open a link the way pymavlink's examples do."""
    from pymavlink import mavutil

    return mavutil.mavlink_connection(link, source_system=255, source_component=190)


def follow(port: str, seconds: str, warm_up: str = "2", systems: str = "1") -> dict[str, Any]:
    """Read all messages for a while; record the age of each RAW_IMU on arrival."""
    del systems  # it reads all vehicles in any case
    link = connect(f"udpin:127.0.0.1:{port}")
    print("READY", flush=True)
    ages_us = array("q")
    messages = 0
    link.recv_match(blocking=True)
    counts_from = time.monotonic() + float(warm_up)
    until = counts_from + float(seconds)
    while (now := time.monotonic()) < until:
        message = link.recv_match(blocking=True, timeout=1.0)
        if message is None or now < counts_from:
            continue
        messages += 1
        if message.get_type() == "RAW_IMU":
            ages_us.append(time.monotonic_ns() // 1000 - message.time_usec)
    return {"messages": messages, "ages_us": ages_us.tolist()}


def snapshots(port: str, seconds: str, warm_up: str = "2", systems: str = "1") -> dict[str, Any]:
    """Read all messages, and look at the newest values ten times a second."""
    del systems
    link = connect(f"udpin:127.0.0.1:{port}")
    print("READY", flush=True)
    link.recv_match(blocking=True)
    looks = 0
    due = counts_from = time.monotonic() + float(warm_up)
    while (now := time.monotonic()) < counts_from + float(seconds):
        link.recv_match(blocking=True, timeout=1.0)
        if now >= due:
            due += 0.1
            looks += "GLOBAL_POSITION_INT" in link.messages and "ATTITUDE" in link.messages
    return {"messages": looks}


def first_position(port: str) -> dict[str, Any]:
    """Wait for the first position, then end."""
    link = connect(f"udpin:127.0.0.1:{port}")
    while True:
        message = link.recv_match(type="GLOBAL_POSITION_INT", blocking=True)
        if message is not None:
            return {"lat_deg": message.lat / 1e7}


def mission(link: str, items: str, verify: str = "no", settle: str = "0") -> dict[str, Any]:
    """Upload a mission item by item on request; optionally read it back."""
    from pymavlink import mavutil

    mav = mavutil.mavlink
    vehicle = connect(link)
    vehicle.wait_heartbeat()
    count = int(items)
    until = time.monotonic() + float(settle)
    while time.monotonic() < until:
        vehicle.recv_match(blocking=True, timeout=0.1)
    began = time.perf_counter()
    vehicle.mav.mission_count_send(vehicle.target_system, vehicle.target_component, count, 0)
    while True:
        message = vehicle.recv_match(
            type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=5
        )
        if message is None:
            raise TimeoutError("mission upload: no answer for 5 s")
        if message.get_type() == "MISSION_ACK":
            if message.type != mav.MAV_MISSION_ACCEPTED:
                raise RuntimeError(f"mission upload: refused with {message.type}")
            break
        lat_deg, lon_deg = place(message.seq)
        vehicle.mav.mission_item_int_send(
            vehicle.target_system, vehicle.target_component, message.seq,
            mav.MAV_FRAME_GLOBAL_RELATIVE_ALT, mav.MAV_CMD_NAV_WAYPOINT, 0, 1, 0, 0, 0, 0,
            round(lat_deg * 1e7), round(lon_deg * 1e7), 100.0, 0,
        )  # fmt: skip
    sent = time.perf_counter() - began
    if verify == "no":
        return {"seconds": sent, "verified": False}
    vehicle.mav.mission_request_list_send(vehicle.target_system, vehicle.target_component, 0)
    answer = vehicle.recv_match(type="MISSION_COUNT", blocking=True, timeout=5)
    if answer is None or answer.count != count:
        raise RuntimeError(f"mission read-back: {answer}")
    for seq in range(count):
        vehicle.mav.mission_request_int_send(vehicle.target_system, vehicle.target_component, seq, 0)
        item = vehicle.recv_match(
            type="MISSION_ITEM_INT",
            condition=f"MISSION_ITEM_INT.seq=={seq}",
            blocking=True,
            timeout=5,
        )
        if item is None:
            raise TimeoutError(f"mission read-back: item {seq} did not come")
        if seq and item.x != round(place(seq)[0] * 1e7):
            raise RuntimeError(f"mission read-back: item {seq} differs")
    vehicle.mav.mission_ack_send(vehicle.target_system, vehicle.target_component, 0, 0)
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
    """Read every parameter with PARAM_REQUEST_LIST, requesting missing ones again."""
    vehicle = connect(link)
    vehicle.wait_heartbeat()
    until = time.monotonic() + float(settle)
    while time.monotonic() < until:
        vehicle.recv_match(blocking=True, timeout=0.1)
    began = time.perf_counter()
    vehicle.param_fetch_all()
    have: set[int] = set()
    total = None
    while total is None or len(have) < total:
        message = vehicle.recv_match(type="PARAM_VALUE", blocking=True, timeout=1.0)
        if message is None:
            for index in sorted(set(range(total or 0)) - have)[:10]:
                vehicle.param_fetch_one(index)
            if total is None:
                vehicle.param_fetch_all()
            if time.perf_counter() - began > 60:
                raise TimeoutError(f"parameters: {len(have)} of {total} after a minute")
            continue
        total = message.param_count
        if message.param_index < total:
            have.add(message.param_index)
    return {"seconds": time.perf_counter() - began, "count": len(have)}


TASKS: dict[str, Callable[..., dict[str, Any]]] = {
    "decode": decode,
    "follow": follow,
    "snapshots": snapshots,
    "first_position": first_position,
    "mission": mission,
    "params": params,
}

if __name__ == "__main__":
    result = TASKS[sys.argv[1]](**dict(part.split("=", 1) for part in sys.argv[2:]))
    print(json.dumps(result), flush=True)

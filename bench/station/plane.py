"""An endlessly flying plane that uses few resources itself: plays the recorded stream over UDP.

The recording lasts 20 s. In each repetition, boot times continue and positions move along a circle, so that the trail
looks like that of a flight. Commands are accepted at once, as fast as an autopilot could. It ends with its standard
input.

Usage: ``python bench/station/plane.py PORT [--hz N]``
"""

from __future__ import annotations

import argparse
import math
import select
import socket
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.prepare import CAPTURE, LAP_MS, LEFT_OUT

RECORDED_HZ = 50
DEG_PER_M = 1.0 / 111_320.0
"""Degrees of latitude per metre, and of longitude at the equator: sufficient for moving an image."""
DRIFT_M_S = 12.0
DRIFT_RADIUS_M = 1500.0


def frames_of(hz: int) -> list[tuple[float, Any]]:
    """Return the recording at another rate: seconds since its beginning, and messages."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    reader: Any = dialect.MAVLink(None)
    reader.robust_parsing = True
    heard = [message for message in reader.parse_buffer(CAPTURE.read_bytes()) if message.get_type() not in LEFT_OUT]
    seen: dict[str, int] = {}
    kept = []
    for place, message in enumerate(heard):
        count = seen[message.get_type()] = seen.get(message.get_type(), -1) + 1
        if message.get_type() == "GLOBAL_POSITION_INT" and abs(message.lat) < 100_000:
            continue  # recorded before the first fix
        is_slow = message.get_type() == "HEARTBEAT"
        times = 1 if is_slow else count * hz // RECORDED_HZ - (count - 1) * hz // RECORDED_HZ
        kept += [(place / len(heard) * LAP_MS / 1000.0, message)] * times
    return kept


def moved(message: Any, lap: int, lap_s: float) -> Any:
    """Return the message as in a later repetition; the same object, changed in place."""
    if lap == 0 and not hasattr(message, "_first"):
        message._first = {
            name: getattr(message, name)
            for name in ("time_boot_ms", "time_usec", "time_unix_usec", "lat", "lon")
            if hasattr(message, name)
        }
    first = message._first
    angle = (lap * LAP_MS / 1000.0 + lap_s) * DRIFT_M_S / DRIFT_RADIUS_M
    north_deg = DRIFT_RADIUS_M * math.sin(angle) * DEG_PER_M
    for name, value in first.items():
        if not value:
            continue
        if name == "lat":
            message.lat = value + round(north_deg * 1e7)
        elif name == "lon":
            east_deg = DRIFT_RADIUS_M * (1.0 - math.cos(angle)) * DEG_PER_M / math.cos(math.radians(first["lat"] / 1e7))
            message.lon = value + round(east_deg * 1e7)
        else:
            setattr(message, name, value + lap * LAP_MS * (1 if name == "time_boot_ms" else 1000))
    return message


def fly(port: int, hz: int) -> None:
    """Send until standard input ends."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    to = ("127.0.0.1", port)
    writer: Any = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    parser: Any = dialect.MAVLink(None)
    parser.robust_parsing = True
    laps = frames_of(hz)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        link.bind(("127.0.0.1", 0))
        began = time.monotonic()
        lap = 0
        while True:
            for lap_s, message in laps:
                due = began + lap * LAP_MS / 1000.0 + lap_s
                while True:
                    left = due - time.monotonic()
                    ready, _, _ = select.select([link, sys.stdin], [], [], max(0.0, left))
                    if sys.stdin in ready and not sys.stdin.read(1):
                        return
                    if link in ready:
                        answer(link, parser, writer, to)
                    elif left <= 0.0:
                        break
                link.sendto(moved(message, lap, lap_s).pack(writer), to)
            lap += 1


def answer(link: socket.socket, parser: Any, writer: Any, to: tuple[str, int]) -> None:
    """Accept the commands of one datagram."""
    for message in parser.parse_buffer(link.recv(2048)) or []:
        if message.get_type() in {"COMMAND_LONG", "COMMAND_INT"}:
            ack = writer.command_ack_encode(
                message.command, 0, 0, 0, message.get_srcSystem(), message.get_srcComponent()
            )
            link.sendto(ack.pack(writer), to)


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("port", type=int)
    options.add_argument(
        "--hz", type=int, default=RECORDED_HZ, help="messages of each stream a second; 50 are 1,000 of all"
    )
    chosen = options.parse_args()
    fly(chosen.port, chosen.hz)


if __name__ == "__main__":
    main()

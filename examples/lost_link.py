#!/usr/bin/env python3
"""Watch a plane that flies: say when its link is lost, and order it home when it is heard again.

Usage: python lost_link.py [LINK]
"""

import sys

import vencejo
from vencejo import Telemetry
from vencejo.geodesy import distance_m

HOME_M = 300.0


def is_home(now: Telemetry) -> bool:
    """Whether the plane is near home."""
    here = now.position.point if now.position else None
    return here is not None and now.home is not None and distance_m(here, now.home.point) < HOME_M


link = sys.argv[1] if len(sys.argv) > 1 else "tcp:127.0.0.1:5760"
with vencejo.connect(link) as plane:
    plane.wait_until(lambda now: now.is_armed and now.position, timeout_s=None)
    # From here on: what happened on the ground, such as a lost link, must not order a plane that takes off home.
    events = plane.events()
    print("armed", flush=True)
    for event in events:
        if event.kind == "disarmed":
            break
        if event.kind == "lost":  # nothing was heard for 5 s; what is sent now may not arrive
            last = plane.telemetry.position
            where = "nowhere" if last is None else f"{last.point}, {last.age_s:.0f} s ago"
            print(f"lost; last seen at {where}; its own failsafe decides what it does", flush=True)
        elif event.kind == "regained":
            plane.return_to_launch()
            print(f"heard again, and on its way home in mode {plane.telemetry.mode}", flush=True)
            plane.wait_until(is_home, timeout_s=600, what="the way home")
            print("it circles at home")
            break

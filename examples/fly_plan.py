#!/usr/bin/env python3
"""Fly a mission file, act by act, and follow the plane until it has landed and disarmed.

Usage: python fly_plan.py FILE [LINK]
"""

import sys

import vencejo

if len(sys.argv) < 2:
    sys.exit(__doc__)
file = sys.argv[1]
link = sys.argv[2] if len(sys.argv) > 2 else "tcp:127.0.0.1:5760"

plan = vencejo.Plan.load(file)
with vencejo.connect(link) as plane:
    # Each act raises when it failed; none is a side effect of another.
    on_board = plane.upload(plan)  # checked before; read back and compared
    print(f"{on_board.count} items on board, {on_board.state}")
    for warning in on_board.findings:
        print(f"warning: {warning}")
    plane.prepare_flight()  # a mode that arms, the mission at its beginning
    plane.wait_until(
        lambda now: now.sys_status and now.sys_status.is_ready_to_arm,
        timeout_s=60,
        what="being ready to arm",
    )
    if input("Arm and start? [y/N] ").strip().lower() != "y":
        sys.exit("nothing was armed")
    try:
        plane.arm()
    except vencejo.CommandRefused as refused:
        sys.exit(f"not armed: {refused}")  # with the autopilot's own reasons
    try:
        plane.start_mission()  # AUTO: the pilot's radio can take over at any time
    except BaseException:
        plane.disarm()  # it is not left armed on the ground
        raise

    item = None
    plane.wait_until(lambda now: now.is_armed, timeout_s=10, what="being armed")
    for now in plane.stream(rate_hz=10, timeout_s=5):
        progress = plane.mission_progress
        if progress.item != item:
            item = progress.item
            print(f"item {item} of {progress.total}, mode {now.mode}")
        if now.is_armed is False:
            break
    else:
        # The plane flies on, and its own failsafe decides what it does; lost_link.py, started before, would send it home.
        sys.exit(
            f"nothing heard for 5 s; the last that was heard: item {item}, {now.position.point if now.position else None}"
        )
print("flown to its end" if progress.is_complete else "disarmed before its end")

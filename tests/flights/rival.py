"""Another ground station, by pymavlink: loads a mission as the mission protocol has it."""

from __future__ import annotations

from pymavlink import mavutil
from vencejo import MissionItem, Plan

from tests.support import HOME


def load_with_pymavlink(rival: mavutil.mavfile, plan: Plan) -> None:
    """Send a plan's mission; item 0 is home."""
    items = [MissionItem.waypoint(*HOME[:2], alt_rel_home_m=0.0), *plan.items]
    rival.mav.mission_count_send(1, 1, len(items), 0)
    while True:
        request = rival.recv_match(
            type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=60
        )
        assert request is not None, "the plane stopped asking for items"
        if request.get_type() == "MISSION_ACK":
            if request.type == mavutil.mavlink.MAV_MISSION_INVALID_SEQUENCE:
                # An item came twice. The plane asks again after a second of its own, which is short when it flies fast.
                continue
            assert request.type == mavutil.mavlink.MAV_MISSION_ACCEPTED
            return
        item = items[request.seq]
        p1, p2, p3, p4, x, y, z = (value or 0.0 for value in item.params)
        frame = 3 if item.has_position else 2
        scale = 1e7 if item.has_position else 1
        rival.mav.mission_item_int_send(
            1, 1, request.seq, frame, item.command, 0, 1, p1, p2, p3, p4, round(x * scale), round(y * scale), z, 0
        )

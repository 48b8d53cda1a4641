"""RTL: return to launch."""

from __future__ import annotations

from vencejo.sim.autopilot.interface import Mode

from .base import Controls, FlightMode

__all__ = ["MODES"]

_TERRAIN_BIT = 4
"""Bit of TERRAIN_FOLLOW."""


class RtlMode(FlightMode):
    """Returns to home or the nearest rally point, circles there, and lands by RTL_AUTOLAND."""

    number = Mode.RTL
    auto_throttle = True
    navigates = True

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self._asked_for_landing = False

    def enter(self) -> None:
        plane = self._plane
        nav = self._nav
        self._asked_for_landing = False
        spot = plane.return_spot()
        ground_m = plane.ground_rel_home_m(spot) if plane.follows_terrain(_TERRAIN_BIT) else None
        if ground_m is not None:
            spot.alt_m, spot.follows_ground = spot.alt_m - ground_m, True
        nav.set_guided(spot)
        nav.next_crosstrack = False
        radius = plane.tune["RTL_RADIUS"]
        nav.loiter.clockwise = (radius if radius != 0 else plane.tune["WP_LOITER_RAD"]) >= 0

    def navigate(self) -> None:
        plane = self._plane
        nav = self._nav
        radius = plane.tune["RTL_RADIUS"]
        if radius != 0:
            nav.loiter.clockwise = radius > 0
        nav.fly_circle(abs(radius))
        if self._asked_for_landing:
            return
        autoland = int(plane.tune["RTL_AUTOLAND"])
        there = nav.on_circle and abs(plane.here().alt_m - nav.target_alt_m) < 10.0
        if autoland == 2 or (autoland == 1 and there):
            self._asked_for_landing = True
            if self._mission.jump_to_landing(plane.distance_to_item):
                self._enter_auto_to_land()
        elif autoland == 4:
            self._asked_for_landing = True
            if self._mission.jump_to_return_path(plane.distance_to_item):
                self._enter_auto_to_land()

    def update(self) -> None:
        self._energy.order()


MODES = (RtlMode,)

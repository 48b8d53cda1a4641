"""AUTOLAND: lands at home by itself, in the direction of the take-off (mode_autoland.cpp, ArduPlane 4.8)."""

from __future__ import annotations

import math
from enum import Enum

from vencejo.sim.autopilot.auto.names import Cmd
from vencejo.sim.autopilot.geo import Spot, bearing_rad, wrap_pi
from vencejo.sim.autopilot.interface import Mode, StoredItem
from vencejo.sim.autopilot.landing import Stage

from .base import Controls, FlightMode

__all__ = ["MODES"]

_TERRAIN_BIT = 12
"""Bit of TERRAIN_FOLLOW."""
_CLIMB_MARGIN_M = 10.0
"""Added to the target of the first climb, so that it is exceeded (fast_climb_extra_alt)."""


class _Leg(Enum):
    CLIMB = 0
    CIRCLE = 1
    LAND = 2


class AutolandMode(FlightMode):
    """A circle on the base leg down to AUTOLAND_WP_ALT, then the final from AUTOLAND_WP_DIST before home."""

    number = Mode.AUTOLAND
    auto_throttle = True
    navigates = True

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self._leg = _Leg.CIRCLE
        self._centre = self._final = Spot(0.0, 0.0, 0.0)
        self._radius_m = 0.0

    def refusal(self) -> str | None:
        if not self._plane.is_flying:
            return "Must already be flying!"
        return None if self._plane.takeoff_course_rad is not None else "Takeoff initial direction not set"

    def enter(self) -> None:
        plane, nav, tune = self._plane, self._nav, self._plane.tune
        course_rad = plane.takeoff_course_rad or 0.0
        self._final = plane.home.moved(course_rad, -tune["AUTOLAND_WP_DIST"])
        self._final.alt_m = plane.home.alt_m + tune["AUTOLAND_WP_ALT"]
        here = plane.here()
        is_left = wrap_pi(course_rad - bearing_rad(self._final, here)) > 0.0
        self._radius_m = min(tune["AUTOLAND_WP_DIST"] * 0.333, abs(tune["WP_LOITER_RAD"]))
        side_rad = -math.pi / 2 if is_left else math.pi / 2
        self._centre = self._final.moved(course_rad + side_rad, self._radius_m * plane.est.eas_to_tas**2)
        self._centre.anticlockwise = is_left
        nav.next_crosstrack = True
        follows = plane.follows_terrain(_TERRAIN_BIT)
        self._centre.follows_ground = follows
        ground_m = (plane.ground_rel_home_m() or 0.0) if follows else 0.0
        missing_m = tune["AUTOLAND_CLIMB"] + ground_m - plane.alt_rel_home_m
        climbs = tune["AUTOLAND_CLIMB"] > 0 and missing_m > 0.0
        self._leg = _Leg.CLIMB if climbs else _Leg.CIRCLE
        first = self._centre.copy()
        if climbs:
            first.alt_m, first.follows_ground = here.alt_m + missing_m + _CLIMB_MARGIN_M, False
        self._fly_to(first)

    def leave(self) -> None:
        self._landing.end()

    def _fly_to(self, centre: Spot) -> None:
        self._nav.set_next(centre)
        self._nav.loiter.clockwise = not centre.anticlockwise

    def navigate(self) -> None:
        nav = self._nav
        if self._leg is _Leg.LAND:
            self._landing.verify()
            return
        nav.fly_circle(self._radius_m)
        if self._leg is _Leg.CLIMB:
            if nav.on_circle or nav.above_next_m > -_CLIMB_MARGIN_M:
                self._leg = _Leg.CIRCLE
                nav.next_crosstrack = True
                self._fly_to(self._centre)
        elif self._commands.loiter_to_alt_is_done(self._plane.home):
            self._leg = _Leg.LAND
            # NAV_LAND at home, on the line from the final approach point.
            home = self._plane.home
            lat_deg, lon_deg = self._plane.frame.to_earth(home.n_m, home.e_m)
            self._landing.begin(StoredItem(0, Cmd.NAV_LAND, 0, 0.0, 0.0, 0.0, 0.0, lat_deg, lon_deg, home.alt_m))
            nav.previous, nav.crosstrack = self._final, True

    def update(self) -> None:
        if self._landing.active and self._landing.stage is not Stage.NORMAL:
            self._landing.order()
        else:
            self._energy.order()

    def bank_max_deg(self, limit_deg: float) -> float:
        return min(limit_deg, self._plane.tune["LEVEL_ROLL_LIMIT"]) if self._leg is _Leg.CLIMB else limit_deg

    def adjust_altitude(self) -> None:
        if not self._landing.adjust_altitude():
            self._nav.adjust_altitude()


MODES = (AutolandMode,)

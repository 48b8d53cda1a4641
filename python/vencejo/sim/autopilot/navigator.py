"""Guidance: the leg or circle being flown, the target altitude, and the count of loiter turns.

It owns the geometry between missions or modes and the control laws. Distances are metres in the tangent plane,
altitudes above mean sea level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .auto.mission import MissionRunner
from .geo import Spot, bearing_rad, distance_m, wrap_pi
from .interface import Mode
from .plane import Plane

__all__ = ["Loiter", "Navigator"]

_HEADING_TOLERANCE_RAD = math.radians(10.0)
_LOOK_S = 0.5
_LOOKS_AHEAD_M = 10_000.0
"""Upper limit of the terrain look-ahead: the end of TERRAIN_LOOKAHD's range."""
_ALONG_THE_LEG_RADII = 3.0
"""Distance in radii beyond which a mission's circle is approached along the leg to it."""


@dataclass(slots=True)
class Loiter:
    """A circle being flown."""

    clockwise: bool = True
    radius_m: float = 0.0
    """Demanded radius, at sea level."""
    turned_rad: float = 0.0
    """Angle flown since the circle was reached."""
    ordered: bool = False
    """Whether the control laws fly this circle, not an earlier one nor the leg to it."""
    counting: bool = False
    last_bearing_rad: float = 0.0
    started_s: float | None = None
    total_rad: float = 0.0
    duration_s: float = 0.0
    goal_met: bool = False
    """Turns, time or altitude are reached; only the exit heading is missing."""
    reached_alt: bool = False
    stuck: bool = False
    next_lap_check_rad: float = 0.0
    lap_alt_m: float = 0.0


class Navigator:
    """Legs, circles and target altitude of one plane."""

    def __init__(self, plane: Plane, mission: MissionRunner) -> None:
        self._plane = plane
        self._mission = mission
        here = plane.here()
        self.previous = here
        self.next = here.copy()
        self.crosstrack = False
        self.next_crosstrack = True
        self.distance = 0.0
        self.proportion = 0.0
        self.turn_angle_deg = 90.0
        self.loiter = Loiter()
        self._circled: Spot | None = None
        """Centre of the circle last set in the control laws; None for a leg."""
        self.hold_course_rad: float | None = None
        self.is_landing = False
        """Whether the leg belongs to a landing, whose slope is flown however small it is."""
        self.target_alt_m = here.alt_m
        self._offset_m = 0.0
        """Altitude difference along a sloped leg; 0 when the target altitude is that of the end."""
        self._follows = False
        """Whether the target altitude counts from the terrain below."""
        self._rise_m = 0.0
        """Climb added for rising terrain ahead."""
        self._looked_s = -math.inf

    # targets

    def set_next(self, spot: Spot) -> None:
        """Fly to the next waypoint of a mission, along the leg from the last one."""
        here = self._plane.here()
        if self.next_crosstrack:
            self.previous = self.next
            self.crosstrack = True
        else:
            self.previous = here
            self.next_crosstrack = True
            self.crosstrack = False
        self.next = spot
        if self.passed(self.previous, self.next):
            self.previous = here
        self.reset_loiter()
        self.update_distance()
        self._set_up_slope(mission=self._plane.in_auto)
        self._set_up_turn()
        self.adjust_altitude()

    def set_guided(self, spot: Spot) -> None:
        """Fly straight to a point outside a mission."""
        here = self._plane.here()
        self.previous = here
        self.next = spot
        self.crosstrack = False
        self.loiter.clockwise = not (self._plane.tune["WP_LOITER_RAD"] < 0 or spot.anticlockwise)
        self.target_alt_m = here.alt_m
        self.reset_loiter()
        self.update_distance()
        self._set_up_slope(mission=False)
        self._set_up_turn()

    def stay(self) -> None:
        """Make the present position the next point."""
        self.previous = self._plane.here()
        self.next = self.previous.copy()

    def reset_loiter(self) -> None:
        """Reset the loiter, for a new target."""
        clockwise, radius = self.loiter.clockwise, self.loiter.radius_m
        self.loiter = Loiter(clockwise=clockwise, radius_m=radius)

    def change_altitude(self, alt_m: float, *, follows_ground: bool) -> None:
        """Change the altitude of the next point, to be reached without a slope."""
        self.next = self.next.copy()
        self.next.alt_m, self.next.follows_ground = alt_m, follows_ground
        self.reset_slope()

    def reset_slope(self) -> None:
        """Fly to the target altitude without a slope."""
        self._offset_m = 0.0

    # geometry

    def update_distance(self) -> None:
        """Update the distance to go and the share of the leg flown; 10 times a second."""
        here = self._plane.here()
        self.distance = distance_m(here, self.next)
        self.proportion = self.proportion_of(self.previous, self.next)

    def proportion_of(self, start: Spot, end: Spot) -> float:
        """Share of a leg that is behind the plane: 0 at its start, 1 at its end."""
        here = self._plane.here()
        n, e = end.n_m - start.n_m, end.e_m - start.e_m
        square = n * n + e * e
        if square < 1e-6:
            return 1.0
        return ((here.n_m - start.n_m) * n + (here.e_m - start.e_m) * e) / square

    def passed(self, start: Spot, end: Spot) -> bool:
        """True beyond the finish line across the end of a leg."""
        return self.proportion_of(start, end) >= 1.0

    def turn_distance(self) -> float:
        """Distance before a waypoint at which the turn to the next leg begins.

        WP_RADIUS, at most the L1 length, and less for turns below 90°. ArduPlane scales WP_RADIUS by the square of true
        over equivalent airspeed (53 m for 50 m at 700 m AMSL); here it is not scaled.
        """
        plane = self._plane
        full = min(plane.tune["WP_RADIUS"], plane.l1_length_m())
        return full * min(1.0, abs(self.turn_angle_deg) / 90.0)

    def _set_up_turn(self) -> None:
        plane = self._plane
        current = self._mission.nav
        following = None if current is None else self._mission.next_nav(current.seq + 1)
        place = None if following is None else plane.spot_of(following, or_none=True)
        if place is None or not plane.in_auto:
            self.turn_angle_deg = 90.0
            return
        now = bearing_rad(self.previous, self.next)
        self.turn_angle_deg = math.degrees(wrap_pi(bearing_rad(self.next, place) - now))

    # altitudes

    def _set_up_slope(self, *, mission: bool) -> None:
        """Choose between a slope along the leg and an immediate change of altitude.

        As ArduPlane: a mission slopes above 20 m or when it descends, other modes only when they descend; differences
        below ALT_SLOPE_MIN are flown immediately.
        """
        here = self._plane.here()
        descends = self.above_next_m > 0.0
        if descends or (mission and here.alt_m - self._plane.home.alt_m > 20.0):
            # Between two heights above terrain the slope starts at the present one; otherwise the altitudes are
            # compared.
            on_ground = self.next.follows_ground and self._follows
            self._set_offset(-self.above_next_m if on_ground else self.next.alt_m - self.previous.alt_m)
        else:
            self._offset_m = 0.0

    def _set_offset(self, offset_m: float) -> None:
        self._offset_m = offset_m
        smallest = self._plane.tune["ALT_SLOPE_MIN"]
        if not self.is_landing and (smallest <= 0 or abs(self._offset_m) < smallest):
            self._offset_m = 0.0

    def adjust_altitude(self) -> None:
        """Set the present target altitude."""
        if self._offset_m == 0.0 or self.on_circle or self.passed(self.previous, self.next):
            self._aim(self.next.alt_m)
            return
        self.set_proportion(self.next, self._offset_m, 1.0 - self.proportion)
        here = self._plane.here()
        highest = self._plane.tune["ALT_SLOPE_MAXHGT"]
        target_m = self.target_alt_m
        if highest > 0 and self._offset_m > 0 and here.alt_m > target_m + highest:
            # Far above a climbing slope (after the zoom of a take-off): start a new one here.
            from_m = self.next.alt_m + self.above_next_m
            self.previous = Spot(self.previous.n_m, self.previous.e_m, from_m)
            self._set_offset(self.next.alt_m - from_m)
            self._aim(self.next.alt_m if self._offset_m == 0.0 else from_m)
        if not self._follows:
            low, high = sorted((self.previous.alt_m, self.next.alt_m))
            self.target_alt_m = min(high, max(low, self.target_alt_m))

    def set_proportion(self, end: Spot, offset_m: float, part: float) -> None:
        """Set the target altitude where ``part`` of the offset remains to the end of a slope."""
        self._aim(end.alt_m - offset_m * min(1.0, max(0.0, part)))

    def _aim(self, alt_m: float) -> None:
        """Set a target altitude; one above terrain counts from home where terrain is unknown, as in ArduPlane."""
        ground_m = self._plane.ground_rel_home_m() if self.next.follows_ground else None
        self._follows = ground_m is not None
        self.target_alt_m = alt_m
        if ground_m is not None:
            self._look_ahead(ground_m)
            self.target_alt_m += ground_m + self._rise_m

    @property
    def next_alt_m(self) -> float:
        """Altitude of the next point above mean sea level; with terrain following over the terrain below."""
        ground_m = self._plane.ground_rel_home_m() if self.next.follows_ground else None
        return self.next.alt_m + (ground_m or 0.0)

    @property
    def above_next_m(self) -> float:
        """Height of the plane above the next point."""
        return self._plane.here().alt_m - self.next_alt_m

    def _look_ahead(self, ground_m: float) -> None:
        """Compute the climb for rising terrain ahead (Plane::lookahead_adjustment), twice a second."""
        plane = self._plane
        speed = plane.est.groundspeed_m_s
        if self.on_circle or speed < 1.0:
            self._rise_m = 0.0
            return
        if plane.time_s - self._looked_s < _LOOK_S:
            return
        self._looked_s = plane.time_s
        spacing_m = max(10.0, plane.tune["TERRAIN_SPACING"])
        climb = 0.5 * plane.tune["TECS_CLMB_MAX"] / speed
        here = plane.here()
        bearing = bearing_rad(here, self.next)
        rise_m, far_m = 0.0, 0.0
        while far_m < min(self.distance, plane.tune["TERRAIN_LOOKAHD"], _LOOKS_AHEAD_M):
            far_m += spacing_m
            ahead_m = plane.ground_rel_home_m(here.moved(bearing, far_m))
            if ahead_m is not None:
                rise_m = max(rise_m, ahead_m - ground_m - climb * far_m)
        self._rise_m = min(1000.0, max(0.0, rise_m + min(0.0, self._offset_m)))

    # demands on the control laws

    def fly_leg(self, start: Spot, end: Spot) -> None:
        """Fly along a leg."""
        self._circled = None
        self._plane.pilot.fly_leg(from_north_m=start.n_m, from_east_m=start.e_m, to_north_m=end.n_m, to_east_m=end.e_m)

    def fly_circle(self, radius_m: float = 0.0) -> None:
        """Circle around the next point; a radius of at most 1 m means WP_LOITER_RAD."""
        plane = self._plane
        loiter = self.loiter
        if radius_m <= 1.0:
            default = plane.tune["WP_LOITER_RAD"]
            radius_m = abs(default) if abs(default) > 1.0 else 60.0
            loiter.clockwise = not (self.next.anticlockwise or default < 0)
        loiter.radius_m = radius_m
        never_there = loiter.started_s is None and plane.in_auto and self.crosstrack
        if never_there and distance_m(plane.here(), self.next) > _ALONG_THE_LEG_RADII * self.circle_radius_m:
            # ArduPlane's update_loiter_update_nav: a distant circle is approached along its leg.
            self.fly_leg(self.previous, self.next)
        else:
            # The radius grows with true airspeed: the same bank needs a wider circle in thin air.
            plane.pilot.fly_circle(
                north_m=self.next.n_m,
                east_m=self.next.e_m,
                radius_m=self.circle_radius_m,
                clockwise=loiter.clockwise,
            )
            self._circled = self.next
            loiter.ordered = True
        if loiter.started_s is None and (self.on_circle or self.proportion > 1.0):
            loiter.started_s = plane.time_s
            if plane.flight_mode is Mode.GUIDED:
                plane.item_reached(0)

    @property
    def on_circle(self) -> bool:
        """True on the circle around the next point, not on the approach to it."""
        return self.loiter.ordered and self._plane.pilot.on_circle

    @property
    def circle_radius_m(self) -> float:
        """Radius over ground of the circle being flown."""
        return self.loiter.radius_m * self._plane.est.eas_to_tas**2

    def count_turns(self) -> None:
        """Sum up the angle flown on the circle, and check its altitude; 10 times a second.

        As ArduPlane's ``loiter_angle_update`` it uses the last guidance: a circle directly after another counts from
        its first moment, starting at the bearing of the previous centre.
        """
        plane, loiter = self._plane, self.loiter
        here = plane.here()
        bearing = bearing_rad(here, self.next if self._circled is None else self._circled)
        is_on = self._circled is not None and plane.pilot.on_circle
        if not loiter.counting:
            if is_on:
                loiter.counting = True
                loiter.turned_rad = 1e-4
                loiter.lap_alt_m = here.alt_m
                loiter.next_lap_check_rad = 3.0 * math.tau
        else:
            delta = wrap_pi(bearing - loiter.last_bearing_rad)
            loiter.turned_rad += delta if loiter.clockwise else -delta
        loiter.last_bearing_rad = bearing
        # Compared with the altitude of the circle, as in ArduPlane; the target altitude may still be on the slope to
        # it.
        if is_on and abs(self.above_next_m) < 5.0:
            loiter.reached_alt = True
            loiter.stuck = False
        elif not loiter.reached_alt and abs(loiter.turned_rad) >= loiter.next_lap_check_rad > 0.0:
            loiter.stuck = abs(here.alt_m - loiter.lap_alt_m) < 5.0
            loiter.lap_alt_m = here.alt_m
            loiter.next_lap_check_rad += 3.0 * math.tau

    def lined_up(self, target: Spot | None) -> bool:
        """True when the circle may be left towards ``target``.

        The tangent must point there within 10°, and 10° more for each turn flown meanwhile, so that no wind keeps the
        plane circling.
        """
        if target is None:
            return True
        here = self._plane.here()
        radius = self.circle_radius_m
        if radius <= 0.0:
            return True
        side = 1.0 if self.loiter.clockwise else -1.0
        from_centre = bearing_rad(self.next, here)
        on_circle = self.next.moved(from_centre, radius)
        distance = distance_m(self.next, target)
        if distance <= 0.0:
            return True
        if distance >= radius:
            wanted = bearing_rad(on_circle, target)
        else:
            # A target inside the circle never lines up: leave where the chord is shortest.
            chord = 2.0 * math.asin((radius - distance) / (2.0 * radius))
            wanted = bearing_rad(self.next, target) + (math.pi / 2 - chord) * side
        heading = from_centre + math.pi / 2 * side
        tolerance = _HEADING_TOLERANCE_RAD * (1 + int(abs(self.loiter.turned_rad) / math.tau))
        if abs(wrap_pi(wanted - heading)) > tolerance:
            return False
        if self.next.exit_tangent:
            self.next = here
        return True

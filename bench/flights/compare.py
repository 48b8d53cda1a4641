"""Differences between a rehearsal and the flight: cross-track, in altitude and in time, for each kind of leg.

A flown position is compared with the nearest point of the rehearsed track during the same visit to the same mission
item, or within `BESIDE_S` of it, so that neither another pass over the position nor a late plane counts as a position
error; lateness is measured by the times at which items are completed. Where several passes are about equally near, such
as the turns of a circle, the altitude of the pass nearest in time counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from vencejo import Command, MissionItem
from vencejo.sim.autopilot.geo import LocalFrame

from bench.flights.track import Array, Flight, Track, Visit

#: In the order of the table.
KINDS = ("take-off", "straight", "turn", "circle", "climb", "landing")
#: Time before and after a visit in which the nearest rehearsed point may lie, s: a turn spans two visits.
BESIDE_S = 5.0
#: Excess distance of another pass over the nearest one up to which its altitude may be used, m.
AS_NEAR_M = 5.0
#: Duration below which an item is passed by rather than flown, such as a circle up to an altitude that the plane
#: already has.
PASSED_BY_S = 1.0
#: Bank angle above which a plane turns rather than corrects its course, degrees.
TURNING_DEG = 12.0
#: Vertical speed above which a plane climbs or descends rather than holds its altitude, m/s, averaged over
#: `CLIMB_OVER_S`.
CLIMBING_M_S = 0.7
CLIMB_OVER_S = 2.0
#: Distance from a circle's centre, in radii, below which a plane is on the circle rather than approaching it.
ON_CIRCLE = 1.5
_CIRCLES = {
    Command.NAV_LOITER_UNLIM: 2,
    Command.NAV_LOITER_TURNS: 2,
    Command.NAV_LOITER_TO_ALT: 1,
}
"""Items flown as circles, with the parameter that contains the radius."""
_OF_WP_LOITER_RAD = (Command.NAV_LOITER_TIME, Command.NAV_RETURN_TO_LAUNCH)


@dataclass(frozen=True)
class Arrival:
    """Completion of an item, seconds since the take-off roll began; of a landing, its touchdown."""

    item: int
    kind: str
    flown_s: float
    rehearsed_s: float | None
    """``None`` when the rehearsal does not complete it."""

    @property
    def late_s(self) -> float | None:
        """Return how much later the rehearsal completes it."""
        return None if self.rehearsed_s is None else self.rehearsed_s - self.flown_s


@dataclass(frozen=True)
class Comparison:
    """Differences between a flight and its rehearsal. Arrays have one value for each sample flown in the air."""

    name: str
    kind: npt.NDArray[np.int64]
    """Index into `KINDS`."""
    cross_m: Array
    height_m: Array
    """Rehearsed minus flown; NaN where there is nothing to compare with, as in ``cross_m``."""
    seconds_a_sample: float
    arrivals: tuple[Arrival, ...]
    touchdown_m: float | None
    """Distance between the rehearsed and the flown touchdown; ``None`` when one is missing."""
    rest_m: float | None
    """Distance between the final positions."""


@dataclass(frozen=True)
class Figures:
    """RMS and maximum for one kind of leg over one or more flights."""

    seconds: float
    not_compared_s: float
    """Flown time without counterpart in the rehearsal."""
    cross_rms_m: float
    cross_worst_m: float
    height_rms_m: float
    height_worst_m: float
    arrivals: int
    missed: int
    """Items completed in the flight but not in the rehearsal."""
    time_rms_percent: float
    """Percent of the time since take-off."""
    time_worst_percent: float
    time_worst_s: float


def compare(flight: Flight, rehearsed: Track) -> Comparison:
    """Compare a flight with its rehearsal."""
    flown = flight.track
    last = int(flown.item[-1])
    land = last if last and flight.plan.items[last - 1].command == Command.NAV_LAND else None
    down, rehearsed_down = flown.touchdown(land), rehearsed.touchdown(land)
    in_air = flown if down is None else flown.part(0, down + 1)
    visits = in_air.visits()
    kind = _kinds(flight, in_air, visits)
    cross_m, height_m = _offsets(in_air, rehearsed, visits)
    arrivals = list(_arrivals(flight, rehearsed, visits, kind))
    touchdown_m = rest_m = None
    if down is not None and land is not None:
        landed_s = None if rehearsed_down is None else float(rehearsed.time_s[rehearsed_down])
        arrivals.append(Arrival(land, "landing", float(flown.time_s[down]), landed_s))
        if rehearsed_down is not None:
            touchdown_m = _apart_m(flown, down, rehearsed, rehearsed_down)
            rest_m = _apart_m(flown, -1, rehearsed, -1)
    return Comparison(
        name=flight.name,
        kind=kind,
        cross_m=cross_m,
        height_m=height_m,
        seconds_a_sample=float(np.median(np.diff(flown.time_s))),
        arrivals=tuple(arrivals),
        touchdown_m=touchdown_m,
        rest_m=rest_m,
    )


def figures(comparisons: Iterable[Comparison], kind: str | None = None) -> Figures | None:
    """Combine comparisons for one kind of leg or all; ``None`` when there are no samples of that kind."""
    cross, height, arrivals = [np.zeros(0)], [np.zeros(0)], []
    seconds = not_compared_s = 0.0
    for one in comparisons:
        wanted = np.full(len(one.kind), True) if kind is None else one.kind == KINDS.index(kind)
        known = wanted & ~np.isnan(one.cross_m)
        cross.append(one.cross_m[known])
        height.append(one.height_m[known])
        seconds += float(np.count_nonzero(wanted)) * one.seconds_a_sample
        not_compared_s += float(np.count_nonzero(wanted & ~known)) * one.seconds_a_sample
        arrivals += [arrival for arrival in one.arrivals if kind in (None, arrival.kind)]
    if not seconds and not arrivals:
        return None
    late = [(arrival.late_s, arrival.flown_s) for arrival in arrivals if arrival.late_s is not None]
    late_s = np.array([abs(by_s) for by_s, _ in late])
    percent = np.array([100.0 * abs(by_s) / max(flown_s, 1.0) for by_s, flown_s in late])
    cross_m, height_m = np.concatenate(cross), np.concatenate(height)
    return Figures(
        seconds=seconds,
        not_compared_s=not_compared_s,
        cross_rms_m=_rms(cross_m),
        cross_worst_m=_worst(cross_m),
        height_rms_m=_rms(height_m),
        height_worst_m=_worst(height_m),
        arrivals=len(arrivals),
        missed=len(arrivals) - len(late),
        time_rms_percent=_rms(percent),
        time_worst_percent=_worst(percent),
        time_worst_s=_worst(late_s),
    )


def _rms(values: Array) -> float:
    return math.sqrt(float(np.mean(values**2))) if len(values) else 0.0


def _worst(values: Array) -> float:
    return float(np.max(np.abs(values))) if len(values) else 0.0


def _apart_m(a: Track, at_a: int, b: Track, at_b: int) -> float:
    return math.hypot(a.north_m[at_a] - b.north_m[at_b], a.east_m[at_a] - b.east_m[at_b])


def _offsets(flown: Track, rehearsed: Track, visits: list[Visit]) -> tuple[Array, Array]:
    """Return the distance from the rehearsed track, and rehearsed minus flown altitude, for each flown sample."""
    cross, height = np.full(len(flown.time_s), np.nan), np.full(len(flown.time_s), np.nan)
    others = {(visit.item, visit.nth): visit for visit in rehearsed.visits()}
    for visit in visits:
        other = others.get((visit.item, visit.nth))
        if other is None:
            continue
        began_s, ended_s = float(rehearsed.time_s[other.begin]), float(rehearsed.time_s[other.end - 1])
        beside = rehearsed.part(*np.searchsorted(rehearsed.time_s, [began_s - BESIDE_S, ended_s + BESIDE_S]))
        if len(beside.time_s) < 2:
            continue
        for at in range(visit.begin, visit.end):
            around_s = began_s + float(flown.time_s[at] - flown.time_s[visit.begin])
            cross[at], alt_m = _nearest(beside, float(flown.north_m[at]), float(flown.east_m[at]), around_s)
            height[at] = alt_m - flown.alt_m[at]
    return cross, height


def _nearest(track: Track, north_m: float, east_m: float, around_s: float) -> tuple[float, float]:
    """Return the distance to a track, and its altitude there; of equally near passes, at the one nearest in time."""
    north, east, alt = track.north_m, track.east_m, track.alt_m
    step_n, step_e = np.diff(north), np.diff(east)
    square = np.maximum(step_n**2 + step_e**2, 1e-12)
    part = np.clip(((north_m - north[:-1]) * step_n + (east_m - east[:-1]) * step_e) / square, 0.0, 1.0)
    away = np.hypot(north[:-1] + part * step_n - north_m, east[:-1] + part * step_e - east_m)
    near = np.flatnonzero(away <= np.min(away) + AS_NEAR_M)
    passes = np.split(near, np.flatnonzero(np.diff(near) > 1) + 1)
    bests = [int(one[np.argmin(away[one])]) for one in passes]
    soonest = min(bests, key=lambda at: abs(float(track.time_s[at]) - around_s))
    return float(np.min(away)), float(alt[soonest] + part[soonest] * (alt[soonest + 1] - alt[soonest]))


def _kinds(flight: Flight, flown: Track, visits: list[Visit]) -> npt.NDArray[np.int64]:
    """Classify each sample by the kind of leg flown."""
    rate_hz = 1.0 / float(np.median(np.diff(flown.time_s)))
    over = max(1, round(CLIMB_OVER_S * rate_hz))
    climb = np.abs(np.convolve(flown.climb_m_s, np.full(over, 1.0 / over), mode="same"))
    turning = np.abs(flown.bank_deg) > TURNING_DEG
    names = np.where(turning, KINDS.index("turn"), KINDS.index("straight"))
    names = np.where(~turning & (climb > CLIMBING_M_S), KINDS.index("climb"), names)
    for visit in visits:
        span = slice(visit.begin, visit.end)
        item = flight.plan.items[visit.item - 1] if visit.item else None
        if item is None or item.command == Command.NAV_TAKEOFF:
            names[span] = KINDS.index("take-off")
        elif item.command == Command.NAV_LAND:
            names[span] = KINDS.index("landing")
        elif item.command in _CIRCLES or item.command in _OF_WP_LOITER_RAD:
            names[visit.begin + _until_circle(flight, item, flown.part(visit.begin, visit.end)) : visit.end] = (
                KINDS.index("circle")
            )
    return names.astype(np.int64)


def _until_circle(flight: Flight, item: MissionItem, track: Track) -> int:
    """Return the number of samples until the circle is reached."""
    home = flight.plan.home
    assert home is not None, "a flight's plan has a home"
    at = (item.lat_deg, item.lon_deg)
    if item.command == Command.NAV_RETURN_TO_LAUNCH or at[0] is None or at[1] is None:
        at = (home.lat_deg, home.lon_deg)
    north_m, east_m = LocalFrame(home.lat_deg, home.lon_deg).to_plane(float(at[0] or 0.0), float(at[1] or 0.0))
    given = item.params[_CIRCLES[Command(item.command)]] if item.command in _CIRCLES else None
    radius_m = abs(given or flight.parameters.get("WP_LOITER_RAD", 80.0))
    near = np.hypot(track.north_m - north_m, track.east_m - east_m) < ON_CIRCLE * radius_m
    return int(np.argmax(near)) if near.any() else len(near)


def _arrivals(flight: Flight, rehearsed: Track, visits: list[Visit], kind: npt.NDArray[np.int64]) -> Iterator[Arrival]:
    """Yield the completion of each item, when the next becomes current; not the last, nor those passed by."""
    flown = flight.track
    ends_s = {(visit.item, visit.nth): float(rehearsed.time_s[visit.end]) for visit in rehearsed.visits()[:-1]}
    for visit in visits[:-1]:
        if flown.time_s[visit.end] - flown.time_s[visit.begin] < PASSED_BY_S:
            continue
        most = KINDS[int(np.bincount(kind[visit.begin : visit.end]).argmax())]
        yield Arrival(visit.item, most, float(flown.time_s[visit.end]), ends_s.get((visit.item, visit.nth)))

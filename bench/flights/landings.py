"""Designed landings of the simulated plane: the best on a random runway in a random wind, from a random position."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from vencejo import GeoPoint, MissionItem, Plan
from vencejo.geodesy import bearing_deg, destination, distance_m
from vencejo.landing import Runway, Wind, landing_alternatives
from vencejo.sim.params import ParamStore

from bench.flights.simulated import HOME, SETTINGS, STRONGEST_WIND_M_S, flight_of, parameters

LONGEST_RUNWAY_M = 400.0
SHORTEST_RUNWAY_M = 100.0


@dataclass(frozen=True)
class Landed:
    """Where a plane came to rest, relative to its landing point."""

    name: str
    wind: Wind
    headwind_m_s: float
    rest_m: float
    """Distance from the point."""
    beyond_m: float
    """Distance along the final leg, negative before the point."""
    rehearsed_m: float | None
    """The same according to the design."""


def land(seed: int) -> Landed:
    """Fly the landing of a seed: any runway, any wind up to 8 m/s, from anywhere within 1,500 m; deterministic."""
    source = random.Random(f"landing {seed}")
    wind = Wind(source.uniform(0.0, 360.0), source.uniform(0.0, STRONGEST_WIND_M_S))
    home = GeoPoint(HOME.lat_deg, HOME.lon_deg)

    def away(bearing_deg: float, distance_m: float) -> GeoPoint:
        return destination(home, bearing_deg=bearing_deg, distance_m=distance_m)

    runway = Runway(home, away(source.uniform(0.0, 360.0), source.uniform(SHORTEST_RUNWAY_M, LONGEST_RUNWAY_M)))
    before, alt_m = away(source.uniform(0.0, 360.0), source.uniform(500.0, 1500.0)), source.uniform(60.0, 160.0)
    best, *_ = landing_alternatives(
        runway,
        coming_from=before,
        wind=wind,
        ground_rel_home_m=0.0,
        parameters=parameters(ParamStore.arduplane(SETTINGS)),
        home=HOME,
    )
    ahead = away(wind.from_deg, 300.0)
    items = (
        MissionItem.takeoff(ahead.lat_deg, ahead.lon_deg, alt_rel_home_m=50.0),
        MissionItem.waypoint(before.lat_deg, before.lon_deg, alt_rel_home_m=round(alt_m)),
        *best.landing.items,
    )
    flown = flight_of(f"landing {seed}", Plan(items=items, home=HOME), wind, heading_deg=wind.from_deg, seed=seed)
    *_, last = items
    assert last.lat_deg is not None, "a landing has a place"
    assert last.lon_deg is not None
    point, rest = GeoPoint(last.lat_deg, last.lon_deg), flown.rest
    off_m = distance_m(point, rest)
    turned = math.radians(bearing_deg(point, rest) - best.landing.course_deg)
    headwind_m_s = best.landing.headwind_m_s or 0.0
    return Landed(flown.flight.name, wind, headwind_m_s, off_m, off_m * math.cos(turned), best.rest_m)


def table(landed: Sequence[Landed]) -> str:
    """Format the worst of them, and all."""
    lines = [f"Landings as designed, flown by the simulated plane in {len(landed)} random winds"]
    for one in sorted(landed, key=lambda one: -one.rest_m)[:3]:
        side = "beyond" if one.beyond_m > 0 else "before"
        lines.append(
            f"{one.name}, {one.wind.speed_m_s:.1f} m/s, {one.headwind_m_s:.1f} ahead".ljust(38)
            + f"at rest {one.rest_m:.1f} m from the point, {abs(one.beyond_m):.1f} m {side} it"
        )
    rests = [one.rest_m for one in landed]
    lines.append(f"  all: at rest median {median(rests):.1f} m, worst {max(rests):.1f} m from the point")
    return "\n".join(lines)


def numbers(landed: Sequence[Landed]) -> dict[str, Any]:
    """Return the same as JSON."""
    rests = [one.rest_m for one in landed]
    flights = [
        {"name": one.name, "rest_m": one.rest_m, "beyond_m": one.beyond_m, "rehearsed_m": one.rehearsed_m}
        for one in landed
    ]
    return {"median_m": median(rests), "worst_m": max(rests), "flights": flights}

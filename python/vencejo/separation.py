"""Separation: conflicts between planned flights, found before they are flown.

Conflicts are reported only; no flight is changed.

Examples
--------
>>> from vencejo import Home, MissionItem, Plan
>>> from vencejo.rehearsal import rehearse
>>> from vencejo.separation import conflicts
>>> home = Home(40.3332, -3.7978, alt_amsl_m=600.0)
>>> takeoff = MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=50.0)
>>> out = MissionItem.waypoint(40.3432, -3.7978, alt_rel_home_m=80.0)
>>> flown = rehearse(Plan(home=home, items=(takeoff, out, MissionItem.return_to_launch())))
>>> [(found.flights, found.horizontal_m) for found in conflicts([flown, flown])][0]
((0, 1), 0.0)
>>> conflicts([flown, flown], starts_s=[0.0, 3600.0])
()
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vencejo import _native
from vencejo.errors import InvalidRequest
from vencejo.rehearsal import Rehearsal

__all__ = ["Conflict", "ConflictPlace", "conflicts"]


@dataclass(frozen=True, slots=True)
class ConflictPlace:
    """Position of a flight at a moment.

    Attributes
    ----------
    time_s : float
        Time on the clock of ``starts_s``, seconds.
    lat_deg, lon_deg : float
    alt_amsl_m : float
        Altitude above mean sea level.
    """

    time_s: float
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


@dataclass(frozen=True, slots=True)
class Conflict:
    """Two flights that come too near to each other.

    Attributes
    ----------
    flights : tuple of int
        Indices of the two, the lower first.
    begins_s, ends_s : float
        When the first begins and ceases to be too near to the other.
    nearest : tuple of ConflictPlace
        Positions of both at their least distance over ground.
    horizontal_m, vertical_m : float
        Distance over ground and difference in height there.
    """

    flights: tuple[int, int]
    begins_s: float
    ends_s: float
    nearest: tuple[ConflictPlace, ConflictPlace]
    horizontal_m: float
    vertical_m: float


def conflicts(
    flights: Sequence[Rehearsal],
    *,
    starts_s: Sequence[float] | None = None,
    horizontal_m: float = 100.0,
    vertical_m: float = 30.0,
    window_s: float = 10.0,
) -> tuple[Conflict, ...]:
    """Find conflicts between rehearsed flights, the earliest first.

    A pair that comes near, parts and comes near again gives a conflict each time.

    Parameters
    ----------
    flights : sequence of Rehearsal
    starts_s : sequence of float, optional
        When each starts, seconds on a common clock; all at 0 by default.
    horizontal_m : float, optional
        Distance over ground below which they are too near, 1 to 10,000.
    vertical_m : float, optional
        Difference in height below which they are too near, 1 to 10,000.
    window_s : float, optional
        How much earlier or later one may be, against another, than its rehearsal says, 0 to 3,600.

    Raises
    ------
    InvalidRequest
        For limits out of range, and for another number of starts than of flights.
    """
    starts = [0.0] * len(flights) if starts_s is None else [float(start) for start in starts_s]
    if len(starts) != len(flights):
        raise InvalidRequest(f"{len(flights)} flights have {len(starts)} starts; give each its own")
    tracks = [
        [(start + moment.time_s, moment.lat_deg, moment.lon_deg, moment.alt_amsl_m) for moment in flight.track]
        for flight, start in zip(flights, starts, strict=True)
    ]
    found = _native.separation_conflicts(tracks, horizontal_m=horizontal_m, vertical_m=vertical_m, window_s=window_s)
    return tuple(
        Conflict(pair, begins_s, ends_s, (ConflictPlace(*nearest[0]), ConflictPlace(*nearest[1])), across_m, up_m)
        for pair, begins_s, ends_s, nearest, across_m, up_m in found
    )

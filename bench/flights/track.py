"""Track of a flight, flown or rehearsed, in metres from home, with times since the beginning of the take-off roll."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from vencejo import Home, Plan
from vencejo.landing import Wind
from vencejo.rehearsal import Airframe
from vencejo.sim.autopilot.geo import LocalFrame

Array: TypeAlias = npt.NDArray[np.float64]

#: Ground speed that shows that the take-off roll has begun, m/s: gusts do not move a standing plane this fast.
ROLLING_M_S = 3.0
#: Distance over which the course of a take-off roll is measured, m.
ROLL_M = 20.0
#: Vertical speed below which a plane is on the ground, m/s; a flare ends with more.
STANDS_M_S = 0.25


class Sample(NamedTuple):
    """State of a plane at a time."""

    time_s: float
    lat_deg: float
    lon_deg: float
    alt_rel_home_m: float
    climb_m_s: float
    groundspeed_m_s: float
    bank_deg: float
    item: int
    """Current mission item, counted from 1; 0 before the first."""


@dataclass(frozen=True)
class Visit:
    """One visit to an item."""

    item: int
    nth: int
    """Number of the visit, from 0: a jump leads to further ones."""
    begin: int
    end: int
    """Range of its samples: ``track[begin:end]``."""


@dataclass(frozen=True)
class Track:
    """Samples as arrays, in order of time."""

    time_s: Array
    north_m: Array
    east_m: Array
    alt_m: Array
    climb_m_s: Array
    groundspeed_m_s: Array
    bank_deg: Array
    item: npt.NDArray[np.int64]

    @classmethod
    def of(cls, samples: list[Sample], *, home: Home, name: str) -> Track:
        """Return the track of a flight from the beginning of its take-off roll; ``name`` identifies it in errors."""
        columns = np.array(samples, dtype=np.float64).reshape(-1, len(Sample._fields)).T
        time_s, lat_deg, lon_deg, alt_m, climb_m_s, groundspeed_m_s, bank_deg, item = columns
        rolling = np.flatnonzero(groundspeed_m_s > ROLLING_M_S)
        if not len(rolling):
            raise ValueError(f"{name}: the plane never moves")
        frame = LocalFrame(home.lat_deg, home.lon_deg)
        places = [frame.to_plane(*place) for place in zip(lat_deg, lon_deg, strict=True)]
        north_m, east_m = np.array(places, dtype=np.float64).T
        # Between two samples, since a plane gains some metres per second within one interval.
        began = max(int(rolling[0]) - 1, 0)
        speeds, times = groundspeed_m_s[began : rolling[0] + 1], time_s[began : rolling[0] + 1]
        whole = cls(
            time_s=time_s - float(np.interp(ROLLING_M_S, speeds, times)),
            north_m=north_m,
            east_m=east_m,
            alt_m=alt_m,
            climb_m_s=climb_m_s,
            groundspeed_m_s=groundspeed_m_s,
            bank_deg=bank_deg,
            item=item.astype(np.int64),
        )
        return whole.part(int(rolling[0]), len(time_s))

    @property
    def takeoff_course_deg(self) -> float:
        """Return the course of the take-off roll, degrees from true north, 0 to 360, measured over `ROLL_M`."""
        north_m, east_m = self.north_m - self.north_m[0], self.east_m - self.east_m[0]
        at = int(np.argmax(np.hypot(north_m, east_m) >= ROLL_M))
        return math.degrees(math.atan2(east_m[at], north_m[at])) % 360.0

    def part(self, begin: int, end: int) -> Track:
        """Return a range of its samples."""
        return Track(**{field.name: getattr(self, field.name)[begin:end] for field in fields(self)})

    def visits(self) -> list[Visit]:
        """Return the visits to items in order."""
        borders = [0, *(np.flatnonzero(np.diff(self.item)) + 1).tolist(), len(self.item)]
        times: dict[int, int] = {}
        found = []
        for begin, end in itertools.pairwise(borders):
            item = int(self.item[begin])
            found.append(Visit(item, times.get(item, 0), begin, end))
            times[item] = times.get(item, 0) + 1
        return found

    def touchdown(self, land_item: int | None) -> int | None:
        """Return the sample of the final touchdown; ``None`` when the plane does not land at that item."""
        if land_item is None or int(self.item[-1]) != land_item:
            return None
        moving = np.flatnonzero(np.abs(self.climb_m_s) > STANDS_M_S)
        return min(int(moving[-1]) + 1, len(self.time_s) - 1) if len(moving) else None


@dataclass(frozen=True)
class Flight:
    """A flight, and the data for its rehearsal."""

    name: str
    plan: Plan
    """Includes home."""
    parameters: dict[str, float]
    wind: Wind
    track: Track
    airframe: Airframe | None = None
    """Additional knowledge of the plane beside its parameters."""

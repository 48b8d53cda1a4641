"""A flight's track, flown or rehearsed, in metres about home, its times counted from the moment at which the take-off roll begins."""

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

#: Ground speed that a plane has once its take-off roll has begun, m/s: no gust rocks one that stands so fast.
ROLLING_M_S = 3.0
#: Way over which a take-off roll shows its course, m.
ROLL_M = 20.0
#: Vertical speed that a plane on the ground does not have any more, m/s; a flare ends with more.
STANDS_M_S = 0.25


class Sample(NamedTuple):
    """Where a plane was."""

    time_s: float
    lat_deg: float
    lon_deg: float
    alt_rel_home_m: float
    climb_m_s: float
    groundspeed_m_s: float
    bank_deg: float
    item: int
    """Mission item being flown, counted from 1; 0 before the first."""


@dataclass(frozen=True)
class Visit:
    """One time that an item was flown."""

    item: int
    nth: int
    """Which time this is, from 0: a jump brings a plane back."""
    begin: int
    end: int
    """Its samples: ``track[begin:end]``."""


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
        """The track of a flight from the beginning of its take-off roll; ``name`` tells which, where it has none."""
        columns = np.array(samples, dtype=np.float64).reshape(-1, len(Sample._fields)).T
        time_s, lat_deg, lon_deg, alt_m, climb_m_s, groundspeed_m_s, bank_deg, item = columns
        rolling = np.flatnonzero(groundspeed_m_s > ROLLING_M_S)
        if not len(rolling):
            raise ValueError(f"{name}: the plane never moves")
        frame = LocalFrame(home.lat_deg, home.lon_deg)
        places = [frame.to_plane(*place) for place in zip(lat_deg, lon_deg, strict=True)]
        north_m, east_m = np.array(places, dtype=np.float64).T
        # Between two samples: a plane gains some metres a second from one to the next.
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
        """Course of the take-off roll, degrees from true north, 0 to 360: towards the first place `ROLL_M` from its beginning."""
        north_m, east_m = self.north_m - self.north_m[0], self.east_m - self.east_m[0]
        at = int(np.argmax(np.hypot(north_m, east_m) >= ROLL_M))
        return math.degrees(math.atan2(east_m[at], north_m[at])) % 360.0

    def part(self, begin: int, end: int) -> Track:
        """Some of its samples."""
        return Track(**{field.name: getattr(self, field.name)[begin:end] for field in fields(self)})

    def visits(self) -> list[Visit]:
        """Which item was flown when."""
        borders = [0, *(np.flatnonzero(np.diff(self.item)) + 1).tolist(), len(self.item)]
        times: dict[int, int] = {}
        found = []
        for begin, end in itertools.pairwise(borders):
            item = int(self.item[begin])
            found.append(Visit(item, times.get(item, 0), begin, end))
            times[item] = times.get(item, 0) + 1
        return found

    def touchdown(self, land_item: int | None) -> int | None:
        """Sample at which the plane stood on the ground for good; ``None`` when it does not land at that item."""
        if land_item is None or int(self.item[-1]) != land_item:
            return None
        moving = np.flatnonzero(np.abs(self.climb_m_s) > STANDS_M_S)
        return min(int(moving[-1]) + 1, len(self.time_s) - 1) if len(moving) else None


@dataclass(frozen=True)
class Flight:
    """A flight and all that a rehearsal of it is told."""

    name: str
    plan: Plan
    """With home."""
    parameters: dict[str, float]
    wind: Wind
    track: Track
    airframe: Airframe | None = None
    """What is known of the plane beside its parameters."""

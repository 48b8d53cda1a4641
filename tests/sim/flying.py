"""Flies the simulated plane without a link: missions of recordings, and whole flights in a second with their track."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from vencejo.sim.autopilot import Autopilot, SimConfig
from vencejo.sim.autopilot.geo import LocalFrame
from vencejo.sim.autopilot.interface import (
    Event,
    MavResult,
    MissionItemReached,
    Mode,
    RallyPoint,
    StatusText,
    StoredItem,
)
from vencejo.sim.autopilot.testing import FixedParameters, FixedPlan, home_item, item

CAPTURES = Path(__file__).resolve().parent.parent / "fixtures" / "captures"
HOME = (40.3332, -3.7978, 600.0)
FRAME = LocalFrame(HOME[0], HOME[1])
SETTLED_S = 22.0
"""Simulated seconds until the estimator is ready and a plane may be armed."""


@dataclass
class Flight:
    """One flight with its events and track."""

    plane: Autopilot
    params: FixedParameters
    plan: FixedPlan
    events: list[tuple[float, Event]] = field(default_factory=list)
    track: list[tuple[int, float, float, float]] = field(default_factory=list)
    """Current item, north, east, height above home: the true position ten times a second."""

    @property
    def texts(self) -> list[str]:
        return [event.text for _, event in self.events if isinstance(event, StatusText)]

    @property
    def reached(self) -> list[int]:
        return [event.seq for _, event in self.events if isinstance(event, MissionItemReached)]

    def position(self) -> tuple[float, float]:
        return FRAME.to_plane(self.plane.body.lat_deg, self.plane.body.lon_deg)

    def distance_to(self, lat_deg: float, lon_deg: float) -> float:
        north, east = FRAME.to_plane(lat_deg, lon_deg)
        here = self.position()
        return math.hypot(here[0] - north, here[1] - east)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> bool:
        """Fly on; True when ``until`` came true."""
        plane = self.plane
        for _ in range(round(seconds * 10)):
            for _ in range(10):
                plane.step()
            self.events.extend((plane.time_s, event) for event in plane.events())
            north, east = self.position()
            self.track.append((plane.mission.current_seq, north, east, plane.body.height_m))
            if until is not None and until():
                return True
        return False

    def saying(self, start: str) -> Callable[[], bool]:
        """Condition that a text was sent."""
        return lambda: self.said(start)

    def said(self, start: str) -> bool:
        return any(text.startswith(start) for text in self.texts)


def make(
    mission: Sequence[StoredItem] = (),
    *,
    params: Mapping[str, float] | None = None,
    rally: Sequence[RallyPoint] = (),
    settle: bool = True,
    **config: Any,
) -> Flight:
    """A plane on the ground, ready to be armed."""
    store, plan = FixedParameters(params), FixedPlan(mission, rally)
    flight = Flight(Autopilot(config=SimConfig(**config), params=store, plan=plan), store, plan)
    if settle:
        flight.run(SETTLED_S)
        flight.events.clear()
        flight.track.clear()
    return flight


def fly_mission(mission: Sequence[StoredItem], seconds: float = 1200.0, **options: Any) -> Flight:
    """Fly a mission from arming in AUTO until it disarms itself."""
    flight = make(mission, **options)
    assert flight.plane.set_mode(Mode.AUTO) is MavResult.ACCEPTED
    assert flight.plane.arm() is MavResult.ACCEPTED
    assert flight.run(seconds, lambda: not flight.plane.armed), flight.texts[-3:]
    return flight


def airborne(mission: Sequence[StoredItem] = (), **options: Any) -> Flight:
    """A plane that took off in mode TAKEOFF and circles at TKOFF_ALT."""
    flight = make(mission, **options)
    flight.plane.set_mode(Mode.TAKEOFF)
    assert flight.plane.arm() is MavResult.ACCEPTED
    assert flight.run(60.0, lambda: flight.plane.nav.on_circle), flight.texts
    flight.events.clear()
    return flight


_WANTED = {33: "GLOBAL_POSITION_INT", 42: "MISSION_CURRENT", 73: "MISSION_ITEM_INT", 253: "STATUSTEXT"}


@lru_cache
def recorded(name: str) -> tuple[Any, ...]:
    """The messages of a recording that these tests use, in order; other frames are not decoded."""
    from pymavlink.dialects.v20 import ardupilotmega

    data = (CAPTURES / name).read_bytes()
    decoder = ardupilotmega.MAVLink(None)
    messages, at_byte = [], 0
    while at_byte + 8 + 12 <= len(data):
        # Eight bytes of time, then a MAVLink 2 frame: marker, length, flags …, 24-bit id.
        frame = at_byte + 8
        assert data[frame] == 0xFD, f"{name}: no MAVLink 2 frame at byte {frame}"
        length = 12 + data[frame + 1] + (13 if data[frame + 2] & 1 else 0)
        if int.from_bytes(data[frame + 7 : frame + 10], "little") in _WANTED:
            messages.append(decoder.decode(bytearray(data[frame : frame + length])))
        at_byte = frame + length
    return tuple(messages)


def recorded_mission(name: str) -> list[StoredItem]:
    """The mission that a recording uploads."""
    items = {}
    for message in recorded(name):
        if message.get_type() == "MISSION_ITEM_INT" and message.get_srcSystem() == 255 and message.mission_type == 0:
            items[message.seq] = StoredItem(
                seq=message.seq,
                command=message.command,
                frame=message.frame,
                p1=message.param1,
                p2=message.param2,
                p3=message.param3,
                p4=message.param4,
                lat_deg=message.x / 1e7,
                lon_deg=message.y / 1e7,
                alt_m=message.z,
            )
    return [items[seq] for seq in sorted(items)]


def recorded_texts(name: str) -> list[str]:
    return [m.text for m in recorded(name) if m.get_type() == "STATUSTEXT"]


def recorded_track(name: str) -> list[tuple[int, float, float, float]]:
    """Current item, north, east and height of a recording."""
    current, track = 0, []
    for message in recorded(name):
        if message.get_type() == "MISSION_CURRENT":
            current = message.seq
        elif message.get_type() == "GLOBAL_POSITION_INT":
            north, east = FRAME.to_plane(message.lat / 1e7, message.lon / 1e7)
            track.append((current, north, east, message.relative_alt / 1000.0))
    return track


_STORY = re.compile(
    r"(Mission: |Reached |Passed |Takeoff |Loiter |Landing |Flare |Set |Throttle |Auto disarmed|Distance |Armed AUTO"
    r"|Triggered AUTO|Autoland |Holding )"
)


def story(texts: Sequence[str]) -> list[str]:
    """Texts of the main events, without measured numbers."""
    told = [text for text in texts if _STORY.match(text) and text != "Throttle failsafe off"]
    return [text if text.startswith("Mission:") else re.sub(r"-?\d+(\.\d+)?", "N", text) for text in told]


def waypoint(seq: int, north: float, east: float, alt: float, *params: float) -> StoredItem:
    """A waypoint by its metres from home."""
    return at(seq, 16, north, east, alt, *params)


def at(seq: int, command: int, north: float, east: float, alt: float, *params: float, frame: int = 3) -> StoredItem:
    """An item with a place by its metres from home."""
    lat, lon = FRAME.to_earth(north, east)
    return item(seq, command, lat, lon, alt, params=params, frame=frame)


def mission(*items: StoredItem) -> list[StoredItem]:
    """Home and the items, renumbered."""
    return [home_item(*HOME), *(_numbered(i + 1, entry) for i, entry in enumerate(items))]


def _numbered(seq: int, entry: StoredItem) -> StoredItem:
    return replace(entry, seq=seq)


def off_track(point: tuple[float, float], line: Sequence[tuple[float, float]]) -> float:
    """Distance of a point from a polyline."""
    best = math.inf
    for (n0, e0), (n1, e1) in itertools.pairwise(line):
        dn, de = n1 - n0, e1 - e0
        square = dn * dn + de * de
        part = 0.0 if square == 0 else max(0.0, min(1.0, ((point[0] - n0) * dn + (point[1] - e0) * de) / square))
        best = min(best, math.hypot(point[0] - n0 - part * dn, point[1] - e0 - part * de))
    return best

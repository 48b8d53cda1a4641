"""Recorded conversations (tests/fixtures/captures), and their replay with the simulated plane."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from vencejo.sim.config import SimOptions
from vencejo.sim.mavlink.codec import dialect
from vencejo.sim.world import MemoryLink, World

from tests.sim.autopilot_double import DoubleAutopilot

CAPTURES = Path(__file__).parent.parent / "fixtures" / "captures"
FACTS = Path(__file__).parent.parent / "fixtures" / "facts"
STATION = 255
SETTLE_S = 5.0

HOME = SimOptions(
    home_lat_deg=40.3332001, home_lon_deg=-3.7977996, home_alt_amsl_m=600.09, start_unix_s=1.7e9, links=()
)
"""Home as the recorded vehicle had it."""


class Entry(NamedTuple):
    """One frame of a transcript."""

    time_s: float
    from_station: bool
    message: Any
    frame: bytes


def read(name: str, until_s: float = math.inf) -> list[Entry]:
    """A ``.tlog`` of both directions: 8-byte big-endian microseconds, then the frame, again and again."""
    data = (CAPTURES / name).read_bytes()
    decoder = dialect.MAVLink(None)
    entries: list[Entry] = []
    offset = 0
    first_us = None
    while offset + 8 < len(data):
        (time_us,) = struct.unpack_from(">Q", data, offset)
        offset += 8
        first_us = time_us if first_us is None else first_us
        if (time_us - first_us) / 1e6 > until_s:
            break
        header = 12 if data[offset] == 0xFD else 8
        frame = data[offset : offset + header + data[offset + 1]]
        offset += len(frame)
        message = decoder.decode(bytearray(frame))
        entries.append(Entry((time_us - first_us) / 1e6, message.get_srcSystem() == STATION, message, frame))
    return entries


def settled_world(options: SimOptions = HOME) -> tuple[World, MemoryLink]:
    """A world whose plane has settled, with a station from which nothing waits."""
    world = World(options, autopilot=DoubleAutopilot)
    station = world.connect()
    assert world.advance(SETTLE_S, until=lambda: world.planes[0].home_set)
    world.advance(0.5)
    station.receive()
    return world, station


def double(world: World, number: int = 0) -> DoubleAutopilot:
    """The autopilot double of a plane."""
    autopilot = world.planes[number].autopilot
    assert isinstance(autopilot, DoubleAutopilot)
    return autopilot


def replay(entries: Iterable[Entry], world: World, station: MemoryLink, *, tail_s: float = 1.0) -> list[Any]:
    """Send the station's half at its recorded times; returns all messages of the plane."""
    answers: list[Any] = []
    start_s = world.planes[0].autopilot.time_s
    for entry in entries:
        if not entry.from_station:
            continue
        answers += listen(world, station, start_s + entry.time_s - world.planes[0].autopilot.time_s)
        station.send_bytes(entry.frame)
    return answers + listen(world, station, tail_s)


def listen(world: World, station: MemoryLink, seconds: float) -> list[Any]:
    """Let time pass while reading; returns the received messages."""
    heard = station.receive()
    for _ in range(max(0, round(seconds * 100))):
        world.tick()
        heard += station.receive()
    return heard


def outline(messages: Iterable[Any], fields: Mapping[str, tuple[str, ...]]) -> list[tuple[Any, ...]]:
    """The messages of some types, each as its type and the fields that matter."""
    return [
        (message.get_type(), *(getattr(message, field) for field in fields[message.get_type()]))
        for message in messages
        if message.get_type() in fields
    ]


def recorded(entries: Iterable[Entry], keep: Callable[[Entry], bool] = lambda _entry: True) -> list[Any]:
    """The vehicle's half."""
    return [entry.message for entry in entries if not entry.from_station and keep(entry)]

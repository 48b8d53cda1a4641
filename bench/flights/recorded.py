"""Flights from recordings: a ``.tlog`` of the whole flight, and a ``.json`` with plan, wind and parameters."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vencejo import Home, MissionItem, Plan
from vencejo.landing import Wind
from vencejo.sim.mavlink.codec import dialect

from bench.flights.track import Flight, Sample, Track
from bench.harness import ROOT

CAPTURES = ROOT / "tests/fixtures/captures"
RECORDINGS = ROOT / "tests/fixtures/flights"
_STAMP_BYTES = 8
_MARKS = (0xFD, 0xFE)
_NAMES = ("ATTITUDE", "GLOBAL_POSITION_INT", "MISSION_CURRENT", "MISSION_ITEM_INT")
_WANTED = {getattr(dialect, f"MAVLINK_MSG_ID_{name}") for name in _NAMES}


def captured() -> Iterator[Flight]:
    """Yield the complete flights among the captures of a real ArduPlane."""
    # The first lacks its own mission. It is that of the upload beside it: as many items (MIS_TOTAL), reached in order.
    for name, upload, wind in (
        ("arduplane-takeoff-to-landing", "mission-upload-items", Wind(0.0, 0.0)),
        ("arduplane-wind-flight", "arduplane-wind-flight", Wind(240.0, 6.0)),
    ):
        home, items = uploaded(CAPTURES / f"{upload}.tlog")
        rows = (line.split() for line in (CAPTURES / "arduplane-params.parm").read_text(encoding="utf-8").splitlines())
        # Only this parameter's setting is in both recordings (PARAM_VALUE); the wind is that of SIM_WIND_SPD and _DIR.
        parameters = {**{row[0]: float(row[1]) for row in rows}, "RTL_AUTOLAND": 2.0}
        yield flight(name, CAPTURES / f"{name}.tlog", Plan(items=items, home=home), parameters, wind)


def recordings(folder: Path) -> Iterator[Flight]:
    """Yield the flights of a folder, by name: each a ``NAME.tlog`` with its ``NAME.json`` (bench/README.md)."""
    for path in sorted(folder.glob("*.json")):
        note: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        items = tuple(MissionItem(row["command"], row["frame"], tuple(row["params"])) for row in note["mission"])
        plan = Plan(items=items, home=Home(**note["home"]))
        wind = Wind(note["wind"]["from_deg"], note["wind"]["speed_m_s"])
        yield flight(path.stem, path.with_suffix(".tlog"), plan, note["parameters"], wind)


def flight(name: str, tlog: Path, plan: Plan, parameters: dict[str, float], wind: Wind) -> Flight:
    """Return one flight of a recording, by its GLOBAL_POSITION_INT."""
    assert plan.home is not None, "a flight's plan has a home"
    samples: list[Sample] = []
    bank_deg, item = 0.0, 0
    for message in _messages(tlog):
        kind = message.get_type()
        if message.get_srcComponent() != 1:
            continue
        if kind == "ATTITUDE":
            bank_deg = math.degrees(message.roll)
        elif kind == "MISSION_CURRENT":
            # Not MISSION_ITEM_REACHED, which is not sent for a position followed by an action: only the newest is.
            item = message.seq
        elif kind == "GLOBAL_POSITION_INT":
            samples.append(
                Sample(
                    time_s=message.time_boot_ms / 1e3,
                    lat_deg=message.lat / 1e7,
                    lon_deg=message.lon / 1e7,
                    alt_rel_home_m=message.relative_alt / 1e3,
                    climb_m_s=-message.vz / 100.0,
                    groundspeed_m_s=math.hypot(message.vx, message.vy) / 100.0,
                    bank_deg=bank_deg,
                    item=item,
                )
            )
    track = Track.of(samples, home=plan.home, name=name)
    return Flight(name, plan, parameters, wind, track)


def uploaded(tlog: Path) -> tuple[Home, tuple[MissionItem, ...]]:
    """Return home and the mission uploaded by a recording's ground station, item by item."""
    sent = {
        message.seq: message
        for message in _messages(tlog)
        if message.get_type() == "MISSION_ITEM_INT" and message.get_srcSystem() == 255 and message.mission_type == 0
    }
    home = Home(sent[0].x / 1e7, sent[0].y / 1e7, sent[0].z)
    return home, tuple(_item(sent[seq]) for seq in sorted(sent) if seq)


def _item(message: Any) -> MissionItem:
    params = (
        message.param1,
        message.param2,
        message.param3,
        message.param4,
        message.x / 1e7,
        message.y / 1e7,
        message.z,
    )
    item = MissionItem(message.command, message.frame, params)
    return item if item.has_position else MissionItem.action(message.command, *params[:4])


def _messages(path: Path) -> Iterator[Any]:
    """Yield the relevant messages of a recording; other frames are not decoded."""
    data = path.read_bytes()
    decoder = dialect.MAVLink(None)
    at = _STAMP_BYTES
    while at + 8 <= len(data):
        if data[at] not in _MARKS:  # damaged: the next mark may be a frame
            at += 1
            continue
        is_v2 = data[at] == 0xFD
        number = int.from_bytes(data[at + 7 : at + 10], "little") if is_v2 else data[at + 5]
        length = 12 + data[at + 1] + (13 if data[at + 2] & 1 else 0) if is_v2 else 8 + data[at + 1]
        if number in _WANTED:
            try:
                yield decoder.decode(bytearray(data[at : at + length]))
            except dialect.MAVError:
                at += 1
                continue
        at += length + _STAMP_BYTES

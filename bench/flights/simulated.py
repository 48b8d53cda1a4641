"""Flights of the simulated plane: random missions in random winds, without a link, at full speed."""

from __future__ import annotations

import math
import random
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from vencejo import GeoPoint, Home, MissionItem, Plan
from vencejo.geodesy import bearing_deg, destination, distance_m
from vencejo.landing import Wind, design_landing
from vencejo.rehearsal import Airframe, learn
from vencejo.sim.autopilot import Autopilot, SimConfig
from vencejo.sim.autopilot.interface import DT_S, MavResult, Mode, StoredItem
from vencejo.sim.autopilot.testing import FixedPlan, home_item
from vencejo.sim.fence import FenceStatus
from vencejo.sim.mavlink.codec import dialect
from vencejo.sim.mavlink.telemetry import BUILDERS, TelemetryContext
from vencejo.sim.params import ParamStore

from bench.flights.track import Flight, Sample, Track

HOME = Home(40.3332, -3.7978, 600.0)
STRONGEST_WIND_M_S = 8.0
#: Simulated seconds until the estimator is ready and the plane can be armed.
SETTLED_S = 22.0
LONGEST_S = 3000.0
STEPS_A_SAMPLE = 10
#: Largest distance of a mission from home, metres.
FARTHEST_M = 1500.0
LOWEST_M, HIGHEST_M = 60.0, 160.0
#: A plane whose return uses the landing of its mission; otherwise it refuses to arm with DO_LAND_START.
SETTINGS = {"RTL_AUTOLAND": 2.0}
#: HEARTBEAT, ATTITUDE, GLOBAL_POSITION_INT and VFR_HUD: inputs for learning a plane.
LESSON = (0, 30, 33, 74)
TELEMETRY = TelemetryContext(
    unix_us_at_boot=0,
    stick_mixing=False,
    rc_rssi=0,
    fence_enabled=False,
    fence_present=False,
    fence=FenceStatus(breached=False, count=0, kind=0, time_s=0.0),
    prearm_ok=True,
    home_set=True,
)
START_UNIX_US = 1_790_000_000_000_000


def random_mission(seed: int) -> tuple[Plan, Wind, float]:
    """Return a mission from take-off to landing, the wind, and the initial heading of the plane, degrees.

    Legs of 80 to 900 m with turns of up to 150 degrees either way, some climbing or descending by up to 60 m, circles
    of every kind, changes of speed, sometimes a jump back, and a designed landing, up to 30 degrees off the wind.
    """
    source = random.Random(f"mission {seed}")
    wind = Wind(source.uniform(0.0, 360.0), source.uniform(0.0, STRONGEST_WIND_M_S))
    heading_deg = (wind.from_deg + source.uniform(-30.0, 30.0)) % 360.0
    home = GeoPoint(HOME.lat_deg, HOME.lon_deg)
    here, course_deg, alt_m = home, heading_deg, float(source.randrange(40, 70, 10))
    ahead = destination(home, bearing_deg=heading_deg, distance_m=300.0)
    items = [MissionItem.takeoff(ahead.lat_deg, ahead.lon_deg, alt_rel_home_m=alt_m)]
    alt_m, length_m = alt_m + 30.0, 600.0
    for leg in range(source.randint(6, 10)):
        here = destination(here, bearing_deg=course_deg, distance_m=length_m)
        if source.random() < 0.4:
            alt_m = min(max(alt_m + source.uniform(-60.0, 60.0), LOWEST_M), HIGHEST_M)
        if leg and source.random() < 0.2:
            items.append(MissionItem.change_airspeed(float(source.randint(16, 26))))
        items.append(_place(source, here, round(alt_m)))
        if distance_m(home, here) > FARTHEST_M:
            course_deg = bearing_deg(here, home) + source.uniform(-40.0, 40.0)
        else:
            course_deg += source.uniform(-150.0, 150.0)
        length_m = source.uniform(80.0, 300.0) if source.random() < 0.3 else source.uniform(300.0, 900.0)
    if source.random() < 0.3:
        items.append(MissionItem.jump(max(2, len(items) - 3), repeats=1))
    items.append(MissionItem.change_airspeed(22.0))
    course_deg = (wind.from_deg + source.uniform(-30.0, 30.0)) % 360.0
    landing = design_landing(
        home, course_deg=course_deg, wind=wind, ground_rel_home_m=0.0, is_clockwise=source.random() < 0.5
    )
    return Plan(items=(*items, *landing.items), home=HOME), wind, heading_deg


def _place(source: random.Random, at: GeoPoint, alt_m: float) -> MissionItem:
    """Return a waypoint, mostly, or a circle."""
    lucky, where = source.random(), (at.lat_deg, at.lon_deg)
    radius_m = source.choice((-1.0, 1.0)) * source.randrange(60, 151, 10)
    if lucky < 0.12:
        turns = float(source.randint(1, 3))
        return MissionItem.loiter_turns(*where, alt_rel_home_m=alt_m, turns=turns, radius_m=radius_m)
    if lucky < 0.18:
        return MissionItem.loiter_time(*where, alt_rel_home_m=alt_m, time_s=float(source.randint(20, 60)))
    if lucky < 0.26:
        return MissionItem.loiter_to_altitude(*where, alt_rel_home_m=alt_m, radius_m=radius_m)
    return MissionItem.waypoint(*where, alt_rel_home_m=alt_m)


def fly(seed: int, airframe: Airframe | None = None) -> Flight:
    """Fly the random mission of a seed, from standstill to standstill; the same seed gives the same flight."""
    plan, wind, heading_deg = random_mission(seed)
    flown = flight_of(f"simulated {seed}", plan, wind, heading_deg=heading_deg, seed=seed)
    return replace(flown.flight, airframe=airframe)


def learned() -> Airframe:
    """Return the simulated plane as learned from a flight: a square at three speeds, with climbs and descents."""
    home = GeoPoint(HOME.lat_deg, HOME.lon_deg)
    places = [destination(home, bearing_deg=bearing, distance_m=700.0) for bearing in (0.0, 90.0, 180.0, 270.0)]
    items = [MissionItem.takeoff(HOME.lat_deg, HOME.lon_deg, alt_rel_home_m=60.0)]
    for speed_m_s, alt_m in ((22.0, 150.0), (17.0, 60.0), (26.0, 160.0), (22.0, 70.0)):
        items.append(MissionItem.change_airspeed(speed_m_s))
        items += [
            MissionItem.waypoint(place.lat_deg, place.lon_deg, alt_rel_home_m=alt_m if place in places[:2] else 110.0)
            for place in places
        ]
    wind = Wind(300.0, 4.0)
    landing = design_landing(home, course_deg=wind.from_deg, wind=wind, ground_rel_home_m=0.0)
    plan = Plan(items=(*items, *landing.items), home=HOME)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "flight.tlog")
        with file.open("wb") as tlog:
            flown = flight_of("the lesson", plan, wind, heading_deg=wind.from_deg, seed=0, tlog=tlog)
        return learn(file, parameters=flown.flight.parameters).airframe


@dataclass(frozen=True)
class Flown:
    """A flight, and its end."""

    flight: Flight
    rest: GeoPoint


def flight_of(
    name: str, plan: Plan, wind: Wind, *, heading_deg: float, seed: int, tlog: BinaryIO | None = None
) -> Flown:
    """Fly a plan that begins and ends on the ground; record it if a file is given."""
    store = ParamStore.arduplane(SETTINGS)
    stored = [
        home_item(HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m),
        *map(_stored, range(1, len(plan) + 1), plan.items),
    ]
    plane = Autopilot(
        config=SimConfig(
            home_lat_deg=HOME.lat_deg,
            home_lon_deg=HOME.lon_deg,
            home_alt_amsl_m=HOME.alt_amsl_m,
            heading_deg=heading_deg,
            wind_m_s=wind.speed_m_s,
            wind_from_deg=wind.from_deg,
            seed=seed,
        ),
        params=store,
        plan=FixedPlan(stored),
    )
    for _ in range(round(SETTLED_S / DT_S)):
        plane.step()
    plane.events()
    if plane.set_mode(Mode.AUTO) is not MavResult.ACCEPTED or plane.arm() is not MavResult.ACCEPTED:
        raise RuntimeError(f"{name}: {plane.events()}")
    samples: list[Sample] = []
    while plane.armed:
        if plane.time_s > LONGEST_S:
            raise RuntimeError(f"{name}: it does not land")
        for _ in range(STEPS_A_SAMPLE):
            plane.step()
        plane.events()
        if tlog is not None:
            _record(plane, tlog)
        body = plane.body
        samples.append(
            Sample(
                time_s=plane.time_s,
                lat_deg=body.lat_deg,
                lon_deg=body.lon_deg,
                alt_rel_home_m=body.height_m,
                climb_m_s=-body.velocity_d_m_s,
                groundspeed_m_s=math.hypot(body.velocity_n_m_s, body.velocity_e_m_s),
                bank_deg=math.degrees(body.roll_rad),
                item=plane.mission.current_seq,
            )
        )
    track = Track.of(samples, home=HOME, name=name)
    rest = GeoPoint(plane.body.lat_deg, plane.body.lon_deg)
    return Flown(Flight(name, plan, parameters(store), wind, track), rest)


def _record(plane: Autopilot, tlog: BinaryIO) -> None:
    """Record the inputs for learning a plane as in a .tlog: the time of day in microseconds, and a frame."""
    snapshot, sender = plane.snapshot(), dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    for message_id in LESSON:
        message = BUILDERS[message_id](snapshot, TELEMETRY)
        if message is not None:
            tlog.write((START_UNIX_US + round(plane.time_s * 1e6)).to_bytes(8, "big") + message.pack(sender))


def parameters(store: ParamStore) -> dict[str, float]:
    """Return the plane's parameters, except SIM_*, which describe ArduPilot's own simulator."""
    return {row.name: row.value for row in map(store.at, range(len(store))) if not row.name.startswith("SIM_")}


def _stored(seq: int, item: MissionItem) -> StoredItem:
    p1, p2, p3, p4, x, y, z = (value or 0.0 for value in item.params)
    return StoredItem(seq, item.command, item.frame, p1, p2, p3, p4, x, y, z)

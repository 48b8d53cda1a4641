"""The comparison of flights with rehearsals reports actual differences, and no others."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect
from vencejo import Home, MissionItem, Plan
from vencejo.geodesy import destination
from vencejo.landing import Wind
from vencejo.plan import GeoPoint

from bench.flights import landings, recorded, simulated
from bench.flights.compare import KINDS, Comparison, Figures, compare, figures
from bench.flights.rehearsed import rehearsal_of
from bench.flights.table import numbers, table
from bench.flights.track import Flight, Sample, Track

HOME = Home(40.0, -3.0, 600.0)
SPEED_M_S = 20.0
Place = tuple[float, float, float]
"""North, east and altitude, metres from home."""


def geo(north_m: float, east_m: float) -> GeoPoint:
    there = destination(GeoPoint(HOME.lat_deg, HOME.lon_deg), bearing_deg=0.0, distance_m=north_m)
    return destination(there, bearing_deg=90.0, distance_m=east_m)


def plan_of(*places: Place) -> Plan:
    """Return waypoints, followed by a landing at the last position."""
    *ways, last = [(geo(north_m, east_m), alt_m) for north_m, east_m, alt_m in places]
    items = [MissionItem.waypoint(at.lat_deg, at.lon_deg, alt_rel_home_m=alt_m) for at, alt_m in ways]
    return Plan(items=(*items, MissionItem.land(last[0].lat_deg, last[0].lon_deg)), home=HOME)


def flown(
    *legs: tuple[int, Place], rate_hz: float = 10.0, stand_s: float = 10.0, speed_m_s: float = SPEED_M_S
) -> Track:
    """Return a straight flight from home through the positions, each with its current item; then it stands."""
    samples: list[Sample] = []
    at, item = (0.0, 0.0, 0.0), 0

    def add(place: Place, climb_m_s: float, groundspeed_m_s: float) -> None:
        point = geo(place[0], place[1])
        time_s = len(samples) / rate_hz
        samples.append(Sample(time_s, point.lat_deg, point.lon_deg, place[2], climb_m_s, groundspeed_m_s, 0.0, item))

    for _ in range(round(rate_hz * stand_s)):
        add(at, 0.0, 0.0)
    for number, to in legs:
        item = number
        length_m = math.hypot(to[0] - at[0], to[1] - at[1])
        steps = round(length_m / speed_m_s * rate_hz)
        for step in range(steps):
            part = step / steps
            place = tuple(a + part * (b - a) for a, b in zip(at, to, strict=True))
            add((place[0], place[1], place[2]), (to[2] - at[2]) * speed_m_s / length_m, speed_m_s)
        at = to
    for _ in range(round(rate_hz * stand_s)):
        add(at, 0.0, 0.0)
    return Track.of(samples, home=HOME, name="made up")


OUT, BACK, DOWN = (1000.0, 0.0, 80.0), (1000.0, 500.0, 80.0), (0.0, 500.0, 0.0)
LEGS = ((1, OUT), (2, BACK), (3, DOWN))


def flight_of(track: Track, plan: Plan | None = None) -> Flight:
    return Flight("made up", plan or plan_of(OUT, BACK, DOWN), {}, Wind(0.0, 0.0), track)


def judged(rehearsed: Track, track: Track | None = None) -> Comparison:
    return compare(flight_of(track or flown(*LEGS)), rehearsed)


def whole(found: Comparison, kind: str | None = None) -> Figures:
    one = figures([found], kind)
    assert one is not None
    return one


def moved(track: Track, **by: float) -> Track:
    return replace(track, **{name: getattr(track, name) + value for name, value in by.items()})


def test_a_track_is_like_itself() -> None:
    found = judged(flown(*LEGS))
    one = whole(found)
    assert one.seconds == pytest.approx(2500.0 / SPEED_M_S, abs=0.2)
    assert (one.cross_worst_m, one.height_worst_m, one.time_worst_s) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert (one.arrivals, one.missed, one.not_compared_s) == (3, 0, 0.0)
    assert (found.touchdown_m, found.rest_m) == (0.0, 0.0)


def test_sparser_samples_are_the_same_track() -> None:
    one = whole(judged(flown(*LEGS, rate_hz=5.0)))
    assert one.cross_worst_m < 0.01
    assert one.height_worst_m < 0.01
    assert one.time_worst_s <= 0.2


def test_times_count_from_the_beginning_of_the_roll() -> None:
    one = whole(judged(flown(*LEGS, stand_s=40.0)))
    assert (one.cross_worst_m, one.time_worst_s) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_across_and_height() -> None:
    found = judged(moved(flown((1, OUT)), east_m=10.0, alt_m=-4.0), flown((1, OUT)))
    one = whole(found)
    assert (one.cross_rms_m, one.cross_worst_m) == pytest.approx((10.0, 10.0), abs=0.01)
    assert (one.height_rms_m, one.height_worst_m) == pytest.approx((4.0, 4.0), abs=0.01)
    assert found.height_m[5] == pytest.approx(-4.0, abs=0.01), "rehearsed less flown"


def test_who_is_slower_is_late_and_not_astray() -> None:
    one = whole(judged(flown(*LEGS, speed_m_s=SPEED_M_S / 1.05)))
    assert one.cross_worst_m < 0.1
    assert one.time_rms_percent == pytest.approx(5.0, abs=0.3)
    assert one.time_worst_s == pytest.approx(0.05 * 125.0, abs=0.3)
    assert one.missed == 0


def test_a_touchdown_elsewhere() -> None:
    rehearsed = flown((1, OUT), (2, BACK), (3, (30.0, 540.0, 0.0)))
    found = judged(rehearsed)
    assert found.touchdown_m == pytest.approx(50.0, abs=2.0)
    assert found.rest_m == pytest.approx(50.0, abs=0.1)
    assert judged(flown((1, OUT), (2, BACK))).touchdown_m is None


def test_another_pass_over_the_place_does_not_count() -> None:
    """The way back is 15 m beside the way out; in the rehearsal it is on the other side."""
    back = ((1, (1000.0, 0.0, 80.0)), (2, (1000.0, 15.0, 80.0)), (3, (200.0, 15.0, 0.0)))
    aside = ((1, (1000.0, 0.0, 80.0)), (2, (1000.0, -15.0, 80.0)), (3, (200.0, -15.0, 0.0)))
    found = judged(flown(*aside), flown(*back))
    last = found.cross_m[-100:]
    assert last == pytest.approx(np.full(100, 30.0), abs=0.1)


def test_a_second_visit_is_compared_with_the_second() -> None:
    twice = ((1, OUT), (2, BACK), (1, (1200.0, 0.0, 80.0)), (2, (1200.0, 500.0, 120.0)), (3, DOWN))
    found = judged(flown(*twice), flown(*twice))
    assert whole(found).height_worst_m < 1e-9
    assert [(arrival.item, arrival.late_s) for arrival in found.arrivals] == [(n, 0.0) for n in (1, 2, 1, 2, 3)]
    once = judged(flown(*LEGS), flown(*twice))
    one = whole(once)
    assert (one.arrivals, one.missed) == (5, 2)
    assert one.not_compared_s == pytest.approx((math.hypot(200.0, 500.0) + 500.0) / SPEED_M_S, abs=0.3)


def spiral(turns: float, speed_m_s: float = SPEED_M_S) -> Track:
    """Return turns on a circle of 100 m, 30 m higher each turn, then away. It climbs first as fast as it departs."""
    radius_m, begin = 100.0, (1, (0.0, 100.0, 50.0))
    corners = [
        (radius_m * math.sin(math.tau * part), radius_m * math.cos(math.tau * part), 50.0 + 30.0 * part)
        for part in np.arange(0.05, turns, 0.05)
    ]
    return flown(begin, *((2, corner) for corner in corners), (3, (0.0, 900.0, 90.0)), speed_m_s=speed_m_s)


def test_turns_of_one_circle_are_told_apart_by_time() -> None:
    faster = whole(judged(spiral(3.0, speed_m_s=SPEED_M_S * 1.1), spiral(3.0)))
    assert faster.cross_worst_m < 0.1
    assert faster.height_worst_m < 0.3


def test_a_turn_more_is_late_and_not_astray() -> None:
    level = [replace(spiral(turns), alt_m=np.zeros(len(spiral(turns).time_s))) for turns in (3.0, 2.0)]
    one = whole(judged(level[1], level[0]))
    assert one.cross_worst_m < 0.1
    assert one.time_worst_s == pytest.approx(math.tau * 100.0 / SPEED_M_S, rel=0.02)


def test_kinds_of_legs() -> None:
    circle = MissionItem.loiter_turns(HOME.lat_deg, HOME.lon_deg, alt_rel_home_m=80.0, turns=1.0, radius_m=100.0)
    out = geo(*OUT[:2])
    items = (
        MissionItem.takeoff(out.lat_deg, out.lon_deg, alt_rel_home_m=50.0),
        MissionItem.waypoint(out.lat_deg, out.lon_deg, alt_rel_home_m=80.0),
        circle,
        *plan_of(DOWN).items,
    )
    track = flown(
        (1, (400.0, 0.0, 50.0)), (2, OUT), (3, (0.0, 0.0, 80.0)), (3, (1.0, 90.0, 80.0)), (4, (600.0, 500.0, 0.0))
    )
    bank_deg = np.where((track.item == 3) & (track.north_m > 900.0), 30.0, track.bank_deg)
    track = replace(track, bank_deg=bank_deg)
    flight = flight_of(track, Plan(items=items, home=HOME))
    found = compare(flight, track)
    seconds = {kind: round(one.seconds) for kind in KINDS if (one := figures([found], kind)) is not None}
    expected = {
        "take-off": 400.0 / SPEED_M_S,
        "climb": 600.0 / SPEED_M_S,
        "turn": 100.0 / SPEED_M_S,
        "straight": (900.0 - 150.0) / SPEED_M_S,
        "circle": (150.0 + 90.0) / SPEED_M_S,
        "landing": math.hypot(599.0, 410.0) / SPEED_M_S,
    }
    assert set(seconds) == set(KINDS)
    assert seconds == {kind: pytest.approx(value, abs=2.0) for kind, value in expected.items()}


def test_the_course_of_the_take_off_roll() -> None:
    assert flown((1, (300.0, -300.0, 40.0)), (2, OUT)).takeoff_course_deg == pytest.approx(315.0, abs=0.1)
    assert [round(flight.track.takeoff_course_deg) for flight in recorded.recordings(recorded.RECORDINGS)] == [240, 120]


def test_a_plane_that_never_moves_has_no_track() -> None:
    with pytest.raises(ValueError, match="never moves"):
        flown()


def test_tables_and_numbers_have_every_flight() -> None:
    flight = flight_of(flown(*LEGS))
    pairs = [compare(flight, moved(flown(*LEGS), east_m=10.0))] * 2
    text = table("Flights", [flight, flight], pairs)
    assert text.count("made up, 0.0 m/s") == 2
    assert "touch-down: median 10.0 m apart, worst 10.0 m" in text
    assert "  all" in text
    told = json.loads(json.dumps(numbers([flight, flight], pairs)))
    assert [one["touchdown_m"] for one in told["flights"]] == pytest.approx([10.0, 10.0], abs=0.1)
    assert told["kinds"]["all"]["arrivals"] == 6


def test_captured_flights_are_read_whole() -> None:
    flights = {flight.name: flight for flight in recorded.captured()}
    for name, items, land_s, rest_m in (
        ("arduplane-takeoff-to-landing", [1, 2, 3, 4, 5, 6, 7, 10, 11], 250.4, 5.15),
        ("arduplane-wind-flight", [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 8, 9, 10, 13, 14], 546.5, 9.92),
    ):
        flight = flights[name]
        found = compare(flight, flight.track)
        assert [arrival.item for arrival in found.arrivals] == items
        # "SIM Hit ground" and "Distance from LAND point" of the recording itself.
        assert found.arrivals[-1].flown_s == pytest.approx(land_s, abs=0.6)
        land = flight.plan.items[-1]
        assert land.lat_deg is not None
        assert land.lon_deg is not None
        point = Track.of(
            [Sample(0.0, land.lat_deg, land.lon_deg, 0.0, 0.0, 9.0, 0.0, 0)], home=HOME_OF_CAPTURES, name="point"
        )
        away_m = math.hypot(flight.track.north_m[-1] - point.north_m[0], flight.track.east_m[-1] - point.east_m[0])
        assert away_m == pytest.approx(rest_m, abs=0.3)
        assert whole(found).cross_worst_m < 1e-6


HOME_OF_CAPTURES = Home(40.3332, -3.7978, 600.0)


def test_recorded_flights_are_read_whole() -> None:
    kinds: dict[str, set[str]] = {}
    for flight in recorded.recordings(recorded.RECORDINGS):
        found = compare(flight, flight.track)
        arrived = {arrival.item for arrival in found.arrivals}
        assert arrived == {number for number, item in enumerate(flight.plan.items, 1) if item.is_nav}
        assert (found.touchdown_m, whole(found).missed, whole(found).not_compared_s) == (0.0, 0, 0.0)
        kinds[flight.name] = {kind for kind in KINDS if figures([found], kind) is not None}
    assert kinds == {"arduplane-circles": set(KINDS), "arduplane-near-waypoints": set(KINDS)}


@pytest.mark.parametrize(
    "spoil", [lambda data: data, lambda data: b"\xfd\x00" + data[:50] + data], ids=["whole", "damaged"]
)
def test_a_folder_of_recordings(tmp_path: Path, spoil: Callable[[bytes], bytes]) -> None:
    """A user's folder: a recording, and a note with the plane's plan and parameters, in MAVLink 1 or 2."""
    packer = dialect.MAVLink(None, srcSystem=7, srcComponent=1)
    data = b""
    for tenth in range(200):
        north_e7 = 400_000_000 + round(max(0, tenth - 50) * 2.0 / 0.0111)
        for message in (
            dialect.MAVLink_mission_current_message(1),
            dialect.MAVLink_global_position_int_message(
                tenth * 100, north_e7, -30_000_000, 680_000, 80_000, 2000 if tenth > 50 else 0, 0, 0, 0
            ),
        ):
            data += struct.pack(">Q", tenth * 100_000) + message.pack(packer, force_mavlink1=tenth % 2 == 0)
    (tmp_path / "club.tlog").write_bytes(spoil(data))
    note = {
        "home": {"lat_deg": 40.0, "lon_deg": -3.0, "alt_amsl_m": 600.0},
        "wind": {"from_deg": 270.0, "speed_m_s": 4.0},
        "mission": [{"command": 16, "frame": 3, "params": [0, 0, 0, 0, 40.01, -3.0, 80]}],
        "parameters": {"WP_RADIUS": 40.0},
    }
    (tmp_path / "club.json").write_text(json.dumps(note))
    (flight,) = recorded.recordings(tmp_path)
    assert (flight.name, flight.wind, flight.parameters) == ("club", Wind(270.0, 4.0), {"WP_RADIUS": 40.0})
    assert flight.plan.items[0].alt_m == 80.0
    # Interpolated between two samples: where it exceeds 3 of its 20 m/s.
    assert flight.track.time_s[-1] == pytest.approx(14.885)
    assert flight.track.north_m[-1] == pytest.approx(298.0, abs=2.0)
    assert flight.track.alt_m[-1] == 80.0


def test_random_missions_are_the_same_by_their_seed_and_land() -> None:
    again = [simulated.random_mission(seed) for seed in (3, 3, 4)]
    assert again[0] == again[1]
    assert again[0] != again[2]
    flight = simulated.fly(3)
    found = compare(flight, simulated.fly(3).track)
    one = whole(found)
    assert (one.cross_worst_m, one.height_worst_m, one.time_worst_s, one.missed) == pytest.approx((0.0,) * 4, abs=1e-9)
    assert found.arrivals[-1].item == len(flight.plan)


def test_rehearsals_of_recorded_flights_are_near_them() -> None:
    """5 m cross-track, 3 m in altitude (RMS of a flight), 10 m at touchdown; from the second minute on 2 % in time."""
    for flight in (*recorded.captured(), *recorded.recordings(recorded.RECORDINGS)):
        found = compare(flight, rehearsal_of(flight))
        one = whole(found)
        assert (one.missed, one.not_compared_s) == (0, 0.0), flight.name
        assert one.cross_rms_m <= 5.0, flight.name
        assert one.height_rms_m <= 3.0, flight.name
        assert found.touchdown_m is not None
        assert found.touchdown_m <= 10.0, flight.name
        # That one circled once more, since it missed the exit by a second.
        if flight.name != "arduplane-circles":
            late = [
                abs(arrival.late_s or 0.0) / arrival.flown_s for arrival in found.arrivals if arrival.flown_s > 60.0
            ]
            assert len(late) > 5
            assert max(late) <= 0.02, flight.name


def test_a_designed_landing_of_the_simulated_plane_ends_at_its_point() -> None:
    landed = landings.land(1)
    assert landed == landings.land(1), "the same flight each time"
    assert landed.rest_m <= 20.0
    assert abs(landed.beyond_m) <= landed.rest_m
    assert landings.table([landed]).endswith(f"worst {landed.rest_m:.1f} m from the point")
    assert landings.numbers([landed])["median_m"] == landed.rest_m

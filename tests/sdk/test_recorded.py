"""What the package says of a recorded flight: every group of telemetry, its units, its texts."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import pytest
import vencejo
from pymavlink import mavutil
from vencejo.recording import summarize, telemetry
from vencejo.replay import Replay
from vencejo.telemetry import GROUPS, AutopilotVersion

from tests.support import CAPTURES, wait_for

FLIGHT = CAPTURES / "arduplane-takeoff-to-landing.tlog"


@pytest.fixture(scope="module")
def plane() -> Iterator[vencejo.Vehicle]:
    """The vehicle of a recording that has been played to its end."""
    with vencejo.Station(f"tlog:{FLIGHT}?speed=2000", record=False) as station:
        vehicle = station.wait_vehicle()
        wait_for(lambda: station.links[0].state == "ended", "the end of the recording", timeout_s=120.0)
        yield vehicle


def test_every_group_converts(plane: vencejo.Vehicle) -> None:
    telemetry = plane.telemetry
    heard = dict(telemetry.groups())
    assert {"heartbeat", "attitude", "position", "hud", "gps", "sys_status", "imu", "pressure", "wind"} <= set(heard)
    assert {"mission", "nav", "ekf", "vibration", "home", "servos", "system_time"} <= set(heard)
    for name, group in heard.items():
        assert isinstance(group, GROUPS[name])
        assert group.age_s >= 0.0
        for field in dataclasses.fields(group):
            value = getattr(group, field.name)
            assert not (isinstance(value, float) and math.isnan(value)), f"{name}.{field.name}"
    assert telemetry.batteries
    told = telemetry.to_dict()
    assert told["position"]["lat_deg"] == heard["position"].lat_deg  # type: ignore[attr-defined]
    assert [imu is None for imu in told["imus"]] == [imu is None for imu in telemetry.imus]
    version = AutopilotVersion(
        age_s=0.0, has_invalid=False, flight_sw="4.6.3", git_hash="", capabilities=0, uid=2**63 + 1
    )
    telemetry.__dict__["version"] = version
    assert telemetry.to_dict()["version"]["uid"] == "9223372036854775809", "more than a number keeps in JSON"
    assert telemetry.invalid_values == 0


def test_the_names_of_all_groups_are_those_of_the_native_side(plane: vencejo.Vehicle) -> None:
    native = plane._native.telemetry()
    for name in GROUPS:
        if name != "battery":
            values = native.group(name)
            if values is not None:
                assert set(values) == {field.name for field in dataclasses.fields(GROUPS[name])}, name
    with pytest.raises(KeyError):
        native.group("no such group")


def test_the_plane_stands_where_the_recording_ended(plane: vencejo.Vehicle) -> None:
    position, hud, heartbeat = plane.telemetry.position, plane.telemetry.hud, plane.telemetry.heartbeat
    assert position is not None
    assert position.lat_deg == pytest.approx(40.3332, abs=0.02)
    assert position.lon_deg == pytest.approx(-3.7978, abs=0.02)
    assert position.alt_amsl_m == pytest.approx(600.0, abs=5.0)
    assert hud is not None
    assert hud.groundspeed_m_s == pytest.approx(0.0, abs=1.0)
    assert heartbeat is not None
    assert (heartbeat.mode, heartbeat.is_armed, heartbeat.autopilot) == ("AUTO", False, 3)


def test_texts_and_items_of_the_flight(plane: vencejo.Vehicle) -> None:
    texts = [text.text for text in plane.texts]
    assert any(text.startswith("Takeoff complete") for text in texts)
    assert any(text.startswith("Distance from LAND point") for text in texts)
    assert len(plane.mission_progress.reached) >= 8


def test_a_recording_is_not_written_to(plane: vencejo.Vehicle) -> None:
    """Nothing goes anywhere: what is asked of a recorded vehicle fails, it does not hang."""
    with pytest.raises(vencejo.VencejoError):
        plane.set_mode("RTL")


def test_telemetry_is_read_out_of_the_file_with_its_units() -> None:
    log = mavutil.mavlink_connection(str(FLIGHT))
    raw = []
    while (message := log.recv_match(type="GLOBAL_POSITION_INT")) is not None:
        raw.append((message.lat, message.lon, message.relative_alt))
    log.close()
    samples = list(telemetry(FLIGHT, rate_hz=50.0))
    assert isinstance(samples[0], vencejo.Telemetry)
    places = set()
    for at in (now.position for now in samples):
        if at is not None and at.point is not None and at.alt_rel_home_m is not None:
            scaled = (at.point.lat_deg * 1e7, at.point.lon_deg * 1e7, at.alt_rel_home_m * 1e3)
            places.add(tuple(round(value) for value in scaled))
    assert len(places) > 0.9 * len(set(raw))
    assert places <= set(raw)
    times = [now.time_s for now in samples]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(summarize(FLIGHT).duration_s, abs=1.0)
    assert {"MANUAL", "AUTO"} <= {now.mode for now in samples}
    slow = list(telemetry(FLIGHT, rate_hz=1.0))
    assert 300 <= len(slow) <= 320
    assert list(telemetry(FLIGHT, system_id=9)) == []
    for wrong in (FLIGHT.with_name("none.tlog"), FLIGHT.parent):
        with pytest.raises(vencejo.FileFormatError):
            next(telemetry(wrong))
    with pytest.raises(vencejo.InvalidRequest):
        telemetry(FLIGHT, rate_hz=0.0)


def test_a_replay_is_a_vehicle_of_its_own_that_goes_to_any_place() -> None:
    def is_armed(vehicle: vencejo.Vehicle) -> bool | None:
        heartbeat = vehicle.telemetry.heartbeat
        return None if heartbeat is None else heartbeat.is_armed

    with vencejo.Station(record=False, heartbeat=False) as station:
        with Replay(station, FLIGHT, start_s=150.0) as replay:
            replay.pause()
            recorded = station.wait_vehicle()
            wait_for(lambda: is_armed(recorded) is True, "its state there")
            status = replay.status
            assert (replay.name, replay.path, status.is_paused) == (FLIGHT.stem, FLIGHT, True)
            assert (status.system_ids, recorded.remote_name) == ((recorded.system_id,), f"{FLIGHT.stem} (replay)")
            assert status.position_s == pytest.approx(150.0, abs=5.0)
            assert status.start is not None
            assert status.time is not None
            assert (status.time - status.start).total_seconds() == pytest.approx(status.position_s, abs=0.1)
            with pytest.raises(vencejo.NotPossibleNow, match="recording"):
                recorded.set_mode("RTL")
            replay.seek(3.0)
            wait_for(lambda: is_armed(recorded) is False, "the ground")
            replay.set_speed(10_000)
            replay.play()
            wait_for(lambda: replay.status.is_over, "its end")
            with pytest.raises(vencejo.InvalidRequest):
                replay.seek(-1.0)
            for speed in (0.0, 1e9, math.nan):
                with pytest.raises(vencejo.InvalidRequest):
                    replay.set_speed(speed)
        assert station.vehicles == []
        with pytest.raises(vencejo.FileFormatError):
            Replay(station, __file__)

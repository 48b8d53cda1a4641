"""Telemetry, message by message: the types and the fields of a recorded ArduPlane, and frames as pymavlink makes them."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import pytest
from pymavlink.dialects.v10 import ardupilotmega as v1
from vencejo.sim.autopilot.interface import Mode, Snapshot
from vencejo.sim.fence import FenceStatus
from vencejo.sim.mavlink.codec import Decoder, dialect, frame, payload_of
from vencejo.sim.mavlink.telemetry import BUILDERS, TelemetryContext, base_mode, build

from tests.sim.transcripts import CAPTURES, double, listen, settled_world

CONTEXT = TelemetryContext(
    unix_us_at_boot=1_700_000_000_000_000,
    stick_mixing=True,
    rc_rssi=255,
    fence_enabled=True,
    fence_present=True,
    fence=FenceStatus(breached=True, count=2, kind=3, time_s=1.5),
    prearm_ok=True,
    home_set=True,
)


def recording() -> list[Any]:
    return Decoder().feed((CAPTURES / "arduplane-50hz-20s.mavlink").read_bytes())


@functools.cache
def snapshot() -> Snapshot:
    world, _ = settled_world()
    return double(world).snapshot()


def flying() -> Snapshot:
    return replace(
        snapshot(),
        mode=Mode.AUTO,
        armed=True,
        target_lat_deg=40.34,
        target_lon_deg=-3.8,
        target_alt_amsl_m=700.0,
        airspeed_error_m_s=-0.16357,
        wind_from_deg=231.99,
    )


def test_every_recorded_message_is_streamed_or_announced() -> None:
    recorded = {message.get_type() for message in recording()}
    assert len(recorded) == 34
    world, station = settled_world()
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 5, 1))
    world.planes[0].say(6, "text")  # type: ignore[arg-type]
    double(world).reboot()
    heard = {message.get_type() for message in listen(world, station, 12.0)}
    assert recorded - heard == set()


def test_at_rest_the_fields_are_those_of_the_recording() -> None:
    last = {message.get_type(): message for message in recording()}
    same = {
        "HEARTBEAT": ("type", "autopilot", "base_mode", "custom_mode", "system_status", "mavlink_version"),
        "SYS_STATUS": ("voltage_battery", "current_battery", "battery_remaining", "load"),
        "POWER_STATUS": ("Vcc", "Vservo", "flags"),
        "MEMINFO": ("brkval", "freemem", "freemem32"),
        "MISSION_CURRENT": ("seq", "total", "mission_state", "mission_mode"),
        "SERVO_OUTPUT_RAW": tuple(f"servo{n}_raw" for n in range(1, 17)),
        "RC_CHANNELS": ("chancount", "rssi", *(f"chan{n}_raw" for n in range(1, 19))),
        "SCALED_IMU3": ("xacc", "yacc", "zacc", "xmag", "ymag", "zmag", "temperature"),
        "GPS_RAW_INT": ("fix_type", "eph", "epv", "vel", "cog", "satellites_visible", "h_acc", "v_acc", "yaw"),
        "WIND": ("direction", "speed", "speed_z"),
        "BATTERY_STATUS": ("id", "type", "temperature", "voltages", "current_battery", "battery_remaining",
                           "charge_state", "voltages_ext", "energy_consumed", "time_remaining"),
        "EKF_STATUS_REPORT": ("flags",),
        "AIRSPEED": ("id", "temperature", "flags"),
    }  # fmt: skip
    world, _ = settled_world()
    now, context = double(world).snapshot(), world.planes[0].context()
    ids = {message.get_type(): message.get_msgId() for message in last.values()}
    for kind, fields in same.items():
        built = build(ids[kind], now, context)
        assert built is not None
        for field in fields:
            ours, theirs = getattr(built, field), getattr(last[kind], field)
            assert (list(ours) if isinstance(ours, tuple) else ours) == theirs, f"{kind}.{field}"


def test_sensor_bits_are_the_recorded_ones() -> None:
    # From arduplane-takeoff-to-landing.tlog and mission-upload-items.tlog: ready on the ground, then armed.
    for armed, enabled, health in ((False, 308379711, 322011199), (True, 325188671, 322042943)):
        context = replace(CONTEXT, fence_enabled=False, fence_present=False)
        status = build(1, replace(snapshot(), armed=armed), context)
        assert status is not None
        assert status.onboard_control_sensors_present == 325188671
        assert status.onboard_control_sensors_enabled == enabled
        assert status.onboard_control_sensors_health == health


def test_failsafes_are_seen_in_the_state_of_sensors_and_battery() -> None:
    for failed, radio_lost, charge_state in ((0, False, 1), (1, False, 2), (2, True, 3)):
        now = replace(snapshot(), battery_failsafe=failed, radio_lost=radio_lost)
        status, battery = build(1, now, CONTEXT), build(147, now, CONTEXT)
        assert status is not None
        assert battery is not None
        health = status.onboard_control_sensors_health
        assert bool(health & dialect.MAV_SYS_STATUS_SENSOR_BATTERY) == (failed == 0)
        assert bool(health & dialect.MAV_SYS_STATUS_SENSOR_RC_RECEIVER) == (not radio_lost)
        assert battery.charge_state == charge_state


@pytest.mark.parametrize(
    ("mode", "armed", "bits"),
    [
        (Mode.MANUAL, False, 81),
        (Mode.AUTO, False, 89),
        (Mode.AUTO, True, 217),
        (Mode.TAKEOFF, True, 217),
        (Mode.FBWA, False, 81),
    ],
)
def test_base_mode(mode: Mode, armed: bool, bits: int) -> None:
    assert base_mode(replace(snapshot(), mode=mode, armed=armed), stick_mixing=True) == bits


def test_in_flight() -> None:
    now = flying()
    nav = build(62, now, CONTEXT)
    assert nav is not None
    assert nav.aspd_error == pytest.approx(-16.357)
    gps = build(24, now, CONTEXT)
    assert gps is not None
    assert gps.alt_ellipsoid - gps.alt == 51_000, "above the ellipsoid and above the sea are two heights"
    wind = build(168, now, CONTEXT)
    assert wind is not None
    assert wind.direction == pytest.approx(-128.01)
    target = build(87, now, CONTEXT)
    assert target is not None
    assert (target.coordinate_frame, target.type_mask, target.lat_int, target.lon_int) == (
        0,
        65016,
        403400000,
        -38000000,
    )
    on_ground = replace(now, mode=Mode.MANUAL, target_lat_deg=None, target_lon_deg=None, target_alt_amsl_m=None)
    assert build(62, on_ground, CONTEXT) is None
    assert build(87, on_ground, CONTEXT) is None


def test_before_a_fix() -> None:
    now = replace(snapshot(), gps_fix_type=1, ekf_flags=1024)
    assert build(32, now, CONTEXT) is None
    gps = build(24, now, CONTEXT)
    assert gps is not None
    assert (gps.lat, gps.eph, gps.time_usec) == (0, 65535, 0)
    time_message = build(2, now, CONTEXT)
    assert time_message is not None
    assert time_message.time_unix_usec == 0
    home = build(242, now, CONTEXT)
    assert home is not None
    assert math.isnan(home.x)
    assert build(242, now, replace(CONTEXT, home_set=False)) is None


def test_planes_of_one_simulator_have_their_own_hardware() -> None:
    versions = [build(148, snapshot(), replace(CONTEXT, system_id=system)) for system in (1, 2)]
    assert [bytes(version.uid2).rstrip(b"\0") for version in versions if version] == [
        b"vencejo-sim-1",
        b"vencejo-sim-2",
    ]


@pytest.mark.parametrize("message_id", sorted(BUILDERS))
def test_frames_are_pymavlinks(message_id: int) -> None:
    message = build(message_id, flying(), CONTEXT)
    assert message is not None
    packer = dialect.MAVLink(None, srcSystem=7, srcComponent=1)
    packer.seq = 42
    ours = frame(payload_of(message), sequence=42, system=7, component=1, version=2)
    assert ours == message.pack(packer)
    ours_v1 = frame(payload_of(message), sequence=42, system=7, component=1, version=1)
    if message_id > 255 or message_id not in v1.mavlink_map:
        assert ours_v1 is None
    else:
        assert ours_v1 is not None
        decoded = v1.MAVLink(None).decode(bytearray(ours_v1))
        assert decoded.get_type() == message.get_type()


@pytest.mark.parametrize("wild", [math.nan, math.inf, -math.inf, 1e30, -1e39])
def test_a_simulation_gone_wrong_still_makes_frames(wild: float) -> None:
    now = flying()
    upset = {
        name: wild
        for name in Snapshot.__dataclass_fields__
        if isinstance(getattr(now, name), float) and name != "time_s"
    }
    now = replace(now, **upset)  # type: ignore[arg-type]
    for message_id in BUILDERS:
        message = build(message_id, now, CONTEXT)
        if message is not None:
            payload_of(message)

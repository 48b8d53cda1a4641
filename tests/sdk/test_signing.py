"""Signing from end to end: a key is given, used, changed and taken away, and nobody is cut off on the way."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil
from vencejo import CommandTimeout, InvalidRequest, NotPossibleNow, Station, Vehicle, connect
from vencejo.sim import SimOptions, SimulatedPlane
from vencejo.sim.world import World

from tests.support import wait_for


@pytest.fixture
def sim() -> Iterator[SimulatedPlane]:
    """A plane with two ports: the first is its USB, the second asks for signatures."""
    links = ("tcp:127.0.0.1:0", "tcp:127.0.0.1:0")
    with SimulatedPlane(SimOptions(links=links, speedup=10.0)) as plane:
        yield plane


def at_usb(sim: SimulatedPlane, folder: Path) -> tuple[Station, Vehicle]:
    vehicle = connect(sim.links[0], signing=folder / "signing", record=folder / "telemetry")
    return vehicle.station, vehicle


def over_the_air(sim: SimulatedPlane, folder: Path) -> tuple[Station, Vehicle]:
    station = Station(signing=folder / "signing", record=folder / "telemetry")
    station.open_link(sim.links[1], accept_unsigned=False)
    return station, station.wait_vehicle()


def on_board(sim: SimulatedPlane) -> Any:
    return sim.call(lambda world: world.planes[0].signing)


def holds(vehicle: Vehicle) -> bool:
    """Whether it is heard and hears us."""
    return vehicle.params.get("AIRSPEED_CRUISE").value > 0


@pytest.mark.fault(39, figure="keys in no log, no .tlog, no output")
def test_a_key_is_given_used_changed_and_taken_away(
    sim: SimulatedPlane, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    secrets = []
    station, vehicle = at_usb(sim, tmp_path)
    with station:
        assert not vehicle.signing.must_sign
        info = vehicle.set_up_signing()
        assert (info.must_sign, info.key, info.unproven) == (True, "vehicle-1", ())
        secrets.append(station.export_signing_key("vehicle-1"))
        assert on_board(sim).key == secrets[0]
        with pytest.raises(NotPossibleNow, match="rotate"):
            vehicle.set_up_signing()
        folder = tmp_path / "signing"
        assert folder.stat().st_mode & 0o777 == 0o700
        assert {(folder / name).stat().st_mode & 0o777 for name in ("keys.json", "times.json")} == {0o600}

    # pymavlink, with the key, hears signatures that it finds right, and is heard; without it, is not.
    other = mavutil.mavlink_connection(sim.links[1], source_system=254, dialect="ardupilotmega")
    try:
        assert other.wait_heartbeat(timeout=120) is not None
        other.mav.param_request_read_send(1, 1, b"AIRSPEED_CRUISE", -1)
        wait_for(lambda: on_board(sim).rejected > 0, "the plane ignores it")
        other.setup_signing(secrets[0])
        other.mav.param_request_read_send(1, 1, b"AIRSPEED_CRUISE", -1)
        assert other.recv_match(type="PARAM_VALUE", blocking=True, timeout=120) is not None
        assert other.mav.signing.goodsig_count > 0
        assert other.mav.signing.badsig_count == 0
    finally:
        other.close()

    station, vehicle = over_the_air(sim, tmp_path)
    with station:
        assert holds(vehicle)
        with pytest.raises(NotPossibleNow, match="listened"):
            vehicle.rotate_signing()
        info = vehicle.rotate_signing(any_link=True)
        assert (info.key, info.unproven) == ("vehicle-1-2", ())
        secrets.append(station.export_signing_key("vehicle-1-2"))
        assert on_board(sim).key == secrets[1] != secrets[0]
        assert holds(vehicle)
        with pytest.raises(InvalidRequest, match="carries a key"):
            vehicle.send_message("SETUP_SIGNING", secret_key=list(secrets[0]), initial_timestamp=0)

    # It stores its signing time each 30 s; and a restart shows by a clock that goes back, behind what is refused until it has heard ours.
    sim.call(lambda world: world.advance(31.0))
    station, vehicle = over_the_air(sim, tmp_path)
    with station:
        assert holds(vehicle), "after a restart of ours"
        events: list[str] = []
        with vehicle.on_event(lambda event: events.append(event.kind)):
            vehicle.reboot(confirm="reboot")
            # What is asked while it restarts may end with that.
            wait_for(lambda: "rebooted" in events, "its restart")
            assert holds(vehicle), "and of the vehicle's"
        # It answers before its first heartbeat, and until that it is not known to stand disarmed.
        vehicle.wait_until(lambda telemetry: telemetry.is_armed is False, timeout_s=120.0)
        assert not vehicle.remove_signing(any_link=True).must_sign
        assert on_board(sim).key is None
        assert holds(vehicle)

    written = [path for path in tmp_path.rglob("*") if path.is_file() and path.name != "keys.json"]
    assert sum(path.stat().st_size for path in written if path.suffix == ".tlog") > 1_000, (
        "there is what to look through"
    )
    said = "".join(capfd.readouterr())
    for secret in secrets:
        assert secret.hex() not in said
        assert not [
            path for path in written if secret in path.read_bytes() or secret.hex().encode() in path.read_bytes()
        ]


@pytest.mark.fault(39, figure="refused, lost and armed: told, the vehicle is held throughout and after restarts")
def test_a_refused_or_lost_key_cuts_nobody_off(sim: SimulatedPlane, tmp_path: Path) -> None:
    station, vehicle = at_usb(sim, tmp_path)
    with station:
        vehicle.set_up_signing()
    station, vehicle = over_the_air(sim, tmp_path)
    with station:
        vehicle.arm(force=True, confirm="force-arm")
        with pytest.raises(NotPossibleNow, match="armed"):
            vehicle.rotate_signing(any_link=True)
        vehicle.disarm(force=True, confirm="force-disarm")

        def say_no(world: World) -> None:
            plane = world.planes[0]
            plane._handlers["SETUP_SIGNING"] = lambda _, m: plane.signing.set_up(m, armed=True)

        sim.call(say_no)
        with pytest.raises(NotPossibleNow, match="Won't setup signing when armed"):
            vehicle.rotate_signing(any_link=True)
        assert vehicle.signing.key == "vehicle-1"
        assert holds(vehicle)

        kept: list[Any] = []
        sim.call(lambda world: world.planes[0]._handlers.update(SETUP_SIGNING=lambda _, m: kept.append(m)))
        with pytest.raises(CommandTimeout, match="nothing was thrown away"):
            vehicle.rotate_signing(any_link=True)
        assert vehicle.signing.key == "vehicle-1"
        assert holds(vehicle), "by the old key"

        # What was lost arrives after all.
        sim.call(lambda world: world.planes[0].signing.set_up(kept[-1], armed=False))
        wait_for(lambda: vehicle.signing.key != "vehicle-1", "the new key shows")
        assert holds(vehicle), "by the new one"
    station, vehicle = over_the_air(sim, tmp_path)
    with station:
        assert vehicle.signing.key != "vehicle-1"
        assert holds(vehicle), "which was written down"


def test_keys_have_names_and_are_shared_with_other_stations(tmp_path: Path) -> None:
    with Station(signing=tmp_path, record=False) as station:
        station.add_signing_key("of-qgc", passphrase="correct horse")
        station.add_signing_key("own")
        assert [key.name for key in station.signing_keys] == ["of-qgc", "own"]
        for name in ("own", "a b", "", "../x"):
            with pytest.raises(InvalidRequest):
                station.add_signing_key(name)
        station.use_signing_key(7, "of-qgc")
        assert station.signing_of(7).must_sign
        with pytest.raises(NotPossibleNow, match="in use"):
            station.forget_signing_key("of-qgc")
        station.forget_signing_key("own")
        key = station.export_signing_key("of-qgc")
    assert key == hashlib.sha256(b"correct horse").digest()
    with Station(signing=tmp_path, record=False) as station:
        assert station.signing_vehicles == [7]
        assert [(key.name, key.vehicles) for key in station.signing_keys] == [("of-qgc", (7,))]

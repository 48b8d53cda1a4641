"""Certificates of a fleet, through the command and the package: made, given out with a token, used, refused, taken away."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import time
from collections.abc import Iterator
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result
from vencejo.cli.commands import app
from vencejo.enrolment import Organisation, check_board, check_ground, join, member
from vencejo.errors import InvalidRequest, LinkError, NotPossibleNow, VencejoError
from vencejo.fleet import Fleet, FleetStatus, has_fleet, router_here

from tests.clock import Clock
from tests.fleet.programs import command
from tests.server.client import Client, WebSocket
from tests.support import reserved_ports, simulated_plane, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")


def run(data: Path, *args: str, command: str = "fleet") -> Result:
    return CliRunner().invoke(app, [command, *args], env={"VENCEJO_DATA": str(data)})


def put(data: Path, *args: str) -> Any:
    result = run(data, *args, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.mark.e2e
def test_an_aircraft_joins_with_a_token_flies_over_tls_and_is_put_out(tmp_path: Path) -> None:
    from vencejo import Station, aio

    ground, board = tmp_path / "ground", tmp_path / "board"
    assert put(ground, "init", "acme", "--host", "127.0.0.1")["made"]
    serve = ("serve", "--fleet", "acme", "--fleet-listen", "tls/127.0.0.1:0", "--fleet-door", "127.0.0.1:0")
    with simulated_plane() as link, command(ground, *serve, "--port", "0", "--link", "udpin:127.0.0.1:0") as station:
        told = station.line()
        assert told["fleet"]["endpoint"].startswith("tls/127.0.0.1:")
        given = put(ground, "enrol", "plane7")
        assert given["doors"] == [told["fleet"]["door"]]
        words = given["command"].split()
        assert words[:3] == ["vencejo", "onboard", "--join"]
        assert words[4:] == ["--link", "/dev/serial0,921600"]
        with command(board, *words[1:4], "--link", link) as aircraft:
            aircraft.until(is_connected=True, holder=None)
            assert "plane7 of the fleet acme" in run(board, "status").stdout, "also while it runs"
            assert any("the autopilot is heard on" in check["message"] for check in put(board, "doctor"))
            ana = Client(told["url"])
            ana.open_session(name="Ana")

            def planes() -> list[dict[str, Any]]:
                return [each for each in ana.done("GET", "vehicles") if each["remote_name"] == "plane7"]

            wait_for(lambda: len(planes()) == 1, "the plane in the list")
            ana.done("POST", "control/take")
            ana.done("POST", f"vehicles/{planes()[0]['system_id']}/mode", {"mode": "FBWA"})
            aircraft.until(holder="ground · Ana")
            wait_for(lambda: planes()[0]["mode"] == "FBWA", "the mode")

            wait_for(lambda: _row(ground, "plane7")["holder"] == "ground · Ana", "who has control")
            row = _row(ground, "plane7")
            assert row["certificate_days"] in (89, 90)
            assert row["revoked"] is None
            secret = (board / "fleet" / "aboard.json").read_text(encoding="ascii")
            assert (board / "fleet" / "aboard.json").stat().st_mode & 0o777 == 0o600
            assert words[3] not in secret, "the token is kept nowhere"

            (plane,) = put(board, "status")["onboard"]
            assert plane == {"name": None, "link": [link], "autopilot_silent_s": None, "links": None}

            # A command on the same computer goes to its router, and overrules nobody.
            def ask(*more: str) -> Result:
                data = {"VENCEJO_DATA": str(ground)}
                return CliRunner().invoke(app, ["ask", "mode", "mode=CIRCLE", "--fleet", "acme", *more], env=data)

            with WebSocket(ana):  # with a page, she keeps control
                wait_for(lambda: _act(ana, planes()[0]["system_id"], "MANUAL"), "an act")
                for more, exit_code, says in (
                    ((), 2, "say which aircraft: --plane NAME (plane7)"),
                    (("--plane", "plan7"), 1, "there is no plan7 in the fleet acme; enrolled: plane7"),
                    (
                        ("--plane", "plane7"),
                        1,
                        "Ana has control of plane7: wait until it is given up; --take-control takes it from",
                    ),
                    (("--plane", "plane7", "--take-control"), 0, "mode: done"),
                ):
                    result = ask(*more)
                    assert (result.exit_code, says in result.output) == (exit_code, True), result.output
            wait_for(lambda: planes()[0]["mode"] == "CIRCLE", "the mode")
            # So does a program.
            own: dict[str, Any] = {"folder": ground / "fleet", "key_file": ground / "fleet/acme.key", "history": False}
            with Station(record=False) as script, Fleet(script, org="acme", **own) as fleet:
                assert fleet.endpoint == told["fleet"]["endpoint"]
                assert script.wait_vehicle(name="plane7").telemetry.mode == "CIRCLE"
                assert asyncio.run(aio.wait_vehicle(script, name="plane7")).remote_name == "plane7"

            # A second aircraft: the first is there again by itself, and so is who has control.
            joined, is_new = join(put(ground, "enrol", "plane8")["token"], file=tmp_path / "second.json")
            assert (joined.name, is_new) == ("plane8", True)
            wait_for(lambda: _act(ana, planes()[0]["system_id"], "CIRCLE"), "an act after the network was joined anew")

            # Put out, it is silent for the ground, and told why it may be.
            assert run(ground, "revoke", "plane7", "--yes").exit_code == 0
            wait_for(lambda: _row(ground, "plane7")["is_present"] is False, "it to be gone", 20.0)
            result = run(ground, "enrol", "plane7")
            assert result.exit_code == 1
            assert "plane7 was revoked" in result.output


@pytest.mark.e2e
def test_a_second_ground_station_joins_commands_by_its_role_and_is_put_out(tmp_path: Path) -> None:
    from vencejo import Station
    from vencejo.errors import ControlHeld, NotPossibleNow
    from vencejo.fleet import Aircraft

    quiet: dict[str, Any] = {"record": False, "signing": False}
    ground = tmp_path / "ground/fleet"
    organisation = Organisation("acme", folder=ground)
    organisation.init(hosts=["127.0.0.1"])
    addresses: dict[str, Any] = {"listen": "tls/127.0.0.1:0", "door": "127.0.0.1:0", "history": False}
    with (
        simulated_plane() as link,
        Station(operator="ground", **quiet) as here,
        Fleet(here, org="acme", folder=ground, key_file=ground / "acme.key", **addresses),
    ):
        aboard = tmp_path / "aboard.json"
        join(organisation.enrol("plane7").text, file=aboard)
        with (
            Station(link, system_id=1, component_id=191, heartbeat=False, operator="board", **quiet) as board,
            Aircraft(board, member_file=aboard, history=False) as aircraft,
        ):
            plane = here.wait_vehicle()
            plane.set_mode("FBWA")
            wait_for(lambda: aircraft.status.holder == "ground", "control of the first")

            # The plane is in the field when the second one joins: it learns whom to obey over the network.
            elsewhere = tmp_path / "tower/fleet"
            token = organisation.enrol_station("tower").text
            found, is_new = join(token, file=elsewhere / "acme.json")
            assert (found.name, found.is_station, found.role, is_new) == ("tower", True, "operator", True)
            with (
                Station(operator="tower", **quiet) as there,
                Fleet(there, org="acme", folder=elsewhere, key_file=elsewhere / "acme.key", history=False) as tower,
            ):
                assert not [check for check in check_board(found, file=elsewhere / "acme.json") if not check.ok]
                seen = there.wait_vehicle()
                assert seen.remote_name == "plane7"
                wait_for(lambda: tower.key.encode() in _listed(aboard), "its key on board")
                with pytest.raises(ControlHeld, match="ground holds control of plane7"):
                    seen.set_mode("CIRCLE")
                assert (seen.control.holder, seen.control.is_held_here) == ("ground", False)
                # The first is a program, which gives it to whoever asks.
                seen.request_control()
                wait_for(lambda: seen.control.is_held_here, "control of the second")
                seen.set_mode("CIRCLE")
                assert aircraft.status.holder == "tower"

                # As an observer it loses control, and reads on.
                join(organisation.enrol_station("tower", role="observer").text, file=elsewhere / "acme.json")
                wait_for(lambda: aircraft.status.holder is None, "the end of its control")
                with pytest.raises(NotPossibleNow, match="observer"):
                    seen.set_mode("FBWA")
                assert len(seen.params.all()) > 100

                # A router that knows nothing of it lets it through still; the plane does not obey.
                revoked = elsewhere / "acme.json"
                organisation.revoke_station("tower")
                wait_for(lambda: tower.key.encode() not in _listed(aboard), "its key gone on board")
                assert [each.name for each in organisation.stations if each.revoked] == ["tower"]
                gone = check_board(found, file=revoked)
                assert any("tower was revoked" in check.message for check in gone if not check.ok)
                wait_for(lambda: not tower.status.is_connected, "that it is out of the fleet")
                assert "has this ground station been revoked?" in (tower.status.problem or "")
                plane.set_mode("FBWA")
                wait_for(lambda: aircraft.status.holder == "ground", "the first to act again")
    # The list outlives a start without any ground station.
    assert b"operator" in _listed(aboard)


def _listed(aboard: Path) -> bytes:
    """The list of ground stations that an aircraft keeps: names and roles as text, keys in hexadecimal digits."""
    signed = base64.b64decode(json.loads(aboard.read_text(encoding="ascii"))["stations"])
    return signed + signed.hex().encode()


def _act(client: Client, system: int, mode: str) -> bool:
    # Without a page, control goes after five seconds in which nothing was asked.
    client.done("POST", "control/take")
    return client.ask("POST", f"vehicles/{system}/mode", {"mode": mode}).status < 300


def _row(ground: Path, name: str) -> dict[str, Any]:
    row: dict[str, Any] = next(row for row in put(ground, "status")["aircraft"] if row["name"] == name)
    return row


@pytest.fixture
def fleet_here(tmp_path: Path) -> Iterator[tuple[Organisation, Any, Path]]:
    """A fleet with its ground station in this process, over QUIC, and a folder for those on board."""
    from vencejo import Station

    organisation = Organisation("acme", folder=tmp_path / "fleet")
    organisation.init(hosts=["127.0.0.1"])
    with (
        Station(record=False, signing=False) as station,
        Fleet(
            station,
            org="acme",
            listen="quic/127.0.0.1:0",
            door="127.0.0.1:0",
            folder=tmp_path / "fleet",
            key_file=tmp_path / "fleet" / "acme.key",
        ) as fleet,
    ):
        yield organisation, fleet, tmp_path


@pytest.mark.e2e
def test_a_program_beside_a_second_router_uses_that(tmp_path: Path) -> None:
    from vencejo import Station

    quiet: dict[str, Any] = {"record": False, "signing": False}
    valley, hill = tmp_path / "valley", tmp_path / "hill"
    organisation = Organisation("acme", folder=valley)
    organisation.init(hosts=["127.0.0.1"])
    own: dict[str, Any] = {"folder": hill, "key_file": hill / "acme.key", "history": False}
    with (
        reserved_ports() as (port,),
        Station(**quiet) as first,
        Fleet(
            first, org="acme", folder=valley, key_file=valley / "acme.key", listen="tls/127.0.0.1:0", door="127.0.0.1:0"
        ) as valleys,
        Station(**quiet) as second,
        Station(**quiet) as beside,
    ):
        at_hill = f"tls/127.0.0.1:{port}"
        join(organisation.enrol_station("hill", routers=[at_hill]).text, file=hill / "acme.json")
        with Fleet(second, org="acme", listen=at_hill, **own) as router:
            # The other router of the list is on this machine too.
            valleys.close()
            assert valleys.status == FleetStatus(is_connected=False, problem="the fleet was left")
            with Fleet(beside, org="acme", **own) as program:
                # Two at one port would not both be there.
                assert router.endpoint == program.endpoint == at_hill


def test_only_a_router_of_the_fleet_is_its_router_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from vencejo import Station

    with reserved_ports() as (port,), Station(record=False, signing=False) as station:
        at = f"tcp/127.0.0.1:{port}"
        monkeypatch.setattr("vencejo.fleet._PORT", port)
        assert router_here("ours", folder=tmp_path) is None, "nobody listens"
        with Fleet(station, org="ours", listen=at, folder=tmp_path, key_file=tmp_path / "key", history=False):
            assert router_here("ours", folder=tmp_path) == at
            assert router_here("theirs", folder=tmp_path) is None


@pytest.mark.e2e
def test_an_aircraft_comes_over_quic_and_has_its_certificate_renewed(
    fleet_here: tuple[Organisation, Fleet, Path],
) -> None:
    organisation, fleet, folder = fleet_here
    board = folder / "board"
    file = board / "fleet" / "aboard.json"
    joined, _ = join(organisation.enrol("plane7").text, file=file)
    assert joined.routers == (fleet.endpoint,)
    before = file.read_bytes()
    # By its own clock it has 25 days left: time for the next one.
    clock = Clock(folder)
    clock.set(65 * 86_400)
    with simulated_plane() as link, command(board, "onboard", "--link", link, clock=clock) as aircraft:
        aircraft.until(is_connected=True, problem=None)
        wait_for(lambda: file.read_bytes() != before, "the next certificate")
        wait_for(lambda: any(each.is_present for each in fleet.aircraft), "the aircraft")
        assert [each.name for each in fleet.aircraft] == ["plane7"]
        roll = json.loads((organisation.folder / "roll.json").read_text(encoding="utf-8"))["members"]["plane7"]
        assert roll["key"] != roll["before"], "of a new key, by the certificate of the one before"


def test_who_is_refused_is_told_why(fleet_here: tuple[Organisation, Fleet, Path]) -> None:
    organisation, fleet, folder = fleet_here
    token = organisation.enrol("plane7", lasts_s=0)
    assert token.text not in repr(token)
    with pytest.raises(NotPossibleNow, match=r"expired; ask for another with: vencejo fleet enrol plane7"):
        join(token.text, file=folder / "late.json")
    token = organisation.enrol("plane7")
    assert organisation.tokens == {"plane7": token.ends}
    found, is_new = join(token.text, file=folder / "aboard.json")
    assert is_new
    assert join(token.text, file=folder / "aboard.json") == (found, False)
    assert member(file=folder / "aboard.json") == found
    with pytest.raises(NotPossibleNow, match="has been used"):
        join(token.text, file=folder / "thief.json")
    assert member(file=folder / "thief.json") is None
    with pytest.raises(InvalidRequest, match="copy it again as a whole"):
        join(token.text[:-1], file=folder / "slip.json")
    # Another fleet's door in the middle: it is not who made the token, and gets nothing.
    other = Organisation("other", folder=folder / "elsewhere")
    other.init(hosts=["127.0.0.1"])
    organisation_roll = json.loads((organisation.folder / "roll.json").read_text(encoding="utf-8"))
    other_roll = json.loads((other.folder / "roll.json").read_text(encoding="utf-8"))
    assert fleet.door is not None
    (other.folder / "roll.json").write_text(json.dumps({**other_roll, "doors": [fleet.door]}), encoding="utf-8")
    with pytest.raises(LinkError, match="somebody else answers there than who made this token"):
        join(other.enrol("plane7").text, file=folder / "middle.json")
    assert organisation_roll == json.loads((organisation.folder / "roll.json").read_text(encoding="utf-8"))
    with pytest.raises(InvalidRequest, match="certificates"):
        _without(folder)
    (folder / "aboard.json").write_text("{}", encoding="ascii")
    with pytest.raises(VencejoError, match="damaged; join the fleet again"):
        member(file=folder / "aboard.json")


def _without(folder: Path) -> None:
    from vencejo import Station

    with Station(record=False, signing=False) as station:
        Fleet(station, org="nobody", listen="tls/127.0.0.1:0", folder=folder, key_file=folder / "nobody.key")


def test_the_doctor_says_what_is_wrong_and_what_to_do(fleet_here: tuple[Organisation, Fleet, Path]) -> None:
    organisation, _, folder = fleet_here
    file = folder / "aboard.json"
    found, _ = join(organisation.enrol("plane7").text, file=file)
    assert not [check for check in check_board(found, file=file) if not check.ok]
    wrong = [check for check in check_ground(organisation) if not check.ok]
    # The certificate is for 127.0.0.1 alone, where this machine may have other addresses as well.
    assert all("--host" in check.remedy for check in wrong), wrong

    def says(checks: list[Any], message: str, remedy: str) -> bool:
        return any(message in check.message and remedy in check.remedy for check in checks if not check.ok)

    organisation.revoke("plane7")
    assert says(check_board(found, file=file), "plane7 was revoked", "vencejo fleet status")
    join(organisation.enrol("plane8").text, file=folder / "other.json")
    now = datetime.fromtimestamp(time.time(), timezone.utc)
    later = now + timedelta(days=75)
    assert says(check_board(found, file=file, now=later), "plane7 ends on", "vencejo fleet enrol plane7")
    assert says(check_ground(organisation, now=later), "certificate of plane8 ends on", "renews it by itself")
    assert says(check_board(found, file=file, now=now - timedelta(days=9000)), "the clock here says", "timedatectl")
    assert says(check_ground(organisation, now=now + timedelta(days=9000)), "authority (CA) ended", "begin anew")
    assert says(check_ground(Organisation("none", folder=folder)), "no fleet none", "vencejo fleet init none")
    # A ground station elsewhere that is a router too, and does not run.
    gone = "tls/127.0.0.1:1"
    join(organisation.enrol_station("hill", routers=[gone]).text, file=folder / "hill.json")
    assert organisation.stations[0].routers == (gone,)
    assert says(check_ground(organisation), f"{gone}: ", "at hill: vencejo serve --fleet")
    assert f"The router of hill at {gone}: nobody listens" in run(folder, "status").output
    assert put(folder, "status")["stations"][0]["routers"][0]["problem"]
    again = f"vencejo fleet enrol --station --router {gone} hill"
    assert says(check_ground(organisation, now=later), "certificate of hill ends on", again)
    if os.name == "posix":
        file.chmod(0o644)
        (organisation.folder / "ca.key").chmod(0o640)
        assert says(check_board(found, file=file), "others on this machine may read", f"chmod 600 {file}")
        assert says(check_ground(organisation), "ca.key", "chmod 600")


def test_the_command_makes_a_fleet_once_and_prints_the_rules_of_a_router(tmp_path: Path) -> None:
    result = run(tmp_path, "enrol", "plane7", "--fleet", "acme")
    assert result.exit_code == 0, result.output
    assert "The fleet acme is made" in result.output
    assert "vencejo serve --fleet acme" in result.output
    assert "vencejo onboard --join vf1." in result.stdout
    folder = tmp_path / "fleet" / "acme"
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert "Nothing was changed" in run(tmp_path, "init", "acme").output
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    result = run(tmp_path, "enrol", "hill", "--router", "tls/hill.example.org:7447", "--role", "chief")
    assert "At the ground station hill" in result.output
    assert "vencejo serve --join vf1." in result.stdout
    result = run(tmp_path, "acl")
    settings = json.loads(result.stdout)
    assert settings["access_control"]["default_permission"] == "deny"
    assert settings["transport"]["link"]["tls"]["enable_mtls"] is True
    assert all(
        path.startswith(str(folder)) for path in settings["transport"]["link"]["tls"].values() if path is not True
    )
    for args, exit_code, says in [
        (("init", "Acme!"), 2, "is not a valid name"),
        (("init", "acme", "--host", "a b"), 2, "'a b' is not a host name or address"),
        (
            ("init", "new", "--ca-cert", __file__, "--ca-key", __file__),
            2,
            "the authority (CA): its certificate cannot be read",
        ),
        (("init", "acme", "--ca-cert", __file__), 2, "--ca-key"),
        (("revoke", "plane9", "--yes"), 1, "no aircraft plane9"),
        (("enrol", "Plane"), 2, "is not a valid name"),
        (("enrol", "Plane", "--fleet", "fresh"), 2, "is not a valid name"),
        (("enrol", "ground", "--station", "--fleet", "fresh"), 1, "take another name"),
        (("enrol", "hill", "--router", "tcp/127.0.0.1:7447", "--fleet", "fresh"), 2, "tcp/127.0.0.1:7447"),
        (("enrol", "hill", "--router", "tcp/127.0.0.1:7447"), 2, "tcp/127.0.0.1:7447"),
        (("enrol", "hill", "--router", "tls/0.0.0.0:7447"), 2, "tls/0.0.0.0:7447"),
        (("join", "vf1.nonsense"), 2, "copy it again as a whole"),
        (("acl", "--fleet", "other"), 1, "vencejo fleet init other"),
    ]:
        result = run(tmp_path, *args)
        assert (result.exit_code, says in result.output) == (exit_code, True), (args, result.output)
    assert not folder.with_name("fresh").exists(), "a name that cannot be makes no fleet"
    both = run(tmp_path, "--fleet", "acme", "--ros2", command="serve")
    assert (both.exit_code, "--ros2-router tcp/127.0.0.1:7450" in both.output) == (2, True), both.output
    assert "this computer is in no fleet" in run(tmp_path / "empty", "doctor").output
    assert "say which fleet" in run(tmp_path / "empty", "enrol", "plane7").output

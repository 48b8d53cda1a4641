"""`vencejo serve` with the simulated plane, through an independent client."""

from __future__ import annotations

import contextlib
import gzip
import http.client
import json
import re
import shutil
import socket
import ssl
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from vencejo.serve import has_app

from tests.faults.test_links import resident_bytes
from tests.server.client import Client, Served, WebSocket, frame, serving
from tests.support import ROOT, Metronome, simulated_plane, wait_for

MOST_OF_A_CLIENT = 4 << 20
"""Return our memory use, bytes."""
DEMO = ROOT / "python" / "vencejo" / "data" / "demo.waypoints"

pytestmark = pytest.mark.e2e


@pytest.fixture(name="plane", scope="module")
def _plane() -> Iterator[str]:
    with simulated_plane() as link:
        yield link


@pytest.fixture(name="served", scope="module")
def _served(plane: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("--link", plane, data=tmp_path_factory.mktemp("data")) as served:
        wait_for(lambda: Client(served.url).done("GET", "vehicles") != [], "a vehicle")
        yield served


@pytest.fixture(name="pilot")
def _pilot(served: Served) -> Iterator[Client]:
    client = served.client(name="pilot")
    if not client.done("GET", "session")["has_control"]:
        wait_for(lambda: client.ask("POST", "control/take").status == 200, "control, once the test before has lost it")
    yield client
    client.ask("DELETE", "session")


def test_a_refusal_says_the_vehicles_reasons(pilot: Client) -> None:
    pilot.done("POST", "vehicles/1/mode", {"mode": "RTL"})
    refused = pilot.ask("POST", "vehicles/1/arm")
    assert refused.status == 409, refused.body
    assert refused.headers["content-type"] == "application/problem+json"
    problem = refused.json
    assert problem["type"] == "urn:vencejo:command-refused"
    assert any("not armable" in reason for reason in problem["reasons"]), problem
    assert "MANUAL" in problem["remedy"]
    pilot.done("POST", "vehicles/1/mode", {"mode": "MANUAL"})
    unknown = pilot.ask("POST", "vehicles/1/mode", {"mode": "SIDEWAYS"})
    assert unknown.status == 422
    assert "SIDEWAYS" in unknown.json["detail"]


@pytest.fixture(name="flyer")
def _flyer(tmp_path: Path) -> Iterator[Client]:
    """A separate plane for tests that fly."""
    with simulated_plane() as link, serving("--link", link, data=tmp_path) as served:
        client = served.client(name="pilot")
        wait_for(lambda: client.done("GET", "vehicles") != [], "a vehicle")
        yield client


def test_a_mission_is_sent_flown_and_followed(flyer: Client) -> None:
    pilot = flyer
    plan = pilot.ask("POST", "plan/parse?name=demo.waypoints", DEMO.read_bytes()).json
    assert pilot.done("POST", "plan/check", {"plan": plan, "vehicle": 1}) == []
    with WebSocket(pilot) as socket:
        hello = socket.until("hello")
        assert hello["has_control"] is True
        socket.say(type="subscribe", vehicle=1, rate_hz=20)
        socket.say(type="assess_plan", seq=7, vehicle=1, plan=plan)
        assessment = socket.until("assessment", seq=7)
        assert (assessment["findings"], assessment["trip"]["end"]) == ([], "end")
        assert assessment["trip"]["distance_m"] > 5000.0
        socket.say(type="plan_way", seq=8, vehicle=1, plan=plan)
        drawn = socket.until("way", seq=8)
        told = pilot.done("POST", "plan/way", {"plan": plan, "vehicle": 1})
        assert (drawn["stops"], drawn["jumps"]) == (told["stops"], told["jumps"])
        # The terrain may have arrived in between.
        points = drawn["profile"]["points"]
        assert points == told["profile"]["points"]
        assert {point["item"] for point in points} > {None, 1}
        nowhere = {"lat_deg": 91.0, "lon_deg": 0.0, "alt_amsl_m": 0.0}
        socket.say(type="plan_way", seq=9, plan={**plan, "home": nowhere})
        assert "91" in socket.until("error", seq=9)["detail"]
        operation = pilot.done("PUT", "vehicles/1/plan/mission", plan)
        assert operation["kind"] == "upload_mission"
        ended = socket.until("operation", id=operation["id"], state="done")
        assert "result" not in ended
        on_board = pilot.done("GET", f"operations/{operation['id']}")["result"]
        assert [item["command"] for item in on_board["items"]] == [item["command"] for item in plan["items"]]
        state = pilot.done("GET", "vehicles/1")["plan_states"]["mission"]
        assert (state["state"], state["count"]) == ("verified", len(plan["items"]))

        pilot.done("POST", "vehicles/1/mode", {"mode": "MANUAL"})

        def is_ready() -> bool:
            status = pilot.done("GET", "vehicles/1")["telemetry"].get("sys_status") or {}
            return status.get("is_ready_to_arm") is True

        wait_for(is_ready, "the pre-arm checks")
        pilot.done("POST", "vehicles/1/mode", {"mode": "AUTO"})
        pilot.done("POST", "vehicles/1/arm")
        socket.until("event", vehicle=1, kind="armed")
        socket.until("event", vehicle=1, kind="item_reached", detail={"item": 1})
        pilot.done("PUT", "vehicles/1/params/SIM_SPEEDUP", {"value": 4})
        groups: dict[str, object] = {}
        items: list[int] = []
        while not items or max(items) < 3:
            message = socket.take()
            assert message is not None
            if message["type"] == "telemetry":
                groups.update(message["groups"])
                progress = message.get("progress")
                items += [progress["item"]] if progress and progress["item"] else []
        pilot.done("PUT", "vehicles/1/params/SIM_SPEEDUP", {"value": 1})
        assert items == sorted(items), "the mission only goes on"
        assert {"heartbeat", "attitude", "position", "hud", "gps", "imu", "wind", "batteries"} <= groups.keys()
        assert pilot.done("GET", "vehicles/1")["telemetry"]["position"]["alt_rel_home_m"] > 10
        ahead = pilot.done("POST", "plan/what-if", {"vehicle": 1, "triggers": ["return-asked"] * 1_000})
        assert ahead["ahead"]["ending"] == "landed", "the rest of its mission, from where it is"
        assert [one["reaction"] for one in ahead["what_ifs"]] == ["returns"]
        assert (ahead["outlook"], ahead["is_circle_known"]) == (None, True), "nothing was expected yet"
        track = {name: ahead["ahead"]["track"][name] for name in ("time_s", "lat_deg", "lon_deg", "height_m", "item")}
        followed = {"vehicle": 1, "triggers": [], "begun": {"now": ahead["now"], "track": track}}
        outlook = pilot.done("POST", "plan/what-if", followed)["outlook"]
        # in a climb the height is not compared
        assert (abs(outlook["late_s"]) < 20.0, abs(outlook["low_m"] or 0.0) < 20.0) == (True, True), outlook
        track["item"].pop()
        assert pilot.ask("POST", "plan/what-if", followed).status == 422, "lists of one length"
        assert pilot.ask("POST", "plan/what-if", {"plan": plan, "vehicle": 1}).status == 422, "a moment is missing"
        pilot.done("POST", "vehicles/1/loiter")
        circles = pilot.done("POST", "plan/what-if", {"vehicle": 1, "triggers": ["return-asked", "radio-lost"]})
        assert circles["ahead"]["ending"] == "unlimited", "what it does now, without its mission"
        assert [one["reaction"] for one in circles["what_ifs"]] == ["returns", "returns"]
        pilot.done("POST", "vehicles/1/mode", {"mode": "TAKEOFF"})
        climbed = pilot.done("POST", "plan/what-if", {"vehicle": 1, "triggers": ["radio-lost"]})
        assert climbed["ahead"]["ending"] == "unlimited", "above TKOFF_ALT it circles"
        assert [one["reaction"] for one in climbed["what_ifs"]] == ["returns"]
        profile = pilot.done("GET", "vehicles/1/profile")
        assert (profile["capacity_mah"], profile["airframe"]["origin"]) == (None, "parameters"), "none were read"
        assert 0.0 < profile["charge_pct"] <= 100.0
        with_battery = {
            "plan": plan,
            "vehicle": 1,
            "profile": {
                "airframe": profile["airframe"],
                "battery": {"capacity_mah": 3300.0, "charge_pct": 100.0, "voltage_v": 15.0, "power_cruise_w": 150.0},
            },
        }
        left = pilot.done("POST", "plan/rehearse", with_battery)
        assert left["battery_unknown"] is None
        assert left["battery"]["capacity_wh"] == pytest.approx(49.5, abs=0.1)
        odds = pilot.done("POST", "plan/rehearse/spread", {**with_battery, "runs": 6, "seed": 4})
        assert (odds["runs"], sum(ending["count"] for ending in odds["endings"])) == (6, 6)
        assert odds["battery_left_pct"]["low"] < odds["battery_left_pct"]["high"] < 100.0
        corridor = odds["corridor"]
        assert len({len(corridor[side]) for side in ("time_s", "left", "right", "low_m", "high_m")}) == 1
        assert pilot.ask("POST", "plan/rehearse/spread", {**with_battery, "runs": 1_001}).status == 422
        pilot.done("POST", "vehicles/1/altitude", {"alt_m": 120, "alt_frame": "home"})
        # A separate connection: one that does not read for as long as this may take is disconnected.
        with WebSocket(pilot) as events:
            events.until("hello")
            pilot.done("POST", "vehicles/1/return-to-launch")
            events.until("event", vehicle=1, kind="mode", detail={"from": "TAKEOFF", "mode": "RTL"})
        asked = pilot.ask("POST", "vehicles/1/reboot")
        assert (asked.status, asked.json["cause"]["act"]) == (428, "reboot")
        given = {"Vencejo-Confirmation": asked.json["cause"]["confirmation"]}
        refused = pilot.ask("POST", "vehicles/1/reboot", **given)
        assert (refused.status, refused.json["type"]) == (409, "urn:vencejo:armed")
        read = pilot.operation("POST", "vehicles/1/plan/mission/read")
        assert read["items"] == on_board["items"]
        known = pilot.done("GET", "vehicles/1/plan/mission")
        assert (known["state"]["state"], known["plan"]) == ("verified", read)
        same = {"hash": known["state"]["hash"], "changes": []}
        assert pilot.done("POST", "vehicles/1/plan/compare", read)["mission"] == same
        read["items"][1]["params"][6] += 10
        changed = {"kind": "changed", "item": 2, "on_board": 2, "fields": ["height"]}
        assert pilot.done("POST", "vehicles/1/plan/compare", read)["mission"] == same | {"changes": [changed]}


def test_parameters_are_read_and_written(pilot: Client) -> None:
    params = pilot.operation("GET", "vehicles/1/params")
    assert len(params) > 100
    before = next(param for param in params if param["name"] == "RTL_AUTOLAND")["value"]
    assert pilot.done("GET", "vehicles/1/params/RTL_AUTOLAND")["value"] == before
    assert pilot.done("PUT", "vehicles/1/params/RTL_AUTOLAND", {"value": 1})["value"] == 1
    pilot.done("PUT", "vehicles/1/params/RTL_AUTOLAND", {"value": before})
    assert pilot.ask("GET", "vehicles/1/params/NO_SUCH").status == 404


@pytest.mark.fault(47, figure="20 browsers and one that does not read cost ≤ 4 MiB each")
@pytest.mark.fault(63, figure="20 browsers and one that does not read: all are served, a command goes through")
def test_twenty_browsers_and_one_that_does_not_read(served: Served, pilot: Client) -> None:
    counts = [0] * 20
    stop = threading.Event()
    before = resident_bytes(served.process.pid)

    def follow(place: int) -> None:
        with WebSocket(served.client(name=f"browser {place}")) as socket:
            socket.say(type="subscribe", vehicle=1, rate_hz=10)
            while not stop.is_set():
                message = socket.take()
                if message is None:
                    return
                counts[place] += message["type"] == "telemetry"

    threads = [threading.Thread(target=follow, args=(place,)) for place in range(len(counts))]
    idle = WebSocket(pilot, receive_buffer=4096)
    idle.say(type="subscribe", vehicle=1, rate_hz=50)
    for thread in threads:
        thread.start()
    try:
        wait_for(lambda: min(counts) >= 20, "telemetry for everybody")
        with Metronome() as metronome:
            pilot.done("POST", "vehicles/1/mode", {"mode": "RTL"})
            assert metronome.now_s < 10.0, "a command waits for nobody's browser"
        seen = min(counts)
        wait_for(lambda: min(counts) >= seen + 10, "telemetry after the command")
        assert resident_bytes(served.process.pid) - before <= (len(counts) + 1) * MOST_OF_A_CLIENT
    finally:
        stop.set()
        for thread in threads:
            thread.join(30)
        idle.close()


@pytest.mark.fault(47, figure="10 messages of 1 MiB: their connections end, ≤ 4 MiB each")
def test_messages_of_a_megabyte_end_their_connection(served: Served, pilot: Client) -> None:
    before = resident_bytes(served.process.pid)
    message = frame(0x1, bytes(1 << 20))
    with WebSocket(pilot) as reading, contextlib.ExitStack() as stack:
        reading.until("hello")
        rude = [stack.enter_context(WebSocket(pilot)) for _ in range(10)]
        for each in rude:
            with contextlib.suppress(OSError):  # it may have disconnected before everything was sent
                each.put(message)
        for each in rude:
            while each.take() is not None:
                pass
        reading.say(type="subscribe", vehicle=1, rate_hz=50)
        reading.until("telemetry")
    assert resident_bytes(served.process.pid) - before <= len(rude) * MOST_OF_A_CLIENT


@pytest.mark.fault(42, figure="another Host 403")
@pytest.mark.fault(41, figure="WebSocket from another site 403, without a session 401")
def test_only_its_own_pages_may_use_it(served: Served, pilot: Client) -> None:
    for path in ("info", "vehicles", "/", "/api/v1/openapi.json"):
        assert pilot.ask("GET", path).status in {200, 503}
        assert pilot.ask("GET", path, Origin="http://evil.example").status == 403
        assert pilot.ask("GET", path, Host="evil.example").status == 403
    assert pilot.ask("POST", "vehicles/1/arm", Origin="http://127.0.0.1:1").status == 403
    with WebSocket(pilot, origin="http://evil.example") as socket:
        assert socket.status == 403
    with WebSocket(pilot, origin=served.url) as socket:
        assert socket.status == 101
    with WebSocket(Client(served.url)) as socket:
        assert socket.status == 401


def test_the_description_is_served_as_committed(pilot: Client) -> None:
    committed = json.loads((ROOT / "schemas" / "openapi.json").read_text(encoding="utf-8"))
    assert pilot.done("GET", "openapi.json") == committed


@pytest.mark.fault(44, figure="viewer, operator, second operator and nobody at a served station; token file 0600")
def test_beyond_loopback_a_token_decides(plane: str, tmp_path: Path) -> None:
    with serving("--link", "udpin:127.0.0.1:0", "--host", "0.0.0.0", "--plain-http", data=tmp_path) as served:
        kept = tmp_path / "server-tokens.json"
        assert stat.S_IMODE(kept.stat().st_mode) == 0o600
        tokens = json.loads(kept.read_text())
        assert (served.token("operator"), served.token("viewer")) == (tokens["operator"], tokens["viewer"])
        nobody = Client(served.url)
        assert nobody.done("GET", "info")["needs_token"] is True
        assert nobody.ask("GET", "vehicles").status == 401
        assert nobody.ask("POST", "session", {"token": "0" * 32}).status == 401
        viewer = served.client(token=served.token("viewer"))
        operator = served.client(token=served.token("operator"))
        link = {"address": plane}
        assert viewer.ask("GET", "links").status == 200
        assert (viewer.ask("POST", "links", link).status, viewer.ask("POST", "control/take").status) == (403, 403)
        second = served.client(token=served.token("operator"))
        assert second.ask("POST", "links", link).status == 423
        opened = operator.done("POST", "links", link)
        wait_for(lambda: viewer.done("GET", "vehicles") != [], "the vehicle of the new link")
        assert operator.ask("DELETE", f"links/{opened['id']}").status == 204
    with serving("--link", "udpin:127.0.0.1:0", "--token", data=tmp_path) as served:
        assert served.token("operator") == tokens["operator"], "the tokens stay"


def test_it_says_where_it_is_and_ends_in_order(tmp_path: Path) -> None:
    pytest.importorskip("segno")
    with serving("--link", "udpin:127.0.0.1:0", data=tmp_path) as served:
        client = served.client()
        with WebSocket(client) as socket:
            socket.until("hello")
            served.process.terminate()
            while socket.take() is not None:
                pass
            assert socket.closed is not None
            assert socket.closed[0] == 1001
        _, errors = served.process.communicate(timeout=120)
        assert "Traceback" not in errors, errors
    command = [sys.executable, "-m", "vencejo.cli", "serve", "--port=0", "--host=0.0.0.0", "--no-record"]
    command += ["--link=udpin:127.0.0.1:0", "--plain-http"]
    env = {"VENCEJO_DATA": str(tmp_path), "PYTHONIOENCODING": "utf-8", "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=env) as process:
        assert process.stdout is not None
        lines = [process.stdout.readline().decode() for _ in range(12)]
        process.terminate()
    assert any("#token=" in line and line.startswith("To command") for line in lines), lines
    assert any("\N{FULL BLOCK}" in line or "\N{UPPER HALF BLOCK}" in line for line in lines), lines


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--host=no.such.host.invalid"], "no address"),
        (["--host=0.0.0.0"], "--plain-http"),
        (["--cert=nothing.pem"], "key"),
        (["--cert=nothing.pem", "--key=nothing.pem"], "PEM"),
        (["--link=nonsense:"], "nonsense"),
    ],
)
def test_what_cannot_be_served_says_why(options: list[str], word: str, tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "vencejo.cli",
        "serve",
        "--port=0",
        "--no-record",
        "--link=udpin:127.0.0.1:0",
        *options,
    ]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode in {1, 2}, ended
    assert word in ended.stderr
    assert "Traceback" not in ended.stderr


OPENSSL = """[ca]
default_ca = own
[own]
new_certs_dir = {folder}
database = {folder}/index
rand_serial = yes
default_md = sha256
policy = any
x509_extensions = names
[any]
commonName = supplied
[names]
subjectAltName = {name}
"""


def certificate_of(folder: Path, *, name: str = "IP:127.0.0.1", until: str = "20991231235959Z") -> tuple[Path, Path]:
    """A certificate that vouches for itself, and its key."""
    certificate, key, request, config = (
        folder / file for file in ("cert.pem", "key.pem", "request.pem", "openssl.cnf")
    )
    config.write_text(OPENSSL.format(folder=folder, name=name), encoding="utf-8")
    (folder / "index").touch()
    curve = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /CN=localhost"
    dates = f"-startdate 20200101000000Z -enddate {until}"
    for make in (
        f"openssl req -new {curve} -keyout {key} -out {request}",
        f"openssl ca -config {config} -selfsign -keyfile {key} -in {request} -out {certificate} {dates} -batch",
    ):
        subprocess.run(make.split(), check=True, capture_output=True)
    return certificate, key


@pytest.mark.fault(45, figure="expired, another's name, TLS 1.1: a client refuses; a key that others may read is told")
@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes a certificate with openssl")
@pytest.mark.filterwarnings("ignore:ssl.TLSVersion")
@pytest.mark.parametrize(
    ("name", "until", "version", "word"),
    [
        ("IP:127.0.0.1", "20200102000000Z", ssl.TLSVersion.TLSv1_2, "expired"),
        ("DNS:station.example", "20991231235959Z", ssl.TLSVersion.TLSv1_2, "mismatch"),
        ("IP:127.0.0.1", "20991231235959Z", ssl.TLSVersion.TLSv1_1, "handshake failure|protocol version"),
    ],
)
def test_a_client_refuses_what_is_no_tls_of_its_station(
    name: str, until: str, version: ssl.TLSVersion, word: str, tmp_path: Path
) -> None:
    certificate, key = certificate_of(tmp_path, name=name, until=until)
    key.chmod(0o644)
    options = ["--link=udpin:127.0.0.1:0", f"--cert={certificate}", f"--key={key}"]
    with serving(*options, data=tmp_path) as served:
        context = ssl.create_default_context(cafile=str(certificate))
        if version < ssl.TLSVersion.TLSv1_2:
            context.set_ciphers("ALL:@SECLEVEL=0")
            context.minimum_version = context.maximum_version = version
        address = ("127.0.0.1", int(served.url.rpartition(":")[2]))
        with socket.create_connection(address, timeout=120) as plain, pytest.raises(ssl.SSLError, match=word):
            context.wrap_socket(plain, server_hostname=address[0])
        assert served.process.stderr is not None
        assert f"chmod 600 {key}" in served.process.stderr.readline()


@pytest.mark.fault(45, figure="a page that came without TLS is another page; Secure and HSTS are set")
@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes a certificate with openssl")
def test_it_speaks_tls_with_a_given_certificate(tmp_path: Path) -> None:
    certificate, key = certificate_of(tmp_path)
    options = ["--link=udpin:127.0.0.1:0", f"--cert={certificate}", f"--key={key}"]
    with serving(*options, data=tmp_path) as served:
        assert served.url.startswith("https://127.0.0.1:")
        port = int(served.url.rpartition(":")[2])
        context = ssl.create_default_context(cafile=str(certificate))
        connection = http.client.HTTPSConnection("127.0.0.1", port, context=context, timeout=120)
        connection.request("POST", "/api/v1/session", headers={"Origin": served.url})
        response = connection.getresponse()
        assert response.status == 200
        assert "; Secure" in response.headers["Set-Cookie"]
        assert response.headers["Strict-Transport-Security"].startswith("max-age=")
        response.read()
        connection.request("POST", "/api/v1/session", headers={"Origin": f"http://127.0.0.1:{port}"})
        assert connection.getresponse().status == 403, "a page that came without TLS is another page"
        connection.close()


@pytest.mark.skipif(not has_app(), reason="the web app is not in this build")
def test_the_pages_come_packed_and_their_parts_are_kept(served: Served) -> None:
    client = Client(served.url)
    page = client.ask("GET", "/", Accept_Encoding="gzip")
    assert (page.status, page.headers["content-type"]) == (200, "text/html; charset=utf-8")
    assert page.headers["cache-control"] == "no-cache"
    assert client.ask("GET", "/", If_None_Match=page.headers["etag"]).status == 304
    assert client.ask("GET", "/some/page/of/the/app").headers["content-type"] == "text/html; charset=utf-8"
    text = gzip.decompress(page.body).decode() if page.headers.get("content-encoding") == "gzip" else page.body.decode()
    parts = re.findall(r'(?:src|href)="(/assets/[^"]+)"', text)
    assert parts
    for part in parts:
        answer = client.ask("GET", part, Accept_Encoding="gzip")
        assert answer.headers["cache-control"] == "public, max-age=31536000, immutable"
        assert answer.headers["content-encoding"] == "gzip"
        kind = "text/javascript" if part.endswith(".js") else "text/css"
        assert answer.headers["content-type"].startswith(kind)
    assert client.ask("GET", "/assets/nothing.js").status == 404
    assert b"root:" not in client.ask("GET", "/../../../../etc/passwd").body

"""What clients of many years send: proxies as their configurations have them, old encodings, batches, pages in a browser."""

from __future__ import annotations

import base64
import contextlib
import os
import socket
import struct
import threading
from collections.abc import Iterator
from typing import Any

import pytest
import vencejo
from vencejo.jderobot import IceServer, IceSettings
from vencejo.jderobot.marks import Marks

from tests.jderobot.support import ANY_PORT, INTERFACES, Client, address_of, client_of
from tests.support import HOME, wait_for

LAT, LON, _ = HOME


@pytest.fixture(scope="module")
def server() -> Iterator[IceServer]:
    """The interfaces of a driver that has heard no vehicle."""
    ports = {**ANY_PORT, "Pose3D.Endpoints": "tcp -h 127.0.0.1 -p 0:ws -h 127.0.0.1 -p 0"}
    # However slowly a test goes on: marks wait for its mission.
    settings = IceSettings().with_settings({**ports, "AloneAfter": "600"}, where="here")
    with vencejo.Station(record=False) as station, IceServer(station, settings) as server:
        yield server


@pytest.fixture
def client(server: IceServer) -> Iterator[Client]:
    """A client of it."""
    with client_of(server.proxies) as client:
        yield client


def proxy(client: Client, interface: str, text: str) -> Any:
    """A proxy as a configuration has it, its port that of the driver: ``checkedCast`` asks for ice_isA."""
    name = {"Extra": "ArDroneExtra"}.get(interface, interface)
    _, port = address_of(client.proxies[interface])
    found = getattr(client.jderobot, f"{name}Prx").checkedCast(
        client.communicator.stringToProxy(text.format(port=port))
    )
    assert found is not None, text
    return found


@pytest.mark.parametrize(
    "text",
    [
        "ardrone_pose3d:default -h localhost -p {port}",
        "ardrone_pose3d:default -h 0.0.0.0 -p {port}",
        "ardrone_pose3d:tcp -h 127.0.0.1 -p {port} -t 10000",
        "ardrone_pose3d -t -e 1.0:default -h 127.0.0.1 -p {port} -t 10000",
        "ardrone_pose3d -e 1.1 -p 1.0:tcp -h 127.0.0.1 -p {port} -z",
    ],
    ids=["localhost", "any", "timeout", "encoding 1.0", "compressed"],
)
def test_proxies_of_existing_configurations(client: Client, text: str) -> None:
    pose = proxy(client, "Pose3D", text)
    assert pose.getPose3DData().q0 == 1.0
    pose.ice_ping()
    assert pose.ice_id() == "::jderobot::Pose3D"
    assert pose.ice_ids() == ["::Ice::Object", "::jderobot::Pose3D"]
    assert pose.ice_isA("::jderobot::Pose3D")
    assert not pose.ice_isA("::jderobot::Navdata")


def test_each_object_tells_its_type_and_the_camera_its_base(client: Client) -> None:
    for interface in INTERFACES:
        module = "vencejo::Telemetry" if interface == "Precise" else f"jderobot::{interface}"
        module = module.replace("::Extra", "::ArDroneExtra")
        assert client.proxy(interface).ice_id() == f"::{module}"
    assert client.camera.ice_ids() == ["::Ice::Object", "::jderobot::Camera", "::jderobot::ImageProvider"]
    # Viewers of the JdeRobot platform have this name for it.
    other = proxy(client, "Camera", "ardrone_camera:default -h 127.0.0.1 -p {port}")
    assert other.getImageFormat()[0] == "RGB8"


@pytest.mark.parametrize("encoding", ["1.0", "1.1"])
def test_missions_of_both_encodings_with_one_pose_twice(client: Client, encoding: str) -> None:
    """The station that JdeRobot had puts the same object twice at the beginning; on the wire it is there once."""
    mission = proxy(client, "Mission", f"ardrone_mission -e {encoding}:tcp -h 127.0.0.1 -p {{port}} -t 10000")
    first = client.jderobot.Pose3DData(x=LAT + 0.01, y=LON, h=40.0)
    rest = client.jderobot.Pose3DData(x=LAT, y=LON, h=40.0)
    extra = proxy(client, "Extra", f"ardrone_extra -e {encoding}:tcp -h 127.0.0.1 -p {{port}}")
    extra.takeoff()
    extra.land()
    assert mission.setMissionData(client.jderobot.MissionData([first, first, rest])) == 2, "no vehicle has been heard"
    first.x = 95.0
    assert mission.setMissionData(client.jderobot.MissionData([rest, first, first])) == 1, "off the globe"
    assert mission.setMissionData(client.jderobot.MissionData([])) == 1
    assert mission.setMissionData(None) == 1
    assert mission.setMissionData(client.jderobot.MissionData([None])) == 1
    assert isinstance(mission.getMissionData(), client.jderobot.MissionData)


def test_calls_of_one_way_in_compressed_batches_arrive(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    # Nothing answers, and a mission that came between the two marks would use up the first.
    landing, mark = threading.Event(), Marks.mark

    def marked(marks: Marks, now_s: float, *, takeoff: bool = False, land: bool = False) -> None:
        mark(marks, now_s, takeoff=takeoff, land=land)
        if land:
            landing.set()

    monkeypatch.setattr(Marks, "mark", marked)
    extra = client.extra.ice_compress(True).ice_batchOneway()
    extra.ledAnimation(1, 2.0, 3.0)
    extra.takeoff()
    extra.land()
    extra.ice_flushBatchRequests()
    wait_for(landing.is_set, "the last call of the batch")
    alone = client.mission_data((LAT, LON, 60.0))
    assert client.mission.setMissionData(alone) == 1, "both marks: one pose cannot be take-off and landing"
    assert client.mission.setMissionData(alone) == 2, "the mission used them up"


def test_a_facet_that_no_object_has_is_refused(client: Client) -> None:
    with pytest.raises(client.ice.FacetNotExistException):
        client.pose.ice_facet("other").ice_ping()
    with pytest.raises(client.ice.ObjectNotExistException):
        client.pose.ice_identity(client.ice.stringToIdentity("category/ardrone_pose3d")).ice_ping()


def test_calls_that_a_client_has_given_up_harm_nothing(client: Client) -> None:
    hasty = client.mission.ice_invocationTimeout(1)
    pending = [hasty.getMissionDataAsync() for _ in range(50)]
    for call in pending:
        with contextlib.suppress(client.ice.InvocationTimeoutException):
            call.result()
    assert client.pose.getPose3DData().q0 == 1.0


def test_web_sockets_for_pages_and_programs(client: Client) -> None:
    """A browser lets any page speak with this machine; only pages of this machine are answered."""
    text = client.proxies["Pose3D"]
    over_ws = text.partition(":")[0] + ":ws" + text.partition(":ws")[2]
    pose = client.jderobot.Pose3DPrx.checkedCast(client.communicator.stringToProxy(over_ws))
    assert pose is not None
    assert isinstance(pose.ice_getConnection().getInfo(), client.ice.WSConnectionInfo)
    assert pose.getPose3DData().q0 == 1.0
    _, port = address_of(over_ws)
    assert page_is_answered(port, "http://localhost:3000")
    assert not page_is_answered(port, "https://example.org")


def test_datagrams_are_no_endpoints() -> None:
    settings = IceSettings(endpoints={"Extra": "udp -h 127.0.0.1 -p 0"})
    with (
        vencejo.Station(record=False) as station,
        pytest.raises(vencejo.InvalidRequest, match=r"Extra.Endpoints is 'udp .*datagrams have no answer"),
        IceServer(station, settings),
    ):
        pass


def page_is_answered(port: int, origin: str) -> bool:
    """Whether ``ice_ping`` by a page of this origin has the answer "done", by RFC 6455 and Ice's protocol alone."""
    with socket.create_connection(("127.0.0.1", port), timeout=120) as page, page.makefile("rb") as stream:
        key = base64.b64encode(os.urandom(16)).decode()
        page.sendall(
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nOrigin: {origin}\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Protocol: ice.zeroc.com\r\n\r\n".encode()
        )
        assert b"101" in stream.readline()
        while stream.readline() != b"\r\n":
            pass

        def read() -> bytes:
            head = stream.read(2)
            size = head[1] & 0x7F
            if size == 126:
                size = struct.unpack(">H", stream.read(2))[0]
            return stream.read(size)

        assert read()[8] == 3, "ValidateConnection"
        body = (
            struct.pack("<I", 1)
            + b"\x0eardrone_pose3d\x00\x00\x08ice_ping\x02\x00"
            + struct.pack("<I", 6)
            + b"\x01\x01"
        )
        message = b"IceP\x01\x00\x01\x00\x00\x00" + struct.pack("<I", 14 + len(body)) + body
        page.sendall(bytes([0x82, 0x80 | len(message)]) + b"\x00" * 4 + message)
        answer = read()
        assert answer[8] == 2, "Reply"
        status = answer[18]
        assert status == 0 or b"not let in" in answer
        return status == 0

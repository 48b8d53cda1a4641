"""What may stand in a request where a Slice class is taken: what clients send is let through, everything else is refused.

Ice for Python ends its process when a reference to an object leads nowhere (3.7.8: one byte 02 does it), so the driver is always a
process of its own here. The bytes that must be let through are those of Ice's own clients, in both encodings and both formats.
"""

from __future__ import annotations

import contextlib
import os
import random
import re
import socket
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from vencejo.jderobot import wire
from vencejo.jderobot.access import Peer
from vencejo.jderobot.dispatch import SHAPES, Dialects
from vencejo.jderobot.wire import Malformed, check

from tests.faults.mock import MockPlane
from tests.jderobot.support import (
    INTERFACES,
    SLICE,
    Client,
    address_of,
    client_of,
    driver,
    load_slices,
    message,
    operations,
    raw,
)
from tests.server.client import Served
from tests.support import wait_for

ENCODINGS = ("1.0", "1.1")
OBJECTS = {"Missions": "Precise"}
"""The settings' name of an interface, where it is another one."""
MUTANTS = int(os.environ.get("VENCEJO_MUTANTS", "300"))
"""Damaged bodies for each operation that takes a class; of garbage to any operation seven times as many."""


def other_mission() -> Any:
    """The proxy of Mission as mission_sequence.ice has it, beside the usual one in one process."""
    ice, jderobot, _ = load_slices("mission")
    folder = SLICE / "jderobot"
    ice.loadSlice("", ["--all", f"-I{SLICE}", "-DMission=MissionOfPoses", str(folder / "mission_sequence.ice")])
    return jderobot.MissionOfPosesPrx


def samples(client: Client) -> dict[str, list[tuple[str, list[tuple[Any, ...]]]]]:
    """Parameters for every operation that takes a class: those that are full, empty, null, and one object twice."""
    jderobot, precise, unset = client.jderobot, client.precise, client.ice.Unset
    pose, other = jderobot.Pose3DData(1, 2, 3, 4, 5, 6, 7, 8), jderobot.Pose3DData(x=0.5)
    item = precise.MissionItem(16, 3, 1.0, unset, 3.0, unset, 40.0, -3.0, 60.0, False)
    zone = precise.Zone(True, [precise.GeoPoint(40.0, -3.0)], 900.0)
    rally = precise.RallyPoint(40.0, -3.0, 70.0)
    plan = precise.Plan(
        [item, precise.MissionItem(), item],
        precise.Home(40.0, -3.0, 600.0),
        [zone, precise.Zone(points=[])],
        rally,
        [rally],
    )
    bare = precise.Plan([], unset, [], unset, [])
    kind = precise.PlanKind.RallyPlan
    return {
        "Pose3D": [("setPose3DData", [(pose,), (None,)])],
        "CMDVel": [("setCMDVelData", [(jderobot.CMDVelData(1, 2, 3, 4, 5, 6),), (None,)])],
        "Camera": [
            ("setCameraDescription", [(jderobot.CameraDescription("nose", "á" * 200, ""),), (None,)]),
        ],
        "Mission": [
            (
                "setMissionData",
                [(jderobot.MissionData(poses),) for poses in ([pose, pose, other, None], [], [other] * 300)]
                + [(None,)],
            )
        ],
        "MissionOfPoses": [
            ("setMissionData", [([pose, pose, other, None],), ([pose],), ([],), ([other, pose] * 200,)])
        ],
        "Missions": [
            ("check", [(7, plan), (0, bare), (0, None)]),
            ("upload", [(7, kind, plan), (0, kind, bare), (0, kind, None)]),
        ],
    }


def written(encoding: str, *, sliced: bool) -> dict[tuple[str, str], list[bytes]]:
    """The parameters of each operation as Ice writes them, by interface and operation."""
    taken: list[bytes] = []

    def ice_invoke(_: Any, data: bytes, current: Any) -> tuple[bool, bytes]:
        taken.append(bytes(data))
        return False, b""

    found: dict[tuple[str, str], list[bytes]] = {}
    with client_of({}, Ice_Default_SlicedFormat=str(int(sliced))) as client:
        ice = client.ice
        proxies = {
            "MissionOfPoses": other_mission(),
            **{name: getattr(client.jderobot, f"{name}Prx") for name in ("Pose3D", "CMDVel", "Camera", "Mission")},
            "Missions": client.precise.MissionsPrx,
        }
        adapter = client.communicator.createObjectAdapterWithEndpoints("", "tcp -h 127.0.0.1 -p 0")
        taker = type("Taker", (ice.Blobject,), {"ice_invoke": ice_invoke})()
        proxy = adapter.add(taker, ice.Identity("taker", "")).ice_encodingVersion(ice.stringToEncodingVersion(encoding))
        adapter.activate()
        for interface, operations in samples(client).items():
            for operation, calls in operations:
                for parameters in calls:
                    with contextlib.suppress(ice.LocalException):  # nothing answers
                        getattr(proxies[interface].uncheckedCast(proxy), operation)(*parameters)
                found[interface, operation], taken = taken, []
                assert len(found[interface, operation]) == len(calls)
    return found


def shapes(interface: str, operation: str) -> tuple[wire.Shape, ...]:
    if interface == "MissionOfPoses":
        return SHAPES["Mission"][operation]["sequence"]
    return SHAPES[interface][operation]["data"]


def passes(data: bytes, wanted: tuple[wire.Shape, ...]) -> bool:
    try:
        check(data, *wanted)
    except Malformed:
        return False
    return True


@pytest.fixture(scope="module")
def genuine() -> dict[tuple[str, str, str, bool], list[bytes]]:
    """What Ice's clients send, by interface, operation, encoding and whether the format is the sliced one."""
    return {
        (interface, operation, encoding, sliced): bodies
        for encoding in ENCODINGS
        for sliced in (False, True)
        for (interface, operation), bodies in written(encoding, sliced=sliced).items()
    }


# The check ---------------------------------------------------------------------------------------------------------


def test_every_operation_that_takes_a_class_is_checked() -> None:
    texts = {
        path: re.sub(r"/\*.*?\*/|//[^\n]*", "", path.read_text(), flags=re.DOTALL) for path in SLICE.rglob("*.ice")
    }
    classes = {name for text in texts.values() for name in re.findall(r"\bclass (\w+)", text)}
    classes |= {
        name for text in texts.values() for of, name in re.findall(r"sequence<(\w+)> (\w+)", text) if of in classes
    }
    found: dict[str, set[str]] = {}
    for text in texts.values():
        for interface, body in re.findall(r"\binterface (\w+)[^{]*\{(.*?)\n    \}", text, re.DOTALL):
            for operation, parameters in re.findall(r"(\w+)\(([^)]*)\)", body):
                if interface != "Observer" and {part.split()[0] for part in parameters.split(",") if part} & classes:
                    found.setdefault(interface, set()).add(operation)
    assert {interface: set(operations) for interface, operations in SHAPES.items()} == found


def test_what_clients_send_is_let_through(genuine: dict[tuple[str, str, str, bool], list[bytes]]) -> None:
    count = 0
    for (interface, operation, encoding, sliced), bodies in genuine.items():
        for body in bodies:
            check(body, *shapes(interface, operation))
            assert body[4:6] == bytes(map(int, encoding.split("."))), sliced
            count += 1
    assert count == 4 * 20


def test_a_mission_shows_its_dialect(genuine: dict[tuple[str, str, str, bool], list[bytes]]) -> None:
    """Whatever is of both dialects at once is no mission: null, and no poses at all."""
    count = 0
    for (interface, operation, _, _), bodies in genuine.items():
        for body in bodies if operation == "setMissionData" else ():
            both = [passes(body, shapes(dialect, operation)) for dialect in ("Mission", "MissionOfPoses")]
            assert both == [interface == "Mission", interface == "MissionOfPoses"] or body[4:] == b"\x01\x01\x00"
            count += 1
    assert count == 32


def with_header(body: bytes, encoding: str = "1.1") -> bytes:
    return struct.pack("<I", 6 + len(body)) + bytes(map(int, encoding.split("."))) + body


NAME = b"\x16::jderobot::Pose3DData"
POSE_11 = b"\x21" + NAME + bytes(32)


@pytest.mark.parametrize(
    ("body", "encoding", "says"),
    [
        (b"", "1.1", "ends too early"),
        (b"\x02", "1.1", "object 2 is missing"),
        (b"\xff\xff\xff\xff\x7f", "1.1", "object 2147483647 is missing"),
        (b"\xff\xff\xff\xff\xff", "1.1", "a size is below 0"),
        (b"\x01" + POSE_11[:-1], "1.1", "ends too early"),
        (b"\x01" + POSE_11 + b"\x00", "1.1", "1 bytes too many"),
        (b"\x01\x01" + NAME + bytes(32) + b"\x20\x00", "1.1", "has slices"),
        (b"\x01\xe1" + NAME + bytes(32), "1.1", "has slices"),
        (b"\x01\x20" + bytes(32), "1.1", "without the name of its type"),
        (b"\x01\x23\x05" + bytes(32), "1.1", "without the name of its type"),
        (b"\x01\x22\x01" + bytes(32), "1.1", "a type that was not named before"),
        (b"\x01\x21\x18::jderobot::CMDVelDat\xff\xff\xff" + bytes(32), "1.1", "no UTF-8"),
        (b"\x01\x21\x16::jderobot::CMDVelData" + bytes(24), "1.1", "in place of ::jderobot::Pose3DData"),
        (b"\x01\x31" + NAME + struct.pack("<i", 37) + bytes(32), "1.1", "says 37 bytes and has 36"),
        (b"\x01\x39" + NAME + struct.pack("<i", 36) + bytes(32) + b"\x01\x00", "1.1", "nothing refers to"),
        (b"\x01\x25" + NAME + bytes(32) + b"\x0b" + bytes(8) + b"\xff", "1.1", "no such optional member"),
        (bytes(4), "1.0", "ends too early"),
        (struct.pack("<i", 1) + b"\x00", "1.0", "wrong sign"),
        (struct.pack("<i", -1) + b"\x00", "1.0", "object 1 is missing"),
        (struct.pack("<i", -1) + b"\x01" + struct.pack("<i", 2) + b"\x00" + NAME, "1.0", "nothing refers to object 2"),
        (struct.pack("<i", -(2**31)) + b"\x00", "1.0", "object 2147483648 is missing"),
        (b"\x00", "1.2", "encoding 1.2"),
        (b"\x00", "2.0", "encoding 2.0"),
    ],
)
def test_what_no_client_sends_is_refused(body: bytes, encoding: str, says: str) -> None:
    with pytest.raises(Malformed, match=says):
        check(with_header(body, encoding), wire.POSE)


def test_sizes_are_compared_before_anything_is_made() -> None:
    for data in (b"", b"\x07\x00\x00\x00\x01", struct.pack("<iBB", 7, 1, 1), struct.pack("<iBB", -1, 1, 1)):
        with pytest.raises(Malformed):
            check(data, wire.POSE)
    many = b"\xff" + struct.pack("<i", 2**31 - 1)
    with pytest.raises(Malformed, match="more than 16384 parts"):
        check(with_header(many + b"\x00"), wire.POSES)
    with pytest.raises(Malformed, match="longer than what is left"):
        check(with_header(b"\xff" + struct.pack("<i", 16_000) + b"\x00"), wire.POSES)
    with pytest.raises(Malformed, match="more than 16384 parts"):
        check(with_header(b"\xff" + struct.pack("<i", 16_385) + bytes(16_385)), wire.POSES)
    check(with_header(b"\xff" + struct.pack("<i", 16_384) + bytes(16_384)), wire.POSES)


def mutants(bodies: list[bytes], wanted: int, seed: int) -> Iterator[bytes]:
    """Bodies with a few bytes changed, cut out or put in, their size put right."""
    chance = random.Random(seed)
    for _ in range(wanted):
        body = bytearray(chance.choice(bodies)[6:])
        for _ in range(chance.choice((1, 1, 1, 2, 4))):
            at = chance.randrange(len(body) + 1)
            odd = chance.choice((0, 1, 2, 3, 5, 33, 49, 57, 127, 128, 254, 255, chance.randrange(256)))
            how = chance.randrange(4)
            if how == 0 or at == len(body):
                body[at:at] = bytes([odd])
            elif how == 1:
                del body[at : at + chance.choice((1, 1, 4, 30))]
            else:
                body[at] = odd
        yield with_header(bytes(body), f"1.{chance.choice(bodies)[5]}")


# The driver --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A driver that has heard no vehicle."""
    with driver("udpin:127.0.0.1:0", data=tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture
def client(served: Served) -> Iterator[Client]:
    with client_of(served.said["ice"]) as client:
        yield client


def object_of(client: Client, interface: str) -> Any:
    """The object of an interface, as bytes are sent to it."""
    text = client.proxies[OBJECTS.get(interface, interface)].replace("_telemetry", "_missions")
    return client.communicator.stringToProxy(text)


@pytest.mark.fault(52, figure="bodies that Ice does not survive are refused, more than 60 a run; it lives")
@pytest.mark.parametrize(
    ("interface", "operation"), [(interface, operation) for interface in SHAPES for operation in SHAPES[interface]]
)
def test_no_body_ends_the_driver(
    client: Client, genuine: dict[tuple[str, str, str, bool], list[bytes]], interface: str, operation: str
) -> None:
    """First those that did, then many that are almost right."""
    target = object_of(client, interface)
    before = {"check": bytes(4), "upload": bytes(5)}.get(operation, b"")
    bodies = [
        body for (_, name, _, _), found in genuine.items() if name == operation for body in found if len(body) < 1000
    ]
    answered = refused = 0

    def send(data: bytes) -> bool:
        try:
            target.ice_invoke(operation, client.ice.OperationMode.Normal, data)
        except (client.ice.UnknownLocalException, client.ice.UnknownException):
            return False
        return True

    for hostile in (b"\x02", b"\x02\x02", b"\x03\x01", b"\x01\x02", b"\x7f", b"\xff\xff\xff\xff\x7f"):
        assert not send(with_header(before + hostile)), hostile
    assert not send(with_header(before + struct.pack("<i", -2) + b"\x00", "1.0"))
    wanted = list(SHAPES[interface][operation].values())
    for mutant in mutants(bodies, MUTANTS, seed=hash_of(operation)):
        if any(passes(mutant, shape) for shape in wanted):
            send(mutant)  # what is let through is well-formed: it is answered, or refused as a value
            answered += 1
        else:
            assert not send(mutant), mutant.hex()
            refused += 1
    assert answered > 3
    assert refused > 60
    assert client.pose.getPose3DData().q0 == 1.0, "it lives"


def hash_of(text: str) -> int:
    """A seed that is the same in every run."""
    return int.from_bytes(text.encode()[:8], "little")


def text(data: bytes) -> bytes:
    return bytes([len(data)]) + data


NO_TEXT = b"\xab\xff"


@pytest.mark.parametrize(
    "header",
    [
        text(NO_TEXT) + b"\x00\x00" + text(b"ice_ping"),
        text(b"ardrone_pose3d") + text(NO_TEXT) + b"\x00" + text(b"ice_ping"),
        text(b"ardrone_pose3d") + b"\x00\x01" + text(NO_TEXT) + text(b"ice_ping"),
        text(b"ardrone_pose3d") + b"\x00\x00" + text(NO_TEXT),
    ],
    ids=["name", "category", "facet", "operation"],
)
@pytest.mark.parametrize("context", [b"\x00", b"\x01" + text(NO_TEXT) * 2], ids=["no context", "context"])
def test_names_that_are_no_text_are_answered(client: Client, header: bytes, context: bytes) -> None:
    """Ice for Python ends its process when it decodes one of them (3.7.8)."""
    with raw(address_of(client.proxies["Pose3D"])) as connection:
        connection.sendall(message(0, struct.pack("<I", 1) + header + b"\x00" + context + with_header(b"")))
        answer = connection.recv(4096)
    assert answer[8] == 2, "Reply"
    assert answer[18] in (2, 3, 4), "no such object, facet or operation"
    assert client.pose.getPose3DData().q0 == 1.0


def test_a_context_that_is_no_text_is_none(client: Client) -> None:
    request = text(b"ardrone_cmdvel") + b"\x00\x00" + text(b"setCMDVelData") + b"\x00\x01" + text(NO_TEXT) * 2
    with raw(address_of(client.proxies["CMDVel"])) as connection:
        connection.sendall(message(0, struct.pack("<I", 1) + request + with_header(b"\x00")))
        answer = connection.recv(4096)
    assert (answer[8], answer[18]) == (2, 0)
    assert answer[-4:] == b"\x01\x00\x00\x00", "null is a bad value"


def test_observers_whose_names_are_no_text_end_nothing(tmp_path: Path) -> None:
    """The driver looks at where an observer is, and calls it."""
    with MockPlane() as plane, driver(plane.link, data=tmp_path) as served, client_of(served.said["ice"]) as client:
        telemetry = client.telemetry
        wait_for(lambda: telemetry.vehicles() == [1], "the vehicle")
        answers = []
        for identity, facet, host, kind in (
            (b"me", b"", b"127.0.0.1", 1),
            (NO_TEXT, b"", b"127.0.0.1", 1),
            (b"me", NO_TEXT, b"127.0.0.1", 1),
            (b"me", b"", NO_TEXT, 1),
            (b"me", b"", NO_TEXT, 4),
            (b"me", b"", NO_TEXT, 3),
            (b"me", b"", b"127.0.0.1", 99),
        ):
            # tcp, udp, ws or none that is known: host, port, timeout, compression, resource.
            endpoint = text(host) + struct.pack("<ii", 9, 1000) + b"\x00" + (text(NO_TEXT) if kind == 4 else b"")
            proxy = text(identity) + b"\x00" + (b"\x01" + text(facet) if facet else b"\x00")
            proxy += b"\x00\x00\x01\x00\x01\x01\x01" + struct.pack("<h", kind) + with_header(endpoint)
            body = with_header(bytes(4) + proxy + struct.pack("<d", 1.0))
            try:
                ok, _ = telemetry.ice_invoke("subscribe", client.ice.OperationMode.Normal, body)
                answers.append("taken" if ok else "refused")
            except (client.ice.UnknownException, client.ice.UnknownLocalException):
                answers.append("unreadable")
            assert telemetry.vehicles() == [1], (identity, facet, host, kind)
        assert answers[0] == "taken", answers
        assert set(answers[3:]) <= {"refused", "unreadable"}, answers


def garbage(chance: random.Random) -> bytes:
    """Parameters of nothing in particular."""
    size = chance.randrange(60)
    return chance.choice(
        (
            lambda: chance.randbytes(size),
            lambda: bytes(chance.choices((0, 1, 2, 3, 5, 33, 57, 127, 255), k=size)),
            lambda: b"\xff" + struct.pack("<i", chance.choice((-1, 0, 255, 2**28, 2**31 - 1))) + bytes(size),
            lambda: text(chance.randbytes(size)) + bytes(8),
            lambda: bytes(4) + text(NO_TEXT) + bytes(8) + text(b"x"),
        )
    )()


@pytest.mark.fault(52, figure="garbage to every operation: an answer each")
def test_garbage_to_every_operation(client: Client) -> None:
    chance = random.Random(5)
    names = {"ArDroneExtra": "Extra", "ImageProvider": "Camera"}
    builtin = {
        f"{name}.{operation}" for name in ("Pose3D", "Mission") for operation in ("ice_isA", "ice_ids", "ice_ping")
    }
    calls = sorted(operations() | builtin)
    with contextlib.ExitStack() as stack:
        connections: dict[str, Any] = {}
        for number in range(7 * MUTANTS):
            interface, _, operation = chance.choice(calls).partition(".")
            setting = names.get(
                interface, "Precise" if interface in ("Telemetry", "Missions", "Control") else interface
            )
            identity = client.proxies[setting].partition(":")[0].replace("_telemetry", f"_{interface.lower()}").strip()
            if setting not in connections:
                connections[setting] = stack.enter_context(raw(address_of(client.proxies[setting])))
            mode = 2 if operation.startswith(("get", "vehicles", "check", "download", "modes", "ice_")) else 0
            facet = b"\x00" if chance.random() < 0.9 else b"\x01" + text(b"sequence")
            request = text(identity.encode()) + b"\x00" + facet + text(operation.encode()) + bytes([mode]) + b"\x00"
            body = with_header(garbage(chance), chance.choice(("1.0", "1.1", "1.1", "1.7", "3.0")))
            connection = connections[setting]
            connection.sendall(message(0, struct.pack("<I", number + 1) + request + body))
            head = connection.recv(14, socket.MSG_WAITALL)
            assert head[8] == 2, (interface, operation, body.hex())
            connection.recv(struct.unpack_from("<I", head, 10)[0] - 14, socket.MSG_WAITALL)
    assert len(connections) == len(INTERFACES)
    assert client.pose.getPose3DData().q0 == 1.0, "it lives"


@pytest.mark.fault(44, figure="every operation of every Ice interface, before its parameters are read")
def test_the_token_is_asked_for_before_anything_is_read(tmp_path: Path) -> None:
    ports = {f"{name}.Endpoints": "tcp -h 0.0.0.0 -p 0" for name in INTERFACES}
    with driver("udpin:127.0.0.1:0", data=tmp_path, ports=ports) as served:
        local = {
            name: f"{proxy.partition(':tcp')[0]}:tcp -h 127.0.0.1 -p {address_of(proxy)[1]}"
            for name, proxy in served.said["ice"].items()
        }
        tokens: tuple[dict[str, str], ...] = ({}, {"token": served.token("viewer")})
        with client_of(local) as client:
            for interface, operations in SHAPES.items():
                for operation in operations:
                    for context in tokens[: 1 if operation == "check" else 2]:  # which a viewer may call
                        with pytest.raises(client.ice.UnknownException) as refused:
                            object_of(client, interface).ice_invoke(
                                operation, client.ice.OperationMode.Normal, with_header(b"\x02"), context
                            )
                        assert "token" in refused.value.unknown


# Both dialects -----------------------------------------------------------------------------------------------------


@pytest.mark.fault(51, figure="clients of both dialects at once, in both encodings")
@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("sliced", ["0", "1"])
def test_both_dialects_of_missions_at_once(served: Served, encoding: str, sliced: str) -> None:
    """Two programs, one object: each sends in its dialect, and gets its own back."""
    with (
        client_of(served.said["ice"], Ice_Default_SlicedFormat=sliced) as one,
        client_of(served.said["ice"], Ice_Default_SlicedFormat=sliced) as other,
    ):
        proxy = f"ardrone_mission -e {encoding}:{one.proxies['Mission'].partition(':')[2]}"
        data = one.jderobot.MissionPrx.checkedCast(one.communicator.stringToProxy(proxy))
        bare = other_mission().uncheckedCast(other.communicator.stringToProxy(proxy))
        poses = one.mission_data((40.0, -3.0, 50.0), (40.1, -3.0, 50.0)).mission
        for _ in range(2):
            assert data.setMissionData(one.jderobot.MissionData(poses)) == 2, "no vehicle has been heard"
            assert bare.setMissionData(poses) == 2
            assert data.getMissionData().mission == []
            assert bare.getMissionData() == []
        bare.ice_getConnection().close(one.ice.ConnectionClose.GracefullyWithWait)
        # An address that sent in both shows nothing: who comes anew says by the facet which one it speaks.
        assert other_mission().uncheckedCast(bare, "sequence").getMissionData() == []
        assert one.jderobot.MissionPrx.checkedCast(data, "data").getMissionData().mission == []
        named = one.jderobot.MissionPrx.checkedCast(data, "sequence")
        assert named.ice_ids() == ["::Ice::Object", "::jderobot::Mission"]
        with pytest.raises(one.ice.FacetNotExistException):
            data.ice_facet("other").ice_ping()


def test_a_client_is_known_by_what_it_sent_and_by_its_address() -> None:
    dialects = Dialects("data")
    assert dialects.of(None) == dialects.of(Peer("10.0.0.1", 1)) == "data"
    dialects.show(Peer("10.0.0.1", 1), "sequence")
    assert dialects.of(Peer("10.0.0.1", 1)) == dialects.of(Peer("10.0.0.1", 2)) == "sequence", "it came back"
    assert dialects.of(Peer("10.0.0.2", 1)) == "data"
    dialects.show(Peer("10.0.0.1", 3), "data")
    assert (dialects.of(Peer("10.0.0.1", 1)), dialects.of(Peer("10.0.0.1", 3))) == ("sequence", "data")
    assert dialects.of(Peer("10.0.0.1", 4)) == "data", "both came from there"
    for port in range(1000):
        dialects.show(Peer("10.0.0.3", port), "sequence")
    assert dialects.of(Peer("10.0.0.1", 1)) == "data", "not for ever"
    assert len(dialects._shown) <= 256
    assert Dialects("sequence").of(Peer("10.0.0.1", 1)) == "sequence"
    dialects.show(None, "sequence")

"""MAVFTP: errors, lost requests, uploads that take effect when they end, and the virtual files."""

from __future__ import annotations

import errno
import struct
import zlib
from typing import NamedTuple

import pytest
from vencejo.sim.mavlink.codec import dialect
from vencejo.sim.mavlink.ftp import FtpError, FtpOp
from vencejo.sim.world import MemoryLink, World

from tests.sim.transcripts import CAPTURES, listen, settled_world

HEADER = struct.Struct("<HBBBBBBI")
MISSION_FILE = (CAPTURES / "mission.dat").read_bytes()


class Answer(NamedTuple):
    """A decoded reply."""

    sequence: int
    session: int
    opcode: int
    request: int
    burst_complete: int
    offset: int
    data: bytes

    @property
    def error(self) -> int:
        assert self.opcode == FtpOp.NAK
        return self.data[0]


class Client:
    """Sends requests and reads the answers to each."""

    def __init__(self, world: World, station: MemoryLink) -> None:
        self.world, self.station = world, station
        self.sequence = 0

    def send(self, op: FtpOp, data: bytes = b"", *, offset: int = 0, size: int | None = None, session: int = 0) -> None:
        header = HEADER.pack(self.sequence, session, op, len(data) if size is None else size, 0, 0, 0, offset)
        self.sequence += 2
        payload = (header + data).ljust(251, b"\0")
        self.station.send(dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, payload))

    def answers(self) -> list[Answer]:
        found = []
        for message in listen(self.world, self.station, 0.1):
            if message.get_type() == "FILE_TRANSFER_PROTOCOL":
                payload = bytes(message.payload)
                sequence, session, opcode, size, request, complete, _, offset = HEADER.unpack_from(payload)
                found.append(Answer(sequence, session, opcode, request, complete, offset, payload[12 : 12 + size]))
        return found

    def ask(
        self, op: FtpOp, data: bytes = b"", *, offset: int = 0, size: int | None = None, session: int = 0
    ) -> Answer:
        self.send(op, data, offset=offset, size=size, session=session)
        (answer,) = self.answers()
        assert answer.sequence == self.sequence - 1
        assert answer.request == op
        return answer


@pytest.fixture
def client() -> Client:
    return Client(*settled_world())


def write_mission(client: Client, data: bytes) -> None:
    assert client.ask(FtpOp.CREATE_FILE, b"@MISSION/mission.dat").opcode == FtpOp.ACK
    for offset in range(0, len(data), 200):
        block = data[offset : offset + 200]
        assert client.ask(FtpOp.WRITE_FILE, block, offset=offset).offset == offset


def count(client: Client) -> int:
    return len(client.world.planes[0].plans.mission_store)


def test_only_the_virtual_files_exist(client: Client) -> None:
    for path in (b"nothing.txt", b"@MISSION/other.dat", b"@SYS/threads.txt", b"/etc/passwd", b"../mission.dat"):
        assert client.ask(FtpOp.OPEN_FILE_RO, path).error == FtpError.FILE_NOT_FOUND
        assert client.ask(FtpOp.CREATE_FILE, path).error == FtpError.FILE_NOT_FOUND
    assert client.ask(FtpOp.LIST_DIRECTORY, b"/").data == b"D.\0D..\0"
    end = client.ask(FtpOp.LIST_DIRECTORY, b"/", offset=90)
    assert (end.error, end.offset) == (FtpError.END_OF_FILE, 90)
    assert client.ask(FtpOp.LIST_DIRECTORY, b"@MISSION").error == FtpError.FILE_NOT_FOUND
    assert client.ask(FtpOp.REMOVE_FILE, b"@MISSION/rally.dat").error == FtpError.FILE_NOT_FOUND


def test_sessions(client: Client) -> None:
    assert client.ask(FtpOp.READ_FILE, size=80).error == FtpError.FILE_NOT_FOUND
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/rally.dat").data == struct.pack("<I", 1 << 20)
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/rally.dat").error == FtpError.FAIL
    assert client.ask(FtpOp.READ_FILE, size=80, session=3).error == FtpError.INVALID_SESSION
    assert client.ask(FtpOp.WRITE_FILE, b"abc").error == FtpError.FAIL
    assert client.ask(FtpOp.READ_FILE, size=80).data == struct.pack("<HHHHH", 0x763D, 2, 0, 0, 0)
    assert client.ask(FtpOp.READ_FILE, size=80, offset=500).error == FtpError.END_OF_FILE
    assert client.ask(FtpOp.TERMINATE_SESSION).opcode == FtpOp.ACK
    assert client.ask(FtpOp.READ_FILE, size=80).error == FtpError.FILE_NOT_FOUND
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/rally.dat").opcode == FtpOp.ACK
    listen(client.world, client.station, 3.5)
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/fence.dat", session=9).opcode == FtpOp.ACK  # the old one timed out


def test_a_station_that_leaves_has_closed_its_file_for_the_next(client: Client) -> None:
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/mission.dat", session=7).opcode == FtpOp.ACK
    client.send(FtpOp.TERMINATE_SESSION, session=7)
    client.station.close()
    another = Client(client.world, client.world.connect())
    assert another.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/mission.dat", session=8).opcode == FtpOp.ACK


def test_malformed_requests(client: Client) -> None:
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/rally.dat", size=5).error == FtpError.INVALID_DATA_SIZE
    assert client.ask(FtpOp.READ_FILE, size=255).error == FtpError.INVALID_DATA_SIZE
    assert client.ask(FtpOp.TRUNCATE_FILE, b"x").error == FtpError.FAIL


def test_a_repeated_request_gets_the_same_answer_again(client: Client) -> None:
    write_mission(client, MISSION_FILE)
    client.sequence += 10
    first = client.ask(FtpOp.TERMINATE_SESSION)
    client.sequence -= 2
    assert client.ask(FtpOp.TERMINATE_SESSION) == first
    assert count(client) == 12


def test_requests_beyond_the_queue_are_lost(client: Client) -> None:
    client.ask(FtpOp.CREATE_FILE, b"@MISSION/mission.dat")
    for offset in range(0, 640, 80):
        client.send(FtpOp.WRITE_FILE, MISSION_FILE[offset : offset + 80], offset=offset)
    assert [answer.offset for answer in client.answers()] == [0, 80, 160, 240, 320]


def test_the_upload_counts_when_the_session_ends_and_reads_back_the_same(client: Client) -> None:
    write_mission(client, MISSION_FILE)
    assert count(client) == 1  # home
    client.ask(FtpOp.TERMINATE_SESSION)
    assert count(client) == 12
    client.ask(FtpOp.OPEN_FILE_RO, b"@MISSION/mission.dat")
    client.send(FtpOp.BURST_READ_FILE, size=239)
    answers = client.answers()
    data = b"".join(a.data for a in sorted(answers[:-1], key=lambda a: a.offset))
    assert data[:10] == MISSION_FILE[:10]
    for at in range(48, len(MISSION_FILE), 38):  # item 0 is the present home; the rest is as written
        # The target of an item (bytes 32 and 33) is the reader's business; a DO_ item has no frame (byte 34).
        assert data[at : at + 32] == MISSION_FILE[at : at + 32]
        assert data[at + 35 : at + 38] == MISSION_FILE[at + 35 : at + 38]
    assert answers[-1].error == FtpError.END_OF_FILE
    assert [a.sequence for a in answers] == list(range(answers[0].sequence, answers[0].sequence + len(answers)))
    client.sequence = answers[-1].sequence + 1  # a burst has used up sequence numbers
    client.ask(FtpOp.TERMINATE_SESSION)
    crc = client.ask(FtpOp.CALC_FILE_CRC32, b"@MISSION/mission.dat").data
    assert crc == struct.pack("<I", zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[:-38],  # fewer items than the header says
        lambda data: b"\0" + data[1:],  # bad magic
        lambda data: data[:86] + bytes(38) + data[124:],  # a block lost
        lambda data: data[:6],
    ],
)
def test_a_damaged_file_changes_nothing(client: Client, damage: object) -> None:
    assert callable(damage)
    write_mission(client, MISSION_FILE)
    client.ask(FtpOp.TERMINATE_SESSION)
    revision = client.world.planes[0].plans.mission_revision
    write_mission(client, damage(MISSION_FILE))
    ended = client.ask(FtpOp.TERMINATE_SESSION)
    # AP_Filesystem_Mission::close: EINVAL.
    assert (ended.opcode, ended.data[:2]) == (FtpOp.NAK, bytes((FtpError.FAIL_ERRNO, errno.EINVAL)))
    assert client.world.planes[0].plans.mission_revision == revision


def test_a_reset_ends_an_upload_as_terminating_it_does(client: Client) -> None:
    write_mission(client, MISSION_FILE)
    client.ask(FtpOp.RESET_SESSIONS)
    assert count(client) == 12


def test_fence_and_rally_files(client: Client) -> None:
    item = struct.Struct("<ffffiifHHBBBBBB")
    corners = [
        item.pack(3, 0, 0, 0, 403340000 + 9000 * i * i, -37970000 + 9000 * i, 0, i, 5001, 1, 1, 3, 0, 1, 1)
        for i in range(3)
    ]
    rally = [item.pack(0, 0, 0, 0, 403340000, -37970000, 60.5, 0, 5100, 1, 1, 3, 0, 1, 2)]
    for name, kind, items in ((b"fence", 1, corners), (b"rally", 2, rally)):
        client.ask(FtpOp.CREATE_FILE, b"@MISSION/" + name + b".dat")
        data = struct.pack("<HHHHH", 0x763D, kind, 0, 0, len(items)) + b"".join(items)
        client.ask(FtpOp.WRITE_FILE, data)
        client.ask(FtpOp.TERMINATE_SESSION)
    plans = client.world.planes[0].plans
    assert [len(shape.points) for shape in plans.fence_store.shapes] == [3]
    assert [point.alt_m for point in plans.rally] == [60.0]
    params = client.world.planes[0].params
    assert (params.get("FENCE_TOTAL"), params.get("RALLY_TOTAL")) == (5, 1)


def test_parameter_file_keeps_one_block_size(client: Client) -> None:
    assert client.ask(FtpOp.OPEN_FILE_RO, b"@PARAM/param.pck?start=5&count=2").data == struct.pack("<I", 1399 * 12)
    first = client.ask(FtpOp.READ_FILE, size=100)
    assert first.data[:6] == struct.pack("<HHH", 0x671B, 2, 1399)
    assert client.ask(FtpOp.READ_FILE, size=50).error == FtpError.FAIL_ERRNO
    client.ask(FtpOp.TERMINATE_SESSION)
    for query in (b"start=2000", b"start=x", b"withdefaults=2"):
        assert client.ask(FtpOp.OPEN_FILE_RO, b"@PARAM/param.pck?" + query).error == FtpError.FAIL_ERRNO


def test_parameters_are_set_by_file(client: Client) -> None:
    body = b"\x02\x80WP_RADIUS\x1e\x00" + b"\x02\x80NO_SUCH_P\x1e\x00"
    data = b"\x1b\x67\x02\x00" + (6 + len(body)).to_bytes(2, "little") + body
    client.ask(FtpOp.CREATE_FILE, b"@PARAM/param.pck")
    client.ask(FtpOp.WRITE_FILE, data)
    client.send(FtpOp.TERMINATE_SESSION)
    heard = listen(client.world, client.station, 0.1)
    assert client.world.planes[0].params.get("WP_RADIUS") == 30
    assert [m.param_value for m in heard if m.get_type() == "PARAM_VALUE" and m.param_id == "WP_RADIUS"] == [30.0]

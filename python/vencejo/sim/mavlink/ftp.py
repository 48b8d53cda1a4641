"""MAVFTP: ArduPlane's file server, one session at a time (https://mavlink.io/en/services/ftp.html).

As on ArduPlane the queue is short: of more than :data:`QUEUE_REQUESTS` simultaneous requests the rest are lost.
"""

from __future__ import annotations

import errno
import struct
import zlib
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum

from vencejo.sim.autopilot.interface import Severity
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.files import FileError, ReadHandle, VirtualFiles, WriteHandle
from vencejo.sim.mavlink.link import Peer

__all__ = ["FtpError", "FtpOp", "FtpServer"]

QUEUE_REQUESTS = 5
"""Length of the request queue; further requests are dropped without an answer."""
REQUESTS_PER_TICK = 3
"""Requests handled in one tick of 10 ms."""
_BURST_BLOCKS = 500
_SESSION_TIMEOUT_S = 3.0
_HEADER = struct.Struct("<HBBBBBBI")
_DATA_BYTES = 239


class FtpOp(IntEnum):
    """Opcodes."""

    NONE = 0
    TERMINATE_SESSION = 1
    RESET_SESSIONS = 2
    LIST_DIRECTORY = 3
    OPEN_FILE_RO = 4
    READ_FILE = 5
    CREATE_FILE = 6
    WRITE_FILE = 7
    REMOVE_FILE = 8
    CREATE_DIRECTORY = 9
    REMOVE_DIRECTORY = 10
    OPEN_FILE_WO = 11
    TRUNCATE_FILE = 12
    RENAME = 13
    CALC_FILE_CRC32 = 14
    BURST_READ_FILE = 15
    ACK = 128
    NAK = 129


class FtpError(IntEnum):
    """Error codes of a NAK."""

    FAIL = 1
    FAIL_ERRNO = 2
    INVALID_DATA_SIZE = 3
    INVALID_SESSION = 4
    NO_SESSIONS_AVAILABLE = 5
    END_OF_FILE = 6
    UNKNOWN_COMMAND = 7
    FILE_EXISTS = 8
    FILE_PROTECTED = 9
    FILE_NOT_FOUND = 10


@dataclass(frozen=True, slots=True)
class _Request:
    peer: Peer
    sequence: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes


@dataclass(frozen=True, slots=True)
class _Reply:
    sequence: int
    session: int
    request: int
    opcode: int = FtpOp.ACK
    offset: int = 0
    data: bytes = b""
    burst_complete: bool = False


class FtpServer:
    """Serves the virtual files of one plane to all its links.

    Parameters
    ----------
    files : VirtualFiles
    reply : callable
        Sends a message to one peer.
    banner : callable
        Sends the banner, as ArduPlane does when the parameter file is opened.
    say : callable
        Sends a text to every link.
    now_s : callable
        Simulated time.
    """

    def __init__(
        self,
        files: VirtualFiles,
        *,
        reply: Callable[[Peer, MavMessage], None],
        banner: Callable[[Peer], None],
        say: Callable[[Severity, str], None],
        now_s: Callable[[], float],
    ) -> None:
        self._files = files
        self._send = reply
        self._banner = banner
        self._say = say
        self._now_s = now_s
        self._queue: deque[_Request] = deque()
        self._session: int | None = None
        self._handle: ReadHandle | WriteHandle | None = None
        self._used_s = 0.0
        self._banner_due = False
        self._last: tuple[int, int, int, _Reply] | None = None
        """System, component and session of the last request, and its answer, which is resent on a retry."""

    def on_message(self, peer: Peer, message: MavMessage) -> None:
        """Queue a request."""
        payload = bytes(message.payload)
        sequence, session, opcode, size, _, _, _, offset = _HEADER.unpack_from(payload)
        if opcode in (FtpOp.ACK, FtpOp.NAK) or len(self._queue) >= QUEUE_REQUESTS:
            return
        self._queue.append(_Request(peer, sequence, session, opcode, size, offset, payload[_HEADER.size :]))

    def tick(self) -> None:
        """Handle some requests."""
        for _ in range(min(REQUESTS_PER_TICK, len(self._queue))):
            self._serve(self._queue.popleft())

    def reset(self) -> None:
        """Reset after a reboot: files being written are lost."""
        self._queue.clear()
        self._session = self._handle = self._last = None

    def _serve(self, request: _Request) -> None:
        key = (request.peer.system, request.peer.component, request.session)
        if (
            self._last is not None
            and self._last[:3] == key
            and self._last[3].sequence == (request.sequence + 1) & 0xFFFF
        ):
            self._push(request.peer, self._last[3])
            return
        reply = _Reply((request.sequence + 1) & 0xFFFF, request.session, request.opcode)
        try:
            answer = self._answer(request, reply)
        except FileError as error:
            answer = self._nak_errno(reply, error.errno)
        if answer is not None:
            self._last = (*key, answer)
            self._push(request.peer, answer)

    def _answer(self, request: _Request, reply: _Reply) -> _Reply | None:
        if request.size > _DATA_BYTES:
            return _nak(reply, FtpError.INVALID_DATA_SIZE)
        ending = request.opcode in (FtpOp.TERMINATE_SESSION, FtpOp.RESET_SESSIONS)
        if request.session != self._session:
            if ending and self._session is not None:
                return reply
            if self._handle is not None:
                if self._now_s() - self._used_s < _SESSION_TIMEOUT_S:
                    return _nak(reply, FtpError.INVALID_SESSION)
                self._close()
        match request.opcode:
            case FtpOp.NONE:
                return reply
            case FtpOp.TERMINATE_SESSION:
                return reply if self._close() else self._nak_errno(reply, errno.EINVAL)
            case FtpOp.RESET_SESSIONS:
                self._close()
                return reply
            case FtpOp.LIST_DIRECTORY:
                return self._list(request, reply)
            case FtpOp.OPEN_FILE_RO | FtpOp.OPEN_FILE_WO | FtpOp.CREATE_FILE:
                return self._open(request, reply)
            case FtpOp.READ_FILE:
                return self._read(request, reply)
            case FtpOp.BURST_READ_FILE:
                return self._burst(request, reply)
            case FtpOp.WRITE_FILE:
                if not isinstance(self._handle, WriteHandle):
                    return _nak(reply, FtpError.FILE_NOT_FOUND if self._handle is None else FtpError.FAIL)
                self._handle.write(request.offset, request.data[: request.size])
                return replace(reply, offset=request.offset)
            case FtpOp.CALC_FILE_CRC32:
                return self._crc(request, reply)
            case FtpOp.CREATE_DIRECTORY | FtpOp.REMOVE_DIRECTORY | FtpOp.REMOVE_FILE | FtpOp.RENAME:
                raise FileError(errno.ENOENT)
        self._say(Severity.DEBUG, f"Unsupported FTP: {request.opcode}")
        return _nak(reply, FtpError.FAIL)

    def _open(self, request: _Request, reply: _Reply) -> _Reply:
        if self._handle is not None and self._now_s() - self._used_s > _SESSION_TIMEOUT_S:
            self._close()
        if self._handle is not None:
            return _nak(reply, FtpError.FAIL)
        path = _path(request)
        if path is None:
            return _nak(reply, FtpError.INVALID_DATA_SIZE)
        if request.opcode == FtpOp.OPEN_FILE_RO:
            handle = self._files.open_read(path)
            self._handle = handle
            reply = replace(reply, data=struct.pack("<I", handle.size))
            self._banner_due = path.startswith("@PARAM/param.pck")
        else:
            self._handle = self._files.open_write(path)
        self._session = request.session
        return reply

    def _read(self, request: _Request, reply: _Reply) -> _Reply:
        if not isinstance(self._handle, ReadHandle):
            return _nak(reply, FtpError.FILE_NOT_FOUND if self._handle is None else FtpError.FAIL)
        data = self._handle.read(request.offset, min(_DATA_BYTES, request.size))
        if not data:
            return _nak(reply, FtpError.END_OF_FILE)
        return replace(reply, offset=request.offset, data=data)

    def _burst(self, request: _Request, reply: _Reply) -> _Reply | None:
        if not isinstance(self._handle, ReadHandle):
            return _nak(reply, FtpError.FILE_NOT_FOUND if self._handle is None else FtpError.FAIL)
        block = min(_DATA_BYTES, request.size or _DATA_BYTES)
        offset = request.offset
        for number in range(_BURST_BLOCKS):
            data = self._handle.read(offset, block)
            if not data:
                return replace(_nak(reply, FtpError.END_OF_FILE), offset=offset, burst_complete=number > 0)
            complete = len(data) < block or number == _BURST_BLOCKS - 1
            self._push(request.peer, replace(reply, offset=offset, data=data, burst_complete=complete))
            offset += len(data)
            reply = replace(reply, sequence=(reply.sequence + 1) & 0xFFFF)
        return None

    def _list(self, request: _Request, reply: _Reply) -> _Reply:
        path = _path(request)
        if path is None:
            return _nak(reply, FtpError.INVALID_DATA_SIZE)
        entries = self._files.list(path)[request.offset :]
        if not entries:
            return replace(_nak(reply, FtpError.END_OF_FILE), offset=request.offset)
        data = b""
        for entry in entries:
            packed = entry.encode("ascii") + b"\0"
            if len(data) + len(packed) > _DATA_BYTES:
                break
            data += packed
        return replace(reply, offset=request.offset, data=data)

    def _crc(self, request: _Request, reply: _Reply) -> _Reply:
        path = _path(request)
        if path is None:
            return _nak(reply, FtpError.INVALID_DATA_SIZE)
        handle = self._files.open_read(path)
        data, block = b"", _DATA_BYTES
        while part := handle.read(len(data), block):
            data += part
        # ArduPilot's CRC-32 starts at zero and is not inverted.
        crc = zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF
        return replace(reply, data=struct.pack("<I", crc))

    def _close(self) -> bool:
        """Close the file; False when it was written and is malformed."""
        handle, self._handle, self._session = self._handle, None, None
        return handle.close() if isinstance(handle, WriteHandle) else True

    @staticmethod
    def _nak_errno(reply: _Reply, number: int) -> _Reply:
        if number == errno.ENOENT:
            return _nak(reply, FtpError.FILE_NOT_FOUND)
        if number == errno.EEXIST:
            return _nak(reply, FtpError.FILE_EXISTS)
        return replace(_nak(reply, FtpError.FAIL_ERRNO), data=bytes((FtpError.FAIL_ERRNO, number)))

    def _push(self, peer: Peer, reply: _Reply) -> None:
        self._used_s = self._now_s()
        header = _HEADER.pack(
            reply.sequence,
            reply.session,
            reply.opcode,
            len(reply.data),
            reply.request,
            int(reply.burst_complete),
            0,
            reply.offset,
        )
        payload = (header + reply.data).ljust(_HEADER.size + _DATA_BYTES, b"\0")
        self._send(peer, dialect.MAVLink_file_transfer_protocol_message(0, peer.system, peer.component, payload))
        if self._banner_due:
            self._banner_due = False
            self._banner(peer)


def _nak(reply: _Reply, error: FtpError) -> _Reply:
    return replace(reply, opcode=FtpOp.NAK, data=bytes((error,)))


def _path(request: _Request) -> str | None:
    """The path of a request, None when its length contradicts the size field."""
    text = request.data.split(b"\0", 1)[0]
    if not text or len(text) != request.size:
        return None
    return text.decode("ascii", "replace")

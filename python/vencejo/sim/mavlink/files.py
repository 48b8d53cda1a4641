"""The virtual files of MAVFTP, the only ones served: packed parameters and the three plans.

Plan file: five uint16 (magic 0x763d, MAV_MISSION_TYPE, options, first item, number of items), then that many packed
38-byte MISSION_ITEM_INT. Parameter file: see :meth:`vencejo.sim.params.ParamStore.pack`.
"""

from __future__ import annotations

import errno
import struct
from collections.abc import Callable
from urllib.parse import parse_qsl

from vencejo.sim.autopilot.interface import Severity
from vencejo.sim.mavlink.mission import PlanItems, PlanKind
from vencejo.sim.params import Parameter, ParamStore, ParamValueError
from vencejo.sim.plan_store import MissionResult, WireItem, normalise

__all__ = ["FileError", "ReadHandle", "VirtualFiles", "WriteHandle"]

PLAN_MAGIC = 0x763D
_HEADER = struct.Struct("<HHHHH")
_ITEM = struct.Struct("<ffffiifHHBBBBBB")
_NO_CLEAR = 1
_PLAN_SIZE = 1024 * 1024
"""Size reported when a plan file is opened: ArduPlane does not know it before reading the file."""
_PARAM_BYTES = 12
"""Reported size of the parameter file: twelve bytes a parameter."""
_MAX_WRITE = 1 << 20


class FileError(Exception):
    """A failed operation; ``errno`` is C's error number."""

    def __init__(self, number: int) -> None:
        super().__init__(errno.errorcode.get(number, str(number)))
        self.errno = number


class ReadHandle:
    """An open file; the content of the parameter file depends on the block size of the reads."""

    def __init__(self, size: int, content: Callable[[int], bytes], *, one_block_size: bool) -> None:
        self.size = size
        self._content = content
        self._one_block_size = one_block_size
        self._block_size = 0
        self._data: bytes | None = None

    def read(self, offset: int, length: int) -> bytes:
        """Read at an offset: fewer bytes at the end, none beyond it.

        Raises
        ------
        FileError
            The block size differs from that of the first read, in a file that is padded for it.
        """
        if self._block_size and self._one_block_size and length != self._block_size:
            raise FileError(errno.EINVAL)
        if self._data is None:
            self._block_size = length
            self._data = self._content(length)
        return self._data[offset : offset + length]


class WriteHandle:
    """A file being written; it takes effect when it is closed."""

    def __init__(self, commit: Callable[[bytes], bool]) -> None:
        self._commit = commit
        self._data = bytearray()

    def write(self, offset: int, data: bytes) -> None:
        """Write at an offset; gaps are zero until written."""
        end = offset + len(data)
        if end > _MAX_WRITE:
            raise FileError(errno.ENOSPC)
        if end > len(self._data):
            self._data.extend(bytes(end - len(self._data)))
        self._data[offset:end] = data

    def close(self) -> bool:
        """Apply the file; False when it is malformed."""
        return self._commit(bytes(self._data))


class VirtualFiles:
    """The file system of one plane.

    Parameters
    ----------
    params : ParamStore
    plans : mapping of file name to (kind, store)
    say : callable
        Sends a text to every link.
    param_set : callable
        Receives each parameter changed by an uploaded file.
    """

    def __init__(
        self,
        params: ParamStore,
        plans: dict[str, tuple[PlanKind, PlanItems]],
        *,
        say: Callable[[Severity, str], None],
        param_set: Callable[[Parameter], None],
    ) -> None:
        self._params = params
        self._plans = plans
        self._say = say
        self._param_set = param_set

    def open_read(self, path: str) -> ReadHandle:
        """Open for reading; ``FileError(ENOENT)`` for anything but the virtual files."""
        path = path.removeprefix("/")
        name, _, query = path.partition("?")
        if name == "@PARAM/param.pck":
            return self._open_params(query)
        plan = self._plans.get(path.removeprefix("@MISSION/")) if path.startswith("@MISSION/") else None
        if plan is None:
            raise FileError(errno.ENOENT)
        return ReadHandle(_PLAN_SIZE, lambda _block: self._plan_bytes(*plan), one_block_size=False)

    def open_write(self, path: str) -> WriteHandle:
        """Open for writing."""
        path = path.removeprefix("/")
        if path == "@PARAM/param.pck":
            return WriteHandle(self._commit_params)
        plan = self._plans.get(path.removeprefix("@MISSION/")) if path.startswith("@MISSION/") else None
        if plan is None:
            raise FileError(errno.ENOENT)
        return WriteHandle(lambda data: self._commit_plan(*plan, data))

    def list(self, path: str) -> list[str]:
        """Directory entries for MAVFTP. As on ArduPlane, no listing has the virtual files."""
        if path.rstrip("/") in ("", "."):
            return ["D.", "D.."]
        raise FileError(errno.ENOENT)

    def _open_params(self, query: str) -> ReadHandle:
        options = {"start": 0, "count": 0, "withdefaults": 0}
        for key, text in parse_qsl(query):
            if key in options and (not text.isdecimal() or int(text) >= 65535):
                raise FileError(errno.EINVAL)
            if key in options:
                options[key] = int(text)
        if options["withdefaults"] > 1 or options["start"] >= len(self._params):
            raise FileError(errno.EINVAL)

        def content(block_size: int) -> bytes:
            return self._params.pack(
                block_size=block_size,
                start=options["start"],
                count=options["count"],
                with_defaults=bool(options["withdefaults"]),
            )

        return ReadHandle(len(self._params) * _PARAM_BYTES, content, one_block_size=True)

    def _plan_bytes(self, kind: PlanKind, store: PlanItems) -> bytes:
        items = [item for seq in range(len(store)) if (item := store.read(seq)) is not None]
        out = bytearray(_HEADER.pack(PLAN_MAGIC, kind.number, 0, 0, len(items)))
        for seq, item in enumerate(items):
            out += _ITEM.pack(
                item.p1, item.p2, item.p3, item.p4, item.x, item.y, item.z, seq, item.command,
                0, 0, item.frame, 0, item.autocontinue, kind.number,
            )  # fmt: skip
        return bytes(out)

    def _commit_plan(self, kind: PlanKind, store: PlanItems, data: bytes) -> bool:
        if len(data) < _HEADER.size:
            return False
        magic, _, options, first, count = _HEADER.unpack_from(data)
        body = data[_HEADER.size :]
        if magic != PLAN_MAGIC or len(body) // _ITEM.size != count:
            return False
        items: list[WireItem] = []
        for index in range(count):
            raw = body[index * _ITEM.size : (index + 1) * _ITEM.size]
            if not any(raw):
                return False  # a block that was lost on the way
            p1, p2, p3, p4, x, y, z, _seq, command, _sys, _comp, frame, current, auto, _kind = _ITEM.unpack(raw)
            items.append(WireItem(first + index, frame, command, p1, p2, p3, p4, x, y, z, current, auto, kind.number))
        keep = bool(options & _NO_CLEAR)
        if keep and kind.number != 0:
            return False
        # A fence is replaced once the new one is complete. A plan that may not be cleared is overwritten, and its tail
        # stays.
        if not keep and (kind.number == 1 or store.clear()):
            store.begin(count)
        for item in items:
            if kind.number == 0 and item.command == 177:
                # Unlike item by item, a jump must stay within the file.
                stored = normalise(item)
                if isinstance(stored, MissionResult) or not 0 < stored.p1 < count:
                    return False
            if store.put(item, last_seq=first + count - 1) is not MissionResult.ACCEPTED:
                store.abandon()
                return False
        if store.complete() is not MissionResult.ACCEPTED:
            for complaint in store.complaints:
                self._say(*complaint)
            return False
        if kind.number == 1 and kind.received is not None:
            self._say(*kind.received)
        return True

    def _commit_params(self, data: bytes) -> bool:
        try:
            values = self._params.unpack(data)
        except ValueError:
            return True  # which ArduPlane does not report
        for name, value in values:
            before = self._params.find(name)
            if before is None:
                continue
            try:
                after = self._params.set(name, value)
            except ParamValueError:
                continue
            if after.value != before.value:
                self._param_set(after)
        return True

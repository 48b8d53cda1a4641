"""Pictures read and decoded in a process of their own, so that what a camera sends can end that process and no other.

FFmpeg and OpenCV decode whatever comes from the network, in C and C++, inside whoever calls them. Here that is a child
with a limit on its memory: it opens a stream or a file, turns H.264 into pixels, or unpacks JPEG, and sends pictures
over a pipe. When it dies the camera is told to be dead, with the reason, and is tried again, less and less often.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import asdict
from typing import IO, Final, Literal, TypeAlias

import numpy as np

from vencejo.camera.address import SourceAddress
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame, Frame, Pixels

__all__ = ["Child", "ChildDied", "ChildSource", "StillDecoder"]

Role: TypeAlias = Literal["source", "decoder", "still"]

MAX_SIDE: Final = 16_384
MAX_BODY: Final = 256 << 20
MAX_STILL: Final = 32 << 20
HEAD: Final = struct.Struct("<BIIdQ")
"""What a message is, width, height, time in seconds, bytes that follow."""
PIXELS, JPEG, H264, H264_KEY, OPEN, FAILED = range(6)


class ChildDied(CameraError):
    """The process that read a camera ended: by what it read, as far as anybody can tell."""


class Child:
    """A process that decodes.

    Parameters
    ----------
    role : {"source", "decoder", "still"}
        What it is to do.
    """

    def __init__(self, role: Role) -> None:
        self._process = _SPARE.take()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._in: IO[bytes] = self._process.stdin
        self._out: IO[bytes] = self._process.stdout
        self.is_closed = False
        self.send(role.encode() + b"\n")

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid

    def send(self, data: bytes) -> bool:
        """Give it bytes; waits until it takes them. ``False`` when it is gone."""
        try:
            self._in.write(data)
            self._in.flush()
        except (OSError, ValueError):
            return False
        return True

    def receive(self) -> tuple[int, int, int, float, bytes] | None:
        """Its next message; ``None`` if it has ended, or sent something invalid."""
        try:
            head = self._out.read(HEAD.size)
            if len(head) != HEAD.size:
                return None
            kind, width, height, at_s, count = HEAD.unpack(head)
            is_size = width <= MAX_SIDE and height <= MAX_SIDE and count <= MAX_BODY
            if not is_size or (kind == PIXELS and count != width * height * 3) or kind > FAILED:
                return None
            body = self._out.read(count)
        except (OSError, ValueError):
            return None
        return None if len(body) != count else (kind, width, height, at_s, body)

    def why(self) -> str:
        """How it ended, for people."""
        self._end()
        code = self._process.returncode
        if code < 0:
            with contextlib.suppress(ValueError):
                return f"signal {-code}, {signal.Signals(-code).name}"
        return f"exit code {code}"

    def close(self) -> None:
        """End it, from any thread. May be called again."""
        self.is_closed = True
        self._end()

    def _end(self) -> None:
        if self._process.poll() is None and not self.is_closed:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(1.0)  # what it says of itself is worth more than that we killed it
        _end(self._process)


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with contextlib.suppress(OSError, ValueError):
            if pipe is not None:
                pipe.close()


class _Spare:
    """A child that has loaded its libraries in advance, so that its user need not wait for that."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        atexit.register(self._close)

    def prepare(self) -> None:
        """Start it, unless it is there."""
        with self._lock:
            if self._process is None or self._process.poll() is not None:
                self._process = self._start()

    def take(self) -> subprocess.Popen[bytes]:
        """The one that waits, or else a new one."""
        with self._lock:
            process, self._process = self._process, None
        return process if process is not None and process.poll() is None else self._start()

    def _start(self) -> subprocess.Popen[bytes]:
        # Not from the working directory; one thread for arithmetic that is not done here.
        env = {**os.environ, "PYTHONSAFEPATH": "1", "OPENBLAS_NUM_THREADS": "1"}
        return subprocess.Popen(
            [sys.executable, "-m", "vencejo.camera.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=env,
            start_new_session=True,  # Ctrl-C on the terminal is for us, and we end it
        )

    def _close(self) -> None:
        if self._process is not None:
            _end(self._process)


_SPARE: Final = _Spare()


def prepare() -> None:
    """Keep a child ready for the next request for pixels."""
    _SPARE.prepare()


def pixels(width: int, height: int, body: bytes) -> Pixels:
    """The picture of a message."""
    return np.frombuffer(body, np.uint8).reshape(height, width, 3)


class ChildSource:
    """A source that is read in a child. See `Source`.

    Parameters
    ----------
    address : SourceAddress

    Raises
    ------
    CameraError
        When it cannot be opened; the text says why.
    """

    def __init__(self, address: SourceAddress) -> None:
        self._shown = address.shown
        self.child = Child("source")
        # Through the pipe: other users can read arguments, and there may be a password.
        about = {**asdict(address), "kind": address.kind.value}
        self.child.send(json.dumps(about).encode() + b"\n")
        try:
            self._next(OPEN)
        except BaseException:
            self.close()
            raise

    def frames(self) -> Iterator[EncodedFrame | Frame]:
        """Pictures as they come. See `Source`."""
        while not self.child.is_closed:
            message = self._next()
            if message is None:
                return
            kind, width, height, at_s, body = message
            if kind == PIXELS:
                yield Frame(bgr=pixels(width, height, body), captured_unix_s=at_s)
                continue
            yield EncodedFrame(
                data=body,
                codec="jpeg" if kind == JPEG else "h264",
                captured_unix_s=at_s,
                is_key=kind != H264,
                width=width,
                height=height,
            )

    def close(self) -> None:
        """End it. See `Source`."""
        self.child.close()

    def _next(self, wanted: int | None = None) -> tuple[int, int, int, float, bytes] | None:
        message = self.child.receive()
        if message is None or (message[0] == OPEN) != (wanted == OPEN):
            if self.child.is_closed:
                return None
            if message is not None and message[0] == FAILED:
                raise CameraError(message[4].decode(errors="replace")[:500])
            how = self.child.why()
            raise ChildDied(
                f"what {self._shown} sends ended the process that reads it ({how}); nothing else was harmed"
            )
        if message[0] == FAILED:
            raise CameraError(message[4].decode(errors="replace")[:500])
        return message


class StillDecoder:
    """Unpacks JPEG pictures, one at a time, in a child that is started with the first."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._child: Child | None = None
        self._is_closed = False

    def decode(self, data: bytes) -> Pixels | None:
        """Blue, green and red of a JPEG file; ``None`` when it is broken, also when it broke its reader."""
        with self._lock:
            if self._is_closed or len(data) > MAX_STILL:
                return None
            child = self._child = self._child or Child("still")
            message = child.receive() if child.send(struct.pack("<Q", len(data)) + data) else None
            if message is None:
                child.close()
                self._child = None
                return None
            kind, width, height, _, body = message
            return pixels(width, height, body) if kind == PIXELS else None

    def close(self) -> None:
        """End it. May be called again."""
        child = self._child
        self._is_closed = True
        if child is not None:
            child.close()

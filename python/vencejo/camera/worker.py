"""The process that decodes what comes from a camera, as a program: `vencejo.camera.child` starts it and says what it is."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import struct
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from vencejo.camera.address import SourceAddress, SourceKind
from vencejo.camera.child import FAILED, H264, H264_KEY, HEAD, JPEG, MAX_SIDE, OPEN, PIXELS
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import Frame, opencv

__all__ = ["limit_memory", "main"]

ROOM: Final = 768 << 20
"""Bytes that a child may take beside what its libraries take when they are loaded: several pictures of 8192 × 4320."""
Put: TypeAlias = Callable[..., None]


def main() -> None:
    """What the child does, until its parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What a library prints is not for the pipe.
    out = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(1 << 26))
    limit_memory()
    role = _line().decode()
    lock = threading.Lock()

    def put(kind: int, body: bytes | memoryview, width: int = 0, height: int = 0, at_s: float = 0.0) -> None:
        with lock:
            view = memoryview(HEAD.pack(kind, width, height, at_s, len(body)))
            for part in (view, memoryview(body)):
                while part:
                    part = part[out.write(part) or 0 :]

    try:
        if role == "source":
            _read_source(put)
        elif role == "decoder":
            _decode_stream(put)
        else:
            _decode_stills(put)
    except CameraError as error:
        put(FAILED, str(error).encode())
    except BrokenPipeError:
        pass
    # Threads of FFmpeg may hang in a network: nothing is to be waited for.
    os._exit(0)


def _line() -> bytes:
    """The parent's next line, and not a byte more."""
    line = b""
    while not line.endswith(b"\n"):
        byte = os.read(0, 1)
        if not byte:
            os._exit(0)
        line += byte
    return line[:-1]


def limit_memory() -> None:
    """Limit the memory of this process to this much more than it has now."""
    opencv()
    try:
        import resource
    except ImportError:  # Windows
        return
    with contextlib.suppress(OSError, ValueError):
        with Path("/proc/self/status").open(encoding="ascii") as status:
            line = next(line for line in status if line.startswith("VmData"))
        limit = int(line.split()[1]) * 1024 + ROOM
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _end_with_parent() -> None:
    while os.read(0, 4096):
        pass
    os._exit(0)


def _read_source(put: Put) -> None:
    from vencejo.camera.sources.ffmpeg import open_file, open_stream

    about = json.loads(_line())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    address = SourceAddress(**{**about, "kind": SourceKind(about["kind"])})
    source = open_file(address) if address.kind is SourceKind.FILE else open_stream(address)
    put(OPEN, b"")
    for frame in source.frames():
        if isinstance(frame, Frame):
            bgr = np.ascontiguousarray(frame.bgr)
            put(PIXELS, bgr.data.cast("B"), frame.width, frame.height, frame.captured_unix_s)
            continue
        kind = JPEG if frame.codec == "jpeg" else H264_KEY if frame.is_key else H264
        put(kind, frame.data, frame.width, frame.height, frame.captured_unix_s)


def _decode_stream(put: Put) -> None:
    from vencejo.camera.decoder import Pipe, pictures_of

    pipe = Pipe()

    def feed() -> None:
        while data := os.read(0, 1 << 20):
            pipe.write(data)
        os._exit(0)

    threading.Thread(target=feed, daemon=True).start()
    for at_s, bgr in pictures_of(pipe):
        put(PIXELS, np.ascontiguousarray(bgr).data.cast("B"), bgr.shape[1], bgr.shape[0], at_s)


def _decode_stills(put: Put) -> None:
    from vencejo.camera import jpeg

    while len(head := sys.stdin.buffer.read(8)) == 8:
        bgr = jpeg.decode(sys.stdin.buffer.read(struct.unpack("<Q", head)[0]))
        if bgr is None or bgr.ndim != 3 or max(bgr.shape) > MAX_SIDE:
            put(FAILED, b"broken")
        else:
            put(PIXELS, np.ascontiguousarray(bgr).data.cast("B"), bgr.shape[1], bgr.shape[0])


if __name__ == "__main__":
    main()

"""The Raspberry Pi's own camera, by libcamera's program ``rpicam-vid``: the board encodes H.264, and we pass it on."""

from __future__ import annotations

import os
import selectors
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from vencejo.camera import h264
from vencejo.camera.address import SourceAddress
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame

__all__ = ["RpicamSource"]

PROGRAMS: Final = ("rpicam-vid", "libcamera-vid")
DEFAULT_SIZE: Final = (1280, 720)
DEFAULT_RATE_HZ: Final = 30
PIECE: Final = 65536
MAX_ERROR: Final = 2000
PATIENCE_S: Final = 5.0
"""A program that sends nothing for this long hangs and is restarted, s."""


class RpicamSource:
    """Starts the program and reads its byte stream.

    Parameters
    ----------
    address : SourceAddress
        The camera's number, and the mode that is wanted: 1280 × 720 at 30 pictures a second when not given.
    find : callable, optional
        Finds a program by name.
    patience_s : float, optional
        How long the program may send nothing, default 5 s.

    Raises
    ------
    CameraError
        When the program is not installed or does not start.
    """

    def __init__(
        self,
        address: SourceAddress,
        *,
        find: Callable[[str], str | None] = shutil.which,
        patience_s: float = PATIENCE_S,
    ) -> None:
        program = next((found for name in PROGRAMS if (found := find(name)) is not None), None)
        if program is None:
            raise CameraError("rpicam-vid is not installed: on a Raspberry Pi, `sudo apt install rpicam-apps`")
        self._size = (address.width or DEFAULT_SIZE[0], address.height or DEFAULT_SIZE[1])
        self._is_closed = False
        self._patience_s = patience_s
        try:
            self._process = subprocess.Popen(
                command(program, address.location, self._size, address.rate_hz or DEFAULT_RATE_HZ),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C on the terminal is for us, and we end it
            )
        except OSError as error:
            raise CameraError(f"{program} does not start: {error.strerror}") from error
        self._said = bytearray()
        self._listener = threading.Thread(target=self._listen, name="rpicam messages", daemon=True)
        self._listener.start()

    def frames(self) -> Iterator[EncodedFrame]:
        """Pictures as they come. See `Source`."""
        out = self._process.stdout
        assert out is not None
        cut = h264.AccessUnits()
        sets: tuple[bytes, bytes] | None = None
        try:
            while piece := self._read(out.fileno()):
                now = time.time()
                for data in cut.push(piece):
                    is_key = h264.is_key(data)
                    if is_key:
                        sets = h264.parameter_sets(data) or sets
                        data = h264.with_parameter_sets(data, sets)
                        # The board gives the nearest size that it can.
                        self._size = (h264.size(sets[0]) if sets is not None else None) or self._size
                    width, height = self._size
                    yield EncodedFrame(
                        data=data, codec="h264", captured_unix_s=now, is_key=is_key, width=width, height=height
                    )
        except (OSError, ValueError) as error:
            if not self._is_closed:
                raise CameraError(f"the camera's program cannot be read: {error}") from error
        finally:
            self._end()
        if not self._is_closed:
            self._listener.join(1.0)
            lines = self._said.decode(errors="replace").strip().splitlines()
            last = lines[-1] if lines else f"exit code {self._process.returncode}"
            raise CameraError(f"the camera's program ended: {last}")

    def _read(self, pipe: int) -> bytes:
        """What the program sends next; nothing at its end."""
        with selectors.DefaultSelector() as waiting:
            waiting.register(pipe, selectors.EVENT_READ)
            if not waiting.select(self._patience_s):
                raise CameraError(f"the camera's program sent nothing for {self._patience_s:g} s")
        return os.read(pipe, PIECE)

    def close(self) -> None:
        """End it. See `Source`."""
        self._is_closed = True
        self._end()

    def _end(self) -> None:
        self._process.terminate()
        try:
            self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _listen(self) -> None:
        """Keep the end of what it says, so that it never waits for us to read it."""
        err = self._process.stderr
        assert err is not None
        while line := err.readline(MAX_ERROR):
            self._said += line
            del self._said[:-MAX_ERROR]


def command(program: str, camera: str, size: tuple[int, int], rate_hz: int) -> Sequence[str]:
    """The command: H.264 for ever to standard output, a key frame with parameter sets each second."""
    return (
        *(program, "--camera", camera, "--timeout", "0", "--nopreview", "--codec", "h264", "--profile", "baseline"),
        *("--inline", "--flush", "--intra", str(rate_hz), "--framerate", str(rate_hz)),
        *("--width", str(size[0]), "--height", str(size[1]), "--output", "-"),
    )

"""H.264 to pixels: a decoder that runs only while pixels are requested."""

from __future__ import annotations

import io
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from vencejo.camera.child import PIXELS, Child, pixels
from vencejo.camera.frames import EncodedFrame, Frame, Pixels, opencv
from vencejo.camera.matroska import MatroskaWriter

__all__ = ["Decoder", "Pipe", "pictures_of"]

PRIMER: Final = 8
"""Times that the first key frame is given. FFmpeg looks at seven pictures of H.264 before it gives the first, to learn in which
order they are shown: with these it has seen them, and every picture after comes at once."""

MAX_BACKLOG: Final = 8 << 20
"""Bytes that wait at most; a decoder that is further behind begins again at a key frame."""
PIECE: Final = 1 << 18


class Decoder:
    """Decodes a stream as it comes, in a process of its own (see `vencejo.camera.child`).

    OpenCV reads streams, not pictures: so it is fed a Matroska stream that never ends.

    Parameters
    ----------
    group : sequence of EncodedFrame
        What to begin with: a key frame and what followed it.
    on_picture : callable, optional
        Called with each picture, in the decoder's thread.
    """

    def __init__(self, group: Sequence[EncodedFrame], *, on_picture: Callable[[Frame], None] | None = None) -> None:
        self._writer = MatroskaWriter(group[0])
        self._pipe = Pipe()
        self._on_picture = on_picture
        self._newest = threading.Condition()
        self._picture: Frame | None = None
        self._has_ended = False
        self._pipe.write(
            self._writer.header() + b"".join(self._writer.block(frame) for frame in (*[group[0]] * PRIMER, *group))
        )
        self._child: Child | None = None
        self._thread = threading.Thread(target=self._run, name="video decoder", daemon=True)
        self._thread.start()

    def feed(self, frame: EncodedFrame) -> bool:
        """Hand on the next picture; never waits. ``False`` when a new decoder is needed from the next key frame on."""
        if self._has_ended or not self._writer.fits(frame) or self._pipe.backlog() > MAX_BACKLOG:
            return False
        self._pipe.write(self._writer.block(frame))
        return True

    def picture(self) -> Frame | None:
        """The newest picture that is decoded."""
        with self._newest:
            return self._picture

    def wait(self, captured_unix_s: float, timeout_s: float) -> Frame | None:
        """The first picture not older than that; the newest when none comes in time."""

        def is_there() -> bool:
            # Times are in milliseconds on their way through the decoder.
            return self._has_ended or (
                self._picture is not None and self._picture.captured_unix_s >= captured_unix_s - 0.002
            )

        with self._newest:
            self._newest.wait_for(is_there, timeout_s)
            return self._picture

    def close(self) -> None:
        """End it. May be called again, and from its own thread."""
        self._pipe.end()
        if self._child is not None:
            self._child.close()
        if self._thread is not threading.current_thread():
            self._thread.join(5.0)

    def _run(self) -> None:
        try:
            child = self._child = Child("decoder")
            threading.Thread(target=self._hand_on, args=(child,), name="video decoder's feeder", daemon=True).start()
            try:
                while not self._pipe.has_ended and (message := child.receive()) is not None and message[0] == PIXELS:
                    _, width, height, at_s, body = message
                    picture = Frame(bgr=pixels(width, height, body), captured_unix_s=self._writer.unix_s(at_s))
                    with self._newest:
                        self._picture = picture
                        self._newest.notify_all()
                    if self._on_picture is not None and not self._pipe.has_ended:
                        self._on_picture(picture)
            finally:
                child.close()
        finally:
            with self._newest:
                self._has_ended = True
                self._newest.notify_all()

    def _hand_on(self, child: Child) -> None:
        while data := self._pipe.read(PIECE):
            if not child.send(data):
                return


def pictures_of(pipe: Pipe) -> Iterator[tuple[float, Pixels]]:
    """Pictures of a Matroska stream, each with its time in seconds; older ones are left out while newer ones wait. In the child."""
    cv2 = opencv()
    # One thread: with more, FFmpeg holds back as many pictures as there are threads.
    capture = cv2.VideoCapture(pipe, cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 1])
    newest_ms = -1.0
    try:
        while capture.isOpened() and pipe.backlog() <= 2 * MAX_BACKLOG and capture.grab():
            at_ms = float(capture.get(cv2.CAP_PROP_POS_MSEC))
            if at_ms <= newest_ms:
                continue  # the first again
            if pipe.backlog() > 0 and not pipe.has_ended:
                continue  # a newer one is there: turning this one into pixels would be for nothing
            is_there, bgr = capture.retrieve()
            if not is_there:
                continue
            newest_ms = at_ms
            yield at_ms / 1000.0, bgr
    finally:
        capture.release()


class Pipe(io.BufferedIOBase):
    """Bytes from one thread to another. Nothing in it may raise: it is called from inside OpenCV."""

    def __init__(self) -> None:
        super().__init__()
        self._bytes = bytearray()
        self._changed = threading.Condition()
        self.has_ended = False

    def write(self, data: object, /) -> int:
        """Add bytes."""
        assert isinstance(data, bytes)
        with self._changed:
            self._bytes += data
            self._changed.notify()
        return len(data)

    def backlog(self) -> int:
        """Bytes that wait."""
        return len(self._bytes)

    def end(self) -> None:
        """No more will come; what waits is thrown away."""
        with self._changed:
            self.has_ended = True
            self._bytes.clear()
            self._changed.notify()

    def read(self, size: int | None = -1, /) -> bytes:
        """Take bytes; waits for the first."""
        with self._changed:
            self._changed.wait_for(lambda: self._bytes or self.has_ended)
            count = len(self._bytes) if size is None or size < 0 else size
            taken = bytes(self._bytes[:count])
            del self._bytes[:count]
            return taken

    def readable(self) -> bool:
        """Yes."""
        return True

    def seekable(self) -> bool:
        """No."""
        return False

    def seek(self, offset: int, whence: int = 0, /) -> int:
        """Say that this cannot be done, in OpenCV's way."""
        return -1

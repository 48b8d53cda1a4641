"""The camera of one plane: takes pictures at its rate, but only while there are viewers."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, NamedTuple

from vencejo.sim.autopilot.interface import Outlook

from .view import Pinhole, Pose

if TYPE_CHECKING:
    from .render import Renderer

__all__ = ["Frame", "NoseCamera"]

_JPEG_QUALITY = 80
_NO_FRAME_S = 60.0
"""Time without a picture after which a viewer gets an error; generous, for busy machines."""


class Frame(NamedTuple):
    """One picture."""

    number: int
    unix_s: float
    """Time of the pose that it shows, seconds since 1970."""
    jpeg: bytes


class NoseCamera:
    """Pictures of one plane for any number of viewers; each gets the newest, and a slow one skips some.

    Parameters
    ----------
    heading_deg : float
        Direction of the runway, degrees true.
    rate_hz : float
        Pictures a second while there are viewers, 1 to 30.
    camera : Pinhole, optional
    """

    def __init__(self, heading_deg: float, rate_hz: float, camera: Pinhole | None = None) -> None:
        self.camera = camera if camera is not None else Pinhole()
        self.rate_hz = rate_hz
        self._heading_deg = heading_deg
        self._renderer: Renderer | None = None
        self._changed = threading.Condition()
        self._sight: tuple[float, Outlook] | None = None
        self._frame: Frame | None = None
        self._viewers = 0
        self._closed = False
        self._thread: threading.Thread | None = None

    # the simulator's side

    @property
    def watched(self) -> bool:
        """True while there are viewers; only then the simulator has to call :meth:`see`."""
        return self._viewers > 0

    def see(self, unix_s: float, outlook: Outlook) -> None:
        """Set the newest state: its time, seconds since 1970, and the outlook."""
        with self._changed:
            self._sight = (unix_s, outlook)
            self._changed.notify_all()

    def close(self) -> None:
        """Stop; viewers see the end of the stream."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join()

    # the viewers' side

    def __enter__(self) -> NoseCamera:
        with self._changed:
            self._viewers += 1
            if self._thread is None and not self._closed:
                self._thread = threading.Thread(target=self._run, name="vencejo-sim-camera", daemon=True)
                self._thread.start()
            self._changed.notify_all()
        return self

    def __exit__(self, *_exception: object) -> None:
        with self._changed:
            self._viewers -= 1
            if self._viewers == 0:
                # The next viewer must not get an old picture.
                self._sight = self._frame = None

    def next_frame(self, after: int = 0, timeout_s: float = _NO_FRAME_S) -> Frame | None:
        """Wait for a picture with a number above ``after``; None when the camera has stopped."""
        with self._changed:
            self._changed.wait_for(
                lambda: self._closed or (self._frame is not None and self._frame.number > after), timeout_s
            )
            frame = self._frame
            return None if self._closed or frame is None or frame.number <= after else frame

    # internals

    def _run(self) -> None:
        number = 0
        due_s = 0.0
        taken: tuple[float, Outlook] | None = None

        def is_new() -> bool:
            # While the simulator is slower than the camera, a state is not shown twice.
            return self._viewers > 0 and self._sight is not None and self._sight is not taken

        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or is_new())
                if not self._closed and (left_s := due_s - time.monotonic()) > 0:
                    self._changed.wait_for(lambda: self._closed, left_s)
                sight = self._sight
                if self._closed:
                    return
                if sight is None:
                    continue
            due_s = max(due_s + 1.0 / self.rate_hz, time.monotonic())
            number += 1
            taken = sight
            unix_s, outlook = sight
            frame = Frame(number, unix_s, self._picture(outlook))
            with self._changed:
                if self._viewers:
                    self._frame = frame
                self._changed.notify_all()

    def _picture(self, outlook: Outlook) -> bytes:
        # OpenCV loads slowly: the first viewer waits for it, not the start of the simulator.
        import cv2

        if self._renderer is None:
            from .render import Renderer

            self._renderer = Renderer(self._heading_deg, self.camera)
        self._renderer.mark(outlook.home_m, outlook.landings_m)
        pose = Pose(*outlook[:6])
        done, jpeg = cv2.imencode(".jpg", self._renderer.render(pose), (cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY))
        if not done:
            raise RuntimeError("OpenCV could not encode a picture as JPEG")
        return jpeg.tobytes()

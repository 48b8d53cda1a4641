"""A camera: its source, read for ever by a thread of its own, and its newest picture.

Encoded pictures are passed on unchanged. They are decoded, and raw ones encoded, only on demand.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final

from vencejo._closing import Closing
from vencejo._given import check_timeout
from vencejo.camera import jpeg
from vencejo.camera.address import NAME, SourceAddress, SourceKind, parse_source
from vencejo.camera.aside import Aside
from vencejo.camera.child import ChildDied, StillDecoder, prepare
from vencejo.camera.decoder import Decoder
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import Codec, EncodedFrame, Frame
from vencejo.camera.recorder import RecorderLimits, Recording, VideoRecorder, default_video_dir
from vencejo.camera.sources import Source, open_source

__all__ = ["Camera", "CameraState", "CameraStatus"]

STALL_S: Final = 2.0
"""A camera without a picture for this long is stalled, s."""
FIRST_RETRY_S: Final = 0.5
LAST_RETRY_S: Final = 10.0
SETTLED_S: Final = 5.0
"""After a source has worked this long, retries begin with the shortest wait again, s."""
ASKED_S: Final = 3.0
"""Decoding, and reading on demand, continue this long after the last request, s."""
MAX_BEHIND_S: Final = 0.5
"""A decoder further behind the newest picture is starting: its first picture is waited for, s."""
KEEPS_UP_S: Final = 0.1
"""How long a running decoder is waited for, s."""
WAKE_S: Final = 8.0
"""Longest wait for the first picture of a source that is read on demand, s."""
MAX_GROUP: Final = 600
MAX_GROUP_BYTES: Final = 8 << 20
RATE_WINDOW_S: Final = 2.0
MIN_RATE_SPAN_S: Final = 1.0


class CameraState(Enum):
    """State of a camera's pictures."""

    STANDBY = "standby"
    STARTING = "starting"
    LIVE = "live"
    STALLED = "stalled"
    DEAD = "dead"


@dataclass(frozen=True, kw_only=True)
class CameraStatus:
    """Status of a camera.

    Attributes
    ----------
    state : CameraState
        ``STANDBY``: a source on demand without viewers; ``STARTING``: before the first picture; ``LIVE``; ``STALLED``:
        the source is connected, but no pictures come; ``DEAD``: the source cannot be opened and is retried for ever.
    reason : str or None
        Why no pictures come.
    codec : {"h264", "jpeg"} or None
        Codec of the source; ``None`` before the first picture, and for raw pictures.
    width, height : int or None
        Pixels.
    rate_hz, bitrate_bit_s : float or None
        Over the last two seconds.
    captured_unix_s : float or None
        When the newest picture was taken.
    frames : int
        Number of pictures so far.
    recording : Recording or None
        The present recording, or the last one if a fault ended it.
    """

    state: CameraState
    reason: str | None = None
    codec: Codec | None = None
    width: int | None = None
    height: int | None = None
    rate_hz: float | None = None
    bitrate_bit_s: float | None = None
    captured_unix_s: float | None = None
    frames: int = 0
    recording: Recording | None = None


class Camera(Closing):
    """A camera. It is read from construction until it is closed.

    Parameters
    ----------
    source : str
        See `vencejo.camera.parse_source`. A source on demand is read only while it is watched (`watch`), recorded, or
        asked for pictures.
    name : str, optional
        1 to 32 letters, digits, ``-`` or ``_``; default ``"camera"``.
    recording_dir : Path, optional
        Folder of recordings; default `vencejo.camera.default_video_dir`.
    recording_limits : RecorderLimits, optional
        Limits of each recording: its size, and the free disk space to keep.
    jpeg_quality : int, optional
        JPEG quality, 1 to 100, default 80, of pictures that are encoded here.
    open : callable, optional
        Function that opens the source; for tests.
    monotonic_s : callable, optional
        Clock for ages.

    Raises
    ------
    CameraError
        For an invalid source or name. A source that cannot be opened is no error: it is retried.

    Examples
    --------
    >>> from vencejo.camera import Camera, CameraState
    >>> with Camera("no-such-file.mp4") as camera:
    ...     camera.status.state in (CameraState.STARTING, CameraState.DEAD)
    True
    """

    def __init__(
        self,
        source: str,
        *,
        name: str = "camera",
        recording_dir: Path | None = None,
        recording_limits: RecorderLimits | None = None,
        jpeg_quality: int = 80,
        open: Callable[[SourceAddress], Source] = open_source,
        monotonic_s: Callable[[], float] = time.monotonic,
    ) -> None:
        if NAME.fullmatch(name) is None:
            raise CameraError(f"{name!r} is not a camera name: 1 to 32 letters, digits, '-' or '_'")
        if not 1 <= jpeg_quality <= 100:
            raise CameraError(f"jpeg_quality is {jpeg_quality}, should be 1 to 100")
        self.name = name
        self._address = parse_source(source)
        self._recording_dir = recording_dir or default_video_dir()
        self._recording_limits = recording_limits
        self._aside = Aside(self._recording_dir, self._address.location)
        self._quality = jpeg_quality
        self._open = open
        self._monotonic_s = monotonic_s
        self._lock = threading.RLock()
        self._arrived = threading.Condition(self._lock)
        self._stop = threading.Event()
        self._source: Source | None = None
        self._state = CameraState.STANDBY if self._address.is_on_demand else CameraState.STARTING
        self._reason: str | None = None
        self._codec: Codec | None = None
        self._size: tuple[int, int] | None = None
        self._captured_unix_s: float | None = None
        self._frames = 0
        self._arrivals: deque[tuple[float, int]] = deque()
        self._last_s: float | None = None
        self._group: list[EncodedFrame] = []
        self._group_bytes = 0
        self._jpeg: EncodedFrame | None = None
        self._raw: Frame | None = None
        """The newest picture of a source that does not encode."""
        self._pixels: Frame | None = None
        """The newest JPEG picture, decoded."""
        self._decoder: Decoder | None = None
        self._stills = StillDecoder()
        self._asked_s: float | None = None
        """When pixels were last requested."""
        self._waiting = 0
        """Number of callers waiting for pixels."""
        self._wanted_s: float | None = None
        """When pictures of any kind were last requested."""
        self._is_watched = False
        self._askers = 0
        """Number of callers waiting for a picture."""
        self._wants_jpeg = False
        self._beginning = threading.Lock()
        """Held while a recording is started or stopped, which may wait for the disk; taken before the other lock."""
        self._recorder: VideoRecorder | None = None
        """The present recording, or the last one if a fault ended it."""
        self._listeners: tuple[Callable[[EncodedFrame], None], ...] = ()
        self._thread = threading.Thread(target=self._run, name=f"camera {name}", daemon=True)
        self._thread.start()

    @property
    def source(self) -> str:
        """The source, without passwords."""
        return self._address.shown

    @property
    def recording_dir(self) -> Path:
        """Folder of its recordings."""
        return self._recording_dir

    @property
    def recording_limits(self) -> RecorderLimits | None:
        """Limits of its recordings; ``None`` for the default ones."""
        return self._recording_limits

    @property
    def status(self) -> CameraStatus:
        """Its present status."""
        with self._lock:
            now = self._monotonic_s()
            state = self._state
            reason = self._reason
            is_quiet = self._last_s is not None and now - self._last_s > STALL_S
            if state is CameraState.LIVE and is_quiet:
                state, reason = CameraState.STALLED, "the source is there, but no pictures come"
            rate_hz, bitrate = self._rates(now) if state is CameraState.LIVE else (None, None)
            return CameraStatus(
                state=state,
                reason=reason,
                codec=self._codec,
                width=None if self._size is None else self._size[0],
                height=None if self._size is None else self._size[1],
                rate_hz=rate_hz,
                bitrate_bit_s=bitrate,
                captured_unix_s=self._captured_unix_s,
                frames=self._frames,
                recording=None if self._recorder is None else self._recorder.status(),
            )

    @property
    def is_on_demand(self) -> bool:
        """Whether its source is read only while it is watched, recorded, or asked for pictures."""
        return self._address.is_on_demand

    def watch(self, is_watched: bool) -> None:
        """Set whether it has viewers: a source on demand is read for its listeners only then."""
        with self._lock:
            if self._is_watched != is_watched:
                self._is_watched = is_watched
                self._want()

    def latest(self, timeout_s: float = 1.0) -> Frame | None:
        """The newest picture in pixels.

        The first call starts decoding, and reading a source on demand; both stop after three seconds without a call.

        Parameters
        ----------
        timeout_s : float, optional
            How long to wait for the first, default 1 s.

        Returns
        -------
        Frame or None
            ``None`` when there was none in time. How old it is: ``time.time() - frame.captured_unix_s``.

        Raises
        ------
        CameraError
            When OpenCV is not installed.
        """
        with self._lock:
            if not self._wait_for_pictures(timeout_s):
                return None
            self._asked_s = self._monotonic_s()
            raw, still, pixels = self._raw, self._jpeg, self._pixels
            # FFmpeg gives a picture when it has the one after it.
            newest = self._group[-2:][0] if self._group else None
            if newest is not None:
                self._ensure_decoder()
            decoder = self._decoder
        if raw is not None:
            return raw
        if still is None:
            with self._waited_for():
                return _decoded(decoder, newest, timeout_s)
        if pixels is not None and pixels.captured_unix_s == still.captured_unix_s:
            return pixels
        bgr = self._stills.decode(still.data)
        if bgr is None:
            return pixels
        pixels = Frame(bgr=bgr, captured_unix_s=still.captured_unix_s)
        self._pixels = pixels
        return pixels

    @contextlib.contextmanager
    def _waited_for(self) -> Iterator[None]:
        """Keep the decoder while the caller waits: it may take longer to start than it is kept without requests."""
        with self._lock:
            self._waiting += 1
        try:
            yield
        finally:
            with self._lock:
                self._waiting -= 1
                self._asked_s = self._monotonic_s()

    def latest_jpeg(self, timeout_s: float = 1.0) -> EncodedFrame | None:
        """The newest picture as JPEG: that of a JPEG source unchanged, others encoded here.

        Parameters
        ----------
        timeout_s : float, optional
            How long to wait for the first, default 1 s.

        Returns
        -------
        EncodedFrame or None
            ``None`` when there was none in time.
        """
        with self._lock:
            if not self._wait_for_pictures(timeout_s):
                return None
            if self._codec == "jpeg":
                return self._jpeg
        frame = self.latest(timeout_s)
        return None if frame is None else jpeg.encoded(frame, quality=self._quality)

    def listen(self, listener: Callable[[EncodedFrame], None]) -> Callable[[], None]:
        """Call a function for each encoded picture, in the camera's thread: it must be quick and not raise.

        Returns
        -------
        callable
            Stops the calls.
        """
        with self._lock:
            self._listeners = (*self._listeners, listener)

        def end() -> None:
            with self._lock:
                self._listeners = tuple(other for other in self._listeners if other is not listener)

        return end

    def want_jpeg(self, wanted: bool) -> None:
        """Set whether listeners also get JPEG pictures of a source with another codec; they are encoded here."""
        with self._lock:
            self._wants_jpeg = wanted
            if wanted and self._codec == "h264" and self._group:
                self._ensure_decoder()

    def start_recording(self) -> Recording:
        """Start recording; returns the present recording if there is one.

        A source that is read on demand is waited for: 8 s at most. H.264 is written from a key frame on: the last one
        if its group of pictures is at hand, else the next.

        Raises
        ------
        CameraError
            When nothing can be written, or no pictures come.
        """
        with self._lock:
            if (recording := self._recording()) is not None:
                return recording
            self._wait_for_pictures(WAKE_S if self._state is CameraState.STANDBY else 0.0)
            if self._state is not CameraState.LIVE:
                raise CameraError(f"no pictures come from {self.source}, so there is nothing to record")
        with self._beginning:
            with self._lock:
                if (recording := self._recording()) is not None:
                    return recording
                if self._stop.is_set():
                    raise CameraError(f"the camera {self.name} is closed")
            # Not under the lock of the pictures: a disk that hangs must not delay them.
            recorder = VideoRecorder(self._recording_dir, self.name, limits=self._recording_limits)
            with self._lock:
                recorder.begin(self._group)
                self._recorder = recorder
            return recorder.status()

    def stop_recording(self) -> Recording | None:
        """Stop recording; ``None`` without a recording."""
        with self._beginning, self._lock:
            recorder, self._recorder = self._recorder, None
            self._want()
        return None if recorder is None else recorder.close()

    def close(self) -> None:
        """Close the source and stop recording. Can be called again."""
        self._stop.set()
        with self._lock:
            source, decoder, self._decoder = self._source, self._decoder, None
            self._arrived.notify_all()
        if source is not None:
            source.close()
        if decoder is not None:
            decoder.close()
        self._stills.close()
        self.stop_recording()
        if threading.current_thread() is not self._thread:
            # A hanging network is not waited for: the thread ends when the call returns.
            self._thread.join(1.0)

    def __repr__(self) -> str:
        return f"<Camera {self.name}: {self.source}, {self.status.state.value}>"

    # The camera's thread ----------------------------------------------------------------------------------------------

    def _run(self) -> None:
        wait_s = FIRST_RETRY_S
        if (left := self._aside.left()) is not None:
            with self._lock:
                self._state, self._reason = CameraState.DEAD, left[0]
            self._stop.wait(left[1])
        while self._wait_for_demand():
            began_s = self._monotonic_s()
            try:
                self._read()
                reason = "the source ended"
            except ChildDied as error:
                reason = self._aside.died(str(error))
                wait_s = max(wait_s, self._aside.wait_s)
            except CameraError as error:
                reason = str(error)
            except Exception as error:  # noqa: BLE001  (a fault in a reader ends no flight: it is shown and tried again)
                reason = f"internal error: {type(error).__name__}: {error}"
            if self._stop.is_set():
                return
            with self._lock:
                if not self._is_demanded():
                    continue
                self._state, self._reason = CameraState.DEAD, reason
                self._forget()
            if self._monotonic_s() - began_s > SETTLED_S and self._aside.wait_s == 0.0:
                wait_s = FIRST_RETRY_S
            self._stop.wait(wait_s)
            wait_s = min(wait_s * 2, LAST_RETRY_S)

    def _wait_for_demand(self) -> bool:
        """Wait until pictures of a source on demand are wanted. ``False`` once the camera is closed."""
        with self._lock:
            if not self._is_demanded():
                self._state, self._reason = CameraState.STANDBY, None
                # The codec stays known for the next request; old pictures are not shown.
                codec = self._codec
                self._forget()
                self._codec = codec
                self._arrived.wait_for(lambda: self._stop.is_set() or self._is_demanded())
                self._state = CameraState.STARTING
            return not self._stop.is_set()

    def _read(self) -> None:
        source = self._open(self._address)
        if self._address.kind in (SourceKind.HTTP, SourceKind.STREAM, SourceKind.FILE):
            prepare()
        with self._lock:
            self._source = source
        try:
            if self._stop.is_set():
                return
            for frame in source.frames():
                if self._stop.is_set() or not self._is_demanded():
                    return
                self._take(frame)
        finally:
            source.close()
            with self._lock:
                self._source = None

    def _take(self, frame: EncodedFrame | Frame) -> None:
        size = len(frame.data) if isinstance(frame, EncodedFrame) else 0
        with self._lock:
            now = self._monotonic_s()
            self._state, self._reason = CameraState.LIVE, None
            self._aside.came(now)
            self._last_s, self._captured_unix_s = now, frame.captured_unix_s
            self._size = (frame.width, frame.height)
            self._frames += 1
            self._arrivals.append((now, size))
            self._forget_arrivals(now)
            codec = frame.codec if isinstance(frame, EncodedFrame) else None
            if codec != self._codec:
                self._forget()
                self._codec = codec
            if isinstance(frame, Frame):
                self._raw = frame
                is_passed_on = self._recording() is not None or (self._wants_jpeg and bool(self._listeners))
            else:
                is_passed_on = True
                if frame.codec == "jpeg":
                    self._jpeg = frame
                else:
                    self._keep(frame)
                    self._feed_decoder(frame, now)
            listeners, recorder = self._listeners, self._recorder
            self._arrived.notify_all()
        if not is_passed_on:
            return
        encoded = jpeg.encoded(frame, quality=self._quality) if isinstance(frame, Frame) else frame
        if recorder is not None:
            recorder.add(encoded)
        for listener in listeners:
            listener(encoded)

    def _keep(self, frame: EncodedFrame) -> None:
        """Keep the group of pictures since the last key frame, from which decoders and recordings start."""
        if frame.is_key:
            self._group, self._group_bytes = [], 0
        elif not self._group:
            return
        self._group.append(frame)
        self._group_bytes += len(frame.data)
        if len(self._group) > MAX_GROUP or self._group_bytes > MAX_GROUP_BYTES:
            self._group, self._group_bytes = [], 0

    def _feed_decoder(self, frame: EncodedFrame, now: float) -> None:
        is_new = self._asked_s is not None and now - self._asked_s <= ASKED_S
        is_asked = self._wants_jpeg or self._waiting > 0 or is_new
        if not is_asked:
            self._drop_decoder()
        elif self._decoder is None:
            if frame.is_key:
                self._ensure_decoder()
        elif not self._decoder.feed(frame):
            self._drop_decoder()
            if frame.is_key:
                self._ensure_decoder()

    def _ensure_decoder(self) -> None:
        if self._decoder is None and self._group:
            self._decoder = Decoder(self._group, on_picture=self._on_picture)

    def _drop_decoder(self) -> None:
        decoder, self._decoder = self._decoder, None
        if decoder is not None:
            # It ends by itself; to wait for it here could be to wait for ourselves.
            threading.Thread(target=decoder.close, name="video decoder's end", daemon=True).start()

    def _on_picture(self, picture: Frame) -> None:
        """In the decoder's thread: pass on a picture to listeners that want JPEG."""
        with self._lock:
            listeners = self._listeners if self._wants_jpeg and self._codec == "h264" else ()
        if listeners:
            encoded = jpeg.encoded(picture, quality=self._quality)
            for listener in listeners:
                listener(encoded)

    def _forget(self) -> None:
        """Drop earlier pictures: they are neither shown as new nor used to decode later ones."""
        self._group, self._group_bytes = [], 0
        self._jpeg, self._raw, self._pixels = None, None, None
        self._codec = None
        self._arrivals.clear()
        self._drop_decoder()
        if self._recorder is not None:
            self._recorder.interrupt()

    # Under the lock ---------------------------------------------------------------------------------------------------

    def _has_pictures(self) -> bool:
        return self._jpeg is not None or self._raw is not None or bool(self._group)

    def _recording(self) -> Recording | None:
        """The present recording; ``None`` once the disk has ended it."""
        status = None if self._recorder is None else self._recorder.status()
        return status if status is not None and status.problem is None else None

    def _want(self) -> None:
        self._wanted_s = self._monotonic_s()
        self._arrived.notify_all()

    def _wait_for_pictures(self, timeout_s: float) -> bool:
        """Wait for a picture, also of a source on demand, which is then read for a while."""
        check_timeout(timeout_s)
        self._askers += 1
        self._arrived.notify_all()
        try:
            return self._arrived.wait_for(self._has_pictures, timeout_s)
        finally:
            self._askers -= 1
            self._want()

    def _is_demanded(self) -> bool:
        if not self._address.is_on_demand or self._is_watched or self._askers > 0 or self._recording() is not None:
            return True
        return self._wanted_s is not None and self._monotonic_s() - self._wanted_s <= ASKED_S

    def _forget_arrivals(self, now: float) -> None:
        while self._arrivals and now - self._arrivals[0][0] > RATE_WINDOW_S:
            self._arrivals.popleft()

    def _rates(self, now: float) -> tuple[float | None, float | None]:
        self._forget_arrivals(now)
        if len(self._arrivals) < 2:
            return None, None
        span_s = self._arrivals[-1][0] - self._arrivals[0][0]
        if span_s < MIN_RATE_SPAN_S:
            return None, None  # pictures queued while a stream was opened come all at once
        bits = 8 * sum(size for _, size in list(self._arrivals)[1:])
        return (len(self._arrivals) - 1) / span_s, bits / span_s if bits else None


def _decoded(decoder: Decoder | None, newest: EncodedFrame | None, timeout_s: float) -> Frame | None:
    if decoder is None or newest is None:
        return None
    picture = decoder.picture()
    # A running decoder is at most a picture behind; a new one has to catch up first.
    is_new = picture is None or newest.captured_unix_s - picture.captured_unix_s > MAX_BEHIND_S
    return decoder.wait(newest.captured_unix_s, timeout_s if is_new else min(timeout_s, KEEPS_UP_S))

"""A camera in the ground station: its pictures go to the server, and what the browsers ask for comes back."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING, Final

from vencejo._closing import Closing
from vencejo.camera.camera import WAKE_S, Camera, CameraState
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame
from vencejo.camera.recorder import keep_still
from vencejo.camera.still import Pose, pose_of, with_pose
from vencejo.errors import ClosedError, VencejoError
from vencejo.video import VideoFeed, VideoRequest, VideoStatus

if TYPE_CHECKING:
    from vencejo.serve import Server

__all__ = ["ServedCamera", "still_picture"]

LOOK_INTERVAL_S: Final = 0.25
"""How often the camera's status is sent to the server, s."""
MAX_STILL_AGE_S: Final = 5.0
"""Greatest age of a picture of which a still is made, s."""


class ServedCamera(Closing):
    """Serves a camera until it is closed; the camera itself goes on.

    Parameters
    ----------
    server : Server
        Whose pages show it.
    camera : Camera

    Raises
    ------
    VencejoError
        When the server has a camera of that name, or as many as it can.
    """

    def __init__(self, server: Server, camera: Camera) -> None:
        self._server = server
        self._camera = camera
        self._feed: VideoFeed = server.add_camera(camera.name, camera.source)
        self._stop = threading.Event()
        self._end = camera.listen(self._publish)
        self._thread = threading.Thread(target=self._serve, name=f"served camera {camera.name}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Take the camera out of the pages. May be called again."""
        self._stop.set()
        self._end()
        self._camera.want_jpeg(False)
        self._camera.watch(False)
        self._feed.close()
        if threading.current_thread() is not self._thread:
            self._thread.join(5.0)

    def _publish(self, frame: EncodedFrame) -> None:
        # The server is closed before the camera, at the end.
        with contextlib.suppress(ClosedError):
            self._feed.publish(
                frame.data,
                codec=frame.codec,
                is_key=frame.is_key,
                width=frame.width,
                height=frame.height,
                captured_unix_s=frame.captured_unix_s,
            )

    def _serve(self) -> None:
        while not self._stop.is_set():
            try:
                self._feed.set_status(self._status())
                request = self._feed.next_request(LOOK_INTERVAL_S)
                jpeg_viewers, h264_viewers = self._feed.jpeg_viewers, self._feed.h264_viewers
                self._camera.watch(jpeg_viewers + h264_viewers > 0)
                self._camera.want_jpeg(jpeg_viewers > 0)
                if request is not None:
                    self._answer(request)
            except ClosedError:
                return

    def _status(self) -> VideoStatus:
        status = self._camera.status
        recording = status.recording
        return VideoStatus(
            state=status.state.value,
            reason=status.reason,
            codec=status.codec,
            size=None if status.width is None or status.height is None else (status.width, status.height),
            rate_hz=status.rate_hz,
            bitrate_bit_s=status.bitrate_bit_s,
            recording=None
            if recording is None
            else (recording.path.name, recording.duration_s, recording.bytes, recording.problem),
        )

    def _answer(self, request: VideoRequest) -> None:
        try:
            picture = b""
            if request.kind in {"snapshot", "keep_snapshot"}:
                picture = still_picture(self._camera, self._server)
                if request.kind == "keep_snapshot":
                    keep_still(
                        self._camera.recording_dir, self._camera.name, picture, limits=self._camera.recording_limits
                    )
            elif request.kind == "start_recording":
                self._camera.start_recording()
            else:
                self._camera.stop_recording()
            self._feed.set_status(self._status())
            request.answer(picture)
        except (VencejoError, OSError) as error:
            request.refuse(str(error))


def still_picture(camera: Camera, server: Server | None = None, *, unix_s: float | None = None) -> bytes:
    """The newest picture as a JPEG file that says when and where it was taken.

    Parameters
    ----------
    camera : Camera
    server : Server, optional
        Whose only vehicle carries the camera; with several vehicles, nobody knows which does, and none is named.
    unix_s : float, optional
        The time of day, for tests.

    Raises
    ------
    CameraError
        When there is no picture of now.
    """
    state = camera.status.state
    # What is there only has to be decoded, however busy the machine is; what is not will hardly come.
    is_worth_waiting = state is CameraState.LIVE or (camera.is_on_demand and state is not CameraState.DEAD)
    frame = camera.latest_jpeg(WAKE_S if is_worth_waiting else 1.0)
    now = time.time() if unix_s is None else unix_s
    if frame is None:
        raise CameraError(f"there is no picture: {camera.status.reason or 'none has come yet'}")
    age_s = now - frame.captured_unix_s
    if age_s > MAX_STILL_AGE_S:
        raise CameraError(f"the newest picture is {age_s:.0f} s old: {camera.status.reason or 'no newer one comes'}")
    vehicles = [] if server is None else server.station.vehicles
    pose = pose_of(vehicles[0].telemetry, max(age_s, 0.0)) if len(vehicles) == 1 else Pose()
    return with_pose(frame.data, frame.captured_unix_s, pose)

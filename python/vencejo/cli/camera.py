"""The command `vencejo camera`, and the cameras of the commands that serve."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vencejo.cli.common import UNREAD, Failed, JsonOption, put_json, say

if TYPE_CHECKING:
    from vencejo.camera import Camera, CameraStatus
    from vencejo.serve import Server
    from vencejo.storage import Floors

OPENING_S: Final = 20.0
"""Longest wait for a source that is neither there nor known to be missing, s."""
LOOK_INTERVAL_S: Final = 0.2
TELL_INTERVAL_S: Final = 2.0

CameraOption = Annotated[
    list[str] | None,
    typer.Option(
        "--camera",
        metavar="[NAME=]SOURCE",
        help="Show a camera: /dev/video0, rpicam, rtsp://…, http://…, or a video file; repeatable. "
        "With on-demand: before the source it is read only while it has viewers.",
    ),
]


def camera(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="/dev/video0, rpicam, rtsp://…, http://…, udp://…, an .sdp file, or a video file; "
            "devices take a mode, such as /dev/video0,1280x720@30.",
        ),
    ],
    snapshot: Annotated[
        Path | None, typer.Option("--snapshot", metavar="FILE", help="Write one picture (JPEG) and end.")
    ] = None,
    record: Annotated[
        bool, typer.Option("--record", help="Record to a file in the data folder until the end.")
    ] = False,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds", metavar="S", min=0.1, help="End this long after it was opened; by default at Ctrl-C."
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Try a camera: show whether pictures come, take one, or record.

    Ends with 1 when nothing was recorded with --record, no picture came in the time of --seconds, or a recording ended
    by itself. To see it in the ground station: vencejo serve --camera SOURCE

    Example: vencejo camera /dev/video0

    Example: vencejo camera rtsp://192.168.1.10/live --snapshot nose.jpg
    """
    from vencejo.camera import Camera

    with Camera(source) as opened:
        opened.watch(True)
        if snapshot is not None:
            take_snapshot(opened, snapshot, seconds or 15.0, json=json)
            return
        watch(opened, record=record, seconds=seconds, json=json)


def take_snapshot(camera: Camera, path: Path, timeout_s: float, *, json: bool) -> None:
    """Write the first picture that comes to a file."""
    from vencejo.camera import still_picture
    from vencejo.storage import write_file

    if camera.latest_jpeg(timeout_s) is None:
        raise Failed(f"no picture came from {camera.source} in {timeout_s:g} s: {why_nothing(camera)}")
    write_file(path, still_picture(camera))
    if json:
        put_json({"file": str(path), "bytes": path.stat().st_size})
    else:
        say(f"Wrote {path}")


def why_nothing(camera: Camera) -> str:
    """Why no pictures come."""
    return camera.status.reason or "no reason known"


def watch(camera: Camera, *, record: bool, seconds: float | None, json: bool) -> None:
    """Tell how the camera is until the time is up or Ctrl-C, and then what was recorded.

    Raises
    ------
    Failed
        When nothing came in that time, nothing was recorded, or a recording ended by itself.
    """
    with contextlib.suppress(KeyboardInterrupt):
        tell(camera, record=record, seconds=seconds, json=json)
    recording = camera.stop_recording()
    if recording is not None:
        say(f"Recorded {recording.duration_s:.1f} s, {recording.bytes / 1e6:.1f} MB: {recording.path}")
        if recording.problem is not None:
            raise Failed(recording.problem)
    elif record:
        raise Failed(f"nothing was recorded: {why_nothing(camera)}")
    elif seconds is not None and camera.status.frames == 0:
        raise Failed(f"no picture came from {camera.source} in {seconds:g} s: {why_nothing(camera)}")


def tell(camera: Camera, *, record: bool, seconds: float | None, json: bool) -> None:
    """Tell how the camera is: when that changes, and now and then. Begins to record with the first pictures."""
    # Opening a source takes its time; what was asked for is counted from there on.
    end_s = None if seconds is None else time.monotonic() + seconds + OPENING_S
    is_opening = True
    told: tuple[object, ...] | None = None
    told_s = 0.0
    pause = threading.Event()
    has_begun = False
    while end_s is None or time.monotonic() < end_s:
        status = camera.status
        if record and not has_begun and status.state.value == "live":
            has_begun = True
            say(f"Recording to {camera.start_recording().path}")
        if seconds is not None and is_opening and status.state.value != "starting":
            is_opening, end_s = False, time.monotonic() + seconds
        news = (status.state, status.reason, status.codec, status.width, status.height)
        if news != told or time.monotonic() - told_s >= TELL_INTERVAL_S:
            told, told_s = news, time.monotonic()
            # A recording goes on when its status is no longer read.
            with contextlib.suppress(*UNREAD) if record else contextlib.nullcontext():
                if json:
                    put_json(as_dict(status))
                else:
                    print(describe(status), flush=True)
        pause.wait(LOOK_INTERVAL_S)


def describe(status: CameraStatus) -> str:
    """One line about a camera."""
    words = [status.state.value]
    if status.width is not None and status.state.value in {"live", "stalled"}:
        words.append(f"{status.width} × {status.height}")
        words.append({"h264": "H.264", "jpeg": "JPEG", None: "not encoded"}[status.codec])
    if status.rate_hz is not None:
        words.append(f"{status.rate_hz:.1f} pictures/s")
    if status.bitrate_bit_s is not None:
        words.append(f"{status.bitrate_bit_s / 1e6:.2f} Mbit/s")
    if status.reason is not None:
        words.append(status.reason)
    return ", ".join(words)


def as_dict(status: CameraStatus) -> dict[str, object]:
    """The same for programs."""
    return {
        "state": status.state.value,
        "reason": status.reason,
        "codec": status.codec,
        "width": status.width,
        "height": status.height,
        "rate_hz": status.rate_hz,
        "bitrate_bit_s": status.bitrate_bit_s,
        "captured_unix_s": status.captured_unix_s,
        "frames": status.frames,
    }


@contextlib.contextmanager
def served_cameras(server: Server, sources: list[str] | None, floors: Floors | None = None) -> Iterator[list[Camera]]:
    """The cameras of ``--camera`` in a server's pages, until the end."""
    if not sources:
        yield []
        return
    from vencejo.camera import Camera, RecorderLimits, ServedCamera, named_source

    limits = None if floors is None else RecorderLimits(free_floor_bytes=floors.video_mb * 1_000_000)

    with contextlib.ExitStack() as stack:
        cameras: list[Camera] = []
        for text in sources:
            name, source = named_source(text, frozenset(camera.name for camera in cameras))
            camera = stack.enter_context(Camera(source, name=name, recording_limits=limits))
            stack.enter_context(ServedCamera(server, camera))
            cameras.append(camera)
        yield cameras


def for_ice(cameras: list[Camera]) -> dict[str, Any]:
    """What the JdeRobot interfaces need to give the cameras' pictures."""
    if not cameras:
        return {}
    from vencejo.camera import FrameSource, encode_rgb

    return {"cameras": [FrameSource(camera) for camera in cameras], "jpeg": encode_rgb}

"""Cameras: pictures from devices, streams, files and the simulated plane, for programs, the ground station and recordings.

Needs the extra ``vencejo[camera]`` for everything but MJPEG over HTTP.

Examples
--------
>>> from vencejo.camera import Camera
>>> with Camera("http://127.0.0.1:1/") as camera:  # nobody is there: it is tried again for ever
...     camera.latest(timeout_s=0.0) is None
True
"""

from __future__ import annotations

from vencejo.camera.address import named_source, parse_source
from vencejo.camera.camera import Camera, CameraState, CameraStatus
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame, Frame
from vencejo.camera.jpeg import encode_rgb
from vencejo.camera.recorder import RecorderLimits, Recording, default_video_dir
from vencejo.camera.rendition import FrameSource
from vencejo.camera.serving import ServedCamera, still_picture

__all__ = [
    "Camera",
    "CameraError",
    "CameraState",
    "CameraStatus",
    "EncodedFrame",
    "Frame",
    "FrameSource",
    "RecorderLimits",
    "Recording",
    "ServedCamera",
    "default_video_dir",
    "encode_rgb",
    "named_source",
    "parse_source",
    "still_picture",
]

"""E6 over Ice: the simulated plane's nose camera, through the driver, to a client of camera.ice."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.jderobot.support import Client, client_of, driver
from tests.support import wait_for

pytestmark = pytest.mark.e2e


@contextlib.contextmanager
def plane_with_camera() -> Iterator[tuple[subprocess.Popen[str], str, str]]:
    """A simulated plane's process, its link and its camera's address."""
    command = [sys.executable, "-m", "vencejo.sim", "--link", "tcp:127.0.0.1:0", "--camera", "127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        said: dict[str, Any] = {}
        try:
            while not {"listening", "camera"} <= said.keys():
                line = process.stdout.readline()
                assert line, "the simulator did not start"
                said.update(json.loads(line))
            yield process, said["listening"], said["camera"]
        finally:
            process.kill()


def picture(client: Client, format_: str = "RGB8") -> Any:
    """A picture, when there is one: a machine with much else to do may not draw one in time."""
    found: list[Any] = []

    def look() -> bool:
        with contextlib.suppress(client.jderobot.DataNotExistException, client.jderobot.HardwareFailedException):
            found.append(client.camera.getImageData(format_))
        return bool(found)

    wait_for(look, f"a picture in {format_}")
    return found[0]


def test_e6_the_nose_camera_is_seen_through_ice_until_it_dies(tmp_path: Path) -> None:
    with (
        plane_with_camera() as (process, link, stream),
        driver(link, "--camera", f"nose={stream}", data=tmp_path) as served,
        client_of(served.said["ice"], Ice_MessageSizeMax="4096") as client,
    ):
        data = picture(client)
        rows, columns = data.description.height, data.description.width
        assert columns <= 640
        rgb = np.frombuffer(bytes(data.pixelData), np.uint8).reshape(rows, columns, 3).astype(float)
        # It stands and looks ahead: sky above, bluer and brighter than the ground below.
        above, below = rgb[: rows // 4].mean(axis=(0, 1)), rgb[-rows // 4 :].mean(axis=(0, 1))
        assert above[2] - above[0] > below[2] - below[0]
        taken = data.timeStamp.seconds + data.timeStamp.useconds / 1e6
        assert abs(time.time() - taken) < 30.0
        assert bytes(picture(client, "JPEG").pixelData).startswith(b"\xff\xd8")
        assert client.camera.getCameraDescription().name == "nose"
        process.kill()
        shown = [client.camera.getImageData("RGB8")]

        def is_marked() -> bool:
            shown.append(client.camera.getImageData("RGB8"))
            before, now = shown[-2:]
            return bool(before.timeStamp == now.timeStamp and before.pixelData != now.pixelData)

        # Its last picture goes on being given, to viewers whom an exception would end, with its age written into it.
        wait_for(is_marked, "the last picture of a dead camera, marked with its age")

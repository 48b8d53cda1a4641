"""A real map server for tests: MapServer's CGI program under a small HTTP server, with a picture of ground whose points are known.

The picture is a GeoTIFF in UTM zone 30 (EPSG:32630), 4 km wide at 4 m in a pixel around 40.333° N 3.798° W: grey, with discs of colour. Where
their middles are was computed by PROJ 9.5.1 (pyproj 3.7.2), which shares no code with the ground station; MapServer warps with PROJ too.
"""

from __future__ import annotations

import contextlib
import http.server
import os
import shutil
import struct
import subprocess
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

LAYER = "ground"
ATTRIBUTION = "Vencejo's test ground"
BACKGROUND = (128, 128, 128)
SIZE_PX = 1000
RESOLUTION_M = 4.0
TOP_LEFT_M = (430_232.0, 4_467_046.0)
"""Easting and northing of the picture's top left corner."""
DISC_PX = 5
"""Radius of a disc, in pixels of the picture."""

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class GroundPoint:
    """The middle of a disc: its pixel in the picture, and where that is on the ground."""

    name: str
    colour: Colour
    column: int
    row: int
    lat_deg: float
    lon_deg: float


POINTS = (
    GroundPoint("red", (230, 0, 0), 150, 130, 40.34640323, -3.81441448),
    GroundPoint("green", (0, 200, 0), 845, 155, 40.34572823, -3.78167313),
    GroundPoint("blue", (0, 0, 230), 505, 500, 40.33318732, -3.79753882),
    GroundPoint("magenta", (230, 0, 230), 165, 860, 40.32010375, -3.81339215),
    GroundPoint("cyan", (0, 210, 230), 825, 820, 40.32175941, -3.78233823),
)

PROGRAMS = ("/usr/lib/cgi-bin/mapserv", "mapserv")


def program() -> str:
    """Where MapServer's program is."""
    for name in PROGRAMS:
        if found := shutil.which(name):
            return found
    raise RuntimeError("no MapServer: sudo apt-get install -y cgi-mapserver")


def ground() -> NDArray[np.uint8]:
    """The picture: rows from the top, red, green, blue."""
    picture = np.full((SIZE_PX, SIZE_PX, 3), BACKGROUND, np.uint8)
    rows, columns = np.ogrid[:SIZE_PX, :SIZE_PX]
    for point in POINTS:
        picture[(rows - point.row) ** 2 + (columns - point.column) ** 2 <= DISC_PX**2] = point.colour
    return picture


def write_geotiff(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a GeoTIFF (OGC 19-008) in UTM zone 30 north, one strip to a row, as it is: so that any part is read quickly."""
    height, width, _ = picture.shape
    pixels = picture.tobytes()
    row = width * 3
    lengths = struct.pack(f"<{height}I", *[row] * height)
    scale = struct.pack("<3d", RESOLUTION_M, RESOLUTION_M, 0.0)
    tie = struct.pack("<6d", 0.0, 0.0, 0.0, *TOP_LEFT_M, 0.0)
    # projected model; pixels are areas; EPSG:32630
    keys = struct.pack("<16H", 1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32630)
    bits = struct.pack("<3H", 8, 8, 8)
    short, long, double = 3, 4, 12
    #      tag, type, count, value or bytes that stand elsewhere
    tags: list[tuple[int, int, int, int | bytes]] = [
        (256, long, 1, width),
        (257, long, 1, height),
        (258, short, 3, bits),
        (259, short, 1, 1),  # as it is
        (262, short, 1, 2),  # RGB
        (273, long, height, b""),  # where the rows stand: known when all else stands
        (277, short, 1, 3),
        (278, long, 1, 1),
        (279, long, height, lengths),
        (284, short, 1, 1),
        (33550, double, 3, scale),
        (33922, double, 6, tie),
        (34735, short, 16, keys),
    ]
    begin = 8 + 2 + 12 * len(tags) + 4
    first = begin + 4 * height + sum(len(value) for *_, value in tags if isinstance(value, bytes))
    offsets = struct.pack(f"<{height}I", *(first + row * index for index in range(height)))
    entries, elsewhere = b"", b""
    for tag, kind, count, value in tags:
        if isinstance(value, bytes):
            entries += struct.pack("<HHII", tag, kind, count, begin + len(elsewhere))
            elsewhere += value or offsets
        elif kind == short:
            entries += struct.pack("<HHIHH", tag, kind, count, value, 0)
        else:
            entries += struct.pack("<HHII", tag, kind, count, value)
    header = struct.pack("<2sHIH", b"II", 42, 8, len(tags))
    path.write_bytes(header + entries + struct.pack("<I", 0) + elsewhere + pixels)


_MAP = """
MAP
  NAME "ground"
  SIZE 256 256
  MAXSIZE 4096
  EXTENT {west} {south} {east} {north}
  IMAGECOLOR 255 255 255
  PROJECTION
    "init=epsg:32630"
  END
  OUTPUTFORMAT
    NAME "png"
    DRIVER AGG/PNG
    MIMETYPE "image/png"
    IMAGEMODE RGBA
  END
  WEB
    METADATA
      "wms_title" "Test ground"
      "wms_onlineresource" "{url}"
      "wms_srs" "EPSG:3857 EPSG:4326 EPSG:32630 EPSG:25830"
      "wms_enable_request" "*"
      "wms_attribution_title" "{attribution}"
    END
  END
  LAYER
    NAME "{layer}"
    TYPE RASTER
    STATUS ON
    DATA "{picture}"
    PROCESSING "RESAMPLE=BILINEAR"
    PROJECTION
      "init=epsg:32630"
    END
    METADATA
      "wms_title" "Ground with discs"
      "wms_attribution_title" "{attribution}"
    END
  END
END
"""


@dataclass
class MapServer:
    """A map server that runs."""

    url: str
    """Address of its WMS."""
    requests: list[str] = field(default_factory=list)
    """Queries that came, oldest first."""
    refuses: bool = False
    """Whether it answers every GetMap with a service exception, as with a layer that is not there, and status 200."""
    answers: threading.Event = field(default_factory=threading.Event)
    """While it is cleared no GetMap is answered: who asked waits."""


@contextlib.contextmanager
def map_server(folder: Path) -> Iterator[MapServer]:
    """MapServer on a free port of this machine, its files in a folder; needs Debian's ``cgi-mapserver``."""
    mapserv = program()
    picture, map_file, configuration = folder / "ground.tif", folder / "ground.map", folder / "mapserver.conf"
    write_geotiff(picture, ground())
    configuration.write_text('CONFIG\n  ENV\n    MS_MAP_PATTERN "."\n  END\nEND\n')
    served: MapServer

    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            _, _, query = self.path.partition("?")
            served.requests.append(query)
            if served.refuses and "getmap" in query.lower():
                query = query.replace(f"={LAYER}", "=nowhere")
            environment = {
                **os.environ,
                "REQUEST_METHOD": "GET",
                "QUERY_STRING": query,
                "MS_MAPFILE": str(map_file),
                "MAPSERVER_CONFIG_FILE": str(configuration),
            }
            if "getmap" in query.lower():
                served.answers.wait()
            answer = subprocess.run([mapserv], env=environment, capture_output=True, check=False).stdout
            head, _, body = answer.partition(b"\r\n\r\n")
            # who asked may have gone while nothing was answered
            with contextlib.suppress(ConnectionError):
                self.send_response(200)
                for line in head.decode().splitlines():
                    name, _, value = line.partition(": ")
                    if name.lower() == "content-type":
                        self.send_header(name, value)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    served = MapServer(f"http://127.0.0.1:{server.server_port}/wms")
    served.answers.set()
    side_m = SIZE_PX * RESOLUTION_M
    map_file.write_text(
        _MAP.format(
            west=TOP_LEFT_M[0],
            south=TOP_LEFT_M[1] - side_m,
            east=TOP_LEFT_M[0] + side_m,
            north=TOP_LEFT_M[1],
            url=served.url,
            attribution=ATTRIBUTION,
            layer=LAYER,
            picture=picture,
        )
    )
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield served
    finally:
        served.answers.set()
        server.shutdown()
        server.server_close()
        thread.join()

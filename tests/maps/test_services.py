"""The maps of `vencejo serve` against a real map server: known ground points at the right pixels, in every system and version."""

from __future__ import annotations

import concurrent.futures
import http.server
import math
import shutil
import sqlite3
import ssl
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.maps.mapserver import (
    ATTRIBUTION,
    LAYER,
    POINTS,
    RESOLUTION_M,
    TOP_LEFT_M,
    GroundPoint,
    MapServer,
    ground,
    map_server,
    write_geotiff,
)
from tests.server.client import Client, Served, serving
from tests.support import wait_for

SEMI_MAJOR_M = 6_378_137.0
PIXEL_M = 8.0
"""Metres in a pixel of the level that is looked at, about."""


@pytest.fixture(name="mapserver", scope="module")
def _mapserver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[MapServer]:
    with map_server(tmp_path_factory.mktemp("mapserver")) as server:
        yield server


@pytest.fixture(name="served", scope="module")
def _served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("data")
    (folder / "maps").mkdir()
    (folder / "maps" / "sources.toml").write_text("# mine\n")
    with serving("--token", "--link", "udpin:127.0.0.1:0", data=folder) as served:
        yield served


@pytest.fixture(name="operator", scope="module")
def _operator(served: Served) -> Client:
    return served.client(name="maps", token=served.token("operator"))


def wms(mapserver: MapServer, name: str, version: str, crs: str, **more: Any) -> dict[str, Any]:
    """Settings of a source."""
    return {
        "id": name,
        "name": name,
        "kind": "wms",
        "url": mapserver.url,
        "local_network": True,
        "version": version,
        "crs": crs,
        "layers": [LAYER],
        "format": "image/png",
        "bounds": {"west_deg": -3.83, "south_deg": 40.30, "east_deg": -3.76, "north_deg": 40.36},
        **more,
    }


def projected(crs: str, point: GroundPoint) -> tuple[float, float]:
    """Where a point is in a system, by what is known without the station: its pixel in UTM, the formulas of the others."""
    if crs == "EPSG:4326":
        return point.lon_deg, point.lat_deg
    if crs == "EPSG:3857":
        lat, lon = math.radians(point.lat_deg), math.radians(point.lon_deg)
        return SEMI_MAJOR_M * lon, SEMI_MAJOR_M * math.asinh(math.tan(lat))
    east, north = TOP_LEFT_M
    return east + (point.column + 0.5) * RESOLUTION_M, north - (point.row + 0.5) * RESOLUTION_M


def level_of(grid: dict[str, Any]) -> int:
    """The level whose pixels are about as large as wanted."""
    unit_m = math.pi * SEMI_MAJOR_M / 180 if grid["crs"] == "EPSG:4326" else 1.0
    sizes = [abs(math.log(level["resolution"] * unit_m / PIXEL_M)) for level in grid["levels"]]
    return sizes.index(min(sizes))


def mosaic(
    client: Client, source: dict[str, Any], number: int, box: tuple[float, float, float, float]
) -> tuple[NDArray[np.uint8], float, float]:
    """All tiles of a level that a rectangle needs, put together, with the coordinates of its top left corner."""
    level = source["grid"]["levels"][number]
    step = level["resolution"] * level["tile_px"][0]
    left, top = level["origin"]
    columns = range(int((box[0] - left) // step), int((box[2] - left) // step) + 1)
    rows = range(int((top - box[3]) // step), int((top - box[1]) // step) + 1)

    def tile(place: tuple[int, int]) -> NDArray[np.uint8]:
        column, row = place
        answer = client.ask("GET", source["tiles_url"].format(z=number, x=column, y=row))
        if answer.status == 404:
            return np.zeros((256, 256, 3), np.uint8)
        assert answer.status == 200, answer.body
        picture = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        return np.asarray(picture[:, :, ::-1], np.uint8)

    places = [(column, row) for row in rows for column in columns]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        tiles = list(pool.map(tile, places))
    lines = [np.hstack(tiles[index : index + len(columns)]) for index in range(0, len(tiles), len(columns))]
    return np.vstack(lines), left + columns[0] * step, top - rows[0] * step


def check_points(client: Client, source: dict[str, Any], tolerance_px: float) -> None:
    """Every disc of the test ground must lie where it should."""
    grid = source["grid"]
    number = level_of(grid)
    resolution = grid["levels"][number]["resolution"]
    places = [projected(grid["crs"], point) for point in POINTS]
    margin = 10 * resolution
    box = (
        min(x for x, _ in places) - margin,
        min(y for _, y in places) - margin,
        max(x for x, _ in places) + margin,
        max(y for _, y in places) + margin,
    )
    picture, left, top = mosaic(client, source, number, box)
    for point, (x, y) in zip(POINTS, places, strict=True):
        near = np.all(np.abs(picture.astype(int) - point.colour) < 60, axis=2)
        rows, columns = np.nonzero(near)
        assert len(rows) >= 5, f"{point.name} is not to be seen"
        found = (columns.mean() + 0.5, rows.mean() + 0.5)
        expected = ((x - left) / resolution, (top - y) / resolution)
        off = math.hypot(found[0] - expected[0], found[1] - expected[1])
        assert off <= tolerance_px, f"{source['id']}: {point.name} is {off:.2f} pixels off"


@pytest.mark.parametrize("crs", ["EPSG:3857", "EPSG:4326", "EPSG:32630", "EPSG:25830"])
@pytest.mark.parametrize("version", ["1.1.1", "1.3.0"])
def test_known_points_are_at_their_pixels(operator: Client, mapserver: MapServer, version: str, crs: str) -> None:
    name = f"w{version.replace('.', '')}-{crs[5:]}"
    source = operator.done("PUT", f"maps/sources/{name}", wms(mapserver, name, version, crs))
    assert source["grid"]["crs"] == crs
    assert (source["grid"]["proj4"] is None) == (crs in {"EPSG:3857", "EPSG:4326"})
    check_points(operator, source, 1.0)


def test_a_geotiff_shows_the_same_points(operator: Client, tmp_path: Path) -> None:
    path = tmp_path / "ground.tif"
    write_geotiff(path, ground())
    taken = operator.done("POST", "maps/files?name=ground.tif", path.read_bytes())
    assert (taken["settings"]["kind"], taken["settings"]["role"]) == ("geotiff", "overlay")
    source = operator.done("PUT", f"maps/sources/{taken['settings']['id']}", taken["settings"])
    assert source["grid"]["crs"] == "EPSG:32630"
    check_points(operator, source, 1.0)
    assert {"path": "files/ground.tif", "bytes": path.stat().st_size, "kind": "geotiff"} in operator.done(
        "GET", "maps/files"
    )


def test_a_folder_of_tiles_is_found_shown_and_kept_to(operator: Client, mapserver: MapServer) -> None:
    maps = Path(operator.done("GET", "maps/config")["folder"])
    seen = operator.done("PUT", "maps/sources/to-copy", wms(mapserver, "to-copy", "1.3.0", "EPSG:3857"))
    number = level_of(seen["grid"])
    folder = maps / "files" / "field"
    west, east = (int((lon_deg + 180) / 360 * 2**number) for lon_deg in (-3.83, -3.76))
    north, south = (
        int((1 - math.asinh(math.tan(math.radians(lat_deg))) / math.pi) / 2 * 2**number) for lat_deg in (40.36, 40.30)
    )
    for column in range(west, east + 1):
        (folder / str(number) / str(column)).mkdir(parents=True)
        for row in range(north, south + 1):
            answer = operator.ask("GET", seen["tiles_url"].format(z=number, x=column, y=row))
            # As gdal2tiles has them: rows from the south.
            (folder / str(number) / str(column) / f"{2**number - 1 - row}.png").write_bytes(answer.body)
    (found,) = [file for file in operator.done("GET", "maps/files") if file["path"] == "files/field"]
    assert (found["kind"], found["bytes"] > 0) == ("folder", True)
    settings = {"id": "field", "name": "Field", "kind": "folder", "path": "files/field", "tms": True}
    source = operator.done("PUT", "maps/sources/field", settings)
    assert (source["grid"]["min_level"], source["grid"]["max_level"]) == (number, number)
    assert source["bounds"]["west_deg"] == pytest.approx(-3.83, abs=360 / 2**number)
    assert (source["offline"]["allowed"], source["may_cache"]) == (False, False)
    check_points(operator, source, 1.0)
    outside = folder / str(number) / str(west) / f"{2**number - 1 - north}.png"
    outside.unlink()
    outside.symlink_to(maps / "sources.toml")
    again = operator.done("PUT", "maps/sources/again", {**settings, "id": "again"})
    refused = operator.ask("GET", again["tiles_url"].format(z=number, x=west, y=north))
    assert (refused.status, "out of the folder" in refused.json["detail"]) == (409, True), refused.json


def test_a_picture_with_corners_shows_the_same_points(operator: Client) -> None:
    encoded, png = cv2.imencode(".png", ground()[:, :, ::-1])
    assert encoded
    taken = operator.done("POST", "maps/files?name=ground.png", png.tobytes())
    settings = taken["settings"]
    # The corners of the picture, by GDAL's gdaltransform.
    settings["corners"] = [
        {"lat_deg": 40.35105545, "lon_deg": -3.82155927},
        {"lat_deg": 40.35138042, "lon_deg": -3.77446111},
        {"lat_deg": 40.31534659, "lon_deg": -3.77404926},
        {"lat_deg": 40.31502203, "lon_deg": -3.82112237},
    ]
    source = operator.done("PUT", f"maps/sources/{settings['id']}", settings)
    assert source["grid"]["crs"] == "EPSG:3857"
    check_points(operator, source, 1.0)
    picture = operator.ask("GET", f"maps/sources/{settings['id']}/image")
    assert (picture.headers["content-type"], picture.body) == ("image/png", png.tobytes())


def test_capabilities_say_what_there_is(operator: Client, mapserver: MapServer) -> None:
    said = operator.done(
        "POST",
        "maps/capabilities",
        {"kind": "wms", "url": f"{mapserver.url}?request=GetMap&layers=x", "local_network": True},
    )
    assert said["version"] == "1.3.0"
    assert "image/png" in said["formats"]
    layer = next(layer for layer in said["layers"] if layer["name"] == LAYER)
    assert {"EPSG:3857", "EPSG:4326", "EPSG:32630", "EPSG:25830"} <= set(layer["crs"])
    assert layer["bounds"]["west_deg"] == pytest.approx(-3.82, abs=0.01)
    assert layer["attribution"]["text"] == ATTRIBUTION


def test_an_exception_with_status_200_is_an_error_in_the_services_words(operator: Client, mapserver: MapServer) -> None:
    settings = wms(mapserver, "wrong", "1.3.0", "EPSG:3857", layers=["nowhere"])
    source = operator.done("PUT", "maps/sources/wrong", settings)
    state = operator.done("POST", "maps/sources/wrong/check")
    assert state["status"] == "failing"
    assert "Invalid layer(s) given in the LAYERS parameter" in state["detail"]
    number = level_of(source["grid"])
    level = source["grid"]["levels"][number]
    x, y = projected("EPSG:3857", POINTS[2])
    step = level["resolution"] * 256
    place = (int((x - level["origin"][0]) // step), int((level["origin"][1] - y) // step))
    answer = operator.ask("GET", f"tiles/wrong/{number}/{place[0]}/{place[1]}")
    assert (answer.status, answer.json["type"]) == (502, "urn:vencejo:source-failed")
    assert "LayerNotDefined" in answer.json["detail"]


@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes a certificate with openssl")
def test_a_service_whose_certificate_nobody_vouches_for_is_told(operator: Client, tmp_path: Path) -> None:
    certificate, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    make = "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 1 -subj /CN=localhost"
    make += f" -addext subjectAltName=IP:127.0.0.1 -keyout {key} -out {certificate}"
    subprocess.run(make.split(), check=True, capture_output=True)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate, key)

    class Quiet(http.server.ThreadingHTTPServer):
        def handle_error(self, request: object, client_address: object) -> None:
            """The other side hangs up, as it should."""

    server = Quiet(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler)
    server.socket = context.wrap_socket(server.socket, server_side=True)
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
    try:
        url = f"https://127.0.0.1:{server.server_port}/{{z}}/{{x}}/{{y}}"
        operator.done(
            "PUT", "maps/sources/tls", {"id": "tls", "name": "tls", "kind": "xyz", "url": url, "local_network": True}
        )
        state = operator.done("POST", "maps/sources/tls/check")
    finally:
        server.shutdown()
        server.server_close()
    assert state["status"] == "offline"
    assert "certificate" in state["detail"]


def test_what_was_seen_is_shown_from_the_cache(operator: Client, mapserver: MapServer) -> None:
    source = operator.done("PUT", "maps/sources/kept", wms(mapserver, "kept", "1.3.0", "EPSG:4326"))
    number = level_of(source["grid"])
    level = source["grid"]["levels"][number]
    x, y = projected("EPSG:4326", POINTS[2])
    step = level["resolution"] * 256
    path = f"tiles/kept/{number}/{int((x + 180) // step)}/{int((90 - y) // step)}"
    first = operator.ask("GET", path)
    asked = len(mapserver.requests)
    again = operator.ask("GET", path)
    assert (first.headers["vencejo-tile"], again.headers["vencejo-tile"]) == ("fetched", "hit")
    assert first.body == again.body
    assert len(mapserver.requests) == asked
    assert again.headers["cache-control"].startswith("private, max-age=")
    unchanged = operator.ask("GET", path, If_None_Match=again.headers["etag"])
    assert (unchanged.status, unchanged.body) == (304, b"")
    cache = operator.done("GET", "maps/sources")["sources"]
    cache = next(source for source in cache if source["id"] == "kept")["state"]["cache"]
    assert cache["tiles"] >= 1


def test_an_offline_area_of_a_wms_in_degrees_goes_out_and_in_again(
    operator: Client, mapserver: MapServer, tmp_path: Path
) -> None:
    operator.done("PUT", "maps/sources/area", wms(mapserver, "area", "1.3.0", "EPSG:4326"))
    plan = {
        "items": [
            {"command": 16, "frame": 3, "params": [None, None, None, None, point.lat_deg, point.lon_deg, 60.0]}
            for point in POINTS[:2]
        ],
        "home": {"lat_deg": POINTS[2].lat_deg, "lon_deg": POINTS[2].lon_deg, "alt_amsl_m": 600.0},
    }
    wanted = {
        "source": "area",
        "name": "Campo de vuelo",
        "shape": {"kind": "plan", "plan": plan, "buffer_m": 200.0},
        "min_level": 11,
        "max_level": 14,
    }
    estimate = operator.done("POST", "maps/areas/estimate", wanted)
    assert estimate["tiles"] == sum(level["tiles"] for level in estimate["levels"]) > 4
    area = operator.done("POST", "maps/areas", wanted)
    wait_for(lambda: operator.done("GET", f"maps/areas/{area['id']}")["state"] == "done", "the area")
    done = operator.done("GET", f"maps/areas/{area['id']}")
    assert (done["done"], done["failed"]) == (estimate["tiles"], 0)
    assert done["shape"]["kind"] == "route"
    exported = operator.ask("GET", f"maps/areas/{area['id']}/export")
    assert exported.headers["content-disposition"] == 'attachment; filename="Campo_de_vuelo.mbtiles"'
    path = tmp_path / "area.mbtiles"
    path.write_bytes(exported.body)
    with sqlite3.connect(path) as file:
        (count,) = file.execute("SELECT COUNT(*) FROM tiles").fetchone()
        notes = dict(file.execute("SELECT name, value FROM metadata"))
    file.close()
    assert (count, notes["name"], notes["format"]) == (estimate["tiles"], "Campo de vuelo", "png")
    operator.done("DELETE", f"maps/areas/{area['id']}")
    operator.done("DELETE", "maps/sources/area/cache")
    taken = operator.done("POST", "maps/areas/import?source=area&name=otra", exported.body)
    assert (taken["state"], taken["name"], taken["done"]) == ("done", "otra", count)
    refused = operator.ask("POST", "maps/areas/import?source=kept2&name=x", exported.body)
    assert refused.status == 404
    assert operator.done("POST", "maps/areas/estimate", wanted)["have"] == estimate["tiles"]


def test_heights_come_from_files(operator: Client) -> None:
    side = 1201
    heights = (np.arange(side)[:, None] + 2 * np.arange(side)[None, :]).astype(">i2")
    heights[600, 600] = -32768
    taken = operator.done("POST", "maps/files?name=N40W004.hgt", heights.tobytes())
    assert (taken["settings"]["kind"], taken["settings"]["role"]) == ("dem", "elevation")
    operator.done("PUT", f"maps/sources/{taken['settings']['id']}", taken["settings"])
    step = 1 / 1200
    point = operator.done("GET", f"elevation?lat_deg={41 - 10.5 * step}&lon_deg={-4 + 20.25 * step}")
    assert point["alt_amsl_m"] == pytest.approx(10.5 + 40.5, abs=1e-6)
    assert (point["source"], point["datum"]) == ("heights", "EGM96")
    assert point["resolution_m"] == pytest.approx(92.8, abs=0.1)
    places = [
        {"lat_deg": 40.5, "lon_deg": -3.5},
        {"lat_deg": 10.0, "lon_deg": 10.0},
        {"lat_deg": 40.25, "lon_deg": -3.5},
    ]
    found = operator.done("POST", "elevation", {"points": places})["points"]
    assert [point["alt_amsl_m"] for point in found] == [None, None, pytest.approx(900 + 1200, abs=1e-6)]
    line = [{"lat_deg": 40.25, "lon_deg": -3.5}, {"lat_deg": 40.25, "lon_deg": -3.4}]
    profile = operator.done("POST", "elevation/profile", {"points": line, "spacing_m": 100})
    assert profile["length_m"] == pytest.approx(8510, abs=5)
    assert profile["unknown"] == 0
    assert profile["max_alt_amsl_m"] == pytest.approx(900 + 1440, abs=1e-3)
    # A geodesic bulges away from the parallel by some metres.
    assert all(2095 < sample["alt_amsl_m"] < 2341 for sample in profile["samples"])


def test_who_looks_sees_maps_and_changes_nothing(served: Served, operator: Client, mapserver: MapServer) -> None:
    operator.done("PUT", "maps/sources/seen", {**wms(mapserver, "seen", "1.3.0", "EPSG:3857"), "key": "s3cret"})
    viewer = served.client(name="looks", token=served.token("viewer"))
    listed = viewer.done("GET", "maps/sources")
    assert listed["file"] == ""
    assert b"s3cret" not in viewer.ask("GET", "maps/sources").body
    assert b"s3cret" not in operator.ask("GET", "maps/config").body
    settings = wms(mapserver, "mine", "1.3.0", "EPSG:3857")
    for method, path, body in [
        ("GET", "maps/config", None),
        ("PUT", "maps/sources/mine", settings),
        ("DELETE", "maps/sources/seen", None),
        ("DELETE", "maps/sources/seen/cache", None),
        ("POST", "maps/sources/seen/check", None),
        ("PUT", "maps/order", {"ids": ["seen"]}),
        ("POST", "maps/capabilities", {"kind": "wms", "url": mapserver.url}),
        ("POST", "maps/files?name=a.mbtiles", b"x"),
        ("GET", "maps/files", None),
        ("POST", "maps/areas/import?source=seen&name=x", b"x"),
    ]:
        answer = viewer.ask(method, path, body)
        assert (answer.status, answer.json["type"]) == (403, "urn:vencejo:role"), (method, path)
    nobody = Client(served.url)
    for path in ("maps/sources", "tiles/seen/0/0/0", "elevation?lat_deg=40&lon_deg=-3"):
        assert nobody.ask("GET", path).status == 401


def test_settings_that_are_wrong_name_their_fields(operator: Client, mapserver: MapServer) -> None:
    settings = {**wms(mapserver, "bad", "1.4.0", "EPSG:2154"), "opacity": 2}
    answer = operator.ask("PUT", "maps/sources/bad", settings)
    assert (answer.status, answer.json["type"]) == (422, "urn:vencejo:source-settings")
    assert {reason.partition(":")[0] for reason in answer.json["reasons"]} == {"opacity", "version", "crs"}
    assert operator.ask("PUT", "maps/sources/other", settings).status == 422
    for kind in ("mbtiles", "folder"):
        outside = {"id": "out", "name": "out", "kind": kind, "path": "/etc"}
        answer = operator.ask("PUT", "maps/sources/out", outside)
        assert answer.status == 422
        assert "maps folder" in answer.json["detail"]
    assert operator.ask("POST", "maps/files?name=../x.mbtiles", b"x").status == 422
    broken = operator.ask("POST", "maps/files?name=x.mbtiles", b"no tiles")
    assert (broken.status, broken.json["type"]) == (422, "urn:vencejo:map-file")
    assert operator.ask("GET", "tiles/nowhere/0/0/0").json["type"] == "urn:vencejo:no-source"

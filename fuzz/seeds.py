"""Generates the seed corpora from the test fixtures: `.venv/bin/python fuzz/seeds.py`."""

from __future__ import annotations

import sqlite3
import struct
from contextlib import closing
from pathlib import Path

FUZZ = Path(__file__).resolve().parent
FIXTURES = FUZZ.parent / "tests" / "fixtures"
CAPTURES = FIXTURES / "captures"
MAX_BYTES = 4096


def put(target: str, name: str, data: bytes) -> None:
    """Write one seed into the corpus of a target."""
    folder = FUZZ / "corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data[:MAX_BYTES])


def frames(path: Path) -> list[bytes]:
    """Return the frames of a recording, one of each message."""
    data, at, found = path.read_bytes(), 8, {}
    while at + 12 < len(data):
        length, flags, identity = data[at + 1], data[at + 2], data[at + 7 : at + 10]
        size = 12 + length + (13 if flags & 1 else 0)
        found.setdefault(identity, data[at : at + size])
        at += size + 8
    return list(found.values())


def main() -> None:
    """Generate all seeds from the recordings and files of the tests."""
    for path in sorted(CAPTURES.glob("*.tlog")):
        heard = frames(path)
        name = path.stem
        put("frame", name, b"\x40" + b"".join(heard))
        put("tlog", name, b"\x40" + path.read_bytes()[: MAX_BYTES - 1])
        says = b"\x01\x00\x00\x19"
        for frame in heard:
            identity = int.from_bytes(frame[7:10], "little")
            ids = (0, 1, 22, 24, 30, 33, 39, 40, 42, 43, 44, 45, 46, 47, 51, 66, 73, 74, 76, 77, 110, 148, 242, 253)
            if identity in ids:
                payload = frame[10 : 10 + frame[1]]
                says += bytes((2, ids.index(identity), len(payload))) + payload
        put("mission", name, says)
    for frame in frames(CAPTURES / "arduplane-takeoff-to-landing.tlog"):
        identity = int.from_bytes(frame[7:9], "little")
        put("message", f"{identity}", struct.pack("<H", identity) + frame[10 : 10 + frame[1]])
        if identity == 110:
            put("ftp", "answer", frame[13:])
    put("params", "param.pck", (CAPTURES / "param.pck").read_bytes())
    put("params", "arduplane.parm", (CAPTURES / "arduplane-params.parm").read_bytes())
    put("ftp", "mission.dat", (CAPTURES / "mission.dat").read_bytes())
    for path in sorted((FIXTURES / "maps").glob("*.tif")):
        put("rasters", path.stem, path.read_bytes())
    plan = b"""{"fileType":"Plan","version":1,"groundStation":"QGroundControl","mission":{"version":2,"items":[{"type":"SimpleItem",
"autoContinue":true,"command":16,"doJumpId":1,"frame":3,"params":[0,0,0,null,40.3,-3.7,100]}],"plannedHomePosition":[40.3,-3.7,600],
"cruiseSpeed":15,"hoverSpeed":5,"firmwareType":3,"vehicleType":1},"geoFence":{"version":2,"circles":[],"polygons":[]},
"rallyPoints":{"version":2,"points":[[40.3,-3.7,50]]}}"""
    put("plan_files", "one.plan", plan)
    put(
        "plan_files",
        "one.waypoints",
        b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t40.3\t-3.7\t600\t1\n1\t0\t3\t16\t0\t0\t0\t0\t40.4\t-3.7\t100\t1\n",
    )
    put(
        "plan_files",
        "fence.waypoints",
        b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t40\t-3\t600\t1\n"
        + b"".join(b"%d\t0\t3\t5001\t3\t0\t0\t0\t40.%d\t-3.%d\t0\t1\n" % (i, i, i * i) for i in (1, 2, 3)),
    )
    put("plan_files", "rally.waypoints", b"QGC WPL 110\n0\t0\t3\t5100\t0\t0\t0\t0\t40.3\t-3.7\t100\t0\n")
    put("plan_files", "fence.fen", b"#saved\n40.05 -3.05\n40 -3\n40.1 -3\n40.1 -3.1\n40 -3\n")
    put("plan_files", "rally.ral", b"RALLY\t40.2\t-3.2\t60\t40\t0\t4\n")
    put(
        "plan_files",
        "one.mission",
        b'{"MAV_AUTOPILOT":3,"complexItems":[],"version":"1.0","items":[{"autoContinue":true,"command":177,"coordinate":[0,0,0],'
        b'"frame":2,"id":1,"param1":1,"param2":2,"param3":0,"param4":0,"type":"missionItem"}],'
        b'"plannedHomePosition":{"coordinate":[40,-3,600]}}',
    )
    put(
        "plan_files",
        "path.kml",
        b"<kml><Document><Placemark><name>a</name><LineString><altitudeMode>absolute</altitudeMode><coordinates>-3.8,40.3,700 -3.9,40.3,710"
        b"</coordinates></LineString></Placemark><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 1,0 1,1 0,0</coordinates>"
        b"</LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>",
    )
    put(
        "plan_files",
        "route.gpx",
        b'<gpx><rte><rtept lat="40.3" lon="-3.8"><ele>700</ele></rtept></rte><wpt lat="1" lon="2"/></gpx>',
    )
    put(
        "plan_files",
        "item.geojson",
        b'{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"vencejo":"item","item":1,"command":16,"frame":3,'
        b'"autocontinue":true,"alt_m":80},"geometry":{"type":"Point","coordinates":[-3.8,40.3]}}]}',
    )
    put("plan_files", "table.csv", b"Lat;Lon;Alt;command\n40,3;-3,8;60;16\n")
    put("websocket", "subscribe", b'{"type":"subscribe","vehicle":1,"rate_hz":10}')
    put("bodies", "goto", b'{"lat_deg":40.3,"lon_deg":-3.7,"alt_m":100,"alt_frame":"home"}')
    put("bodies", "plan", b'{"items":[{"command":16,"frame":3,"params":[0,0,0,0,40.0,-3.0,100]}],"home":null}')
    put(
        "map_services",
        "wms",
        b'<WMS_Capabilities version="1.3.0"><Service><Title>t</Title></Service><Capability><Layer><Name>a</Name><CRS>EPSG:3857</CRS></Layer></Capability></WMS_Capabilities>',
    )
    put(
        "map_services",
        "wmts",
        b'<Capabilities xmlns:ows="http://www.opengis.net/ows/1.1"><Contents><Layer><ows:Identifier>a</ows:Identifier><TileMatrixSetLink><TileMatrixSet>g</TileMatrixSet></TileMatrixSetLink></Layer></Contents></Capabilities>',
    )
    put("tile_archives", "pmtiles", b"PMTiles\x03" + bytes(119))
    path = FUZZ / "corpus/tile_archives/mbtiles"
    path.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as tiles:
        tiles.executescript(
            "PRAGMA page_size=512; CREATE TABLE metadata(name,value); CREATE TABLE tiles(zoom_level,tile_column,tile_row,tile_data);"
            "INSERT INTO metadata VALUES('name','Field'),('bounds','-4,40,-3,41'); INSERT INTO tiles VALUES(0,0,0,X'89504e470d0a1a0a');"
        )


if __name__ == "__main__":
    main()

"""The package's geodesy against that of others, and what it refuses."""

from __future__ import annotations

import csv
import itertools
import math
from pathlib import Path

import pytest
from vencejo import GeoPoint, InvalidRequest
from vencejo.geodesy import UtmPosition, bearing_deg, destination, distance_m, line, points_along, utm

FIXTURES = Path(__file__).resolve().parent.parent / "fixtures" / "geodesy"


def rows(name: str) -> list[list[float]]:
    """The numbers of a fixture's rows."""
    with (FIXTURES / f"{name}.csv").open(encoding="ascii") as file:
        return [[float(value) for value in row if value[-1:].isdigit()] for row in list(csv.reader(file))[1:]]


def test_geographiclib_measures_the_same() -> None:
    checked = 0
    for lat1, lon1, lat2, lon2, _, _, length, *_ in rows("geodesics"):
        start, end = GeoPoint(lat1, lon1), GeoPoint(lat2, lon2)
        found = line(start, end)
        assert abs(found.distance_m - length) < 1e-6
        assert distance_m(start, end) == found.distance_m
        assert bearing_deg(start, end) == found.bearing_start_deg
        there = destination(start, bearing_deg=found.bearing_start_deg, distance_m=length)
        assert distance_m(there, end) < 1e-6
        checked += 1
    assert checked >= 500


def test_proj_puts_utm_coordinates_there() -> None:
    checked = 0
    for epsg, lat, lon, x, y in rows("projections"):
        if epsg == 3857:
            continue
        zone, is_north = int(epsg) % 100, epsg < 32700
        found = utm(GeoPoint(lat, lon), zone=zone, is_north=is_north)
        assert found.epsg == epsg
        assert math.hypot(found.easting_m - x, found.northing_m - y) < 1e-6
        assert distance_m(UtmPosition(zone, is_north, x, y).geo(), GeoPoint(lat, lon)) < 1e-6
        checked += 1
    assert checked == 400


def test_a_line_is_divided() -> None:
    start, end = GeoPoint(0.0, 179.0), GeoPoint(0.0, -179.0)
    points = points_along(start, end, step_m=50_000.0)
    assert points[0] == start
    assert points[-1] == end
    assert len(points) == 6
    assert all(distance_m(a, b) < 50_000 for a, b in itertools.pairwise(points))


def test_what_is_not_on_earth_is_refused() -> None:
    with pytest.raises(InvalidRequest, match="not a position on Earth"):
        distance_m(GeoPoint(91.0, 0.0), GeoPoint(0.0, 0.0))
    with pytest.raises(InvalidRequest, match="finite"):
        destination(GeoPoint(0.0, 0.0), bearing_deg=float("nan"), distance_m=1.0)
    with pytest.raises(InvalidRequest, match="zone 61"):
        utm(GeoPoint(0.0, 0.0), zone=61)
    with pytest.raises(InvalidRequest, match="finite"):
        UtmPosition(30, True, float("inf"), 0.0).geo()

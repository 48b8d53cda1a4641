"""Geometry on the WGS-84 ellipsoid: distances, bearings, positions along a line, and coordinates of UTM maps.

The same code that the driver, the checks and the progress of missions use. Distances along the ground are geodesics (C.
F. F. Karney, "Algorithms for geodesics", J. Geodesy 87, 2013), good to micrometres anywhere, over the poles and the
date line too; UTM is Krüger's series to n⁶ (Karney, J. Geodesy 85, 2011), good to nanometres.

Examples
--------
>>> from vencejo import GeoPoint
>>> from vencejo.geodesy import bearing_deg, destination, distance_m
>>> home = GeoPoint(40.3332, -3.7978)
>>> there = destination(home, bearing_deg=90.0, distance_m=1500.0)
>>> round(distance_m(home, there), 3), round(bearing_deg(home, there), 3)
(1500.0, 90.0)
"""

from __future__ import annotations

from dataclasses import dataclass

from vencejo import _native
from vencejo.plan import GeoPoint

__all__ = [
    "GeodesicLine",
    "UtmPosition",
    "bearing_deg",
    "destination",
    "distance_m",
    "line",
    "points_along",
    "utm",
]


@dataclass(frozen=True)
class GeodesicLine:
    """The shortest line between two positions.

    Attributes
    ----------
    distance_m : float
        Its length, metres.
    bearing_start_deg, bearing_end_deg : float
        Its direction at its start and, onwards, at its end; degrees clockwise from true north, 0 to 360.
    """

    distance_m: float
    bearing_start_deg: float
    bearing_end_deg: float


@dataclass(frozen=True)
class UtmPosition:
    """A position in a zone of Universal Transverse Mercator on WGS-84.

    Attributes
    ----------
    zone : int
        1 to 60.
    is_north : bool
        Northern hemisphere; in the southern one northings count from 10 000 km south of the equator.
    easting_m, northing_m : float
        Metres.
    """

    zone: int
    is_north: bool
    easting_m: float
    northing_m: float

    @property
    def epsg(self) -> int:
        """Code of the zone in the EPSG register: 32601 to 32660, 32701 to 32760."""
        return (32600 if self.is_north else 32700) + self.zone

    def geo(self) -> GeoPoint:
        """Latitude and longitude.

        Raises
        ------
        InvalidRequest
            There is no such zone, or a coordinate is not finite.
        """
        return GeoPoint(*_native.geo_from_utm(self.zone, self.is_north, self.easting_m, self.northing_m))


def distance_m(start: GeoPoint, end: GeoPoint) -> float:
    """Distance along the ground, metres.

    Raises
    ------
    InvalidRequest
        A position is not on Earth. (So for every function here.)
    """
    return _native.distance_m(start.lat_deg, start.lon_deg, end.lat_deg, end.lon_deg)


def bearing_deg(start: GeoPoint, end: GeoPoint) -> float:
    """Direction from one position to another where one starts, degrees clockwise from true north, 0 to 360."""
    return line(start, end).bearing_start_deg


def line(start: GeoPoint, end: GeoPoint) -> GeodesicLine:
    """The shortest line between two positions."""
    return GeodesicLine(*_native.geodesic_line(start.lat_deg, start.lon_deg, end.lat_deg, end.lon_deg))


def destination(start: GeoPoint, *, bearing_deg: float, distance_m: float) -> GeoPoint:
    """Where one is after going straight on from a position, in a direction (degrees from true north), for some metres."""
    return GeoPoint(*_native.geodesic_end(start.lat_deg, start.lon_deg, bearing_deg, distance_m))


def points_along(start: GeoPoint, end: GeoPoint, *, step_m: float = 20_000.0) -> tuple[GeoPoint, ...]:
    """Positions along the shortest line, both ends included, at most ``step_m`` metres apart; at most 1 025."""
    points = _native.geodesic_points(start.lat_deg, start.lon_deg, end.lat_deg, end.lon_deg, step_m)
    return tuple(GeoPoint(*point) for point in points)


def utm(position: GeoPoint, *, zone: int | None = None, is_north: bool | None = None) -> UtmPosition:
    """Easting and northing of a position.

    Parameters
    ----------
    position : GeoPoint
    zone : int, optional
        1 to 60; the one that maps of the position are made in (with the exceptions of Norway and Svalbard) when
        omitted.
    is_north : bool, optional
        Hemisphere; that of the position when omitted.

    Examples
    --------
    >>> place = utm(GeoPoint(40.3332, -3.7978))
    >>> place.zone, place.epsg, round(place.easting_m, 2), round(place.northing_m, 2)
    (30, 32630, 432231.83, 4465045.61)
    """
    own = UtmPosition(*_native.utm_from_geo(position.lat_deg, position.lon_deg, None))
    if zone is None and is_north is None:
        return own
    wanted = (own.zone if zone is None else zone, own.is_north if is_north is None else is_north)
    return UtmPosition(*_native.utm_from_geo(position.lat_deg, position.lon_deg, wanted))

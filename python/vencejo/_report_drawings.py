"""The drawings of a printed plan: a map without tiles and a height profile, as SVG.

Both are drawn in units of one thousandth of the page's width. Everything that is written into them is a number or
escaped.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from html import escape

from vencejo.landing import Wind
from vencejo.plan import Circle, MissionItem, Plan
from vencejo.rehearsal import Moment, Rehearsal

__all__ = ["Words", "map_drawing", "profile_drawing"]

WIDTH = 1000.0
MAX_POINTS = 3000
"""Of a track that is drawn: more are not seen on paper."""
EARTH_RADIUS_M = 6_371_008.8
"""Mean radius (IUGG), for a drawing of some kilometres."""
DOT = 13.0
"""Radius of a numbered point."""


@dataclass(frozen=True)
class Words:
    """What the drawings say, and how they write numbers.

    Attributes
    ----------
    say : function
        A text by its key, escaped.
    number : function
        A number with so many decimals.
    """

    say: Callable[[str], str]
    number: Callable[[float, int], str]


@dataclass(frozen=True)
class _View:
    """Where a place lies in a drawing: an equirectangular map, north up."""

    lat_deg: float
    lon_deg: float
    scale: float
    height: float

    @classmethod
    def of(cls, places: Sequence[tuple[float, float]], *, margin: float = 56.0) -> _View:
        """The view that shows all places, as large as fits."""
        lats, first = [lat for lat, _ in places], places[0][1]
        lons = [first + _turn(lon - first) for _, lon in places]
        lat, lon = (min(lats) + max(lats)) / 2.0, (min(lons) + max(lons)) / 2.0
        per_degree = math.radians(1.0) * EARTH_RADIUS_M
        wide_m = max((max(lons) - min(lons)) * per_degree * math.cos(math.radians(lat)), 1.0)
        high_m = max((max(lats) - min(lats)) * per_degree, 1.0)
        height = min(max(WIDTH * high_m / wide_m, 460.0), 640.0)
        # less than 200 m across is a point on a field
        scale = min((WIDTH - 2 * margin) / max(wide_m, 200.0), (height - 2 * margin) / max(high_m, 200.0))
        return cls(lat, lon, scale, height)

    def at(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        per_degree = math.radians(1.0) * EARTH_RADIUS_M * self.scale
        across = _turn(lon_deg - self.lon_deg) * per_degree * math.cos(math.radians(self.lat_deg))
        return WIDTH / 2.0 + across, self.height / 2.0 - (lat_deg - self.lat_deg) * per_degree


def _turn(degrees: float) -> float:
    """A difference of longitudes the short way, so that the 180th meridian is a line like others."""
    return (degrees + 180.0) % 360.0 - 180.0


def map_drawing(plan: Plan, flown: Rehearsal, wind: Wind, words: Words) -> str:
    """The route, the flown track, fence, rally points and landing, with north, scale and wind."""
    track = _thinned(flown.track)
    stops = [(number, item) for number, item in enumerate(plan.items, 1) if _is_stop(item)]
    places = [(moment.lat_deg, moment.lon_deg) for moment in track]
    places += [(item.lat_deg or 0.0, item.lon_deg or 0.0) for _, item in stops]
    places += [(point.lat_deg, point.lon_deg) for point in plan.rally]
    if plan.home is not None:
        places.append((plan.home.lat_deg, plan.home.lon_deg))
    view = _View.of(_with_near_fence(plan, places))
    parts = [
        f'<svg class="map" viewBox="0 0 {WIDTH:.0f} {view.height:.0f}" role="img" aria-label="{words.say("map")}">',
        (
            '<defs><pattern id="no" width="12" height="12" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">'
            '<line class="hatch" x1="0" y1="0" x2="0" y2="12"/></pattern></defs>'
        ),
        f'<rect class="paper" width="{WIDTH:.0f}" height="{view.height:.0f}"/>',
        *_grid(view),
        *_fence(plan, view),
    ]
    ways = [view.at(item.lat_deg or 0.0, item.lon_deg or 0.0) for _, item in stops]
    line = [view.at(moment.lat_deg, moment.lon_deg) for moment in track]
    parts.append(f'<polyline class="route" points="{_points(ways)}"/>')
    parts.append(f'<polyline class="case" points="{_points(line)}"/><polyline class="track" points="{_points(line)}"/>')
    parts += _arrows(line)
    for number, point in enumerate(plan.rally, 1):
        x, y = view.at(point.lat_deg, point.lon_deg)
        parts.append(
            f'<g class="rally"><path d="M{x:.1f} {y - 15:.1f}l15 26h-30z"/>{_label(x, y + 29, f"R{number}")}</g>'
        )
    if plan.home is not None:
        x, y = view.at(plan.home.lat_deg, plan.home.lon_deg)
        # what is numbered there stays to be seen
        y += 2.2 * DOT if any(math.hypot(x - to_x, y - to_y) < 2.0 * DOT for to_x, to_y in ways) else 0.0
        house = f'<path d="M{x:.1f} {y - 15:.1f}l15 12v15h-30v-15z"/>'
        parts.append(f'<g class="home">{house}{_label(x, y + 7, words.say("home-letter"))}</g>')
    if flown.touch_down is not None:
        x, y = view.at(flown.touch_down.lat_deg, flown.touch_down.lon_deg)
        parts.append(f'<path class="down" d="M{x - 8:.1f} {y - 8:.1f}l16 16m0 -16l-16 16"/>')
    parts += _stops(stops, view)
    parts += [_north(), _wind(wind, words), _scale_bar(view, words), "</svg>"]
    return "\n".join(parts)


def _is_stop(item: MissionItem) -> bool:
    return item.is_nav and item.lat_deg is not None and item.lon_deg is not None and bool(item.lat_deg or item.lon_deg)


def _with_near_fence(plan: Plan, places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The places, and those of a fence that is not so far out that the flight would become a dot."""
    lats, lons = [lat for lat, _ in places], [lon for _, lon in places]
    reach_lat, reach_lon = 1.0 * (max(lats) - min(lats)) + 1e-3, 1.0 * (max(lons) - min(lons)) + 1e-3

    def near(place: tuple[float, float]) -> bool:
        return (
            min(lats) - reach_lat <= place[0] <= max(lats) + reach_lat
            and min(lons) - reach_lon <= place[1] <= max(lons) + reach_lon
        )

    fence = [
        (point.lat_deg, point.lon_deg)
        for zone in plan.fence.zones
        if not isinstance(zone, Circle)
        for point in zone.points
    ]
    return places + [place for place in fence if near(place)]


def _thinned(track: Sequence[Moment]) -> Sequence[Moment]:
    step = max(1, math.ceil(len(track) / MAX_POINTS))
    return (*track[:-1:step], track[-1])


def _points(places: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in places)


def _label(x: float, y: float, text: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle">{escape(text)}</text>'


def _grid(view: _View) -> Iterable[str]:
    step = _nice(WIDTH / view.scale / 6.0) * view.scale
    for index in range(1, int(WIDTH / step) + 1):
        yield f'<line class="grid" x1="{index * step:.1f}" y1="0" x2="{index * step:.1f}" y2="{view.height:.0f}"/>'
    for index in range(1, int(view.height / step) + 1):
        yield f'<line class="grid" x1="0" y1="{index * step:.1f}" x2="{WIDTH:.0f}" y2="{index * step:.1f}"/>'


def _fence(plan: Plan, view: _View) -> Iterable[str]:
    for zone in plan.fence.zones:
        kind = "inside" if zone.inclusion else "outside"
        if isinstance(zone, Circle):
            x, y = view.at(zone.center.lat_deg, zone.center.lon_deg)
            yield f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{zone.radius_m * view.scale:.1f}"/>'
        else:
            corners = _points(view.at(point.lat_deg, point.lon_deg) for point in zone.points)
            yield f'<polygon class="{kind}" points="{corners}"/>'


def _arrows(line: Sequence[tuple[float, float]]) -> Iterable[str]:
    """Heads along a track, one every 110 units."""
    left = 60.0
    for (x, y), (to_x, to_y) in itertools.pairwise(line):
        length = math.hypot(to_x - x, to_y - y)
        left -= length
        if left <= 0.0 < length:
            angle = math.degrees(math.atan2(to_y - y, to_x - x))
            yield f'<path class="head" d="M-5 -5.5L6 0L-5 5.5z" transform="translate({to_x:.1f} {to_y:.1f}) rotate({angle:.0f})"/>'
            left = 110.0


def _stops(stops: Sequence[tuple[int, MissionItem]], view: _View) -> Iterable[str]:
    """The numbered points; those that would cover each other share one."""
    shared: list[tuple[float, float, list[tuple[int, MissionItem]]]] = []
    for number, item in stops:
        x, y = view.at(item.lat_deg or 0.0, item.lon_deg or 0.0)
        for there_x, there_y, here in shared:
            if math.hypot(there_x - x, there_y - y) < 1.5 * DOT:
                here.append((number, item))
                break
        else:
            shared.append((x, y, [(number, item)]))
    for x, y, here in shared:
        numbers = [number for number, _ in here]
        text = str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]}·{numbers[-1]}"
        kind = "land" if any(item.name == "NAV_LAND" for _, item in here) else "stop"
        half = max(DOT, 5.0 * len(text) + 5.0)
        lead = ""
        if kind == "land":
            # the place itself is left to the touch-down
            lead = f'<line class="lead" x1="{x:.1f}" y1="{y:.1f}" x2="{x:.1f}" y2="{y - 2.2 * DOT:.1f}"/>'
            y -= 2.4 * DOT
        box = (
            f'<rect x="{x - half:.1f}" y="{y - DOT:.1f}" width="{2 * half:.1f}" height="{2 * DOT:.1f}" rx="{DOT:.0f}"/>'
        )
        yield f'{lead}<g class="{kind}">{box}{_label(x, y + 5.5, text)}</g>'


def _north() -> str:
    return (
        '<g class="sign" transform="translate(954 50)"><circle r="30"/><path class="needle" d="M0 -20L8 14L0 8L-8 14z"/>'
        '<text y="-34" text-anchor="middle">N</text></g>'
    )


def _wind(wind: Wind, words: Words) -> str:
    speed = f"{words.number(wind.speed_m_s, 0)} m/s"
    if wind.is_calm:
        return f'<g class="sign" transform="translate(878 50)"><circle r="30"/>{_label(0, 5, speed)}</g>'
    arrow = '<path class="blow" d="M0 -21V12M-8 5L0 19L8 5"/>'
    return (
        f'<g class="sign" transform="translate(878 50)"><circle r="30"/><g transform="rotate({wind.from_deg % 360.0:.0f})">{arrow}</g>'
        f"{_label(0, 50, speed)}{_label(0, 68, f'{wind.from_deg % 360.0:.0f}°')}</g>"
    )


def _scale_bar(view: _View, words: Words) -> str:
    length_m = _nice(WIDTH / view.scale / 5.0)
    text = f"{words.number(length_m, 0)} m" if length_m < 1000.0 else f"{words.number(length_m / 1000.0, 0)} km"
    x, y, wide = 24.0, view.height - 22.0, length_m * view.scale
    bar = f'<path d="M{x:.0f} {y - 7:.1f}v7h{wide:.1f}v-7"/>'
    return f'<g class="scale">{bar}{_label(x + wide / 2.0, y - 9, text)}</g>'


def _nice(value: float) -> float:
    """The largest of 1, 2, 5, 10, … that is not above a value."""
    power: float = 10.0 ** math.floor(math.log10(max(value, 1e-9)))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= value * (1.0 + 1e-9))


def profile_drawing(plan: Plan, flown: Rehearsal, words: Words) -> str:
    """Height above home over time, as flown and as asked for, with the moments when items are reached."""
    track = _thinned(flown.track)
    high = 300.0
    left, right, top, bottom = 54.0, 16.0, 38.0, 40.0
    end_s = max(track[-1].time_s, 1.0)
    low_m = min(0.0, *(moment.alt_rel_home_m for moment in track))
    most_m = max(10.0, *(max(moment.alt_rel_home_m, moment.alt_asked_m) for moment in track))
    step_m = _nice((most_m - low_m) / 3.0)
    most_m = math.ceil(most_m / step_m) * step_m
    low_m = math.floor(low_m / step_m) * step_m

    def at(time_s: float, alt_m: float) -> tuple[float, float]:
        return (
            left + (WIDTH - left - right) * time_s / end_s,
            top + (high - top - bottom) * (most_m - alt_m) / (most_m - low_m),
        )

    parts = [
        f'<svg class="profile" viewBox="0 0 {WIDTH:.0f} {high:.0f}" role="img" aria-label="{words.say("profile")}">'
    ]
    for index in range(round((most_m - low_m) / step_m) + 1):
        alt_m = low_m + index * step_m
        _, y = at(0.0, alt_m)
        parts.append(f'<line class="grid" x1="{left:.0f}" y1="{y:.1f}" x2="{WIDTH - right:.0f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{left - 8:.0f}" y="{y + 5:.1f}" text-anchor="end">{words.number(alt_m, 0)}</text>')
    step_s = _time_step(end_s)
    for index in range(int(end_s / step_s) + 1):
        x, _ = at(index * step_s, 0.0)
        minutes, seconds = divmod(round(index * step_s), 60)
        parts.append(
            f'<line class="tick" x1="{x:.1f}" y1="{high - bottom:.0f}" x2="{x:.1f}" y2="{high - bottom + 6:.0f}"/>'
        )
        parts.append(_label(x, high - bottom + 24, f"{minutes}:{seconds:02}"))
    line = [at(moment.time_s, moment.alt_rel_home_m) for moment in track]
    asked = [at(moment.time_s, moment.alt_asked_m) for moment in track]
    _, base = at(0.0, low_m)
    area = f"M{line[0][0]:.1f} {base:.1f}L{_points(line)}L{line[-1][0]:.1f} {base:.1f}z"
    parts.append(f'<path class="flown" d="{area}"/><polyline class="asked" points="{_points(asked)}"/>')
    parts.append(f'<polyline class="track" points="{_points(line)}"/>')
    free = 0.0
    for passage in flown.passages:
        if passage.reached_s is None or not plan.items[passage.item - 1].is_nav:
            continue
        x, _ = at(passage.reached_s, 0.0)
        if x >= free:
            parts.append(f'<line class="mark" x1="{x:.1f}" y1="{top - 10:.0f}" x2="{x:.1f}" y2="{high - bottom:.0f}"/>')
            parts.append(f'<g class="number">{_label(x, top - 15, str(passage.item))}</g>')
            free = x + 26.0
    parts.append("</svg>")
    return "\n".join(parts)


def _time_step(end_s: float) -> float:
    steps = (10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0)
    return next((step for step in steps if end_s / step <= 12.0), steps[-1])

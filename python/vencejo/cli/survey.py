"""The command `vencejo plan survey`: an area or a corridor to photograph, laid out, rehearsed and saved as a plan."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    distance,
    duration,
    finding_text,
    put_json,
    say,
    say_notes,
    stdout,
    table,
)
from vencejo.cli.flight import GroundAboveHomeOption, ParamsOption, WindFromOption, WindOption, parameters_of, wind_of
from vencejo.cli.landing import place_of

if TYPE_CHECKING:
    from vencejo.plan import GeoPoint, Plan
    from vencejo.survey import Camera, Survey


def survey(
    area: Annotated[
        Path | None,
        typer.Argument(
            metavar="AREA",
            help="A plan file: its first fence polygon to stay in is the area, or with --width its waypoints are the line.",
        ),
    ] = None,
    places: Annotated[
        str | None,
        typer.Option("--area", metavar="PLACES", help='The corners, or with --width the line, as "lat,lon lat,lon …".'),
    ] = None,
    width: Annotated[
        float | None, typer.Option("--width", metavar="M", help="Width of a corridor along the line; 0: one pass.")
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            "--camera",
            metavar="NAME",
            help='A camera by name (--camera list), or "W×H mm, W×H px, F mm" of another, as "13.2x8.8,5472x3648,10.4".',
        ),
    ] = None,
    portrait: Annotated[
        bool, typer.Option("--portrait", help="Mount the camera with the wide side of the picture along the track.")
    ] = False,
    gsd: Annotated[float | None, typer.Option("--gsd", metavar="CM", help="Ground sampling distance.")] = None,
    height: Annotated[float | None, typer.Option("--height", metavar="M", help="Height above the ground.")] = None,
    overlap: Annotated[
        tuple[float, float], typer.Option("--overlap", metavar="FRONT SIDE", help="Overlap of pictures, per cent.")
    ] = (75.0, 65.0),
    spacing: Annotated[
        float | None,
        typer.Option("--spacing", metavar="M", help="Distance between lines, instead of the side overlap."),
    ] = None,
    course: Annotated[
        float | None,
        typer.Option("--course", metavar="DEGREES", help="Course of the lines; by default across the wind."),
    ] = None,
    wind: WindOption = None,
    wind_from: WindFromOption = None,
    airspeed: Annotated[float | None, typer.Option("--airspeed", metavar="M/S", help="Of the survey.")] = None,
    margin: Annotated[
        float | None,
        typer.Option(
            "--margin",
            metavar="M",
            help="How far pictures reach beyond the edge; by default until the overlap holds there.",
        ),
    ] = None,
    lead_in: Annotated[
        float | None,
        typer.Option(
            "--lead-in", metavar="M", help="Straight distance before a line; by default until the plane has settled."
        ),
    ] = None,
    above_terrain: Annotated[
        bool,
        typer.Option("--above-terrain", help="Altitudes count from the terrain, which the vehicle has to know."),
    ] = False,
    ground_above_home: GroundAboveHomeOption = None,
    params: ParamsOption = None,
    into: Annotated[
        Path | None, typer.Option("--into", metavar="FILE", help="Plan into which to insert it, before its landing.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="File to write: .plan or .waypoints.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    json: JsonOption = False,
) -> None:
    """Lay out a survey that the plane can fly, and show the coverage of its rehearsed flight.

    Lines lie across the wind; turns and leads are those that the plane can fly. In a .plan file it is a survey that
    QGroundControl opens and edits. Ends with 1 when a line would be missed.

    Example: vencejo plan survey field.plan --camera "Sony a6000 16mm" --gsd 3 --wind 5 --wind-from 240 -o survey.plan

    Example: vencejo plan survey --area "40.33,-3.80 40.34,-3.80 40.34,-3.79" --width 60 --spacing 40 --height 100 --json
    """
    from vencejo.landing import landing_item
    from vencejo.plan import Plan
    from vencejo.survey import design_corridor, design_survey

    if camera == "list":
        _list_cameras(json=json)
        return
    if output is not None and output.exists() and not force:
        raise Failed(f"{output} exists; add --force to overwrite it")
    if (area is None) == (places is None):
        raise Failed("give either a file with the area or --area", Exit.USAGE)
    drawn = None if area is None else Plan.load(area)
    plan = Plan() if into is None else Plan.load(into)
    home = plan.home or (None if drawn is None else drawn.home)
    shape = _places(places or "") if drawn is None else _drawn(area, drawn, is_line=width is not None)
    given: dict[str, Any] = {
        "camera": None if camera is None else _camera(camera),
        "is_landscape": not portrait,
        "gsd_m": None if gsd is None else gsd / 100.0,
        "height_m": height,
        "front_overlap": overlap[0] / 100.0,
        "side_overlap": overlap[1] / 100.0,
        "spacing_m": spacing,
        "wind": wind_of(wind, wind_from),
        "margin_m": margin,
        "lead_in_m": lead_in,
        "is_above_terrain": above_terrain,
        "ground_rel_home_m": ground_above_home,
        "airspeed_m_s": airspeed,
        "home": home,
        "parameters": parameters_of(params),
    }
    if width is None:
        laid = design_survey(shape, course_deg=course, **given)
    elif course is None:
        laid = design_corridor(shape, width, **given)
    else:
        raise Failed("a corridor has the course of its line; leave out --course or --width", Exit.USAGE)
    if output is not None:
        whole = laid.placed_in(plan, before=landing_item(plan))
        say_notes(dataclasses.replace(whole, home=home).save(output))
    if json:
        put_json(_as_json(laid))
    else:
        _tell(laid)
        if output is not None:
            say(f"Saved as {output}")
    if any(line.is_missed for line in laid.flown.lines):
        raise typer.Exit(Exit.FAILED)


def _places(text: str) -> tuple[GeoPoint, ...]:
    from vencejo.plan import GeoPoint

    def point(pair: str) -> GeoPoint:
        try:
            lat, lon = (float(number) for number in pair.split(","))
        except ValueError:
            raise Failed(f"'{pair}' is not a position: write latitude,longitude, as 40.33,-3.80", Exit.USAGE) from None
        return GeoPoint(lat, lon)

    return tuple(point(pair) for pair in text.split())


def _drawn(file: Path | None, plan: Plan, *, is_line: bool) -> tuple[GeoPoint, ...]:
    """The line or the area that a plan holds."""
    from vencejo.plan import Polygon

    if is_line:
        places = (place_of(item) for item in plan if item.name == "NAV_WAYPOINT")
        line = tuple(place for place in places if place is not None)
        if len(line) < 2:
            raise Failed(f"{file} holds no line: a corridor needs two waypoints or more")
        return line
    for zone in plan.fence.zones:
        if isinstance(zone, Polygon) and zone.inclusion:
            return zone.points
    raise Failed(f"{file} holds no area: draw one as a fence polygon to stay in, or give --area")


def _camera(text: str) -> Camera:
    from vencejo.survey import CAMERAS, Camera

    known = {name.lower(): camera for name, camera in CAMERAS.items()}
    if text.lower() in known:
        return known[text.lower()]
    try:
        sensor, image, focal = text.lower().replace("×", "x").split(",")
        (width_mm, height_mm), (width_px, height_px) = (part.split("x") for part in (sensor, image))
        return Camera(float(width_mm), float(height_mm), int(width_px), int(height_px), float(focal))
    except ValueError:
        raise Failed(
            f"'{text}' is not a known camera: choose one of --camera list, or write one as 13.2x8.8,5472x3648,10.4",
            Exit.USAGE,
        ) from None


def _list_cameras(*, json: bool) -> None:
    from vencejo.survey import CAMERAS

    if json:
        put_json({name: dataclasses.asdict(camera) for name, camera in CAMERAS.items()})
        return
    shown = table("Camera", "Sensor", "Picture", "Focal length", right=("Sensor", "Picture", "Focal length"))
    for name, camera in CAMERAS.items():
        shown.add_row(
            name,
            f"{camera.sensor_width_mm:g} × {camera.sensor_height_mm:g} mm",
            f"{camera.image_width_px} × {camera.image_height_px}",
            f"{camera.focal_length_mm:g} mm",
        )
    stdout().print(shown)


def _as_json(laid: Survey) -> dict[str, object]:
    shown = dataclasses.asdict(laid)
    del shown["complex_item"]
    return shown


_COURSES = {
    "asked": "as asked",
    "across-wind": "across the wind",
    "along-area": "along the area",
    "corridor": "along the line",
}


def _tell(laid: Survey) -> None:
    flown = laid.flown
    print(f"{len(laid.lines)} lines {_COURSES[laid.course_from]}, {laid.course_deg:.0f}°, {laid.spacing_m:.1f} m apart")
    scale = "" if laid.gsd_m is None else f", {100 * laid.gsd_m:.2g} cm a pixel"
    print(f"{laid.height_m:.0f} m above the ground{scale}")
    if laid.footprint_m is not None and laid.trigger_m is not None:
        across, along = laid.footprint_m
        print(f"{laid.photos} pictures of {across:.0f} × {along:.0f} m, one every {laid.trigger_m:.1f} m")
    print(
        f"Turns of {laid.turn_radius_m:.0f} m, {laid.lead_in_m:.0f} m before each line; "
        f"{laid.area_m2 / 10_000:.1f} ha, {len(laid.items)} items, {distance(laid.length_m)}, {duration(laid.duration_s)}"
    )
    for caution in laid.cautions:
        print(f"caution: {caution.message}")
    if flown.covered is not None and flown.overlapped is not None:
        print(
            f"Rehearsed: {len(flown.photos)} pictures show {flown.covered:.1%} of the area, "
            f"{flown.overlapped:.1%} on {flown.views_promised} or more"
        )
    for finding in flown.findings:
        print(finding_text(finding))

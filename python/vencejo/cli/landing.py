"""The command `vencejo plan land`: the landings that there are for a wind, and a mission that ends with one of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vencejo.cli.common import Exit, Failed, JsonOption, clean, put_json, say_notes, stdout, table
from vencejo.cli.flight import (
    GroundAboveHomeOption,
    GroundOption,
    ParamsOption,
    WindFromOption,
    WindOption,
    ground_of,
    numbers,
    parameters_of,
    wind_of,
)

if TYPE_CHECKING:
    from vencejo.landing import LandingAlternative, Runway
    from vencejo.plan import GeoPoint, MissionItem, Plan


def land(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A plan file, landing or not.")],
    at: Annotated[
        str | None, typer.Option("--at", metavar="LAT,LON", help="Touch-down point; by default that of the mission.")
    ] = None,
    runway: Annotated[
        str | None,
        typer.Option("--runway", metavar="LAT,LON,LAT,LON", help="The two ends of a runway, instead of a point."),
    ] = None,
    course: Annotated[
        float | None, typer.Option("--course", help="Course of the final leg or its opposite, degrees from true north.")
    ] = None,
    wind: WindOption = None,
    wind_from: WindFromOption = None,
    ground_above_home: GroundAboveHomeOption = None,
    ground: GroundOption = None,
    params: ParamsOption = None,
    choice: Annotated[
        int, typer.Option("--choice", min=1, help="Which of the landings is written; 1 is the best.")
    ] = 1,
    write: Annotated[
        Path | None, typer.Option("--write", metavar="FILE", help="File to write the mission with the landing to.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Show the landings at a point or on a runway, the best for the wind first, and end a mission with one of them.

    Each is rehearsed from the last place of the mission. The file is changed only where --write names it. Ends with 1
    when the landing that is written is not to be flown.

    Example: vencejo plan land mission.plan --runway 40.3332,-3.7978,40.3332,-3.7943 --wind 6 --wind-from 250 --write landing.plan
    """
    from vencejo import Plan
    from vencejo.landing import landing_alternatives

    plan = Plan.load(file)
    kept = without_landing(plan)
    places = [place for item in kept if (place := place_of(item)) is not None]
    site = site_of(plan, at, runway)
    found = landing_alternatives(
        site,
        course_deg=course,
        coming_from=places[-1] if places else None,
        wind=wind_of(wind, wind_from),
        ground_rel_home_m=ground_above_home,
        parameters=parameters_of(params),
        home=plan.home,
        ground=ground_of(ground),
    )
    if choice > len(found):
        raise Failed(f"there are {len(found)} landings to choose from, no {choice}th")
    if json:
        put_json([dataclasses.asdict(one) for one in found])
    else:
        shown = table("No", "Course", "Circle", "Verdict", "Why", right=("No", "Course"))
        for number, one in enumerate(found, 1):
            side = "right" if one.is_clockwise else "left"
            why = ", ".join(reason.message for reason in one.reasons)
            shown.add_row(str(number), f"{one.landing.course_deg:.0f}°", side, one.verdict, why)
        stdout().print(shown)
    if write is None:
        return
    chosen = found[choice - 1]
    notes = dataclasses.replace(plan, items=(*kept, *chosen.landing.items)).save(write)
    say_notes((*plan.notes, *notes))
    if not json:
        for caution in chosen.landing.cautions:
            print(f"Mind: {caution.message}")
        print(clean(f"{write}: {len(kept) + len(chosen.landing.items)} items, the landing {said(chosen)}"))
    if chosen.verdict == "bad":
        raise typer.Exit(Exit.FAILED)


def said(one: LandingAlternative) -> str:
    """A landing in a few words."""
    side = "right" if one.is_clockwise else "left"
    return f"on course {one.landing.course_deg:.0f}°, its circle to the {side}"


def without_landing(plan: Plan) -> tuple[MissionItem, ...]:
    """What a mission flies before its landing, or before a return that ends it."""
    from vencejo.landing import landing_item
    from vencejo.plan import Command

    number = landing_item(plan)
    if number is not None:
        return plan.items[: number - 1]
    ends = bool(plan.items) and plan.items[-1].command == Command.NAV_RETURN_TO_LAUNCH
    return plan.items[:-1] if ends else plan.items


def site_of(plan: Plan, at: str | None, runway: str | None) -> GeoPoint | Runway:
    """Where to land: as said, else where the mission does."""
    from vencejo.landing import Runway
    from vencejo.plan import Command, GeoPoint

    if at is not None and runway is not None:
        raise Failed("--at and --runway: give one of them", Exit.USAGE)
    if runway is not None:
        one, other, *rest = numbers("--runway", runway, "LAT,LON,LAT,LON")
        return Runway(GeoPoint(one, other), GeoPoint(*rest))
    if at is not None:
        return GeoPoint(*numbers("--at", at, "LAT,LON"))
    lands = next((item for item in plan.items if item.command == Command.NAV_LAND), None)
    point = None if lands is None else place_of(lands)
    if point is None:
        raise Failed("the mission has no landing: say where, by --at or --runway")
    return point


def place_of(item: MissionItem) -> GeoPoint | None:
    """Where an item has the plane fly; ``None`` for an action, and for 0/0, which is "here" to ArduPilot."""
    from vencejo.plan import GeoPoint

    if not item.is_nav or item.lat_deg is None or item.lon_deg is None or (item.lat_deg == 0.0 and item.lon_deg == 0.0):
        return None
    return GeoPoint(item.lat_deg, item.lon_deg)

"""The commands `vencejo plan …`: plans in files, without a vehicle: checked, rehearsed, landed, converted, and printed."""

from __future__ import annotations

import dataclasses
import datetime
import enum
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    clean,
    distance,
    finding_text,
    put_json,
    require_plan_name,
    say,
    say_notes,
    stdout,
    table,
)
from vencejo.cli.flight import (
    CapacityOption,
    ClearanceOption,
    Flight,
    GroundOption,
    LearnOption,
    ParamsOption,
    PowerOption,
    ReserveOption,
    VoltageOption,
    WindFromOption,
    WindOption,
    numbers,
    parameters_of,
)
from vencejo.cli.landing import land
from vencejo.cli.survey import survey

if TYPE_CHECKING:
    from vencejo.plan import Finding, Plan
    from vencejo.rehearsal import Rehearsal, Spread

plan_app = typer.Typer(
    no_args_is_help=True,
    help="Check, rehearse, convert and print plans in files, and give them a landing.\n\nNo vehicle is needed.\n\n"
    "Example: vencejo plan check mission.plan",
)

PlanArgument = Annotated[Path, typer.Argument(metavar="FILE", help="A plan file.")]
HomeOption = Annotated[
    str | None,
    typer.Option(
        "--home", metavar="LAT,LON,ALT", help="Planned home, altitude above mean sea level; by default the file's."
    ),
]


@plan_app.command()
def check(
    file: PlanArgument,
    home: HomeOption = None,
    wind: WindOption = None,
    wind_from: WindFromOption = None,
    params: ParamsOption = None,
    learned_from: LearnOption = None,
    capacity: CapacityOption = None,
    voltage: VoltageOption = None,
    power: PowerOption = None,
    reserve: ReserveOption = None,
    ground: GroundOption = None,
    clearance: ClearanceOption = 30.0,
    json: JsonOption = False,
) -> None:
    """Look for what is wrong or doubtful in a plan: in its items, and in the flight that it makes in this wind.

    Ends with 1 when there is an error. A plan without a home is not rehearsed, which is said.

    Example: vencejo plan check mission.plan --wind 7 --wind-from 240
    """
    from vencejo.errors import InvalidRequest
    from vencejo.findings import with_flown

    plan = _load(file, home)
    findings = plan.check(parameters=parameters_of(params))
    flown, why = None, None
    try:
        if plan.items:
            battery = (capacity, voltage, power, reserve)
            flight = Flight(params, learned_from, wind, wind_from, ground, clearance, battery)
            flown = flight.fly(plan)
            findings = with_flown(findings, flown.findings)
    except InvalidRequest as error:
        why = str(error)
    if json:
        put_json(
            {
                "file": str(file),
                "notes": [dataclasses.asdict(note) for note in plan.notes],
                "findings": [_finding_json(finding) for finding in findings],
                "ending": None if flown is None else flown.ending,
                "not_rehearsed": why,
            }
        )
    else:
        say_notes(plan.notes)
        for finding in findings:
            print(finding_text(finding))
        if why is not None:
            say(f"not rehearsed: {why}")
        errors = sum(finding.severity == "error" for finding in findings)
        print(clean(f"{file}: errors: {errors}, warnings: {len(findings) - errors}"))
    if any(finding.severity == "error" for finding in findings):
        raise typer.Exit(Exit.FAILED)


@plan_app.command()
def rehearse(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A plan file.")],
    home: HomeOption = None,
    wind: WindOption = None,
    wind_from: WindFromOption = None,
    gust: Annotated[
        float, typer.Option("--gust", min=0.0, max=20.0, help="Standard deviation of the gusts, m/s.")
    ] = 0.0,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Which gusts.")] = 0,
    params: ParamsOption = None,
    learned_from: LearnOption = None,
    capacity: CapacityOption = None,
    voltage: VoltageOption = None,
    power: PowerOption = None,
    reserve: ReserveOption = None,
    runs: Annotated[
        int,
        typer.Option("--runs", min=0, max=100_000, help="Flights more, in winds that differ a little, for the odds."),
    ] = 0,
    ground: GroundOption = None,
    clearance: ClearanceOption = 30.0,
    json: JsonOption = False,
) -> None:
    """Fly a plan of a file without a plane: when it reaches each item, how near it comes, and where and how the flight ends.

    Ends with 1 when the flight ends in the ground, is held by the wind, or does not begin.

    Example: vencejo plan rehearse mission.plan --wind 7 --wind-from 240 --params plane.param
    """
    from vencejo.rehearsal import rehearse_many

    plan = _load(file, home)
    battery = (capacity, voltage, power, reserve)
    flight = Flight(params, learned_from, wind, wind_from, ground, clearance, battery)
    _say_where(plan, home)
    flown = flight.fly(plan, gust_m_s=gust, seed=seed)
    odds = None
    if runs:
        odds = rehearse_many(plan, **flight.given, runs=runs, seed=seed, clearance_m=flight.clearance_m)
    if json:
        put_json(dataclasses.asdict(flown) | ({} if odds is None else {"odds": dataclasses.asdict(odds)}))
    else:
        say_notes(plan.notes)
        _tell(plan, flown)
        if odds is not None:
            _tell_odds(odds)
    if flown.ending in ("ground", "held", "grounded"):
        raise typer.Exit(Exit.FAILED)


plan_app.command()(land)
plan_app.command()(survey)


@plan_app.command()
def convert(
    source: Annotated[
        Path, typer.Argument(metavar="IN", help="A plan file, or a map: .kml, .kmz, .geojson, .gpx, .csv.")
    ],
    target: Annotated[Path, typer.Argument(metavar="OUT", help="File to write; its ending selects the format.")],
    alt: Annotated[
        float | None,
        typer.Option("--alt", metavar="METRES", help="Altitude above home for positions of the mission without one."),
    ] = None,
    home: HomeOption = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite OUT.")] = False,
    json: JsonOption = False,
) -> None:
    """Write a plan in another format, and say what had to be assumed and what was not kept.

    What heights count from is never changed in silence: a note on standard error says it. Formats: .plan, .waypoints,
    .kml, .kmz, .geojson, .gpx, .csv; .mission, .fen and .ral are read.

    Example: vencejo plan convert path.kml mission.plan --alt 80 --home 40.3332,-3.7978,690
    """
    require_plan_name(target)
    if target.exists() and not force:
        raise Failed(f"{target} exists; add --force to overwrite it")
    plan = _load(source, home)
    read = plan.notes
    if alt is not None:
        # Both zero means where the plane is then.
        lacks = [item.alt_m is None and bool(item.lat_deg or item.lon_deg) for item in plan]
        items = (item.with_altitude(alt) if lacking else item for item, lacking in zip(plan, lacks, strict=True))
        plan = dataclasses.replace(plan, items=tuple(items))
        read = tuple(note for note in read if note.code != "heights-missing")
    _say_where(plan, home)
    written = plan.save(target)
    counts = {"items": len(plan.items), "zones": len(plan.fence.zones), "rally_points": len(plan.rally)}
    if json:
        notes = {
            "read": [dataclasses.asdict(note) for note in read],
            "written": [dataclasses.asdict(note) for note in written],
        }
        put_json({"file": str(target), **counts, **notes})
        return
    say_notes((*read, *written))
    parts = f"{counts['items']} items, {counts['zones']} fence zones, {counts['rally_points']} rally points"
    print(clean(f"{target}: {parts}"))


#: Findings that show a home, or the plan, in another place.
_ELSEWHERE: Final = {"out-of-reach", "area-out-of-reach", "far-from-home"}


class Language(str, enum.Enum):
    """Of a report."""

    en = "en"
    es = "es"


@plan_app.command()
def report(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A plan file.")],
    out: Annotated[Path, typer.Option("--output", "-o", metavar="HTML", help="File to write.")],
    language: Annotated[Language, typer.Option("--language", help="Language of the report.")] = Language.en,
    title: Annotated[
        str | None, typer.Option("--title", help="Title of the report; by default the file's name.")
    ] = None,
    home: HomeOption = None,
    wind: WindOption = None,
    wind_from: WindFromOption = None,
    params: ParamsOption = None,
    learned_from: LearnOption = None,
    capacity: CapacityOption = None,
    voltage: VoltageOption = None,
    power: PowerOption = None,
    reserve: ReserveOption = None,
    ground: GroundOption = None,
    clearance: ClearanceOption = 30.0,
    json: JsonOption = False,
) -> None:
    """Write a plan and its rehearsed flight as one HTML file that needs no network and prints on A4.

    Example: vencejo plan report mission.plan -o report.html --wind 7 --wind-from 240 --language es
    """
    from vencejo.report import plan_report
    from vencejo.storage import write_file
    from vencejo.what_if import what_if

    plan = _load(file, home)
    _say_where(plan, home)
    battery = (capacity, voltage, power, reserve)
    flight = Flight(params, learned_from, wind, wind_from, ground, clearance, battery)
    flown = flight.fly(plan)
    fifths = [flown.duration_s * part / 5.0 for part in (1, 2, 3, 4)]
    page = plan_report(
        plan,
        flown,
        title=title or file.stem,
        wind=flight.given["wind"],
        language=language.value,
        parameters=flight.given["parameters"],
        airframe=flight.given["airframe"],
        what_ifs=what_if(plan, fifths, **flight.given),
        made=datetime.datetime.now().astimezone(),
    )
    write_file(out, page.encode())
    if json:
        put_json({"file": str(out), "ending": flown.ending, "notes": [dataclasses.asdict(note) for note in plan.notes]})
    else:
        say_notes(plan.notes)
        print(clean(f"{out}: written; open it in a browser, or print it"))


def _load(file: Path, home: str | None) -> Plan:
    """Load a plan, with a home in place of its own if one is given."""
    from vencejo import Home, Plan

    plan = Plan.load(file)
    if home is None:
        return plan
    return dataclasses.replace(plan, home=Home(*numbers("--home", home, "LAT,LON,ALT")))


def _say_where(plan: Plan, home: str | None) -> None:
    """Say that a home which was given lies in another place than the plan: once, whatever number of items that is told of."""
    if home is not None:
        for finding in [finding for finding in plan.check() if finding.code in _ELSEWHERE][:1]:
            say(finding_text(finding))


def _tell(plan: Plan, flown: Rehearsal) -> None:
    shown = table("Item", "Command", "Begins", "Reached", "Passes at", right=("Item", "Begins", "Reached", "Passes at"))
    for passage in flown.passages:
        shown.add_row(
            str(passage.item),
            plan.items[passage.item - 1].name,
            f"{passage.begins_s:.0f} s",
            "never" if passage.reached_s is None else f"{passage.reached_s:.0f} s",
            "" if passage.nearest_m is None else f"{passage.nearest_m:.0f} m",
        )
    stdout().print(shown)
    for finding in flown.findings:
        print(finding_text(finding))
    print(f"{_ENDINGS[flown.ending]} after {flown.duration_s:.0f} s and {distance(flown.distance_m)}")
    off_m = flown.touch_down_off_m(plan)
    if flown.touch_down is not None and off_m is not None:
        print(f"Touches the ground {off_m:.0f} m from the landing point, at {flown.touch_down.groundspeed_m_s:.0f} m/s")
    print(f"Flown with {_AIRFRAMES[flown.airframe]}")
    if flown.battery is None:
        print(f"What is left of the battery cannot be told: {_BATTERY_UNKNOWN[flown.battery_unknown or 'power']}")
    else:
        left, full = flown.battery.left, flown.battery.capacity_wh
        print(f"Of the battery's {full:.0f} Wh {100.0 * max(0.0, left):.0f} % are left")


def _tell_odds(odds: Spread) -> None:
    ways = ", ".join(f"{count} {ending}" for ending, count in odds.endings.items())
    took = odds.duration_s
    print(f"Of {odds.runs} flights: {ways}; nine in ten take {took.low:.0f} to {took.high:.0f} s")
    if odds.battery_left is not None:
        print(
            f"Nineteen in twenty leave {100.0 * odds.battery_left.low:.0f} % of the battery or more; "
            f"{odds.below_reserve} less than its reserve"
        )
    if odds.touch_down_m is not None:
        print(
            f"Half of them touch down within {odds.touch_down_m.median:.0f} m of this one, "
            f"nineteen in twenty within {odds.touch_down_m.high:.0f} m"
        )


def _finding_json(finding: Finding) -> dict[str, Any]:
    return {
        "severity": finding.severity,
        "code": finding.code,
        "item": finding.item,
        "figures": dict(finding.figures),
        "message": finding.message,
        "remedy": finding.remedy,
    }


_ENDINGS: Final[Mapping[str, str]] = {
    "landed": "Landed, at rest",
    "returned": "Circles over home or a rally point",
    "unlimited": "Circles without end",
    "endless": "Flies on for ever: a jump repeats without end. One round was flown, which ended",
    "ground": "HITS THE GROUND",
    "held": "IS HELD BY THE WIND: it comes no nearer to its next point",
    "grounded": "DOES NOT LEAVE THE GROUND",
    "not-rehearsed": "Comes to an item that is not rehearsed",
    "too-long": "Still flies",
}
_BATTERY_UNKNOWN: Final[Mapping[str, str]] = {
    "power": "the plane's power is not known; give --power, or --learn it from a recorded flight",
    "capacity": "its capacity is not known; give --capacity, or BATT_CAPACITY in --params",
    "voltage": "its voltage is not known; give --voltage",
}
_AIRFRAMES: Final[Mapping[str, str]] = {
    "parameters": "a foam pusher, as far as parameters do not tell of another plane",
    "simulator": "the plane of ArduPilot's simulator",
    "flight": "the plane that was learned from a flight",
}

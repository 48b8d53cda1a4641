"""The commands `vencejo mission …`: plans between files and the vehicle, and what is in them."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    YesOption,
    confirm,
    distance,
    finding_text,
    grouped,
    progress_bar,
    put_json,
    require_plan_name,
    say_notes,
    stdout,
    table,
)
from vencejo.cli.connecting import OnVehicle

if TYPE_CHECKING:
    from vencejo.plan import Plan
    from vencejo.values import PlanChange
    from vencejo.vehicle import Danger, PlanKind

CLEARS: Final[Mapping[PlanKind, Danger]] = {
    "mission": "clear-mission",
    "fence": "clear-fence",
    "rally": "clear-rally",
}
"""Confirmations given by the question of the command."""

mission_app = typer.Typer(
    no_args_is_help=True,
    help="Upload, download, compare, clear or show missions, fences and rally points.\n\nNothing is armed or started by any of "
    "these.\n\nExample: vencejo mission show mission.waypoints",
)


class Kind(str, enum.Enum):
    """Which part of a plan."""

    mission = "mission"
    fence = "fence"
    rally = "rally"
    all = "all"


KindOption = Annotated[Kind, typer.Option("--kind", help="Which part of the plan.")]


@mission_app.command()
@grouped
def upload(
    on: OnVehicle,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A plan file.")],
    kind: KindOption = Kind.mission,
    check: Annotated[bool, typer.Option("--check/--no-check", help="Refuse a plan with errors.")] = True,
    json: JsonOption = False,
) -> None:
    """Replace the mission on board, read it back and compare.

    Success means that the vehicle has it. With --kind all everything that the file holds is sent; what it does not hold
    stays as it is on board.

    Example: vencejo mission upload mission.waypoints --link tcp:127.0.0.1:5760

    Example: vencejo mission upload field.plan --kind fence
    """
    from vencejo import Plan

    plan = Plan.load(file)
    kinds = [part for part in _kinds(kind) if kind is not Kind.all or count(plan, part)]
    if not any(count(plan, part) for part in kinds):
        raise Failed(
            without(file, plan, kind.value) + f"; `vencejo mission clear --kind {kind.value}` empties it on board"
        )
    with on.vehicle() as vehicle:
        for part in kinds:
            if check and part == "mission":
                _tell_findings(plan, vehicle.check_plan(plan), json=json)
            with progress_bar(f"Uploading {part}", quiet=json) as bar:
                state = vehicle.upload(plan, kind=part, check=check, progress=bar)
            sent = state.count if state.count is not None else count(plan, part)
            if json:
                put_json({"kind": part, "state": state.state, "count": state.count, "hash": state.hash})
            else:
                print(f"{part}: {sent} items on board and verified")


@mission_app.command()
@grouped
def download(
    on: OnVehicle,
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="File to write; its ending selects the format: .waypoints, .plan, .kml…"),
    ],
    kind: KindOption = Kind.mission,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    json: JsonOption = False,
) -> None:
    """Read the mission from the vehicle into a file. A .waypoints file holds one kind, a .plan file all; see vencejo plan convert.

    Example: vencejo mission download on-board.waypoints

    Example: vencejo mission download on-board.plan --kind all --link udpin:0.0.0.0:14550
    """
    require_plan_name(file)
    if kind is Kind.all and file.suffix.lower() in (".waypoints", ".txt", ".gpx"):
        raise Failed(f"{file}: such a file holds a mission, a fence or rally points; name it .plan", Exit.USAGE)
    if file.exists() and not force:
        raise Failed(f"{file} exists; add --force to overwrite it")
    if not file.resolve().parent.is_dir():
        raise Failed(f"{file}: there is no folder {file.resolve().parent}")
    plan = _read(on, kind, quiet=json)
    notes = plan.save(file)
    counts = {part: count(plan, part) for part in _kinds(kind)}
    if json:
        put_json({"file": str(file), **counts, "notes": [dataclasses.asdict(note) for note in notes]})
    else:
        say_notes(notes)
        print(f"{file}: " + ", ".join(f"{part} {held}" for part, held in counts.items()))


@mission_app.command()
@grouped
def compare(
    on: OnVehicle,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A plan file.")],
    kind: KindOption = Kind.mission,
    json: JsonOption = False,
) -> None:
    """Read the plan on board and show how the file's plan differs from it, as this vehicle stores items.

    Ends with 0 when nothing differs and with 3 when something does; 1 means that it could not be compared.

    Example: vencejo mission compare mission.waypoints --link tcp:127.0.0.1:5760

    Example: vencejo mission compare field.plan --kind all --json
    """
    from vencejo import Plan

    plan = Plan.load(file)
    with on.vehicle() as vehicle:
        with progress_bar(f"Reading {kind.value}", quiet=json) as bar:
            vehicle.download(kinds=_kinds(kind), progress=bar)
        found = {part: vehicle.compare_plan(plan, kind=part) for part in _kinds(kind)}
        states = {part: vehicle.plan_state(part) for part in found}
    for part, changes in found.items():
        if changes is None and states[part].may_be_mixed:
            raise Failed(f"the {part} on board cannot be compared: {states[part].detail}; upload it again")
        if changes is None:
            raise Failed(f"the {part} on board has changed while it was read; compare it once more")
        if json:
            put_json({"kind": part, "changes": [dataclasses.asdict(change) for change in changes]})
        elif changes:
            for change in changes:
                print(f"{part}: {_change_text(change)}")
        else:
            print(f"{part}: as on board")
    if any(found.values()):
        raise typer.Exit(Exit.DIFFERS)


@mission_app.command()
@grouped
def clear(
    on: OnVehicle,
    kind: KindOption = Kind.mission,
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Remove the mission from the vehicle, after asking.

    Example: vencejo mission clear --link tcp:127.0.0.1:5760 --yes
    """
    with on.vehicle() as vehicle:
        flying = vehicle.telemetry.is_armed is True
        question = f"Remove the {'whole plan' if kind is Kind.all else kind.value} from the vehicle"
        if not confirm(question + (", which is ARMED?" if flying else "?"), yes=yes):
            raise Failed("nothing was removed")
        for part in _kinds(kind):
            vehicle.clear(kind=part, confirm=CLEARS[part])
            if json:
                put_json({"kind": part, "state": vehicle.plan_state(part).state})
            else:
                print(f"{part}: removed")


@mission_app.command()
@grouped
def show(
    on: OnVehicle,
    file: Annotated[
        Path | None, typer.Argument(metavar="FILE", help="A plan file; by default the vehicle's plan.")
    ] = None,
    kind: KindOption = Kind.mission,
    json: JsonOption = False,
) -> None:
    """Show a mission, of a file or on board, as a table, with what the checks find.

    Example: vencejo mission show mission.waypoints

    Example: vencejo mission show --link tcp:127.0.0.1:5760 --kind fence --json
    """
    from vencejo import Plan

    plan = Plan.load(file) if file is not None else _read(on, kind, quiet=json)
    if json:
        put_json(as_json(plan, _kinds(kind)))
        return
    console = stdout()
    for part in _kinds(kind):
        if part == "mission":
            console.print(mission_table(plan))
            if plan.home is not None:
                home = plan.home
                print(f"Planned home: {home.lat_deg:.7f}, {home.lon_deg:.7f}, {home.alt_amsl_m:.1f} m above sea level")
            print(f"{len(plan.items)} items, {distance(plan.length_m)}")
            for finding in plan.check() if plan.items else ():
                print(finding_text(finding))
        else:
            console.print(fence_table(plan) if part == "fence" else rally_table(plan))


def _kinds(kind: Kind) -> list[PlanKind]:
    return ["mission", "fence", "rally"] if kind is Kind.all else [kind.value]


def _read(on: OnVehicle, kind: Kind, *, quiet: bool) -> Plan:
    with (
        on.vehicle() as vehicle,
        progress_bar(f"Reading {kind.value}", quiet=quiet) as bar,
    ):
        return vehicle.download(kinds=_kinds(kind), progress=bar)


def _change_text(change: PlanChange) -> str:
    if change.kind == "added":
        return f"item {change.item} is not on board"
    if change.kind == "removed":
        return f"item {change.on_board} on board is not in the file"
    moved = "" if change.item == change.on_board else f", item {change.on_board} on board"
    return f"item {change.item}{moved} differs: {', '.join(change.fields)}"


def _tell_findings(plan: Plan, findings: tuple[Any, ...], *, json: bool) -> None:
    for finding in findings:
        if json:
            put_json(
                {
                    "finding": finding.code,
                    "severity": finding.severity,
                    "item": finding.item,
                    "figures": dict(finding.figures),
                    "text": finding_text(finding),
                }
            )
        elif finding.severity != "error":
            print(finding_text(finding))  # errors are in the refusal


def count(plan: Plan, kind: PlanKind) -> int:
    """How many items, zones or points a plan holds of a kind."""
    return len({"mission": plan.items, "fence": plan.fence.zones, "rally": plan.rally}[kind])


_NAMES = {"mission": "mission", "fence": "fence", "rally": "rally points", "all": "plan"}


def without(file: Path, plan: Plan, kind: str) -> str:
    """That a file holds nothing of a kind, and how what it does hold is sent."""
    held = [part for part in _kinds(Kind.all) if count(plan, part)]
    ways = "; ".join(f"send its {part} with `vencejo mission upload {file} --kind {part}`" for part in held)
    return f"{file} holds no {_NAMES[kind]}" + (f": {ways}" if ways else "")


FRAMES = {0: "above sea level", 2: "", 3: "above home", 10: "above terrain"}


def mission_table(plan: Plan) -> Any:
    """The items of a mission as a table."""
    shown = table("item", "command", "latitude", "longitude", "altitude", "parameters", right=("item", "altitude"))
    for index, item in enumerate(plan.items, start=1):
        position = item.lat_deg is not None and item.lon_deg is not None
        altitude = "" if item.alt_m is None else f"{item.alt_m:.1f} m {FRAMES.get(item.frame, f'frame {item.frame}')}"
        params = item.params[:4] if item.has_position else item.params
        shown.add_row(
            str(index),
            item.name.removeprefix("MAV_CMD_"),
            f"{item.lat_deg:.7f}" if position else "",
            f"{item.lon_deg:.7f}" if position else "",
            altitude,
            ", ".join(f"{place} = {value:g}" for place, value in enumerate(params, start=1) if value),
        )
    return shown


def fence_table(plan: Plan) -> Any:
    """The zones of a fence as a table."""
    from vencejo import Circle

    shown = table("zone", "shape", "keep", "where", right=("zone",))
    for index, zone in enumerate(plan.fence.zones, start=1):
        points = (zone.center,) if isinstance(zone, Circle) else zone.points
        where = "  ".join(f"{point.lat_deg:.7f}, {point.lon_deg:.7f}" for point in points)
        shape = f"circle of {zone.radius_m:.0f} m" if isinstance(zone, Circle) else f"polygon of {len(points)} corners"
        shown.add_row(str(index), shape, "inside" if zone.inclusion else "outside", where)
    return shown


def rally_table(plan: Plan) -> Any:
    """The rally points as a table."""
    shown = table("point", "latitude", "longitude", "altitude", right=("point", "altitude"))
    for index, point in enumerate(plan.rally, start=1):
        altitude = f"{point.alt_m:.1f} m {FRAMES.get(point.frame, f'frame {point.frame}')}"
        shown.add_row(str(index), f"{point.lat_deg:.7f}", f"{point.lon_deg:.7f}", altitude)
    return shown


def as_json(plan: Plan, kinds: list[PlanKind]) -> dict[str, Any]:
    """A plan as JSON; items count from 1."""
    from vencejo import Circle

    shown: dict[str, Any] = {}
    if "mission" in kinds:
        home = plan.home
        shown["home"] = (
            None if home is None else {"lat_deg": home.lat_deg, "lon_deg": home.lon_deg, "alt_amsl_m": home.alt_amsl_m}
        )
        shown["items"] = [
            {
                "item": index,
                "command": int(item.command),
                "name": item.name,
                "frame": int(item.frame),
                "lat_deg": item.lat_deg,
                "lon_deg": item.lon_deg,
                "alt_m": item.alt_m,
                "params": list(item.params),
                "autocontinue": item.autocontinue,
            }
            for index, item in enumerate(plan.items, start=1)
        ]
        shown["length_m"] = None if plan.length_m is None else round(plan.length_m, 1)
        shown["findings"] = [
            {
                "severity": found.severity,
                "code": found.code,
                "item": found.item,
                "figures": dict(found.figures),
                "message": found.message,
            }
            for found in (plan.check() if plan.items else ())
        ]
    if "fence" in kinds:
        shown["fence"] = [
            {
                "inclusion": zone.inclusion,
                "center": [zone.center.lat_deg, zone.center.lon_deg],
                "radius_m": zone.radius_m,
            }
            if isinstance(zone, Circle)
            else {"inclusion": zone.inclusion, "points": [[point.lat_deg, point.lon_deg] for point in zone.points]}
            for zone in plan.fence.zones
        ]
    if "rally" in kinds:
        shown["rally"] = [
            {"lat_deg": point.lat_deg, "lon_deg": point.lon_deg, "alt_m": point.alt_m, "frame": int(point.frame)}
            for point in plan.rally
        ]
    return shown

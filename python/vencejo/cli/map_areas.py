"""The commands `vencejo maps area …`: maps that are fetched ahead for a field without network."""

from __future__ import annotations

import contextlib
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    YesOption,
    clean,
    confirm,
    progress_bar,
    put_json,
    say,
    status,
    stdout,
    table,
)
from vencejo.cli.landing import place_of
from vencejo.cli.map_service import FolderOption, MapService, StationOption, TokenOption, map_service, opened, quoted

areas_app = typer.Typer(
    no_args_is_help=True,
    help="Download maps in advance, for fields without network.\n\nExample: vencejo maps area list",
)

LOOK_S: Final = 0.5
ZOOMS: Final = "8-17"

SourceArgument = Annotated[str, typer.Argument(metavar="SOURCE", help="Id of a source.")]
AreaArgument = Annotated[
    str, typer.Argument(metavar="AREA", help="Id or name of an area, as `vencejo maps area list` shows them.")
]
AroundOption = Annotated[
    Path | None, typer.Option("--around", metavar="PLAN", help="The surroundings of a .plan or .waypoints file.")
]
BufferOption = Annotated[float, typer.Option("--buffer", metavar="METRES", min=0.0, help="How far around the plan.")]
BoxOption = Annotated[
    str | None,
    typer.Option(
        "--box",
        metavar="W,S,E,N",
        help="Degrees: west, south, east, north; west greater than east: over the date line.",
    ),
]
ZoomOption = Annotated[
    str, typer.Option("--zoom", metavar="FROM-TO", help="Levels of the source's grid; for XYZ the zooms.")
]


@areas_app.command("list")
def list_areas(
    station: StationOption = None, token: TokenOption = None, maps: FolderOption = None, json: JsonOption = False
) -> None:
    """Show the offline areas.

    Example: vencejo maps area list
    """
    with map_service(station, token, maps) as service:
        areas = service.ask("GET", "maps/areas")
    if json:
        put_json(areas)
        return
    shown = table("Id", "Source", "Name", "Zooms", "State", "Tiles", "Fetched", right=("Tiles", "Fetched"))
    for area in areas:
        tiles = f"{area['done']:,} of {area['tiles']:,}"
        zooms = f"{area['min_level']}-{area['max_level']}"
        shown.add_row(area["id"], area["source"], clean(area["name"]), zooms, area["state"], tiles, size(area["bytes"]))
    stdout().print(shown)


@areas_app.command()
def estimate(
    source: SourceArgument,
    around: AroundOption = None,
    buffer: BufferOption = 500.0,
    box: BoxOption = None,
    zoom: ZoomOption = ZOOMS,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Say how many tiles and bytes an area would be.

    Example: vencejo maps area estimate pnoa --around field.plan --buffer 1000 --zoom 10-17
    """
    with map_service(station, token, maps) as service:
        found = service.ask("POST", "maps/areas/estimate", _wanted(source, "estimate", around, buffer, box, zoom))
    if json:
        put_json(found)
    else:
        print(_estimated(found))
    if found["refused"]:
        raise Failed(found["refused"])


@areas_app.command()
def download(
    source: SourceArgument,
    name: Annotated[str, typer.Option("--name", metavar="NAME", help="Name of the area.")],
    around: AroundOption = None,
    buffer: BufferOption = 500.0,
    box: BoxOption = None,
    zoom: ZoomOption = ZOOMS,
    yes: YesOption = False,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Fetch an area. Ctrl-C pauses it; `vencejo maps area resume` goes on.

    Example: vencejo maps area download pnoa --name Field --around field.plan --buffer 1000 --zoom 10-17 --yes

    Example: vencejo maps area download ign-base --name Valley --box -4.1,40.2,-3.9,40.4
    """
    wanted = _wanted(source, name, around, buffer, box, zoom)
    with map_service(station, token, maps) as service:
        found = service.ask("POST", "maps/areas/estimate", wanted)
        if found["refused"]:
            raise Failed(found["refused"])
        say(_estimated(found))
        if not confirm("Fetch it?", yes=yes):
            raise typer.Exit(Exit.FAILED)
        _follow(service, "maps/areas", wanted, json=json)


@areas_app.command()
def resume(
    area: AreaArgument,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Go on with an area, and try again what failed. Ctrl-C pauses it.

    Example: vencejo maps area resume Field
    """
    with map_service(station, token, maps) as service:
        found = _find(service, area)
        _follow(service, f"maps/areas/{found['id']}/resume", json=json)


@areas_app.command()
def pause(
    area: AreaArgument,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
) -> None:
    """Pause the download of an area, in whichever process, until it is resumed.

    Example: vencejo maps area pause Field --station http://192.168.1.20:8765
    """
    with map_service(station, token, maps) as service:
        found = service.ask("POST", f"maps/areas/{_find(service, area)['id']}/pause")
    say(f"{clean(found['name'])}: {found['state']}, {found['done']:,} of {found['tiles']:,} tiles are here")


@areas_app.command()
def remove(
    area: AreaArgument,
    yes: YesOption = False,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
) -> None:
    """Remove an area; its tiles may then be forgotten like others.

    Example: vencejo maps area remove Field --yes
    """
    with map_service(station, token, maps) as service:
        found = _find(service, area)
        if not confirm(f"Remove the area '{clean(found['name'])}' of {found['source']}?", yes=yes):
            raise typer.Exit(Exit.FAILED)
        service.ask("DELETE", f"maps/areas/{found['id']}")
    say(f"Removed {clean(found['name'])}")


@areas_app.command()
def export(
    area: AreaArgument,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The MBTiles file to write.")],
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Write what is here of an area to an MBTiles file, for another station or program.

    Example: vencejo maps area export Field field.mbtiles
    """
    with map_service(station, token, maps) as service:
        found = _find(service, area)
        with status(f"Writing {file} …"):
            count = service.save(f"maps/areas/{found['id']}/export", file)
    if json:
        put_json({"file": str(file), "bytes": count, "tiles": found["done"]})
    else:
        say(f"Wrote {file}, {size(count)}")


@areas_app.command("import")
def import_area(
    source: SourceArgument,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="An MBTiles file that was exported from the same source.")
    ],
    name: Annotated[
        str | None, typer.Option("--name", metavar="NAME", help="Name of the area; by default as in the file.")
    ] = None,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Take the tiles of a file into a source, as an area that is done.

    Example: vencejo maps area import pnoa field.mbtiles
    """
    with map_service(station, token, maps) as service, opened(file) as source_file, status(f"Reading {file} …"):
        taken = service.send_file(f"maps/areas/import?source={quoted(source)}&name={quoted(name or '')}", source_file)
    if json:
        put_json(taken)
    else:
        say(f"{clean(taken['name'])}: {taken['done']:,} tiles")


def size(count: int) -> str:
    """Bytes for people: decimal, as disks are sold."""
    for unit, digits in (("B", 0), ("kB", 0), ("MB", 1)):
        if count < 1000 ** ({"B": 1, "kB": 2, "MB": 3}[unit]):
            return f"{count / 1000 ** ({'B': 0, 'kB': 1, 'MB': 2}[unit]):.{digits}f} {unit}"
    return f"{count / 1e9:.2f} GB"


def _wanted(source: str, name: str, around: Path | None, buffer_m: float, box: str | None, zoom: str) -> dict[str, Any]:
    """An area as the station takes it."""
    low, found, high = zoom.partition("-")
    if not (low.isdecimal() and (high.isdecimal() or not found)):
        raise Failed(f"--zoom {zoom}: takes one level or two, such as 10-17", Exit.USAGE)
    if (around is None) == (box is None):
        raise Failed("where? give --around with a plan's file, or --box", Exit.USAGE)
    shape: dict[str, Any]
    if around is not None:
        from vencejo import Plan

        plan = Plan.load(around)
        points = [] if plan.home is None else [{"lat_deg": plan.home.lat_deg, "lon_deg": plan.home.lon_deg}]
        places = (place_of(item) for item in plan.items)
        points += [{"lat_deg": place.lat_deg, "lon_deg": place.lon_deg} for place in places if place is not None]
        if not points:
            raise Failed(f"{around} has no position")
        shape = {"kind": "route", "points": points, "buffer_m": buffer_m}
    else:
        assert box is not None
        try:
            west, south, east, north = (float(number) for number in box.split(","))
        except ValueError:
            raise Failed(f"--box {box}: takes four numbers: west,south,east,north", Exit.USAGE) from None
        shape = {"kind": "box", "west_deg": west, "south_deg": south, "east_deg": east, "north_deg": north}
    levels = {"min_level": int(low), "max_level": int(high or low)}
    return {"source": source, "name": name, "shape": shape, **levels}


def _estimated(found: dict[str, Any]) -> str:
    """What an area would take, in a line."""
    measured = "" if found["tile_bytes_measured"] else ", reckoned by usual tiles"
    return f"{found['tiles']:,} tiles, {found['have']:,} of them here; about {size(found['bytes'])} to fetch{measured}"


def _find(service: MapService, wanted: str) -> dict[str, Any]:
    """The area of an id or a name."""
    areas = service.ask("GET", "maps/areas")
    found: list[dict[str, Any]] = [area for area in areas if wanted in (area["id"], area["name"])]
    if not found:
        raise Failed(f"there is no offline area '{wanted}'; vencejo maps area list shows them")
    if len(found) > 1:
        raise Failed(f"{len(found)} areas are called '{wanted}': take one by its id", Exit.USAGE)
    return found[0]


@contextlib.contextmanager
def _interrupt_kept() -> Iterator[list[int]]:
    """Keep a Ctrl-C until what is begun here can be named."""
    kept: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: kept.append(number))
    try:
        yield kept
    finally:
        signal.signal(signal.SIGINT, before)


def _follow(service: MapService, path: str, wanted: dict[str, Any] | None = None, *, json: bool) -> None:
    """Begin to fetch an area, and show how it comes, until it is here. Ctrl-C pauses it."""
    told: str | None = None
    with _interrupt_kept() as interrupted:
        area = service.ask("POST", path, wanted)
    try:
        if interrupted:
            raise KeyboardInterrupt
        with progress_bar(clean(area["name"]), quiet=json) as progress:
            while area["state"] == "running":
                progress(area["done"] + area["failed"], area["tiles"])
                if area["detail"] and area["detail"] != told:
                    told = area["detail"]
                    say(clean(told))
                time.sleep(LOOK_S)
                area = service.ask("GET", f"maps/areas/{area['id']}")
    except KeyboardInterrupt:
        area = service.ask("POST", f"maps/areas/{area['id']}/pause")
        say(
            f"Paused: {area['done']:,} of {area['tiles']:,} tiles are here. Go on with: vencejo maps area resume {area['id']}"
        )
        raise
    if json:
        put_json(area)
    else:
        say(
            f"{clean(area['name'])}: {area['state']}, {area['done']:,} of {area['tiles']:,} tiles are here, {size(area['bytes'])}"
        )
    if area["state"] != "done" or area["failed"]:
        raise Failed(area["detail"] or f"the area is {area['state']}")

"""The commands `vencejo maps …`: map sources and their cache, of this machine or of a station that runs."""

from __future__ import annotations

import enum
import json as json_module
import time
import urllib.parse
from pathlib import Path
from typing import Annotated, Any

import typer

from vencejo.cli.common import Exit, Failed, JsonOption, YesOption, clean, confirm, put_json, say, status, stdout, table
from vencejo.cli.map_areas import areas_app, size
from vencejo.cli.map_service import FolderOption, MapService, StationOption, TokenOption, map_service, opened, quoted

maps_app = typer.Typer(
    no_args_is_help=True,
    help="Map sources, their cache, and areas for fields without network.\n\nWithout --station the maps folder of this machine "
    "is opened, which a station that runs here may use at the same time.\n\nExample: vencejo maps list",
)
maps_app.add_typer(areas_app, name="area")

LocalNetworkOption = Annotated[
    bool, typer.Option("--local-network", help="The service is on this machine or in its network.")
]
IdArgument = Annotated[str, typer.Argument(metavar="ID", help="Id of a source, as `vencejo maps list` shows them.")]


class Kind(str, enum.Enum):
    """How a service is asked."""

    xyz = "xyz"
    wms = "wms"
    wmts = "wmts"
    geotiff = "geotiff"


@maps_app.command("list")
def list_sources(
    station: StationOption = None, token: TokenOption = None, maps: FolderOption = None, json: JsonOption = False
) -> None:
    """Show the sources: how they fare, and what is kept of them.

    Example: vencejo maps list

    Example: vencejo maps list --station http://192.168.1.20:8765 --json
    """
    with map_service(station, token, maps) as service:
        listed = service.ask("GET", "maps/sources")
    if json:
        put_json(listed)
        return
    shown = table("Id", "Name", "Kind", "Role", "State", "Kept", "Offline areas", right=("Kept",))
    for source in listed["sources"]:
        cache = source["state"]["cache"]
        shown.add_row(
            source["id"],
            clean(source["name"]),
            source["kind"],
            source["role"],
            source["state"]["status"],
            "–" if cache is None else size(cache["bytes"]),
            "yes" if source["offline"]["allowed"] else "no",
        )
    stdout().print(shown)
    if listed["file"]:
        say(f"Their file: {listed['file']}")
    if listed["file_error"]:
        say(f"The file is wrong, the last right one is in use: {listed['file_error']}")


@maps_app.command()
def presets(
    station: StationOption = None, token: TokenOption = None, maps: FolderOption = None, json: JsonOption = False
) -> None:
    """Show well-known sources with their terms; `vencejo maps add` takes their ids.

    Example: vencejo maps presets
    """
    with map_service(station, token, maps) as service:
        found = service.ask("GET", "maps/presets")
    if json:
        put_json(found)
        return
    for preset in found:
        key = " (needs your key)" if preset["needs_key"] else ""
        print(
            f"{preset['id']}: {preset['name']}{key}\n  {preset['description']}\n  {preset['terms_url'] or ''}".rstrip()
        )


@maps_app.command()
def layers(
    url: Annotated[str, typer.Argument(metavar="URL", help="Address of a WMS or WMTS.")],
    wmts: Annotated[bool, typer.Option("--wmts", help="It is a WMTS.")] = False,
    key: Annotated[str | None, typer.Option("--key", help="Your key, where the address has {key}.")] = None,
    local_network: LocalNetworkOption = False,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Ask a map service which layers it has.

    Example: vencejo maps layers https://www.ign.es/wms-inspire/pnoa-ma
    """
    asked = {"kind": "wmts" if wmts else "wms", "url": url, "key": key, "local_network": local_network}
    with map_service(station, token, maps) as service, status(f"Asking {urllib.parse.urlsplit(url).netloc} …"):
        said = service.ask("POST", "maps/capabilities", asked)
    if json:
        put_json(said)
        return
    print(clean(f"{said['title'] or url} ({said['kind'].upper()} {said['version']}); {', '.join(said['formats'])}"))
    for what in ("fees", "access_constraints"):
        if said[what]:
            print(clean(f"{what.replace('_', ' ')}: {said[what]}"))
    shown = table("Layer", "Title", "Systems")
    for layer in said["layers"]:
        if layer["name"]:
            systems = layer.get("crs") or []
            more = f" and {len(systems) - 6} more" if len(systems) > 6 else ""
            shown.add_row(clean(layer["name"]), clean(layer["title"] or ""), ", ".join(systems[:6]) + more)
    stdout().print(shown)


@maps_app.command()
def add(
    what: Annotated[
        str,
        typer.Argument(
            metavar="WHAT",
            help="A preset's id, a file (MBTiles, PMTiles, GeoTIFF, elevations), a name in the maps folder, or an address.",
        ),
    ],
    kind: Annotated[
        Kind | None, typer.Option("--kind", help="Kind of an address; by default recognised by its form.")
    ] = None,
    id: Annotated[
        str | None, typer.Option("--id", metavar="ID", help="Id of the source; by default made from its name.")
    ] = None,
    name: Annotated[str | None, typer.Option("--name", metavar="NAME", help="Display name.")] = None,
    layer: Annotated[
        list[str] | None, typer.Option("--layer", metavar="NAME", help="Layer of a WMS or WMTS; repeatable for WMS.")
    ] = None,
    key: Annotated[str | None, typer.Option("--key", metavar="KEY", help="Your key for the service.")] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="FIELD=VALUE",
            help="Any other field of a source, such as max_zoom=18 or crs=EPSG:25830; repeatable.",
        ),
    ] = None,
    overlay: Annotated[bool, typer.Option("--overlay", help="Show it over the base map.")] = False,
    local_network: LocalNetworkOption = False,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Add a source, and try it. Ends with 1 when that failed; the source is kept.

    A file is copied into the maps folder. What a source of the same id was before is replaced; its key stays.

    Example: vencejo maps add field.mbtiles

    Example: vencejo maps add google-satellite --key MYKEY

    Example: vencejo maps add https://tiles.example.org/{z}/{x}/{y}.png --name Club

    Example: vencejo maps add https://www.ign.es/wms-inspire/pnoa-ma --layer OI.OrthoimageCoverage --set crs=EPSG:4326

    Example: vencejo maps add https://files.example.org/ortho.tif --overlay
    """
    with map_service(station, token, maps) as service:
        settings = _settings(service, what, kind, name, layer or [])
        if name is not None:
            settings["name"] = name
        if overlay:
            settings["role"] = "overlay"
        if local_network:
            settings["local_network"] = True
        if key is not None:
            settings["key"] = key
        settings.update(_fields(set_ or []))
        if id is not None:
            settings["id"] = id
        service.ask("PUT", f"maps/sources/{quoted(settings['id'])}", settings)
        with status(f"Trying {settings['id']} …"):
            result = _try(service, settings["id"])
    if json:
        put_json(result)
    else:
        print(_tried(result))
    if not result["ok"]:
        raise typer.Exit(Exit.FAILED)


@maps_app.command()
def remove(
    id: IdArgument,
    cache: Annotated[bool, typer.Option("--cache", help="Remove its cache too, offline areas included.")] = False,
    yes: YesOption = False,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
) -> None:
    """Remove a source. Its cache stays for when it is added again, unless --cache is given.

    Example: vencejo maps remove club --yes
    """
    with map_service(station, token, maps) as service:
        what = f"Remove the map source '{id}'" + (" with all that is kept of it" if cache else "")
        if not confirm(f"{what}?", yes=yes):
            raise typer.Exit(Exit.FAILED)
        service.ask("DELETE", f"maps/sources/{quoted(id)}?cache={'true' if cache else 'false'}")
    say(f"Removed {id}")


@maps_app.command("test")
def try_sources(
    ids: Annotated[list[str] | None, typer.Argument(metavar="[ID…]", help="Which ones; by default all.")] = None,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
    json: JsonOption = False,
) -> None:
    """Fetch one tile of each source, past its cache, and say what came.

    Before a flight this tells which maps there will be. Ends with 1 when one of them failed.

    Example: vencejo maps test pnoa

    Example: vencejo maps test --json
    """
    with map_service(station, token, maps) as service:
        known = [source["id"] for source in service.ask("GET", "maps/sources")["sources"]]
        results = []
        for each in ids or known:
            if each not in known:
                raise Failed(f"there is no map source '{each}'; vencejo maps list shows them", Exit.USAGE)
            with status(f"Trying {each} …"):
                results.append(_try(service, each))
            if not json:
                print(_tried(results[-1]), flush=True)
    if json:
        put_json(results)
    if not all(result["ok"] for result in results):
        raise typer.Exit(Exit.FAILED)


@maps_app.command()
def cache(
    station: StationOption = None, token: TokenOption = None, maps: FolderOption = None, json: JsonOption = False
) -> None:
    """Show how much is kept of each source.

    Example: vencejo maps cache
    """
    with map_service(station, token, maps) as service:
        listed = service.ask("GET", "maps/sources")["sources"]
    caches = {source["id"]: source["state"]["cache"] for source in listed if source["state"]["cache"] is not None}
    if json:
        put_json(caches)
        return
    shown = table("Source", "Tiles", "Of areas", "Size", "At most", right=("Tiles", "Of areas", "Size", "At most"))
    for source, fill in caches.items():
        tiles, pinned = f"{fill['tiles']:,}", f"{fill['pinned_tiles']:,}"
        shown.add_row(source, tiles, pinned, size(fill["bytes"]), size(fill["max_bytes"]))
    stdout().print(shown)
    say(f"Together {size(sum(fill['bytes'] for fill in caches.values()))}")


@maps_app.command()
def clear(
    id: IdArgument,
    yes: YesOption = False,
    station: StationOption = None,
    token: TokenOption = None,
    maps: FolderOption = None,
) -> None:
    """Forget what is kept of a source, but for its offline areas.

    Example: vencejo maps clear pnoa --yes
    """
    with map_service(station, token, maps) as service:
        if not confirm(f"Forget what is kept of '{id}'? Without network it will be missing.", yes=yes):
            raise typer.Exit(Exit.FAILED)
        service.ask("DELETE", f"maps/sources/{quoted(id)}/cache")
    say(f"Cleared {id}")


def _settings(service: MapService, what: str, kind: Kind | None, name: str | None, layers: list[str]) -> dict[str, Any]:
    """Settings of a preset, a file or an address."""
    if what.startswith(("http://", "https://")):
        return _of_address(what, kind or _kind_of(what), name, layers)
    preset = next((found for found in service.ask("GET", "maps/presets") if found["id"] == what), None)
    if preset is not None:
        return dict(preset["settings"])
    if not what.strip():
        raise Failed("what is to be added? a preset (vencejo maps presets), a file or an address", Exit.USAGE)
    path = Path(what)
    kinds = service.ask("GET", "maps/kinds")
    there = next((file for file in service.ask("GET", "maps/files") if file["path"] in (what, f"files/{what}")), None)
    if there is not None and there["kind"] is not None:
        role = next(known["roles"][0] for known in kinds if known["kind"] == there["kind"])
        shown = name or Path(there["path"]).stem
        return {"id": _id(shown), "name": shown, "kind": there["kind"], "role": role, "path": there["path"]}
    if path.is_dir():
        folder = Path(service.ask("GET", "maps/config")["folder"]) / "files"
        raise Failed(
            f"{what} is a folder: copy it into {folder} on the station's machine, then vencejo maps add {path.name}",
            Exit.USAGE,
        )
    ends = [end for known in kinds for end in known["file_ends"]]
    if not path.name.lower().endswith(tuple(ends)):
        raise Failed(
            f"{what} is no preset, no address and no file of a kind that is known ({', '.join(ends)})", Exit.USAGE
        )
    with opened(path) as file, status(f"Copying {path.name} …"):
        return dict(service.send_file(f"maps/files?name={quoted(path.name)}", file)["settings"])


def _kind_of(url: str) -> Kind:
    """What an address is by its form."""
    low = url.lower()
    if "{x}" in low or "{q}" in low:
        return Kind.xyz
    if urllib.parse.urlsplit(low).path.endswith((".tif", ".tiff")):
        return Kind.geotiff
    return Kind.wmts if "wmts" in low else Kind.wms


def _of_address(url: str, kind: Kind, name: str | None, layers: list[str]) -> dict[str, Any]:
    parts = urllib.parse.urlsplit(url)
    shown = name or (Path(parts.path).stem if kind is Kind.geotiff else parts.hostname) or "map"
    settings: dict[str, Any] = {"id": _id(shown), "name": shown, "kind": kind.value, "url": url}
    if kind is Kind.geotiff:
        settings["role"] = "overlay"
    if kind in (Kind.wms, Kind.wmts) and not layers:
        raise Failed(f"which layer? `vencejo maps layers {url}` lists them; give one with --layer", Exit.USAGE)
    if kind is Kind.wms:
        settings["layers"] = layers
    if kind is Kind.wmts:
        settings["layer"] = layers[0]
    return settings


def _id(name: str) -> str:
    """An id made of a name."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "-" for c in name.lower())
    return plain.strip("-")[:40] or "map"


def _fields(pairs: list[str]) -> dict[str, Any]:
    """Fields given as FIELD=VALUE: numbers, true, false and JSON are what they say, everything else is text."""
    fields = {}
    for pair in pairs:
        name, found, text = pair.partition("=")
        if not found or not name:
            raise Failed(f"--set {pair}: takes FIELD=VALUE, such as max_zoom=18", Exit.USAGE)
        try:
            fields[name] = json_module.loads(text)
        except ValueError:
            fields[name] = text
    return fields


def _try(service: MapService, id: str) -> dict[str, Any]:
    """Fetch one tile past the cache, and look at it."""
    began = time.monotonic()
    state = service.ask("POST", f"maps/sources/{quoted(id)}/check")
    took_s = time.monotonic() - began
    source = next(each for each in service.ask("GET", "maps/sources")["sources"] if each["id"] == id)
    result: dict[str, Any] = {
        "id": id,
        "ok": state["status"] in ("ok", "unused"),
        "status": state["status"],
        "reason": state["detail"],
        "took_s": round(took_s, 3),
        "tile": None,
        "type": None,
        "bytes": None,
    }
    tile = None if source["grid"] is None else _middle(source["grid"])
    if result["ok"] and tile is not None:
        try:
            address = source["tiles_url"]
            for place, number in zip(("{z}", "{x}", "{y}"), tile, strict=True):
                address = address.replace(place, str(number))
            answer = service.request("GET", address)
        except Failed as error:
            result["reason"] = str(error)
        else:
            result.update(tile="/".join(map(str, tile)), type=answer.kind, bytes=len(answer.body))
    return result


def _middle(grid: dict[str, Any]) -> tuple[int, int, int] | None:
    """The tile in the middle of a grid, on its middle level: the one that the station's own check asks for."""
    number = (grid["min_level"] + grid["max_level"]) // 2
    level = grid["levels"][number]
    if grid["extent"] is None:
        return None if level["size"] is None else (number, level["size"][0] // 2, level["size"][1] // 2)
    left, bottom, right, top = grid["extent"]
    step = [level["resolution"] * px for px in level["tile_px"]]
    column = int(((left + right) / 2 - level["origin"][0]) // step[0])
    row = int((level["origin"][1] - (bottom + top) / 2) // step[1])
    return (number, max(0, column), max(0, row))


def _tried(result: dict[str, Any]) -> str:
    """One line about a source that was tried."""
    if not result["ok"]:
        return clean(f"{result['id']}: {result['status']}: {result['reason'] or 'no reason known'}")
    if result["bytes"] is None:
        return clean(f"{result['id']}: ok" + (f", {result['reason']}" if result["reason"] else ""))
    return f"{result['id']}: ok, tile {result['tile']}, {result['type']}, {size(result['bytes'])}, {result['took_s']:.2f} s"

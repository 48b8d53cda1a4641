"""Histories of a fleet's aircraft: `vencejo fleet history`, and what `vencejo replay` tells of such a file."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vencejo.cli.common import Exit, Failed, JsonOption, duration, put_json, say, size, stdout, table

if TYPE_CHECKING:
    from vencejo.history import Contents, Kept

MAX_GAPS: Final = 20
"""Gaps of one aircraft that are shown."""


def fleet_history(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="One aircraft; by default all.")] = None,
    folder: Annotated[
        Path | None,
        typer.Option("--folder", metavar="DIR", help="Folder of the files; by default in the data folder."),
    ] = None,
    json: JsonOption = False,
) -> None:
    """List what is kept of each aircraft, and which gaps there are.

    On the ground it is what was heard, and what was fetched after a cut; on board, what was told and ordered there.

    Example: vencejo fleet history

    Example: vencejo fleet history plane7 --json
    """
    from vencejo.history import kept

    if folder is not None and not folder.is_dir():
        raise Failed(f"--folder {folder} is not a folder", Exit.USAGE)
    found = [each for each in kept(folder) if name in (None, each.name)]
    if name is not None and not found:
        raise Failed(f"nothing is kept here of an aircraft {name}; see: vencejo fleet history")
    if json:
        put_json([_as_json(each) for each in found])
        return
    if not found:
        say("Nothing is kept yet: `vencejo serve --fleet` and `vencejo onboard` do.")
        return
    shown = table("aircraft", "files", "size", "states", "events", "orders", "missing", "lost", right=("files", "size"))
    for each in found:
        missing = sum(gap.last - gap.first + 1 for gap in each.gaps if not gap.is_lost)
        lost = sum(gap.last - gap.first + 1 for gap in each.gaps if gap.is_lost)
        counts = [str(each.records.get(stream, "–")) for stream in ("state", "event", "audit")]
        shown.add_row(each.name, str(len(each.files)), size(each.bytes), *counts, str(missing), str(lost))
    stdout().print(shown)
    for each in found:
        for gap in each.gaps[:MAX_GAPS]:
            what = "not to be had any more" if gap.is_lost else "fetched when the aircraft is there"
            print(f"{each.name}, boot {gap.boot}: {gap.stream} {gap.first} to {gap.last}: {what}")
        if len(each.gaps) > MAX_GAPS:
            print(f"{each.name}: {len(each.gaps) - MAX_GAPS} gaps more; see --json")
        if name is not None:
            for path in each.files:
                print(path)


def _as_json(each: Kept) -> dict[str, Any]:
    return {**asdict(each), "folder": str(each.folder), "files": [str(path) for path in each.files]}


def tell_history(file: Path, *, json: bool) -> None:
    """Tell what is in a history file."""
    from vencejo.history import contents

    found = contents(file)
    if not found.streams:
        raise Failed(f"{file} holds no record of an aircraft")
    if json:
        put_json({**asdict(found), "start": None if found.start is None else found.start.isoformat()})
    else:
        _print(file, found)


def _print(file: Path, found: Contents) -> None:
    begins = "" if found.start is None else f", from {found.start:%Y-%m-%d %H:%M:%S} UTC"
    print(
        f"{file}: {found.aircraft or 'an aircraft'}, {size(file.stat().st_size)}, {duration(found.duration_s)}{begins}"
    )
    if found.skipped_bytes:
        print(f"{found.skipped_bytes} bytes are damaged or no whole record and were skipped")
    shown = table("boot", "stream", "records", "from", "to", "missing", right=("records", "from", "to", "missing"))
    for each in found.streams:
        first, last = each.ranges[0][0], each.ranges[-1][1]
        shown.add_row(f"{each.boot:016x}", each.stream, str(each.count), str(first), str(last), str(each.missing))
    stdout().print(shown)

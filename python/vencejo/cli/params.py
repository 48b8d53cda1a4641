"""The commands `vencejo params …`: read and write the vehicle's parameters, one by one or as a file."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from vencejo.cli.common import (
    Failed,
    JsonOption,
    YesOption,
    confirm,
    grouped,
    progress_bar,
    put_json,
    say,
    stdout,
    table,
)
from vencejo.cli.connecting import OnVehicle

if TYPE_CHECKING:
    from vencejo.values import Parameter
    from vencejo.vehicle import Danger, Vehicle

params_app = typer.Typer(
    no_args_is_help=True,
    help="Read and write the vehicle's parameters.\n\nExample: vencejo params get WP_RADIUS AIRSPEED_CRUISE",
)


@params_app.command()
@grouped
def get(
    on: OnVehicle,
    names: Annotated[list[str], typer.Argument(metavar="NAME…", help="Names of parameters.")],
    json: JsonOption = False,
) -> None:
    """Read some parameters.

    Example: vencejo params get WP_RADIUS AIRSPEED_CRUISE

    Example: vencejo params get RTL_AUTOLAND --json --link tcp:127.0.0.1:5760
    """
    with on.vehicle() as vehicle:
        found = [vehicle.params.get(name.upper()) for name in names]
    if json:
        put_json({parameter.name: number(parameter) for parameter in found})
        return
    for parameter in found:
        print(f"{parameter.name} {text(parameter.value)}")


class Declined(Failed):
    """Whoever was asked did not want a parameter to be written."""


def write(vehicle: Vehicle, name: str, value: float, *, yes: bool) -> Parameter:
    """Write a parameter; when that is dangerous, after asking."""
    from vencejo import ConfirmationNeeded

    try:
        return vehicle.params.set(name, value)
    except ConfirmationNeeded as needed:
        danger = cast("Danger", needed.act)
        if not confirm(f"{name} = {text(value)} is dangerous ({danger}). Write it?", yes=yes):
            raise Declined(f"{name} was not written") from needed
    return vehicle.params.set(name, value, confirm=danger)


@params_app.command("set", context_settings={"ignore_unknown_options": True})
@grouped
def set_(
    on: OnVehicle,
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the parameter.")],
    value: Annotated[float, typer.Argument(metavar="VALUE", help="Its new value.")],
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Write one parameter and show what the vehicle has then. It asks before dangerous changes, such as switching the fence off.

    Example: vencejo params set WP_RADIUS 40

    Example: vencejo params set LAND_PITCH_DEG -1 --link tcp:127.0.0.1:5760
    """
    with on.vehicle() as vehicle:
        before = vehicle.params.get(name.upper())
        after = write(vehicle, before.name, value, yes=yes)
    if json:
        put_json({"name": after.name, "before": number(before), "after": number(after)})
    else:
        print(f"{after.name} {text(before.value)} → {text(after.value)}")


@params_app.command("list")
@grouped
def list_(
    on: OnVehicle,
    pattern: Annotated[str, typer.Argument(metavar="PATTERN", help="A name, in which * stands for anything.")] = "*",
    json: JsonOption = False,
) -> None:
    """List the parameters.

    Example: vencejo params list 'LAND_*'
    """
    with on.vehicle() as vehicle:
        found = read_all(vehicle, quiet=json)
    chosen = {name: found[name] for name in sorted(found) if fnmatch.fnmatchcase(name, pattern.upper())}
    if not chosen:
        raise Failed(f"none of the vehicle's {len(found)} parameters is named like {pattern}")
    if json:
        put_json({name: number(parameter) for name, parameter in chosen.items()})
        return
    for name, parameter in chosen.items():
        print(f"{name} {text(parameter.value)}")


@params_app.command()
@grouped
def save(
    on: OnVehicle,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write: .param.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
    json: JsonOption = False,
) -> None:
    """Save all parameters to a file.

    Example: vencejo params save bixler.param
    """
    from vencejo import save_params

    if file.exists() and not force:
        raise Failed(f"{file} exists; add --force to overwrite it")
    if not file.resolve().parent.is_dir():
        raise Failed(f"{file}: there is no folder {file.resolve().parent}")
    with on.vehicle() as vehicle:
        found = read_all(vehicle, quiet=json)
    save_params(file, found)
    if json:
        put_json({"file": str(file), "count": len(found)})
    else:
        print(f"{file}: {len(found)} parameters")


@params_app.command()
@grouped
def load(
    on: OnVehicle,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A .param, .parm or .params file.")],
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Write the parameters of a file that differ, after showing the differences and asking.

    Parameters that the vehicle does not have are told and left out; what it counts or measures by itself (STAT_…, the
    pressure on the ground) is left out too. A parameter that enables others may need a reboot and a second load.

    Example: vencejo params load bixler.param --link /dev/ttyACM0,115200
    """
    from vencejo import load_params

    wanted = load_params(file)
    with on.vehicle() as vehicle:
        changes, unknown = compare(wanted, read_all(vehicle, quiet=json))
        if unknown:
            say(f"Not on this vehicle, left out: {', '.join(unknown)}")
        if not changes:
            _tell_load(file, Written(), json=json)
            return
        if not json:
            stdout().print(changes_table(changes))
        question = f"Write {len(changes)} parameter{'s' if len(changes) > 1 else ''}"
        if not confirm(question + (" to the vehicle, which is ARMED?" if vehicle.telemetry.is_armed else "?"), yes=yes):
            raise Failed("nothing was written")
        refused = write_all(vehicle, file, changes, yes=yes, json=json)
    if refused:
        raise Failed(f"{len(refused)} of {len(changes)} parameters were not written: {', '.join(refused)}")


@dataclass
class Written:
    """What became of the parameters of a file."""

    written: int = 0
    refused: list[str] = field(default_factory=list)
    """Refused by the vehicle, or by the person who was asked."""
    unknown: str | None = None
    """Which one was being written when something ended it."""
    untried: list[str] = field(default_factory=list)


def write_all(vehicle: Vehicle, file: Path, changes: list[Change], *, yes: bool, json: bool) -> list[str]:
    """Write the changes and report each result, also when interrupted; returns the refused ones."""
    from vencejo import ParameterError

    done = Written(untried=[change.name for change in changes])
    try:
        with progress_bar("Writing parameters", quiet=json) as bar:
            for count, change in enumerate(changes, start=1):
                done.unknown = done.untried.pop(0)
                try:
                    write(vehicle, change.name, change.wanted, yes=yes)
                    done.written += 1
                except (Declined, ParameterError) as error:
                    done.refused.append(change.name)
                    say(str(error))
                done.unknown = None
                bar(count, len(changes))
    finally:
        _tell_load(file, done, json=json)
    return done.refused


def _tell_load(file: Path, done: Written, *, json: bool) -> None:
    if done.unknown is not None:
        say(f"It ended while {done.unknown} was being written: whether the vehicle has it is not known.")
    if done.untried:
        say(f"Not tried: {', '.join(done.untried)}")
    if json:
        put_json({"file": str(file), **asdict(done)})
    elif done == Written():
        print(f"{file}: the vehicle has these values already")
    else:
        print(f"{file}: {done.written} parameters written")


@dataclass(frozen=True)
class Change:
    """A parameter that a file would change."""

    name: str
    present: float
    wanted: float


def compare(wanted: Mapping[str, float], present: Mapping[str, Parameter]) -> tuple[list[Change], list[str]]:
    """What a file would change, and the names that the vehicle does not have."""
    from vencejo.params import differing

    changes, unknown = differing(wanted, present)
    return [Change(name, present[name].value, value) for name, value in changes.items()], list(unknown)


def changes_table(changes: list[Change]) -> object:
    """The changes as a table."""
    shown = table("parameter", "on the vehicle", "in the file", right=("on the vehicle", "in the file"))
    for change in changes:
        shown.add_row(change.name, text(change.present), text(change.wanted))
    return shown


def read_all(vehicle: Vehicle, *, quiet: bool) -> dict[str, Parameter]:
    """Read all parameters with a progress bar."""
    with progress_bar("Reading parameters", quiet=quiet) as bar:
        return vehicle.params.all(progress=bar)


def text(value: float) -> str:
    """A value with the digits that a 32-bit float holds."""
    return f"{value:.7g}"


def number(parameter: Parameter) -> float | int | None:
    """A value for JSON: an integer parameter as an integer, what is not finite as null."""
    if not math.isfinite(parameter.value):
        return None
    return parameter.value if parameter.type in (9, 10) else int(parameter.value)

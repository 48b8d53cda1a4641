"""The command `vencejo telemetry`: what the vehicle says, on the screen or as JSON lines."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    ForwardOption,
    JsonOption,
    RecordOption,
    clean,
    grouped,
    put_json,
    stdout,
)
from vencejo.cli.connecting import OnVehicle

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import RenderableType

    from vencejo.telemetry import Telemetry
    from vencejo.vehicle import Vehicle


@grouped
def telemetry(
    on: OnVehicle,
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", min=0.1, max=50.0, help="Samples per second.")] = 5.0,
    once: Annotated[
        bool, typer.Option("--once", help="Show one sample as soon as all groups have been received.")
    ] = False,
    groups: Annotated[
        str | None,
        typer.Option("--groups", metavar="NAMES", help="Only these groups, such as attitude,position,battery."),
    ] = None,
    json: JsonOption = False,
    record: RecordOption = True,
    forward: ForwardOption = None,
) -> None:
    """Show the vehicle's telemetry, until Ctrl-C.

    With --json one object is written per line and sample; a value that is not known is null, and every group has its
    age. Nothing is recorded with --once.

    Example: vencejo telemetry --link tcp:127.0.0.1:5760

    Example: vencejo telemetry --once --json --groups position,battery
    """
    names = parse_groups(groups)
    with on.vehicle(
        rate_hz=min(50.0, max(4.0, rate)),
        record=record and not once,
        forward=forward,
    ) as vehicle:
        if once:
            show(vehicle, wait_for(vehicle, names, on.timeout), names, json=json)
        elif json:
            for sample in samples(vehicle, rate):
                put_json(as_json(vehicle, sample, names))
        else:
            _watch(vehicle, rate, names)


def parse_groups(text: str | None) -> tuple[str, ...]:
    """Names of the groups wanted, checked; empty for all."""
    if text is None:
        return ()
    from vencejo.telemetry import GROUPS

    names = tuple(name.strip() for name in text.split(",") if name.strip())
    for name in names:
        if name not in GROUPS:
            raise Failed(f"there is no telemetry group '{name}'; the groups are {', '.join(GROUPS)}", Exit.USAGE)
    if not names:
        raise Failed("--groups names no group; write for example --groups attitude,position", Exit.USAGE)
    return names


def samples(vehicle: Vehicle, rate_hz: float) -> Iterator[Telemetry]:
    """Snapshots for ever; on a silent link one a second, so that the ages are seen to grow."""
    while True:
        yield from vehicle.stream(rate_hz=rate_hz, timeout_s=1.0)
        yield vehicle.telemetry


def wait_for(vehicle: Vehicle, names: tuple[str, ...], timeout_s: float) -> Telemetry:
    """Wait until all groups that were asked for are there, or the usual ones."""
    usual = ("heartbeat", "attitude", "position", "hud", "gps", "sys_status")
    missing: list[str] = []
    until = time.monotonic() + timeout_s
    for sample in samples(vehicle, 20.0):
        here = group_values(sample)
        missing = [name for name in names or usual if name not in here]
        if not missing:
            return sample
        if time.monotonic() >= until:
            break
    raise Failed(f"the vehicle did not send {', '.join(missing)} within {timeout_s:g} s")


def group_values(sample: Telemetry) -> dict[str, Any]:
    """The groups that are there, as plain dictionaries by name; a vehicle may have several batteries."""
    values = sample.to_dict()
    batteries = values.pop("batteries", [])
    if batteries:
        values["battery"] = batteries
    # The first inertial sensor is the group imu.
    if not any(values["imus"][1:]):
        del values["imus"]
    return values


def as_json(vehicle: Vehicle, sample: Telemetry, names: tuple[str, ...]) -> dict[str, Any]:
    """One sample as JSON; groups that were asked for and not heard are null."""
    here = group_values(sample)
    chosen = {name: here.get(name) for name in names} if names else here
    which = {"system_id": vehicle.system_id, "remote_name": vehicle.remote_name}
    return {**which, "time_s": round(sample.time_s, 6), **chosen}


def show(vehicle: Vehicle, sample: Telemetry, names: tuple[str, ...], *, json: bool) -> None:
    """Write one sample."""
    if json:
        put_json(as_json(vehicle, sample, names))
    else:
        stdout().print(render(vehicle, sample, names))


def render(vehicle: Vehicle, sample: Telemetry, names: tuple[str, ...]) -> RenderableType:
    """One sample as a table: group, age, values."""
    from rich.text import Text

    from vencejo.cli.common import table
    from vencejo.telemetry import LOST_AFTER_S, STALE_AFTER_S

    title = vehicle.remote_name or f"Vehicle {vehicle.system_id}"
    shown = table("group", "age", "values", right=("age",), title=title)
    here = group_values(sample)
    for name in names or here:
        group = here.get(name)
        if group is None:
            shown.add_row(name, "–", "not heard")
            continue
        for part in group if isinstance(group, list) else [group]:
            if part is None:
                continue
            age_s = part["age_s"]
            mark = "" if age_s <= STALE_AFTER_S else " stale" if age_s <= LOST_AFTER_S else " LOST"
            values = ", ".join(f"{key} {plain(value, key)}" for key, value in part.items() if key not in HIDDEN)
            if part["has_invalid"]:
                values += ", some values invalid"
            shown.add_row(Text(name, "bold"), f"{age_s:.1f} s{mark}", Text(clean(values), "dim" if mark else ""))
    return shown


HIDDEN = ("age_s", "has_invalid")


def plain(value: Any, name: str = "") -> str:
    """A telemetry value as a person reads it: positions to the centimetre, the rest to a thousandth at most."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        text = f"{value:.{7 if name in ('lat_deg', 'lon_deg') else 3}f}".rstrip("0").rstrip(".")
        return "0" if text == "-0" else text
    if isinstance(value, (tuple, list)):
        return "[" + " ".join(plain(part, name) for part in value) + "]"
    return str(value)


def _watch(vehicle: Vehicle, rate_hz: float, names: tuple[str, ...]) -> None:
    console = stdout()
    if not console.is_terminal:
        for sample in samples(vehicle, rate_hz):
            print(line(sample, names), flush=True)
        return
    from rich.live import Live

    with Live(console=console, auto_refresh=False, transient=False) as live:
        for sample in samples(vehicle, rate_hz):
            live.update(render(vehicle, sample, names), refresh=True)


def line(sample: Telemetry, names: tuple[str, ...]) -> str:
    """One sample as one line."""
    here = group_values(sample)
    parts = []
    for name in names or ("heartbeat", "position", "hud", "battery"):
        group = here.get(name)
        for part in group if isinstance(group, list) else [group]:
            if part is None:
                parts.append(f"{name}: not heard")
            else:
                values = " ".join(f"{key}={plain(value, key)}" for key, value in part.items() if key != "has_invalid")
                parts.append(f"{name}: {values}")
    return clean(f"{sample.time_s:.3f} " + "; ".join(parts))

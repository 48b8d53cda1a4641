"""The command `vencejo links`: how links are written, which serial ports are there, and how a link is doing."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vencejo.cli.common import Failed, JsonOption, clean, number, put_json, stdout, table

if TYPE_CHECKING:
    from vencejo.link import LinkInfo, SerialPort
    from vencejo.station import Station

FORMS: Final = (
    ("udpin:HOST:PORT", "udpin:0.0.0.0:14550", "listen on UDP; what ground stations do"),
    ("udpout:HOST:PORT", "udpout:192.168.1.10:14550", "send to one address over UDP"),
    ("udpbcast:HOST:PORT", "udpbcast:192.168.1.255:14550", "broadcast over UDP until somebody answers"),
    ("tcp:HOST:PORT", "tcp:127.0.0.1:5760", "connect to a TCP server, such as a simulator"),
    ("tcpin:HOST:PORT", "tcpin:0.0.0.0:5760", "be a TCP server"),
    ("DEVICE,BAUD", "/dev/ttyUSB0,57600", "a serial port: a telemetry radio or a USB cable"),
    ("tlog:FILE", "tlog:flight.tlog?speed=2", "replay a recording"),
)
"""Form, example and use of every kind of link."""


def links(
    link: Annotated[
        list[str] | None, typer.Option("--link", "-l", metavar="LINK", help="Open this link and show it live.")
    ] = None,
    once: Annotated[
        bool,
        typer.Option("--once", help="Show the links once, as soon as each has received something or the time is over."),
    ] = False,
    timeout: Annotated[
        float, typer.Option("--timeout", metavar="SECONDS", min=0.1, help="With --once: how long to listen.")
    ] = 10.0,
    json: JsonOption = False,
) -> None:
    """Show how links are written and which serial ports are there; with --link, the state of a link.

    A link is only listened to: nothing is asked of the vehicle and nothing is recorded.

    Example: vencejo links

    Example: vencejo links --link udpin:0.0.0.0:14550 --link /dev/ttyACM0,115200
    """
    if link:
        _watch(link, once=once, timeout_s=timeout, json=json)
        return
    from vencejo.link import serial_ports

    ports = serial_ports()
    if json:
        forms = [{"form": form, "example": example, "use": use} for form, example, use in FORMS]
        put_json({"forms": forms, "serial_ports": [asdict(port) | {"link": port.link} for port in ports]})
        return
    shown = table("form", "example", "what it is")
    for row in FORMS:
        shown.add_row(*row)
    console = stdout()
    console.print(shown)
    print(
        "The forms of MAVSDK, MAVROS and pymavlink are understood too. VENCEJO_LINK holds the link used without --link."
    )
    if ports:
        console.print(ports_table(ports))
    else:
        print("Serial ports: none found")


def ports_table(found: list[SerialPort]) -> Any:
    """Serial ports as a table."""
    shown = table("serial port", "what it is", "link", "state")
    for port in found:
        state = "" if port.is_allowed else "not allowed: sudo usermod -aG dialout $USER, then log in again"
        state = "in use" if port.is_in_use else state
        shown.add_row(clean(port.device), clean(port.description or ""), clean(port.link), state)
    return shown


def _watch(addresses: list[str], *, once: bool, timeout_s: float, json: bool) -> None:
    from vencejo import Station

    with Station(*addresses, record=False, heartbeat=False, request_streams=False) as station:
        if once:
            found = _first_heard(station, timeout_s)
            _show(station, json=json)
            silent = [info for info in found if not info.frames_received]
            if silent:
                reasons = "; ".join(f"{info.address}: {clean(info.detail or 'nothing heard')}" for info in silent)
                raise Failed(f"nothing was heard within {timeout_s:g} s on {reasons}")
            return
        console = stdout()
        if json or not console.is_terminal:
            for _ in _every(1.0):
                _show(station, json=json)
        from rich.live import Live

        with Live(console=console, auto_refresh=False) as live:
            for _ in _every(0.5):
                live.update(links_table(station.links, _vehicles(station)), refresh=True)


def _first_heard(station: Station, timeout_s: float) -> list[LinkInfo]:
    until = time.monotonic() + timeout_s
    for _ in _every(0.05):
        found = station.links
        if all(info.frames_received for info in found) or time.monotonic() >= until:
            return found
    raise AssertionError("unreachable")


def _every(period_s: float) -> Iterator[None]:
    while True:
        yield
        time.sleep(period_s)


def _show(station: Station, *, json: bool) -> None:
    if json:
        put_json({"links": [asdict(info) for info in station.links], "vehicles": _vehicles(station)})
    else:
        stdout().print(links_table(station.links, _vehicles(station)))


def _vehicles(station: Station) -> list[int]:
    return [vehicle.system_id for vehicle in station.vehicles]


def links_table(found: list[LinkInfo], vehicles: list[int]) -> Any:
    """State and counters of links as a table."""
    names = ("link", "state", "heard", "frames in", "out", "lost", "bad CRC", "garbage", "round trip")
    who = ", ".join(map(str, vehicles)) or "none yet"
    shown = table(*names, right=names[2:], title=f"Vehicles heard: {who}")
    for info in found:
        shown.add_row(
            clean(info.address),
            info.state + (f": {clean(info.detail)}" if info.detail else ""),
            "never" if info.age_s is None else f"{info.age_s:.1f} s ago",
            str(info.frames_received),
            str(info.frames_sent),
            f"{info.frames_lost} ({number(info.loss_pct, '%', 1)})",
            str(info.bad_crc),
            f"{info.garbage_bytes} B",
            number(info.round_trip_ms, "ms", 1),
        )
    return shown

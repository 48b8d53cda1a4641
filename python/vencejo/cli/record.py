"""The commands `vencejo record` and `vencejo replay`: what goes over a link, to a .tlog file and back."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from vencejo.cli.common import (
    DEFAULT_LINK,
    Exit,
    Failed,
    ForwardOption,
    JsonOption,
    LinkOption,
    clean,
    duration,
    progress_bar,
    put_json,
    require_file,
    say,
    size,
    stderr,
    stdout,
    table,
)
from vencejo.cli.connecting import real_link, recording_told
from vencejo.cli.history import tell_history

if TYPE_CHECKING:
    from vencejo.station import Station
    from vencejo.values import RecorderInfo

LINES_EVERY_S: Final = 10.0
UP_WITHIN_S: Final = 5.0
"""How long a replay waits for the links that it goes to."""
REST_S: Final = 2.0
"""A link that has sent nothing for this long has nothing waiting: a frame takes 0.3 s at 9,600 baud."""


def record(
    link: LinkOption = DEFAULT_LINK,
    to: Annotated[
        Path | None, typer.Option("--to", metavar="DIR", help="Folder of the recordings; by default the data folder.")
    ] = None,
    rate: Annotated[
        float, typer.Option("--rate", metavar="HZ", min=4.0, max=50.0, help="Messages per second asked for.")
    ] = 10.0,
    listen_only: Annotated[bool, typer.Option("--listen-only", help="Send nothing, not even a heartbeat.")] = False,
    forward: ForwardOption = None,
    json: JsonOption = False,
) -> None:
    """Record every frame of a link to a .tlog file, until Ctrl-C.

    Ends with 0 when something was recorded. The vehicle is asked for its streams; with --listen-only it is not.

    Example: vencejo record --link udpin:0.0.0.0:14550 --to flights

    Example: vencejo record --link /dev/ttyUSB0,57600 --listen-only
    """
    from vencejo import Station

    if to is not None:
        to.mkdir(parents=True, exist_ok=True)
    began = time.monotonic()
    with Station(
        real_link(link),
        rate_hz=rate,
        record=True if to is None else to,
        heartbeat=not listen_only,
        request_streams=not listen_only,
        forward_to=forward or (),
    ) as station:
        info = station.recorder
        try:
            with recording_told(station):
                _watch_recording(station, began, json=json)
        except (KeyboardInterrupt, SystemExit):
            pass  # how a recording ends
        finally:
            info = station.recorder or info
    _tell_recording(info, time.monotonic() - began, json=json)


def _watch_recording(station: Station, began: float, *, json: bool) -> None:
    if json:
        for _ in _every(1.0):
            put_json({"recording": _as_json(station.recorder), "links": [asdict(info) for info in station.links]})
        return
    # What was asked for is the recording: how it goes is status, and whoever stops reading that ends no recording.
    console = stderr()
    if not console.is_terminal:
        for _ in _every(LINES_EVERY_S):
            say(recording_line(station.recorder, time.monotonic() - began))
        return
    from rich.live import Live

    with Live(console=console, auto_refresh=False) as live:
        for _ in _every(0.5):
            live.update(_recording_picture(station, time.monotonic() - began), refresh=True)


def _every(period_s: float) -> Iterator[None]:
    while True:
        yield
        time.sleep(period_s)


def recording_line(info: RecorderInfo | None, elapsed_s: float) -> str:
    """The state of a recording in one line."""
    if info is None:
        return "nothing is recorded"
    text = f"{duration(elapsed_s)} {info.frames} frames, {size(info.bytes)}"
    if info.dropped:
        text += f", {info.dropped} lost to a slow disk"
    if info.path is not None:
        text += f", {info.path}"
    return text + (f", NOT RECORDING: {clean(info.problem)}" if info.problem else "")


def _recording_picture(station: Station, elapsed_s: float) -> Any:
    from rich.console import Group
    from rich.text import Text

    from vencejo.cli.links import links_table

    vehicles = [vehicle.system_id for vehicle in station.vehicles]
    return Group(Text(recording_line(station.recorder, elapsed_s)), links_table(station.links, vehicles))


def _tell_recording(info: RecorderInfo | None, elapsed_s: float, *, json: bool) -> None:
    if info is None or info.path is None or not info.frames:
        problem = f": {clean(info.problem)}" if info is not None and info.problem else ": nothing was heard"
        raise Failed(f"nothing was recorded{problem}")
    if json:
        put_json({"recording": _as_json(info)})
    else:
        print(f"Recorded {recording_line(info, elapsed_s)}")


def _as_json(info: RecorderInfo | None) -> dict[str, Any] | None:
    return None if info is None else {**asdict(info), "path": None if info.path is None else str(info.path)}


def replay(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A .tlog recording, or the .mcap history of a fleet's aircraft.")
    ],
    to: Annotated[
        list[str] | None,
        typer.Option(
            "--to", metavar="LINK", help="Link to which to send it, such as udpout:127.0.0.1:14550; repeatable."
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", metavar="TIMES", min=0.01, max=10_000.0, help="Times the recorded pace.")
    ] = 1.0,
    serve: Annotated[
        bool, typer.Option("--serve", help="Show it in the ground station, with pause, speed and seeking.")
    ] = False,
    start: Annotated[
        float, typer.Option("--start", metavar="SECONDS", min=0.0, help="With --serve: from where in the file.")
    ] = 0.0,
    port: Annotated[
        int,
        typer.Option("--port", metavar="PORT", min=0, max=65535, help="With --serve: TCP port; 0 takes a free one."),
    ] = 8080,
    json: JsonOption = False,
) -> None:
    """Tell what is in a recording; with --to, play it to a ground station.

    Frames are sent untouched, both sides of the conversation, and nothing of ours is added. With --serve the ground
    station shows it, marked as a recording, which takes no orders.

    Example: vencejo replay flight.tlog

    Example: vencejo replay flight.tlog --to udpout:127.0.0.1:14550 --speed 2

    Example: vencejo replay flight.tlog --serve

    Example: vencejo replay plane7_2026-11-25T08-00-00Z.mcap --serve --speed 4
    """
    require_file(file)
    is_history = file.suffix.lower() == ".mcap"
    if is_history and to:
        raise Failed("an .mcap file has no frames to send: show it with --serve", Exit.USAGE)
    if serve and to:
        raise Failed("either --serve, or --to: a recording is shown here or sent", Exit.USAGE)
    if serve:
        _serve(file, speed=speed, start_s=start, port=port, json=json)
        return
    if start:
        raise Failed("--start needs --serve", Exit.USAGE)
    if is_history:
        tell_history(file, json=json)
        return
    from vencejo.recording import summarize

    summary = summarize(file)
    if not summary.frames:
        raise Failed(f"{file} holds no MAVLink frame: a recording is a .tlog file")
    if to:
        _play(file, to, speed, summary.frames, json=json)
        return
    if json:
        put_json(asdict(summary))
        return
    print(f"{file}: {summary.frames} frames, {size(file.stat().st_size)}, {duration(summary.duration_s)}")
    if summary.skipped_bytes:
        print(f"{summary.skipped_bytes} bytes were no whole frame and were skipped")
    shown = table("system", "component", "what", "frames", right=("system", "component", "frames"))
    for sender in summary.senders:
        shown.add_row(str(sender.system_id), str(sender.component_id), sender.what, str(sender.frames))
    console = stdout()
    console.print(shown)
    shown = table("message", "frames", "per second", right=("frames", "per second"))
    for name, frames in summary.messages.items():
        shown.add_row(name, str(frames), f"{frames / max(summary.duration_s, 1e-3):.1f}")
    console.print(shown)
    for event in summary.events:
        print(f"{duration(event.time_s):>8}  {event.system_id}  {clean(event.text)}")


def _play(file: Path, to: list[str], speed: float, frames: int, *, json: bool) -> None:
    from vencejo import Station

    # An address of our own that no recording has: frames of the recorded ground station would pass for ours and stay.
    with Station(system_id=254, component_id=240, record=False, heartbeat=False, request_streams=False) as station:
        for address in to:
            station.open_link(address, forward=True)
        # What is played before they are up goes nowhere; one that never comes keeps nobody waiting.
        deadline = time.monotonic() + UP_WITHIN_S
        reasons: dict[int, str] = {}
        for _ in _every(0.02):
            missing = [info for info in station.links if info.state != "up"]
            for info in missing:
                if info.detail is not None and info.id not in reasons:
                    reasons[info.id] = f"{info.address} is not open: {clean(info.detail)}"
                    say(reasons[info.id])
            if not missing or time.monotonic() >= deadline:
                break
        if len(missing) == len(to):
            raise Failed(f"nothing could be sent to {', '.join(info.address for info in missing)}")
        played = station.open_link(f"tlog:{os.fspath(file)}?speed={speed:g}")
        with progress_bar(f"Playing {file.name}", quiet=json) as bar:
            for _ in _every(0.1):
                infos = {info.id: info for info in station.links}
                source = infos.pop(played, None)  # a link that has ended may be gone
                sent = {info.address: info.frames_sent for info in infos.values()}
                if source is not None:
                    bar(source.frames_received, frames)
                if source is None or source.state == "ended":
                    break
        changed_at = time.monotonic()
        for _ in _every(0.05):  # what waits in a slow link's queue
            before, sent = sent, {info.address: info.frames_sent for info in station.links if info.id != played}
            if sent != before:
                changed_at = time.monotonic()
            if min(sent.values(), default=0) >= frames or time.monotonic() - changed_at >= REST_S:
                break
    if json:
        put_json({"file": str(file), "frames": frames, "sent": sent})
    else:
        print(f"{file}: {frames} frames; sent " + ", ".join(f"{count} to {name}" for name, count in sent.items()))
    if not any(sent.values()):
        raise Failed(f"nothing could be sent to {', '.join(to)}")


def _serve(file: Path, *, speed: float, start_s: float, port: int, json: bool) -> None:
    """Serve the ground station with one recording, until Ctrl-C."""
    from vencejo import Station
    from vencejo.cli.serve import tell, wait
    from vencejo.replay import Replay
    from vencejo.serve import Server

    with (
        Station(record=False, heartbeat=False, request_streams=False) as station,
        Replay(station, file, speed=speed, start_s=start_s) as replay,
        Server(station, host="127.0.0.1", port=port) as server,
    ):
        if not json:
            say(f"{replay.name} is replayed, {speed:g} times as fast as it flew. It takes no orders.")
        tell(server, json=json)
        with contextlib.suppress(KeyboardInterrupt):
            wait(server)

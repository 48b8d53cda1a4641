"""The command `vencejo demo`: the ground station with a simulated plane, and a whole flight to watch in it."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import json as json_module
import os
import queue
import shlex
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vencejo.cli.camera import served_cameras
from vencejo.cli.common import (
    Failed,
    JsonOption,
    RecordOption,
    distance,
    say,
    status,
)
from vencejo.cli.connecting import recording_told
from vencejo.cli.fly import check, fly_plan
from vencejo.cli.fly import tell as tell_flight
from vencejo.cli.serve import open_page
from vencejo.cli.serve import tell as tell_address

if TYPE_CHECKING:
    from vencejo import Plan, Station, Vehicle
    from vencejo.cli.report import Reporter
    from vencejo.serve import Operator, Server

START_TIMEOUT_S: Final = 60.0
LANDING_LIMIT_M: Final = 20.0
"""The demo has succeeded only when the plane rests this near its landing point."""
PORT: Final = 8765
PAGE_TIMEOUT_S: Final = 15.0
"""How long a browser that was opened is waited for before the plane takes off."""
SPEEDUP_PARAM: Final = "SIM_SPEEDUP"
"""ArduPilot's simulator has it too."""
OPERATOR: Final = "demo"
"""Name of the demo's operator in browsers."""


def demo(
    speedup: Annotated[
        float,
        typer.Option("--speedup", metavar="TIMES", min=0.1, max=50.0, help="Simulated seconds per second of the demo."),
    ] = 5.0,
    seed: Annotated[int, typer.Option("--seed", help="The same seed gives the same air and sensor noise.")] = 0,
    wind: Annotated[float, typer.Option("--wind", metavar="M_S", min=0.0, max=15.0, help="Wind speed.")] = 0.0,
    wind_from: Annotated[
        float, typer.Option("--wind-from", metavar="DEG", help="Direction that the wind comes from.")
    ] = 240.0,
    gust: Annotated[float, typer.Option("--gust", metavar="M_S", min=0.0, max=10.0, help="Scale of the gusts.")] = 0.0,
    port: Annotated[
        int,
        typer.Option("--port", min=0, max=65535, help="Where the station is served; a free one when it is taken."),
    ] = PORT,
    open_browser: Annotated[
        bool | None,
        typer.Option("--open/--no-open", help="Open the station in a browser; by default on a desktop."),
    ] = None,
    camera: Annotated[
        bool | None,
        typer.Option(
            "--camera/--no-camera", help="Show the plane's nose camera; by default if vencejo[camera] is installed."
        ),
    ] = None,
    exit_after_landing: Annotated[
        bool,
        typer.Option("--exit-after-landing", help="End after the flight, for scripts."),
    ] = False,
    json: JsonOption = False,
    record: RecordOption = True,
) -> None:
    """Fly a simulated plane in the ground station: take-off, waypoints, circles, landing, in about two minutes.

    A simulated plane is started, and the station is served on this machine. The demo mission is uploaded to the plane
    over a real MAVLink link, verified, flown and followed while you watch; nobody is asked, because nothing real flies.
    The demo holds control meanwhile; whoever asks for it in the browser gets it, and the demo then only watches.

    After the landing the plane is yours, in real time, until Ctrl-C: take control in the browser and fly your own
    mission. Parameter SIM_SPEEDUP makes it faster.

    Ends with 0 when the plane rested within 20 m of its landing point.

    Example: vencejo demo

    Example: vencejo demo --exit-after-landing --wind 5 --wind-from 270 --gust 1 --seed 7
    """
    from vencejo import Plan, Station
    from vencejo.cli.report import Reporter

    path = demo_mission()
    options = [f"--speedup={speedup:g}", f"--seed={seed}", f"--wind={wind:g}", f"--wind-from={wind_from:g}"]
    with Reporter(json=json) as reporter:
        plan = Plan.load(path)
        check(plan.check(), reporter, "nothing was sent")
        air = f"wind {wind:g} m/s from {wind_from:g}°" if wind else "no wind"
        reporter.step(
            "loaded",
            f"Demo mission: {len(plan)} items, {distance(plan.length_m)}; {air}; {speedup:g} times real time",
            items=len(plan),
        )
        nose_options = camera_options(camera)
        if nose_options:
            # While the simulator starts: nothing waits for it later.
            threading.Thread(target=importlib.import_module, args=("vencejo.camera",), daemon=True).start()
        with (
            simulated_plane([*options, f"--gust={gust:g}", *nose_options]) as (link, nose, alive),
            Station(link, record=record) as station,
            recording_told(station),
            _server(station, port) as server,
            server.operator(OPERATOR) as operator,
            contextlib.ExitStack() as shown,
        ):
            shown.enter_context(served_cameras(server, [] if nose is None else [f"nose=on-demand:{nose}"]))
            tell_address(server, json=json)
            if nose is None and camera is None:
                say(f"The station shows the plane's nose camera too after: {camera_packages()}")
            if has_desktop() if open_browser is None else open_browser:
                open_page(server)
                _wait_for_page(server)
            with status("Waiting for the plane …"):
                vehicle = operator.vehicle(station.wait_vehicle(timeout_s=START_TIMEOUT_S))
            fault = _fly(vehicle, plan, reporter, operator, alive)
            if not exit_after_landing:
                _hand_over(link, operator, reporter, speedup)
                reporter.step("next", next_commands(link), link=link)
                _stay(alive)
        if fault is not None:
            raise fault


def camera_options(wanted: bool | None) -> list[str]:
    """What the simulator is told for a nose camera.

    Raises
    ------
    Failed
        When one is wanted and its packages are missing.
    """
    has_packages = all(importlib.util.find_spec(name) is not None for name in ("cv2", "PIL"))
    if wanted and not has_packages:
        raise Failed(f"the camera needs packages that are not installed: {camera_packages()}")
    return ["--camera=127.0.0.1:0"] if has_packages and wanted is not False else []


def camera_packages() -> str:
    """The command that installs what `vencejo[camera]` names, into the Python that runs: from a checkout, too."""
    wanted = [line.partition(";") for line in metadata.requires("vencejo") or []]
    names = [name.strip() for name, _, when in wanted if "extra" in when and "camera" in when]
    return shlex.join([sys.executable, "-m", "pip", "install", *(names or ["vencejo[camera]"])])


def has_desktop() -> bool:
    """Whether a browser can be opened here."""
    if sys.platform in {"darwin", "win32"}:
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _server(station: Station, port: int) -> Server:
    """The station's server, on a free port when the one wanted is taken."""
    from vencejo import VencejoError
    from vencejo.serve import Server

    try:
        return Server(station, port=port)
    except VencejoError as error:
        if port == 0:
            raise
        say(f"Port {port} is taken, perhaps by another station: a free one is used instead. ({error})")
        return Server(station, port=0)


def _wait_for_page(server: Server) -> None:
    """Give the browser time to show the station, so that the take-off is seen."""
    deadline = time.monotonic() + PAGE_TIMEOUT_S
    with status("Waiting for the browser …"):
        while server.clients == 0 and time.monotonic() < deadline:
            time.sleep(0.1)


def _fly(
    vehicle: Vehicle, plan: Plan, reporter: Reporter, operator: Operator, alive: Callable[[], None]
) -> Failed | None:
    """Fly the mission; gives back what was not as it should be."""
    from vencejo.cli.follow import Ending

    def look() -> None:
        alive()
        asking = operator.requested_by
        if asking is not None and operator.has_control:
            operator.release()
            reporter.step("control", f"{asking} has control now: the demo only watches", holder=asking)

    flight = fly_plan(vehicle, plan, reporter, ask=lambda _: True, ready_timeout_s=120.0, patience_s=60.0, alive=look)
    tell_flight(flight, vehicle, reporter)
    if not flight.outcome.ok or flight.outcome.ending is not Ending.LANDED:
        return Failed(flight.outcome.text)
    error_m = flight.landing_error_m
    if error_m is None or error_m > LANDING_LIMIT_M:
        where = "at an unknown place" if error_m is None else f"{error_m:.1f} m from its landing point"
        return Failed(f"the plane landed {where}: more than {LANDING_LIMIT_M:g} m is not good enough")
    return None


def _hand_over(link: str, operator: Operator, reporter: Reporter, speedup: float) -> None:
    """Leave the plane to the visitor: in real time, and with control free.

    It is on the ground, disarmed by itself, with its mission on board; its home moves to where it stands when it is
    armed.
    """
    if speedup != 1.0:
        _real_time(link, speedup)
    operator.close()
    reporter.step("yours", "The plane is yours now, in real time: take control in the browser. Ctrl-C ends it.")


def _real_time(link: str, speedup: float) -> None:
    """Return to real time, for the next operator.

    That is the simulator's business, not the aircraft's: it is asked for over a link of its own, whoever holds control.
    """
    from vencejo import VencejoError, connect

    try:
        with connect(link, record=False, own_system_id=254) as simulator:
            simulator.params.set(SPEEDUP_PARAM, 1.0)
    except VencejoError as error:
        say(f"The plane goes on at {speedup:g} times real time: {error}")


def demo_mission() -> Path:
    """The file of the demo mission, which comes with the package."""
    return Path(__file__).resolve().parent.parent / "data" / "demo.waypoints"


def _stay(alive: Callable[[], None]) -> None:
    """Until Ctrl-C, or until the simulated plane is gone."""
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            alive()
            time.sleep(0.5)


def next_commands(link: str) -> str:
    """What to try beside the browser."""
    return (
        "In another terminal, with the same plane:\n"
        f"  vencejo telemetry --link {link}     # what it says\n"
        f"  vencejo fly {shlex.quote(str(demo_mission()))} --link {link}     # fly it from here"
    )


@contextlib.contextmanager
def simulated_plane(options: list[str]) -> Iterator[tuple[str, str | None, Callable[[], None]]]:
    """Start the simulator on a free port; gives its link, its camera, and a function that raises when it has died."""
    # Its standard input ends when we do, however we do: no plane flies on with nobody there.
    command = [sys.executable, "-m", "vencejo.sim", "--end-with-stdin", "--link", "tcp:127.0.0.1:0", *options]
    has_camera = any(option.startswith("--camera") for option in options)
    with tempfile.TemporaryFile() as errors:
        # A session of its own: Ctrl-C on the terminal is for us, and we end it below.
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, start_new_session=True
        )

        def why() -> str:
            errors.seek(0)
            lines = errors.read().decode(errors="replace").strip().splitlines()
            return lines[-1] if lines else f"exit code {process.poll()}"

        def alive() -> None:
            if process.poll() is not None:
                raise Failed(f"the simulated plane has stopped: {why()}")

        try:
            with status("Starting the simulated plane …"):
                told = _told(process, ["listening", *(["camera"] if has_camera else [])])
            if told is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(1.0)
                raise Failed(f"the simulated plane did not start: {why()}")
            yield told["listening"], told.get("camera"), alive
        finally:
            process.terminate()
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    pipe.close()


def _told(process: subprocess.Popen[bytes], wanted: list[str]) -> dict[str, str] | None:
    """What the simulator says when it starts, a line of JSON for each thing that is wanted; ``None`` when it does not come."""
    said: queue.Queue[bytes] = queue.Queue(maxsize=len(wanted))
    out = process.stdout
    assert out is not None

    def listen() -> None:
        for _ in wanted:
            said.put(out.readline())

    threading.Thread(target=listen, daemon=True).start()
    told: dict[str, str] = {}
    for _ in wanted:
        try:
            line = said.get(timeout=START_TIMEOUT_S)
        except queue.Empty:
            return None
        if not line:
            return None
        told |= json_module.loads(line)
    return told

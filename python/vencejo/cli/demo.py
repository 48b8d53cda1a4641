"""The command `vencejo demo`: a whole flight of the simulated plane, from nothing to its landing point."""

from __future__ import annotations

import contextlib
import json as json_module
import queue
import shlex
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Final

import typer

from vencejo.cli.common import Failed, JsonOption, RecordOption, distance, status, vehicle_on
from vencejo.cli.fly import check, fly_plan, tell

START_TIMEOUT_S: Final = 60.0
LANDING_LIMIT_M: Final = 20.0
"""The demo has succeeded only when the plane rests this near its landing point."""


def demo(
    speedup: Annotated[
        float,
        typer.Option("--speedup", metavar="TIMES", min=0.1, max=50.0, help="Simulated seconds per second."),
    ] = 5.0,
    seed: Annotated[int, typer.Option("--seed", help="The same seed gives the same air and sensor noise.")] = 0,
    wind: Annotated[float, typer.Option("--wind", metavar="M_S", min=0.0, max=15.0, help="Wind speed.")] = 0.0,
    wind_from: Annotated[float, typer.Option("--wind-from", metavar="DEG", help="Where the wind comes from.")] = 240.0,
    gust: Annotated[float, typer.Option("--gust", metavar="M_S", min=0.0, max=10.0, help="Scale of the gusts.")] = 0.0,
    json: JsonOption = False,
    record: RecordOption = True,
) -> None:
    """Fly a simulated plane: take-off, waypoints, circles, landing, in about two minutes.

    A simulated plane is started, the demo mission is uploaded to it over a real MAVLink link, verified, flown and
    followed; nothing has to be set up and nobody is asked, because nothing real flies. Ends with 0 when the plane rests
    within 20 m of its landing point.

    Example: vencejo demo

    Example: vencejo demo --wind 5 --wind-from 270 --gust 1 --seed 7
    """
    from vencejo import Plan
    from vencejo.cli.follow import Ending
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
        with (
            simulated_plane([*options, f"--gust={gust:g}"]) as (link, alive),
            vehicle_on(link, timeout_s=START_TIMEOUT_S, record=record) as vehicle,
        ):
            flight = fly_plan(
                vehicle, plan, reporter, ask=lambda _: True, ready_timeout_s=120.0, patience_s=60.0, alive=alive
            )
            tell(flight, vehicle, reporter)
        error_m = flight.landing_error_m
        if not json:
            reporter.step("next", next_commands(path))
        if not flight.outcome.ok or flight.outcome.ending is not Ending.LANDED:
            raise Failed(flight.outcome.text)
        if error_m is None or error_m > LANDING_LIMIT_M:
            where = "at an unknown place" if error_m is None else f"{error_m:.1f} m from its landing point"
            raise Failed(f"the plane landed {where}: more than {LANDING_LIMIT_M:g} m is not good enough")


def demo_mission() -> Path:
    """The file of the demo mission, which comes with the package."""
    return Path(__file__).resolve().parent.parent / "data" / "demo.waypoints"


def next_commands(mission: Path) -> str:
    """What to try after the demo."""
    return (
        "Now try, each in a terminal of its own:\n"
        "  vencejo sim                                     # a simulated plane that stays\n"
        "  vencejo telemetry --link tcp:127.0.0.1:5760     # what it says\n"
        f"  vencejo fly {shlex.quote(str(mission))} --link tcp:127.0.0.1:5760     # fly it yourself"
    )


@contextlib.contextmanager
def simulated_plane(options: list[str]) -> Iterator[tuple[str, Callable[[], None]]]:
    """Start the simulator on a free port; gives its link, and a function that raises when it has died."""
    command = [sys.executable, "-m", "vencejo.sim", "--link", "tcp:127.0.0.1:0", *options]
    with tempfile.TemporaryFile() as errors:
        # A session of its own: Ctrl-C on the terminal is for us, and we end it below.
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors, start_new_session=True
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
                line = _first_line(process)
            if not line:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(1.0)
                raise Failed(f"the simulated plane did not start: {why()}")
            yield json_module.loads(line)["listening"], alive
        finally:
            process.terminate()
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            if process.stdout is not None:
                process.stdout.close()


def _first_line(process: subprocess.Popen[bytes]) -> bytes:
    """The line in which the simulator says where it listens; empty when it does not come."""
    said: queue.Queue[bytes] = queue.Queue(maxsize=1)
    out = process.stdout
    assert out is not None
    threading.Thread(target=lambda: said.put(out.readline()), daemon=True).start()
    try:
        return said.get(timeout=START_TIMEOUT_S)
    except queue.Empty:
        return b""

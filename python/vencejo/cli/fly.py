"""The command `vencejo fly`: check, upload, verify, prepare, arm, start and follow a mission, each an act of its own."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    ForwardOption,
    JsonOption,
    RecordOption,
    YesOption,
    clean,
    confirm,
    distance,
    duration,
    finding_text,
    grouped,
    progress_bar,
    say,
    status,
)
from vencejo.cli.connecting import OnVehicle
from vencejo.cli.mission import without

if TYPE_CHECKING:
    from vencejo.cli.follow import Outcome
    from vencejo.cli.report import Reporter
    from vencejo.plan import Finding, Plan
    from vencejo.telemetry import Telemetry
    from vencejo.vehicle import Vehicle

RUN_PREARM_CHECKS: Final = 401
"""MAV_CMD_RUN_PREARM_CHECKS: asks for the pre-arm failures at once instead of at the next half minute."""
PREARM_VALID_S: Final = 35.0
"""ArduPilot repeats its pre-arm failures every 30 s."""
ASK_AGAIN_S: Final = 10.0
NO_ANSWER_S: Final = 4.0
"""SYS_STATUS comes twice a second; after this long without one the vehicle does not report whether it is ready."""
PICTURES_HZ: Final = 5.0


@grouped
def fly(
    on: OnVehicle,
    plan: Annotated[
        Path, typer.Argument(metavar="PLAN", help="A .waypoints (QGC WPL 110) or .plan (QGroundControl) file.")
    ],
    yes: YesOption = False,
    json: JsonOption = False,
    ready_timeout: Annotated[
        float,
        typer.Option("--ready-timeout", metavar="SECONDS", min=0.0, help="How long to wait for the pre-arm checks."),
    ] = 60.0,
    patience: Annotated[
        float,
        typer.Option(
            "--patience", metavar="SECONDS", min=0.0, help="How long to follow a plane that has left AUTO mode."
        ),
    ] = 120.0,
    despite_mixed_plan: Annotated[
        bool,
        typer.Option(
            "--despite-mixed-plan",
            help="Arm and start although the mission on board may be a mixture left by another station. This is recorded.",
        ),
    ] = False,
    record: RecordOption = True,
    forward: ForwardOption = None,
) -> None:
    """Fly a mission: check it, upload and verify it, prepare, arm, start in AUTO, follow until it has landed.

    A plane that stands in a mode that does not arm, as after a landing, is brought to MANUAL; that is said before. It
    asks before it arms. A fence and rally points in the plan are uploaded too. The pilot's radio can take over at any
    time: a change of mode is told and never undone. When the link is lost, its age is shown and it is waited for.
    Ctrl-C ends the following; the plane goes on flying.

    Ends with 0 when the mission was flown to its end, with 1 and the reason when it was not.

    Example: vencejo fly mission.waypoints --link udpin:0.0.0.0:14550

    Example: vencejo fly mission.plan --link /dev/ttyUSB0,57600 --yes --json
    """
    from vencejo import Plan
    from vencejo.cli.report import Reporter

    with Reporter(json=json) as reporter:
        loaded = Plan.load(plan)
        if not yes and not sys.stdin.isatty():
            raise Failed(
                "there is no terminal to ask on before arming: add --yes to go on without being asked", Exit.USAGE
            )
        check(loaded.check(), reporter, "nothing was sent")
        if not loaded.items:
            raise Failed(without(plan, loaded, "mission"))
        reporter.step("loaded", f"{plan}: {len(loaded)} items, {distance(loaded.length_m)}", items=len(loaded))
        with on.vehicle(record=record, forward=forward) as vehicle:
            flight = fly_plan(
                vehicle,
                loaded,
                reporter,
                ask=lambda question: confirm(question, yes=yes),
                ready_timeout_s=ready_timeout,
                patience_s=patience,
                despite_mixed_plan=despite_mixed_plan,
            )
            tell(flight, vehicle, reporter)
        if not flight.outcome.ok:
            raise Failed(flight.outcome.text)


@dataclass(frozen=True)
class Flight:
    """What came of a flight."""

    outcome: Outcome
    time_s: float | None
    """From take-off to touch-down."""
    landing_error_m: float | None
    """From where it stands to its landing point."""


def check(findings: tuple[Finding, ...], reporter: Reporter, unsent: str, known: tuple[Finding, ...] = ()) -> None:
    """Tell what the checks found; errors end it."""
    for finding in findings:
        if finding not in known:
            reporter.step(
                "finding",
                finding_text(finding),
                severity=finding.severity,
                code=finding.code,
                item=finding.item,
            )
    errors = sum(finding.severity == "error" for finding in findings)
    if errors:
        raise Failed(f"the plan has {errors} error{'s' if errors > 1 else ''}: {unsent}")


def fly_plan(
    vehicle: Vehicle,
    plan: Plan,
    reporter: Reporter,
    *,
    ask: Callable[[str], bool],
    ready_timeout_s: float,
    patience_s: float,
    alive: Callable[[], None] = lambda: None,
    despite_mixed_plan: bool = False,
) -> Flight:
    """Upload, arm, start and follow. Each step ends the command when it fails, and says how the plane is left.

    `alive` is called with each picture and ends the following by raising.
    """
    from vencejo import modes

    telemetry = _first_position(vehicle)
    check(vehicle.check_plan(plan), reporter, "nothing was sent", known=plan.check())
    flies = telemetry.is_armed is True and telemetry.is_on_ground is not True
    if flies and telemetry.mode in modes.MISSION and not ask("The plane is flying a mission. Replace it now?"):
        raise Failed("not sent: the plane goes on with its mission")
    upload(vehicle, plan, reporter)
    if not vehicle.telemetry.is_armed:
        _prepare(vehicle, reporter, despite_mixed_plan)
        _wait_until_ready(vehicle, reporter, ready_timeout_s)
        if not ask("Arm and start the mission now? The propeller will turn."):
            raise Failed("not armed: the mission is on board and verified")
        _arm_and_start(vehicle, reporter, despite_mixed_plan)
    elif ask("The plane is armed. Start the mission now?"):
        _start(vehicle, reporter, despite_mixed_plan, from_item=1)
    else:
        raise Failed("not started: the mission is on board and verified, the plane is armed")
    return follow(vehicle, plan, reporter, patience_s=patience_s, alive=alive)


def upload(vehicle: Vehicle, plan: Plan, reporter: Reporter) -> None:
    """Upload what the plan holds, and verify it."""
    from vencejo.vehicle import PlanKind

    kinds: list[tuple[PlanKind, bool, str]] = [
        ("fence", bool(plan.fence.zones), "fence"),
        ("rally", bool(plan.rally), "rally points"),
        ("mission", True, "mission"),
    ]
    for kind, wanted, name in kinds:
        if not wanted:
            continue
        try:
            with progress_bar(f"Uploading {name}", quiet=reporter.json) as bar:
                state = vehicle.upload(plan, kind=kind, progress=bar)
        except KeyboardInterrupt:
            say(f"Interrupted while the {name} was uploaded: what the vehicle holds is unknown.")
            raise
        text = f"{name} uploaded and verified: {state.count if state.count is not None else len(plan)} items"
        if state.position_error_m is not None:
            text += f"; this vehicle keeps positions to {state.position_error_m:.1f} m"
        reporter.step(
            "uploaded",
            text,
            kind=kind,
            count=state.count,
            hash=state.hash,
            position_error_m=state.position_error_m,
        )


def follow(
    vehicle: Vehicle, plan: Plan, reporter: Reporter, *, patience_s: float, alive: Callable[[], None] = lambda: None
) -> Flight:
    """Show the flight until it is over. Sends nothing."""
    from vencejo.cli.follow import Follower, distance_from_landing_m, view_of

    follower = Follower(plan, patience_s=patience_s)
    telemetry = vehicle.telemetry
    try:
        with reporter.pictures():
            for telemetry in _pictures(vehicle):
                alive()
                texts, progress = vehicle.texts, vehicle.mission_progress
                for note in follower.step(telemetry, progress, texts):
                    reporter.note(note)
                reporter.view(view_of(telemetry, progress, texts, plan=plan, elapsed_s=follower.elapsed_s))
                if follower.outcome is not None:
                    break
    except BaseException:
        progress = vehicle.mission_progress
        say(
            f"Following ended. The plane goes on flying: mode {telemetry.mode}, item {progress.item or '–'} of "
            f"{progress.total or len(plan)}. Watch it again with: vencejo telemetry"
        )
        raise
    assert follower.outcome is not None
    return Flight(follower.outcome, follower.flight_time_s, distance_from_landing_m(plan, telemetry))


def tell(flight: Flight, vehicle: Vehicle, reporter: Reporter) -> None:
    """Tell how it ended."""
    from vencejo.cli.follow import Ending

    outcome = flight.outcome
    text = outcome.text[:1].upper() + outcome.text[1:]
    on_ground = outcome.ending is Ending.LANDED
    if on_ground and flight.landing_error_m is not None:
        text += f", {flight.landing_error_m:.1f} m from its landing point"
    if flight.time_s is not None:
        text += f", after {duration(flight.time_s)} in the air"
    recorder = vehicle.station.recorder
    path = None if recorder is None or recorder.path is None else str(recorder.path)
    reporter.step(
        "end",
        text + ".",
        outcome=outcome.ending.value,
        ok=outcome.ok,
        landing_error_m=None if flight.landing_error_m is None or not on_ground else round(flight.landing_error_m, 2),
        flight_time_s=None if flight.time_s is None else round(flight.time_s, 1),
        recording=path,
    )
    if path is not None and not reporter.json:
        say(f"Recorded in {path}")


def _pictures(vehicle: Vehicle) -> Iterator[Telemetry]:
    while True:
        yield from vehicle.stream(rate_hz=PICTURES_HZ, timeout_s=1.0)
        yield vehicle.telemetry  # nothing new for a second: the ages grow


def _first_position(vehicle: Vehicle) -> Telemetry:
    """Wait until it is known where the plane is and whether it flies; go on without after a while."""
    from vencejo import CommandTimeout

    def known(telemetry: Telemetry) -> bool:
        position = telemetry.position
        return position is not None and position.lat_deg is not None and telemetry.extended is not None

    with status("Waiting for the vehicle's position …"):
        try:
            return vehicle.wait_until(known, timeout_s=10.0)
        except CommandTimeout:
            say("The vehicle does not say where it is: the plan is not checked against its position.")
            return vehicle.telemetry


def prearm_reasons(vehicle: Vehicle, since_s: float) -> list[str]:
    """What the vehicle says against arming, newest last, without repetitions."""
    found = dict.fromkeys(
        clean(text.text).partition(":")[2].strip()
        for text in vehicle.texts
        if text.time_s >= since_s and text.text.lower().startswith(("prearm:", "preflight fail:"))
    )
    return list(found)


def _wait_until_ready(vehicle: Vehicle, reporter: Reporter, timeout_s: float) -> None:
    """Wait until the pre-arm checks pass, showing what is against it."""
    from vencejo import CommandRefused, CommandTimeout

    began = time.monotonic()
    asked: float | None = None
    told: set[str] = set()
    ready: bool | None = None
    with status("Waiting for the pre-arm checks …"):
        for telemetry in _pictures(vehicle):
            if asked is None or time.monotonic() - asked > ASK_AGAIN_S:
                # Older vehicles do not know it, and repeat their reasons by themselves.
                with contextlib.suppress(CommandRefused, CommandTimeout):
                    vehicle.command(RUN_PREARM_CHECKS)
                asked = time.monotonic()
                continue
            now = time.monotonic()
            checks = telemetry.sys_status
            # Only what was said since counts: the upload may have changed it.
            is_news = checks is not None and checks.age_s < now - asked
            ready = checks.is_ready_to_arm if checks is not None and is_news else None
            if ready or (ready is None and now - asked > NO_ANSWER_S):
                break  # without an answer, arming will show it
            reasons = prearm_reasons(vehicle, telemetry.time_s - PREARM_VALID_S)
            for reason in reasons if ready is False else ():
                if reason not in told:
                    told.add(reason)
                    reporter.step("prearm", f"not ready: {reason}", reason=reason)
            if now - began > timeout_s and ready is False:
                listed = "; ".join(reasons) or "it does not say why"
                raise Failed(f"the vehicle is not ready to arm after {timeout_s:g} s: {listed}")
    if ready:
        reporter.step("ready", "ready to arm", ready=True)
    else:
        reporter.step("ready", "the vehicle does not tell whether it is ready: arming will", ready=None)


def _prepare(vehicle: Vehicle, reporter: Reporter, despite: bool) -> None:
    """Bring it into a mode that arms, and the mission to its beginning; say so before."""
    preparation = vehicle.flight_preparation
    if preparation is not None and preparation.is_needed:
        reporter.step(
            "preparing",
            f"preparing the flight: {preparation}",
            from_mode=preparation.from_mode,
            mode=preparation.mode,
            rewinds_mission=preparation.rewinds_mission,
        )
    vehicle.prepare_flight(despite_mixed_plan=despite)


def _arm_and_start(vehicle: Vehicle, reporter: Reporter, despite: bool) -> None:
    """Arm, and start the mission at its first item. Whatever ends this in between, Ctrl-C too, the plane is not left armed unseen."""
    from vencejo import CommandRefused, ControlHeld, NotPossibleNow, modes

    may_be_armed = True
    try:
        try:
            vehicle.arm(despite_mixed_plan=despite)
        except (CommandRefused, ControlHeld, NotPossibleNow):
            may_be_armed = False
            raise
        reporter.step("armed", "armed")
        # A pilot who chose AUTO before has started it by that.
        _start(vehicle, reporter, despite, from_item=None if vehicle.telemetry.mode in modes.MISSION else 1)
    except BaseException:
        if may_be_armed:
            _stand_down(vehicle)
        raise


def _start(vehicle: Vehicle, reporter: Reporter, despite: bool, *, from_item: int | None) -> None:
    vehicle.start_mission(from_item=from_item, despite_mixed_plan=despite)
    reporter.step("started", f"mission started: the plane is in {vehicle.telemetry.mode}")


def _stand_down(vehicle: Vehicle) -> None:
    """Disarm what was armed here, also where it does not show that yet; what flies its mission already goes on."""
    from vencejo import modes

    telemetry = vehicle.telemetry
    if telemetry.is_armed and telemetry.mode in modes.MISSION:
        say(f"THE PLANE IS ARMED, in {telemetry.mode}: it flies its mission.")
        return
    try:
        vehicle.disarm()
        say("The mission was not started: the plane is disarmed again.")
    except BaseException as error:  # noqa: BLE001 - what ended the flight is raised by the caller
        armed = "IS STILL ARMED" if vehicle.telemetry.is_armed else "MAY BE ARMED"
        say(f"The mission was not started and THE PLANE {armed}: {str(error) or type(error).__name__}")

"""The same vehicle for asyncio: every waiting method is a coroutine over the same native calls.

Examples
--------
>>> import asyncio
>>> from vencejo import Plan, aio
>>> async def fly() -> None:
...     async with await aio.connect("tcp:127.0.0.1:5760") as plane:
...         await plane.upload(Plan.load("mission.waypoints"))
...         await plane.prepare_flight()
...         await plane.arm()
...         await plane.start_mission()
...         async for telemetry in plane.stream(rate_hz=1):
...             print(telemetry.position)
>>> asyncio.run(fly())  # doctest: +SKIP
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, cast

from vencejo import _native
from vencejo._given import check_timeout, deadline_of, number
from vencejo._vehicle_state import Danger, PlanKind, VehicleState, command_number, event_of, height_of, joined, place_of
from vencejo.arrivals import AsyncArrivals
from vencejo.errors import (
    CommandRefused,
    CommandTimeout,
    ControlHeld,
    InvalidRequest,
    NotPossibleNow,
    VencejoError,
)
from vencejo.plan import Home, Plan
from vencejo.signing import SigningInfo
from vencejo.station import Station
from vencejo.telemetry import Telemetry
from vencejo.values import Event, Parameter, PlanState
from vencejo.vehicle import MavlinkMessage, ProgressCallback

__all__ = ["AsyncParameters", "AsyncVehicle", "connect", "wait_vehicle"]

_POLL_S = 0.02
_LOOK_S = 1.0
"""How often a loop that waits looks whether Ctrl-C was pressed."""


async def _finished(pending: _native.Pending, progress: ProgressCallback | None = None) -> Any:
    """Wait for an operation without blocking the loop; cancelling the task cancels the operation."""
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()

    def wake() -> None:
        with contextlib.suppress(RuntimeError):  # the loop has been closed meanwhile
            loop.call_soon_threadsafe(ended.set)

    pending.on_done(wake)
    told: tuple[int, int] | None = None

    def tell() -> None:
        nonlocal told
        step = pending.progress()
        if progress is not None and step is not None and step[1] and step != told:
            progress(*step)
            told = step

    looking: asyncio.TimerHandle

    def look() -> None:
        # A signal that comes after Python has looked and before `select` sleeps, between which it may wait for the GIL,
        # is handled when the loop wakes for something else.
        nonlocal looking
        looking = loop.call_later(_LOOK_S, look)

    look()
    try:
        while progress is not None and not ended.is_set():
            tell()
            try:
                await asyncio.wait_for(ended.wait(), 0.1)
            except asyncio.TimeoutError:
                continue
        await ended.wait()
        tell()
    except BaseException:
        pending.cancel()
        raise
    finally:
        looking.cancel()
    return pending.wait(0.0)


async def wait_vehicle(
    station: Station, system_id: int | None = None, *, name: str | None = None, timeout_s: float | None = 30.0
) -> AsyncVehicle:
    """Wait for a vehicle's heartbeat on a station; see `Station.wait_vehicle`."""
    check_timeout(timeout_s)
    pending = station._awaited(system_id, name)
    try:
        native = await asyncio.wait_for(_finished(pending), timeout_s)
    except asyncio.TimeoutError:
        pending.cancel()
        native = pending.wait(0.0)
    return AsyncVehicle(native, station)


async def connect(
    link: str,
    *,
    system_id: int | None = None,
    timeout_s: float | None = 30.0,
    rate_hz: float = 10.0,
    message_rates: Mapping[str, float] | None = None,
    record: bool | str | os.PathLike[str] = True,
    own_system_id: int = 255,
    own_component_id: int = 190,
    forward_to: Iterable[str] = (),
    signing: bool | str | os.PathLike[str] = True,
) -> AsyncVehicle:
    """Connect to a vehicle and wait for its heartbeat; see `vencejo.connect`."""
    station = Station(
        link,
        system_id=own_system_id,
        component_id=own_component_id,
        rate_hz=rate_hz,
        message_rates=message_rates,
        record=record,
        forward_to=forward_to,
        signing=signing,
    )
    try:
        return await wait_vehicle(station, system_id, timeout_s=timeout_s)
    except BaseException:
        station.close()
        raise


class AsyncVehicle(VehicleState):
    """A vehicle for asyncio. Methods are those of `vencejo.Vehicle`, to be awaited; cancelling one cancels its work."""

    async def __aenter__(self) -> AsyncVehicle:
        return self

    async def __aexit__(self, *exception: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the station behind this vehicle, and with it all links."""
        await asyncio.get_running_loop().run_in_executor(None, self._station.close)

    async def stream(self, *, rate_hz: float = 10.0, timeout_s: float | None = None) -> AsyncIterator[Telemetry]:
        """Snapshots for ever, at most this many a second; see `vencejo.Vehicle.stream`."""
        if not 0.1 <= rate_hz <= 50.0:
            raise InvalidRequest(f"rate_hz is {rate_hz}, should be 0.1 to 50")
        seen: int | None = None
        due = time.monotonic()
        heard, deadline = None, deadline_of(timeout_s)
        while True:
            while (count := self._changed(seen)) is None:
                if deadline is not None and time.monotonic() >= deadline:
                    return
                await asyncio.sleep(_POLL_S)
            seen, snapshot = count, self.telemetry
            if snapshot.messages != heard:
                heard, deadline = snapshot.messages, deadline_of(timeout_s)
            elif deadline is not None and time.monotonic() >= deadline:
                return
            yield snapshot
            now = time.monotonic()
            due = max(due + 1.0 / rate_hz, now)
            await asyncio.sleep(due - now)

    async def wait_until(
        self, condition: Callable[[Telemetry], object], *, timeout_s: float | None, what: str = "the condition"
    ) -> Telemetry:
        """Wait until a function of the telemetry is true; see `vencejo.Vehicle.wait_until`."""
        deadline = deadline_of(timeout_s)
        while not condition(telemetry := self.telemetry):
            if deadline is not None and time.monotonic() >= deadline:
                raise CommandTimeout(f"{what} did not come true within {timeout_s:g} s")
            self._changed(None)
            await asyncio.sleep(_POLL_S)
        return telemetry

    def messages(
        self, *names: str, timeout_s: float | None = None, capacity: int = 1024
    ) -> AsyncArrivals[MavlinkMessage]:
        """Iterate over raw messages of this vehicle by ``async for``, from now on; see `vencejo.Vehicle.messages`."""
        return AsyncArrivals(
            self._native.subscribe_messages(list(names) or None, capacity), lambda message: message, timeout_s
        )

    def events(self, *, timeout_s: float | None = None, capacity: int = 1024) -> AsyncArrivals[Event]:
        """Iterate over the events of this vehicle by ``async for``, from now on; see `vencejo.Vehicle.events`."""
        return AsyncArrivals(self._native.subscribe_events(capacity), event_of, timeout_s)

    async def _wait(self, pending: _native.Pending, progress: ProgressCallback | None = None) -> Any:
        return await _finished(pending, progress)

    def _changed(self, seen: int | None) -> int | None:
        """Look whether something new has arrived, without waiting."""
        return self._native.wait_change(seen, 0.0)

    # Written by scripts/aio_methods.py: do not edit.

    async def arm(
        self, *, force: bool = False, confirm: Danger | None = None, despite_mixed_plan: bool = False
    ) -> None:
        """Arm; returns when the vehicle shows it. `force` skips its own checks (``confirm="force-arm"``), not those of a PX4.

        Raises
        ------
        CommandRefused
            With the vehicle's pre-arm reasons.
        NotPossibleNow
            While the mission on board may be a mixture of two (`PlanState.may_be_mixed`). In a mode that follows the
            mission also while that leads out of reach, over 200 km from home and the vehicle, or neither of these is
            known. `despite_mixed_plan` overrides both, which is noted among the vehicle's texts.
        ControlHeld
            When another operator holds control. Every request raises this.
        ConfirmationNeeded
            When `force` is not confirmed.
        """
        await self._wait(self._ask("arm", force=force, confirm=confirm, despite_mixed_plan=despite_mixed_plan))

    async def disarm(self, *, force: bool = False, confirm: Danger | None = None) -> None:
        """Disarm; returns when the vehicle shows it.

        `force` stops the motor even in the air (``confirm="force-disarm"``). Without it, a vehicle that flies or does
        not report that it is on the ground is disarmed only with ``confirm="disarm-in-flight"``.
        """
        await self._wait(self._ask("disarm", force=force, confirm=confirm))

    async def set_mode(self, mode: str | int, *, despite_mixed_plan: bool = False) -> None:
        """Change the flight mode by name (``"AUTO"``, ``"fbwa"``…) or number; returns when the vehicle shows it.

        A mode that follows the mission is refused while that may be mixed or leads out of reach, see `arm`.
        """
        await self._wait(self._ask("mode", mode=mode, despite_mixed_plan=despite_mixed_plan))

    async def takeoff(self, *, alt_rel_home_m: float) -> None:
        """Take off and climb to an altitude above home. Does not arm.

        An ArduPlane gets its take-off altitude and mode TAKEOFF: it begins to roll when it is armed. So does a PX4.
        """
        await self._wait(self._ask("takeoff", alt_rel_home_m=alt_rel_home_m))

    async def goto(
        self,
        lat_deg: float,
        lon_deg: float,
        *,
        alt_rel_home_m: float | None = None,
        alt_amsl_m: float | None = None,
        alt_terrain_m: float | None = None,
        loiter_radius_m: float | None = None,
        clockwise: bool = True,
        speed_m_s: float | None = None,
        change_mode: bool = True,
        below_home: bool = False,
    ) -> None:
        """Fly to a position and circle there (mode GUIDED, of a PX4 AUTO_LOITER, entered unless `change_mode` is false).

        Give the altitude once, in one of its three references. The speed of a plane is an airspeed, that of others one
        over ground. A plane that refuses the speed flies to the position all the same. An ArduPlane in GUIDED keeps
        radius and speed of the go-to before where none is given; a PX4 takes a sense with a radius only.

        An altitude more than 20 m below home is refused unless `below_home` is set: it is usually one above the sea
        given as one above home, or the reverse. Within 500 m of the vehicle the ground decides instead, if the vehicle
        reports it (``telemetry.terrain``): a valley needs no `below_home` there, a hill above home's level does.

        Raises
        ------
        InvalidRequest
            For a position that is not on Earth, is 0/0, or lies more than 200 km from home and from the vehicle, as one
            with latitude and longitude swapped; an altitude that is missing, given twice, or too low; a radius or
            speed out of its range.
        """
        await self._wait(
            self._ask(
                "goto",
                lat_deg=lat_deg,
                lon_deg=lon_deg,
                **height_of(alt_rel_home_m, alt_amsl_m, alt_terrain_m),
                radius_m=loiter_radius_m,
                clockwise=clockwise,
                speed_m_s=speed_m_s,
                change_mode=change_mode,
                below_home=below_home,
            )
        )

    async def set_airspeed(self, airspeed_m_s: float) -> None:
        """Change the airspeed target."""
        await self._wait(self._ask("speed", kind="airspeed", speed_m_s=airspeed_m_s))

    async def set_groundspeed(self, groundspeed_m_s: float) -> None:
        """Change the minimum ground speed. A fixed wing with PX4 takes airspeeds alone."""
        await self._wait(self._ask("speed", kind="groundspeed", speed_m_s=groundspeed_m_s))

    async def set_altitude(
        self, *, alt_rel_home_m: float | None = None, alt_amsl_m: float | None = None, below_home: bool = False
    ) -> None:
        """Change the altitude of the present target. Not to 0, which ArduPlane takes for no altitude.

        In AUTO it holds until the next item. A PX4 takes one in AUTO_LOITER alone: elsewhere it would leave its mode.

        Raises
        ------
        InvalidRequest
            For an altitude too low for `goto` unless `below_home` is set.
        NotPossibleNow
            While an ArduPlane is landing, or may be landing in a mission that was not read: it would flare and stop its
            motor in the air.
        """
        await self._wait(self._ask("altitude", **height_of(alt_rel_home_m, alt_amsl_m), below_home=below_home))

    async def fly_course(self, course_deg: float, *, accel_m_s2: float = 5.0) -> None:
        """Turn to a course over ground and stay on it. Only for an ArduPlane that is in GUIDED.

        Parameters
        ----------
        course_deg : float
            Degrees from true north, 0 to below 360.
        accel_m_s2 : float, optional
            Greatest centripetal acceleration of the turn, 0.05 to 20; 5 is a bank of 27 degrees.
        """
        await self._wait(self._ask("course", course_deg=course_deg, accel_m_s2=accel_m_s2))

    async def climb_to(
        self,
        *,
        alt_rel_home_m: float | None = None,
        alt_amsl_m: float | None = None,
        rate_m_s: float | None = None,
        below_home: bool = False,
    ) -> None:
        """Climb or sink to an altitude. Only for an ArduPlane that is in GUIDED.

        Without a rate (0.01 to 50 m/s) it does so as fast as it can. Since 4.7 an ArduPlane makes hardly a thirtieth of a
        rate: better leave it out, and raise the altitude step by step. An altitude that is too low for `goto` is refused
        unless `below_home` is set.
        """
        height = height_of(alt_rel_home_m, alt_amsl_m)
        await self._wait(self._ask("climb", **height, rate_m_s=rate_m_s, below_home=below_home))

    async def set_velocity(
        self,
        *,
        forward_m_s: float = 0.0,
        right_m_s: float = 0.0,
        down_m_s: float = 0.0,
        yaw_rate_rad_s: float = 0.0,
    ) -> None:
        """Fly at a velocity relative to the heading. Only for an ArduCopter in GUIDED or a PX4 in OFFBOARD.

        There is no acknowledgement: it returns when the message is sent. Repeat it; the vehicle stops when no more
        come, ArduCopter after 3 s (GUID_TIMEOUT), PX4 after 0.5 s.

        Parameters
        ----------
        forward_m_s, right_m_s, down_m_s : float, optional
            From -50 to 50.
        yaw_rate_rad_s : float, optional
            Clockwise seen from above, from -10 to 10.

        Raises
        ------
        InvalidRequest
            For a vehicle that does not hover, or is in another mode.
        """
        await self._wait(
            self._ask(
                "velocity",
                forward_m_s=forward_m_s,
                right_m_s=right_m_s,
                down_m_s=down_m_s,
                yaw_rate_rad_s=yaw_rate_rad_s,
            )
        )

    async def loiter(self) -> None:
        """Circle at the present position (mode LOITER)."""
        await self._wait(self._ask("loiter"))

    async def return_to_launch(self) -> None:
        """Return home or to a rally point (mode RTL)."""
        await self._wait(self._ask("return-to-launch"))

    async def land(self, *, despite_mixed_plan: bool = False) -> None:
        """Land: a plane on the landing of its mission, others in mode LAND.

        An ArduPlane finds the landing by its DO_LAND_START. One without that mark, in a mission that was read, is flown
        from its last leg, in AUTO. Nothing is sent to a plane that flies its landing already; a PX4 whose mission has
        none is refused. It is refused while the mission may be mixed, see `arm`.

        Raises
        ------
        NotPossibleNow
            For a disarmed plane, which would land as soon as it is armed, and for a PX4 plane on the ground, which
            would be armed by it and take off.
        """
        await self._wait(self._ask("land", despite_mixed_plan=despite_mixed_plan))

    async def abort_landing(self, *, alt_rel_home_m: float | None = None) -> None:
        """Abort a landing and climb; a PX4 to its own height, MIS_LND_ABRT_ALT."""
        await self._wait(self._ask("abort-landing", alt_rel_home_m=alt_rel_home_m))

    async def set_home(self, home: Home | None = None, *, confirm: Danger | None = None) -> None:
        """Move home to a position, or to where the vehicle is; in flight only with ``confirm="move-home"``.

        Raises
        ------
        ConfirmationNeeded
            For a vehicle that flies, or does not report that it is on the ground, without `confirm`.
        InvalidRequest
            For a position that is not on Earth, is 0/0, or lies more than 200 km from home and from the vehicle.
        """
        await self._wait(self._ask("home", **place_of(home), confirm=confirm))

    async def switch_fence(self, on: bool, *, confirm: Danger | None = None) -> None:
        """Switch the fence on board on or off (``confirm="fence-off"``), until a parameter or a restart changes it.

        A PX4 has parameter GF_ACTION instead.

        Raises
        ------
        CommandRefused
            When the vehicle has no fence to switch on. An ArduPlane loads its fence only once it knows its position,
            some 20 s after its start.
        ConfirmationNeeded
            When it is switched off without `confirm`.
        """
        await self._wait(self._ask("switch-fence", on=on, confirm=confirm))

    async def set_up_signing(self, *, key: str | None = None, any_link: bool = False) -> SigningInfo:
        """Give a signing key to a vehicle that does not sign, and wait until it signs with it, at most 5 s.

        The vehicle must be disarmed. From then on only its signed messages are accepted, except over USB and on this
        machine. Nothing changes until it signs with the key.

        Parameters
        ----------
        key : str, optional
            Name of a key of this machine (`Station.signing_keys`); a new one by default.
        any_link : bool, optional
            Allow sending the key, which crosses the link unencrypted, over one that others can listen to.

        Raises
        ------
        NotPossibleNow
            When it is armed or not heard, signs already, others can listen to the link, or it refuses.
        CommandTimeout
            When it did not sign with the key in time. It is addressed as before; if it signs later, that is followed.
        """
        await self._wait(self._native.change_signing("set_up", key=key, any_link=any_link))
        return self.signing

    async def rotate_signing(self, *, key: str | None = None, any_link: bool = False) -> SigningInfo:
        """Replace the key of a vehicle that signs; both keys are accepted until it signs with the new one.

        Parameters and exceptions are those of `set_up_signing`.
        """
        await self._wait(self._native.change_signing("rotate", key=key, any_link=any_link))
        return self.signing

    async def remove_signing(self, *, any_link: bool = False) -> SigningInfo:
        """Remove a vehicle's key, and wait until it no longer signs. The key stays on this machine.

        Parameters and exceptions are those of `set_up_signing`.
        """
        await self._wait(self._native.change_signing("remove", key=None, any_link=any_link))
        return self.signing

    async def reboot(self, *, confirm: Danger | None = None) -> None:
        """Restart the autopilot; only when it is disarmed, and with ``confirm="reboot"``."""
        await self._wait(self._ask("reboot", confirm=confirm))

    async def request_control(self) -> bool:
        """Ask for control of an aircraft that another ground station of the fleet has, or take it if it is free.

        Other requests to the aircraft take its control only while that is free, or as `Fleet` was told to overrule. The
        request stands until it is granted, declined, or withdrawn with `release_control`; `control` shows what has
        become of it. For a vehicle on a link it is `Operator.request`.

        Returns
        -------
        bool
            Whether requests of this operator have control now.

        Raises
        ------
        ControlHeld
            When another operator of this station, or one on board, has control of an aircraft of a fleet.
        NotPossibleNow
            When another station asks for it already.
        VehicleLost
            When it is not heard.
        """
        await self._wait(self._native.request_control())
        return self._native.has_control()

    async def keep_control(self, *, requested_by: str | None = None) -> None:
        """Decline another ground station's request for control of this aircraft.

        Parameters
        ----------
        requested_by : str, optional
            Decline it only if it is this operator's; by default the present one.
        """
        await self._wait(self._native.keep_control(requested_by))

    async def release_control(self) -> None:
        """Give control of this aircraft to the ground station that asks for it, or to nobody; or withdraw a request."""
        await self._wait(self._native.release_control())

    async def upload(
        self,
        plan: Plan,
        *,
        kind: PlanKind = "mission",
        check: bool = True,
        while_heard: bool = False,
        progress: ProgressCallback | None = None,
    ) -> PlanState:
        """Replace the mission (or fence, or rally points) on board; returns when it has been read back and compared.

        Nothing is armed or started.

        Parameters
        ----------
        plan : Plan
        kind : {"mission", "fence", "rally"}, optional
            Which part of the plan.
        check : bool, optional
            Refuse it with errors before anything is sent.
        while_heard : bool, optional
            Give up as soon as the vehicle is lost, instead of after the transfer's own timeout.
        progress : function of (done, total), optional
            Called during the transfer.

        Returns
        -------
        PlanState
            With the warnings of the checks in ``findings``.

        Raises
        ------
        PlanRefused
            When the checks find an error.
        TransferError
            When it fails; the plan on board is then unknown.
        Cancelled
            When the vehicle was lost and `while_heard` is set.
        """
        upload = self._upload(plan, kind, check, while_heard)
        await self._wait(upload[0], progress)
        return self._uploaded(kind, upload)

    async def download(
        self, *, kinds: Sequence[PlanKind] = ("mission",), progress: ProgressCallback | None = None
    ) -> Plan:
        """Read the mission from the vehicle, and the fence and the rally points if `kinds` names them."""
        from vencejo.plan import Plan

        parts = {kind: Plan._from_native(await self._wait(self._native.download(kind), progress)) for kind in kinds}
        return joined(parts)

    async def clear(self, *, kind: PlanKind = "mission", confirm: Danger | None = None) -> None:
        """Remove the mission (or fence, or rally points); returns when the vehicle confirms it.

        Needs ``confirm="clear-mission"``, ``"clear-fence"`` or ``"clear-rally"``.
        """
        await self._wait(self._native.clear(kind, confirm))

    async def prepare_flight(self, *, despite_mixed_plan: bool = False) -> None:
        """Prepare a flight, on the ground and disarmed: change to a mode that arms, and rewind the mission.

        After a landing an ArduPlane is in AUTO at the landing of its mission, or in RTL if the mission was replaced; it
        arms in neither. `flight_preparation` says what will change, and a note among the vehicle's texts (`note`)
        announces it. Nothing is armed or started.

        Raises
        ------
        NotPossibleNow
            When the vehicle is armed or in the air, and while the mission may be mixed, see `arm`.
        """
        await self._wait(self._ask("prepare-flight", despite_mixed_plan=despite_mixed_plan))

    async def start_mission(self, *, from_item: int | None = None, despite_mixed_plan: bool = False) -> None:
        """Begin the mission (mode AUTO), at an item counted from 1 if given. Does not arm.

        Item 1 rewinds the mission: jump counters start again. If an ArduPlane restarts its mission at each change to
        AUTO (``MIS_RESTART`` 1), ``from_item`` is set once more. Refused while the mission may be mixed or leads out of
        reach, see `arm`.
        """
        await self._wait(self._ask("mission/start", from_item=from_item, despite_mixed_plan=despite_mixed_plan))

    async def pause_mission(self) -> None:
        """Interrupt the mission (mode LOITER)."""
        await self._wait(self._ask("mission/pause"))

    async def resume_mission(self, *, despite_mixed_plan: bool = False) -> None:
        """Resume the mission at its current item (mode AUTO), also with ``MIS_RESTART`` 1.

        Refused while the mission may be mixed or leads out of reach, see `arm`.
        """
        await self._wait(self._ask("mission/resume", despite_mixed_plan=despite_mixed_plan))

    async def set_current_item(self, item: int, *, despite_mixed_plan: bool = False) -> None:
        """Make an item, counted from 1, the current one; refused while the mission may be mixed, see `arm`."""
        await self._wait(self._ask("mission/current", item=item, despite_mixed_plan=despite_mixed_plan))

    async def send_and_fly(self, plan: Plan, *, progress: ProgressCallback | None = None) -> PlanState:
        """Upload a mission, verify it, prepare the flight, arm and start it at its first item: the one operation that does all.

        A vehicle that is armed already is neither prepared nor armed. One that was armed by this call is disarmed again
        when the mission does not start, whatever the reason: an error, Ctrl-C, a cancelled task.

        Returns
        -------
        PlanState
            As `upload`: it flies in spite of the warnings in ``findings``.

        Raises
        ------
        VencejoError
            Whatever step fails; later steps are then not taken. Its text says so if the vehicle may still be armed.
        """
        on_board = await self.upload(plan, progress=progress)
        if self.telemetry.is_armed:
            await self.start_mission(from_item=1)
            return on_board
        await self.prepare_flight()
        may_be_armed = True
        try:
            try:
                await self.arm()
            except (CommandRefused, ControlHeld, NotPossibleNow):
                may_be_armed = False
                raise
            await self.start_mission(from_item=1)
        except BaseException as error:
            if may_be_armed:
                await self._stand_down(error)
            raise
        return on_board

    async def _stand_down(self, reason: BaseException) -> None:
        """Disarm a vehicle that was armed for a flight that did not begin; one that flies its mission already goes on."""
        from vencejo import modes

        telemetry = self.telemetry
        if telemetry.is_armed and telemetry.mode in modes.MISSION:
            return
        try:
            await self.disarm()
        except VencejoError as error:
            why = f"{str(reason) or type(reason).__name__}; the vehicle MAY STILL BE ARMED: {error}"
            raise VencejoError(f"the mission was not started: {why}") from reason

    async def note(self, text: str, *, severity: int = 6) -> None:
        """Add a note to the vehicle's texts, for everyone who uses this station. Nothing is sent to the vehicle.

        Parameters
        ----------
        text : str
            Truncated to 500 characters.
        severity : int, optional
            MAV_SEVERITY: 3 error, 4 warning, 5 notice, 6 info (default).
        """
        await self._wait(self._ask("texts", severity=severity, text=text))

    @property
    def params(self) -> AsyncParameters:
        """The vehicle's parameters."""
        return AsyncParameters(self)

    async def ask(
        self,
        name: str,
        values: Mapping[str, Any] | None = None,
        *,
        confirm: Danger | None = None,
        despite_mixed_plan: bool = False,
    ) -> MavlinkMessage | None:
        """Make any request by its name and values as in the HTTP API; returns when it is done, with the message it requested, if any.

        Examples
        --------
        >>> await plane.ask("speed", {"kind": "airspeed", "speed_m_s": 18.0})  # doctest: +SKIP
        >>> home = await plane.ask("request-message", {"message": "HOME_POSITION"})  # doctest: +SKIP

        Raises
        ------
        InvalidRequest
            For an unknown name, listing the known ones, and for a value that is wrong or missing.
        ConfirmationNeeded
            When it is dangerous and not confirmed by the name of its danger.
        """
        asked = self._native.request(name, dict(values or {}), confirm, despite_mixed_plan)
        return cast("MavlinkMessage | None", await self._wait(asked))

    async def command(
        self, command: int | str, *params: float, confirm: Danger | None = None, despite_mixed_plan: bool = False
    ) -> int:
        """Send any command by COMMAND_LONG and return its ``result_param2``. Missing parameters are 0.

        A dangerous one has to be confirmed as the method for the same act.

        Raises
        ------
        CommandRefused, CommandTimeout
        NotPossibleNow
            For a command that arms, follows the mission or jumps in it, while the mission may be mixed; see `arm`.
        """
        number, seven = command_number(command), self._seven(params)
        return int(await self._wait(self._native.command_long(number, seven, confirm, despite_mixed_plan)) or 0)

    async def command_int(
        self,
        command: int | str,
        *params: float,
        frame: int,
        x: int = 0,
        y: int = 0,
        z: float = 0.0,
        confirm: Danger | None = None,
        despite_mixed_plan: bool = False,
    ) -> int:
        """Send any command by COMMAND_INT, with its position as scaled integers of the frame (degE7 in a global frame)."""
        asked = self._command_int(command, params, frame, x, y, z, confirm, despite_mixed_plan)
        return int(await self._wait(asked) or 0)

    async def request_message(self, name: str | int) -> MavlinkMessage:
        """Request one message once, by its name or number, and return it."""
        return cast("MavlinkMessage", await self._wait(self._ask("request-message", message=name)))

    async def set_message_rate(self, name: str | int, rate_hz: float | Literal["default", "stop"] | None) -> None:
        """Set how often the vehicle sends a message, now and after each of its restarts. This overrides other stations.

        Parameters
        ----------
        name : str or int
            The message's name, such as ``"ATTITUDE"``, or its number.
        rate_hz : float, "default", "stop" or None
            0.0005 (one in 2,000 s) to 50 messages a second; ``"default"`` or 0 for the vehicle's own rate; ``"stop"``
            or ``None`` to stop it.

        Raises
        ------
        CommandRefused
            When the vehicle's firmware lacks the message, or cannot send it this often.
        """
        await self._wait(self._ask("set-message-rate", message=name, rate_hz="stop" if rate_hz is None else rate_hz))

    # (end of what is written by a script)


class AsyncParameters:
    """The parameters of a vehicle, for asyncio; see `vencejo.Parameters`."""

    # Written by scripts/aio_methods.py: do not edit.

    def __init__(self, vehicle: AsyncVehicle) -> None:
        self._vehicle = vehicle

    async def get(self, name: str) -> Parameter:
        """Read one parameter.

        Raises
        ------
        ParameterError
            When the vehicle does not have it; with similar names, once all were read (`all`).
        """
        from vencejo.values import Parameter

        with self._vehicle._suggesting(name):
            return Parameter(*await self._vehicle._wait(self._vehicle._native.param_read(name)))

    async def set(self, name: str, value: float, *, confirm: Danger | None = None) -> Parameter:
        """Write one parameter and return the vehicle's new value. Switching the fence off needs ``confirm="fence-off"``.

        Raises
        ------
        ParameterError
            When the vehicle does not have it, or keeps a different value.
        TypeError
            For a value that is no number.
        """
        from vencejo.values import Parameter

        value = number("value", value)
        with self._vehicle._suggesting(name):
            return Parameter(*await self._vehicle._wait(self._vehicle._native.param_set(name, value, confirm)))

    async def all(self, *, progress: ProgressCallback | None = None) -> dict[str, Parameter]:
        """Read all parameters, by name."""
        from vencejo.values import Parameter

        found = await self._vehicle._wait(self._vehicle._native.param_list(), progress)
        self._vehicle._param_names = tuple(name for name, *_ in found)
        return {name: Parameter(name, value, kind, default) for name, value, kind, default in found}

    async def save(self, path: str | os.PathLike[str], *, progress: ProgressCallback | None = None) -> int:
        """Read all parameters and write them to a ``.param`` file; returns their number."""
        from vencejo.params import save_params

        found = await self.all(progress=progress)
        save_params(path, found)
        return len(found)

    async def load(
        self, path: str | os.PathLike[str], *, progress: ProgressCallback | None = None
    ) -> tuple[dict[str, Parameter], tuple[str, ...]]:
        """Write the parameters of a file that differ from the vehicle's, one by one.

        What the vehicle counts or measures by itself (``STAT_…``, the pressure on the ground) is left out. A parameter
        that enables others may need a reboot and a second load.

        Returns
        -------
        tuple of (dict of str to Parameter, tuple of str)
            What was written, and the names that the vehicle does not have.

        Raises
        ------
        FileFormatError
            When the file cannot be read.
        ParameterError
            When the vehicle keeps a different value; those before it are written.
        ConfirmationNeeded
            For a value that switches the fence off: write it by `set`.
        """
        from vencejo.params import differing, load_params

        wanted = load_params(path)
        changes, unknown = differing(wanted, await self.all(progress=progress))
        written = {}
        for name, value in changes.items():
            written[name] = await self.set(name, value)
        return written, unknown

    # (end of what is written by a script)

    def __getitem__(self, name: str) -> Awaitable[float]:
        """Read one value: ``await plane.params["AIRSPEED_CRUISE"]``. `set` writes one."""
        return self._value(name)

    async def _value(self, name: str) -> float:
        return (await self.get(name)).value

    # Neither can wait; without these Python would try `params[0]`.
    __iter__ = None
    __contains__ = None

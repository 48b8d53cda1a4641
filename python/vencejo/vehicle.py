"""A vehicle: what it says, what it is asked to do, and what it answers.

Uploading, arming, changing the mode and starting are separate acts: no method does another's as a side effect, except
`Vehicle.send_and_fly`, which says so. A method returns when the vehicle has done it, or shows it, and raises with the
vehicle's own words when it does not.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo._native import MavlinkMessage
from vencejo.errors import (
    CommandRefused,
    CommandTimeout,
    ControlHeld,
    InvalidRequest,
    NotPossibleNow,
    VencejoError,
)

if TYPE_CHECKING:
    from vencejo.findings import Finding
    from vencejo.landing import Wind
    from vencejo.link import LinkInfo
    from vencejo.plan import Home, Plan
    from vencejo.rehearsal import Airframe, Battery, Ground, Learned, Rehearsal
    from vencejo.signing import SigningInfo
    from vencejo.station import Station
    from vencejo.telemetry import Telemetry
    from vencejo.values import Event, FlightPreparation, MissionProgress, Parameter, PlanChange, PlanState, StatusText
    from vencejo.what_if import Trigger, WhatIf

__all__ = [
    "MavlinkMessage",
    "Parameters",
    "Vehicle",
]

Danger: TypeAlias = Literal[
    "force-arm",
    "force-disarm",
    "disarm-in-flight",
    "terminate",
    "clear-mission",
    "clear-fence",
    "clear-rally",
    "clear-all",
    "reboot",
    "fence-off",
    "erase",
    "write-files",
]
"""What can end a flight or destroy what is on board, by the names with which a program confirms it."""

PlanKind = Literal["mission", "fence", "rally"]
ProgressCallback = Callable[[int, int], None]

_LOOK_S = 0.2
_F32_MAX = 3.4028234663852886e38


def _event(kind: str, time_s: float, detail: dict[str, Any]) -> Event:
    from vencejo.values import Event

    return Event(kind, time_s, MappingProxyType(detail))


def _call_back(subscription: _native.Subscription, call: Callable[[Any], None]) -> None:
    """Call a function with each entry until the subscription ends, in a thread that the program's end does not wait for."""

    def run() -> None:
        while (item := subscription.next()) is not None:
            try:
                call(item)
            except Exception:  # noqa: BLE001 - as any callback's: told, and on to the next
                threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread())))
            del item

    threading.Thread(target=run, name="vencejo-callback", daemon=True).start()


def _height(
    alt_rel_home_m: float | None, alt_amsl_m: float | None, alt_terrain_m: float | None = None
) -> dict[str, Any]:
    heights = (("home", alt_rel_home_m), ("amsl", alt_amsl_m), ("terrain", alt_terrain_m))
    given = [{"alt_frame": frame, "alt_m": alt_m} for frame, alt_m in heights if alt_m is not None]
    if len(given) != 1:
        raise InvalidRequest("give the height once: as alt_rel_home_m, alt_amsl_m or alt_terrain_m")
    return given[0]


def _signing_info(info: dict[str, Any]) -> SigningInfo:
    from vencejo.signing import SigningInfo

    return SigningInfo(**{**info, "unproven": tuple(info["unproven"])})


class VehicleState:
    """What `Vehicle` and `vencejo.aio.AsyncVehicle` know without asking: everything here returns at once."""

    def __init__(self, native: _native.Vehicle, station: Station) -> None:
        self._native = native
        self._station = station
        belongs_here(self)

    @property
    def system_id(self) -> int:
        """The vehicle's MAVLink system id; of one far away the id from 256 to 65,535 by which this station knows it."""
        return self._native.system_id

    @property
    def station(self) -> Station:
        """The station that hears it."""
        return self._station

    @property
    def telemetry(self) -> Telemetry:
        """A snapshot of everything that it said, each value with its age."""
        # Plans, telemetry and the like are imported where they are first used: their classes take longer to make than a vehicle to be
        # heard.
        from vencejo.telemetry import Telemetry

        return Telemetry(self._native.telemetry())

    @property
    def change_count(self) -> int:
        """A number that is another one as soon as something new has come from the vehicle."""
        return self._native.change_count()

    @property
    def texts(self) -> list[StatusText]:
        """The newest texts that it wrote, oldest first."""
        from vencejo.values import StatusText

        return [StatusText(*text) for text in self._native.texts()]

    @property
    def mission_progress(self) -> MissionProgress:
        """Where it stands in its mission."""
        from vencejo.values import MissionProgress

        return MissionProgress(**self._native.progress())

    @property
    def flight_preparation(self) -> FlightPreparation | None:
        """What a flight needs first; ``None`` before the first heartbeat. See `Vehicle.prepare_flight`."""
        found = self._native.flight_preparation()
        from vencejo.values import FlightPreparation

        return None if found is None else FlightPreparation(*found)

    def plan_state(self, kind: PlanKind = "mission") -> PlanState:
        """What is known of the mission, the fence or the rally points on board."""
        from vencejo.values import PlanState

        return PlanState(**self._native.plan_state(kind))

    def plan_on_board(self, kind: PlanKind = "mission") -> Plan | None:
        """The mission, the fence or the rally points on board as they were read; ``None`` while they are not known.

        Nothing is asked of the vehicle: the station reads by itself what it does not know (see `plan_state`). `download`
        reads it now.
        """
        from vencejo.plan import Plan

        found = self._native.plan_on_board(kind)
        return None if found is None else Plan._from_native(found)

    def compare_plan(self, plan: Plan, *, kind: PlanKind = "mission") -> tuple[PlanChange, ...] | None:
        """How the mission, the fence or the rally points of a plan differ from those on board, as this vehicle keeps items.

        Nothing is asked of the vehicle: the station reads by itself what it does not know (see `plan_state`). `download`
        reads it now.

        Parameters
        ----------
        plan : Plan
            The plan.
        kind : {"mission", "fence", "rally"}
            Which part of it.

        Returns
        -------
        tuple of PlanChange or None
            From what is on board to the plan; empty when the vehicle has it as it is. ``None`` while what is on board is
            not known to be whole.

        Raises
        ------
        InvalidRequest
            For a plan with a value that cannot be, such as a latitude of 91°.
        """
        from vencejo.values import PlanChange

        found = self._native.plan_changes(plan._to_native(), kind)
        if found is None:
            return None
        return tuple(PlanChange(what, item, on_board, tuple(fields)) for what, item, on_board, fields in found)

    @property
    def link(self) -> LinkInfo | None:
        """The link that it is reached over, with the counts of this vehicle alone; ``None`` when it is heard on none."""
        from vencejo.link import LinkInfo

        info = self._native.link()
        return None if info is None else LinkInfo(**info)

    @property
    def remote_name(self) -> str | None:
        """Its name in a fleet, when it is far away: no link of this station reaches it, a station on board does."""
        return self._native.remote_name()

    @property
    def is_reached(self) -> bool | None:
        """Whether it hears us; ``None`` when that is not known.

        ``False``: it is heard, but has answered nothing of ours for 4.5 s, asked again and again. The link works in one
        direction only, or the vehicle takes nothing without a signing key that we lack.
        """
        return self._native.is_reached()

    @property
    def lacks_terrain(self) -> bool:
        """Whether it asks for the ground's altitude at places where no map of the server that serves its station knows it."""
        return self._native.lacks_terrain()

    @property
    def rival(self) -> str | None:
        """Where another vehicle is heard that uses the same system id, in words; ``None`` when there is none.

        That one is not followed, and nothing is sent to it. Of an aircraft of a fleet, where another computer speaks by its name: then
        nothing is sent to either.
        """
        return self._native.rival()

    def follow_rival(self) -> bool:
        """Follow and command that other vehicle from now on, and this one no more; at a link alone.

        Returns
        -------
        bool
            Whether there is one.

        Raises
        ------
        ControlHeld
            When somebody else holds control.
        """
        return self._native.follow_rival()

    @property
    def signing(self) -> SigningInfo:
        """How it signs: its key by name, and what was verified and refused."""
        return _signing_info(self._native.signing())

    @property
    def mode_names(self) -> list[str]:
        """Names of the modes that this kind of vehicle has."""
        heartbeat = self.telemetry.heartbeat
        return [] if heartbeat is None else _native.mode_names(heartbeat.mav_type, heartbeat.autopilot)

    def on_message(
        self, callback: Callable[[MavlinkMessage], None], *, names: Iterable[str] | None = None, capacity: int = 1024
    ) -> _native.Subscription:
        """Call a function for each raw message of this vehicle, in one thread of its own.

        Parameters
        ----------
        callback : function of a MavlinkMessage
            A slow one loses the oldest messages (`Subscription.dropped`), it never delays the link. While more than 4,000 come a
            second it is called with several at a time, up to 2 ms later.
        names : iterable of str, optional
            Only these messages.
        capacity : int, optional
            Messages that wait for the callback at most.

        Returns
        -------
        Subscription
            Close it, or use it in a ``with`` statement, to end the calls; closing the station ends them too.
        """
        subscription = self._native.subscribe_messages(None if names is None else list(names), capacity)
        _call_back(subscription, callback)
        return subscription

    def on_event(self, callback: Callable[[Event], None], *, capacity: int = 1024) -> _native.Subscription:
        """Call a function for each event of this vehicle, in one thread of its own."""
        subscription = self._native.subscribe_events(capacity)
        _call_back(subscription, lambda item: callback(_event(*item)))
        return subscription

    def send_message(
        self, name: str, *, confirm: Danger | None = None, despite_mixed_plan: bool = False, **fields: Any
    ) -> None:
        """Send any message of the dialect: the escape hatch.

        Fields are named as in the message definition, in the units of the wire; those not given are 0. The vehicle is
        put into ``target_system`` and ``target_component`` when these are not given. There is no answer. Of its values
        only those are refused that no autopilot can take: numbers beyond 32 bits, positions that are not on Earth, heights
        beyond -1,000 to 100,000 m, and a new height of 0, which ArduPlane takes for none. One that is dangerous has to be
        confirmed, and what arms, follows the mission or jumps in it is held back while that may be mixed
        (`PlanState.may_be_mixed`), unless it is `despite_mixed_plan`.

        Raises
        ------
        InvalidRequest
            For a message or field that the dialect does not have, or a value that is refused.
        NotPossibleNow
            While the mission may be mixed.
        """
        self._native.send_message(name, fields, confirm, despite_mixed_plan)

    def check_plan(self, plan: Plan) -> tuple[Finding, ...]:
        """Check a plan that this vehicle is to fly as it is now. Errors first.

        It knows the vehicle's position and home, whether it stands on the ground, whether it can hover, and what of its
        parameters was read.
        """
        from vencejo.plan import findings_of

        return findings_of(self._native.check_plan(plan._to_native(), False))

    def rehearse(
        self,
        plan: Plan,
        *,
        airframe: Airframe | None = None,
        battery: Battery | None = None,
        wind: Wind | None = None,
        ground: Ground | None = None,
        clearance_m: float = 30.0,
    ) -> Rehearsal:
        """Fly a plan as this plane would in a wind (calm by default), from the ground at its home or else the plan's.

        Parameters that were read are the plane's, missing ones have the values of ArduPilot's simulated plane: read them first,
        by ``vehicle.params.all()``. Battery and power are taken from its telemetry and the flight followed so far.
        ``airframe`` (:meth:`learned` has one), ``battery``, ``ground`` and ``clearance_m`` are those of
        :func:`vencejo.rehearsal.rehearse`.

        Raises
        ------
        InvalidRequest
            When neither the vehicle nor the plan has a home, and for a number out of its range.
        """
        from vencejo.rehearsal import _blowing, _of_native, _plan, _profile, _within

        flown = self._native.rehearse(
            _plan(plan)._to_native(),
            _blowing(wind),
            _profile(airframe, battery),
            ground,
            _within("clearance_m", clearance_m, 0.0, 1_000.0),
        )
        if flown is None:
            raise InvalidRequest("a rehearsal begins at home: neither the vehicle nor the plan has one")
        return _of_native(flown)

    def learned(self) -> Learned | None:
        """What the plane's flight teaches of it, as :func:`vencejo.rehearsal.learn`; ``None`` where that is too little yet.

        Of the last ten minutes in the air, as far as this station followed them.
        """
        from vencejo.rehearsal import _learned

        learned = self._native.learned()
        return None if learned is None else _learned(learned)

    def what_if(
        self,
        plan: Plan | None = None,
        at_s: float | Sequence[float] | None = None,
        triggers: Sequence[Trigger] | None = None,
        *,
        airframe: Airframe | None = None,
        battery: Battery | None = None,
        wind: Wind | None = None,
        ground: Ground | None = None,
    ) -> tuple[WhatIf, ...]:
        """What follows when something happens at moments of a plan, with this plane's own failsafes: :func:`vencejo.what_if.what_if`.

        Without a plan and a moment it is from now on, as the vehicle flies: its mission, or in GUIDED, LOITER, CIRCLE or RTL to the end of
        that; in a mode that a pilot steers straight on until something is decided.

        Raises
        ------
        InvalidRequest
            As there, for a plan without a moment or a moment without a plan, and without both when it is not known that the vehicle
            flies, and how.
        """
        from vencejo.rehearsal import _blowing, _plan, _profile
        from vencejo.what_if import TRIGGERS, _moments, _named, _of_tuples

        if (plan is None) is not (at_s is None):
            raise InvalidRequest("a plan comes with at_s, a moment of it; now is asked for without both")
        found = self._native.what_if(
            None if plan is None or at_s is None else (_plan(plan)._to_native(), _moments(at_s)),
            _named(TRIGGERS if triggers is None else triggers),
            _blowing(wind),
            _profile(airframe, battery),
            ground,
        )
        if found is None:
            lacks = "it is not known to fly, and how" if plan is None else "neither the vehicle nor the plan has a home"
            raise InvalidRequest(f"nothing can be rehearsed: {lacks}")
        return _of_tuples(found)

    def _require_sound(self, plan: Plan) -> None:
        """Refuse a plan with an error; it may wait on board until the plane flies."""
        from vencejo.plan import findings_of, refuse_errors

        refuse_errors(findings_of(self._native.check_plan(plan._to_native(), True)))

    # Each operation as it starts; the front doors below only differ in how they wait for the end.

    def _ask(
        self, name: str, *, confirm: Danger | None = None, despite_mixed_plan: bool = False, **values: Any
    ) -> _native.Pending:
        """Ask for what describes itself in the core (`Request`), by its name and values; ``None`` is not given."""
        return self._native.request(name, values, confirm, despite_mixed_plan)

    def _upload(self, plan: Plan, kind: PlanKind, check: bool, while_heard: bool = False) -> _native.Pending:
        from vencejo.plan import Plan

        if not isinstance(plan, Plan):
            raise TypeError(f"a Plan is uploaded, not a {type(plan).__name__}; Plan.load reads one from a file")
        if check and kind == "mission":
            self._require_sound(plan)
        pending = self._native.upload(kind, plan._to_native(), not check)
        if while_heard:
            watch = self.on_event(lambda event: pending.cancel() if event.kind == "lost" else None)
            pending.on_done(watch.close)
        return pending

    def _uploaded(self, kind: PlanKind, pending: _native.Pending) -> PlanState:
        from dataclasses import replace

        return replace(self.plan_state(kind), position_error_m=pending.position_error_m())

    def _command_int(
        self,
        command: int | str,
        params: Sequence[float],
        frame: int,
        x: int,
        y: int,
        z: float,
        confirm: Danger | None,
        despite_mixed_plan: bool,
    ) -> _native.Pending:
        if len(params) > 4:
            raise InvalidRequest(f"a COMMAND_INT has four parameters and a position, not {len(params)}")
        for name, value, low, high in (
            ("frame", frame, 0, 255),
            ("x", x, -(2**31), 2**31 - 1),
            ("y", y, -(2**31), 2**31 - 1),
        ):
            if not low <= value <= high:
                raise InvalidRequest(f"{name} is {value}, should be {low} to {high}")
        number, four = _command_number(command), self._seven(params)[:4]
        return self._native.command_int(number, frame, four, x, y, z, confirm, despite_mixed_plan)

    @staticmethod
    def _seven(params: Sequence[float]) -> list[float]:
        if len(params) > 7:
            raise InvalidRequest(f"a command has seven parameters, not {len(params)}")
        for place, value in enumerate(params, 1):
            if abs(value) > _F32_MAX:
                raise InvalidRequest(
                    f"parameter {place} is {value}: give a number that fits 32 bits; NaN leaves it to a PX4"
                )
        return [*map(float, params), *(0.0,) * (7 - len(params))]

    def __repr__(self) -> str:
        heartbeat = self.telemetry.heartbeat
        state = "not heard yet" if heartbeat is None else f"{heartbeat.mode}{', armed' if heartbeat.is_armed else ''}"
        return f"<{type(self).__name__} {self.system_id}: {state}>"


class Vehicle(Closing, VehicleState):
    """A vehicle, for synchronous programs. Made by `vencejo.connect` or `Station.wait_vehicle`.

    Every method that waits can be interrupted with Ctrl-C; what it had begun is then cancelled.

    Examples
    --------
    >>> import vencejo
    >>> with vencejo.connect("tcp:127.0.0.1:5760") as plane:  # doctest: +SKIP
    ...     plane.upload(vencejo.Plan.load("mission.waypoints"))
    ...     plane.prepare_flight()
    ...     plane.arm()
    ...     plane.start_mission()
    """

    def close(self) -> None:
        """Close the station behind this vehicle, and with it all links."""
        self._station.close()

    def _wait(self, pending: _native.Pending, progress: ProgressCallback | None = None) -> Any:
        try:
            if progress is not None:
                seen, told = 0, None
                while (step := pending.wait_progress(seen)) is not None:
                    seen, *told = step
                    if told[1]:
                        progress(*told)
                # The last report may have come together with the end.
                last = pending.progress()
                if last is not None and last[1] and list(last) != told:
                    progress(*last)
            return pending.wait(None)
        except BaseException:
            pending.cancel()
            raise

    # Watching ------------------------------------------------------------------------------------------------------

    def stream(self, *, rate_hz: float = 10.0, timeout_s: float | None = None) -> Iterator[Telemetry]:
        """Snapshots for ever, at most this many a second, each when something new has arrived.

        Parameters
        ----------
        rate_hz : float, optional
            From 0.1 to 50.
        timeout_s : float, optional
            Ends the stream when nothing new has arrived for so long. Without it a lost vehicle's stream waits.

        Raises
        ------
        ClosedError
            When the station is closed meanwhile.
        """
        if not 0.1 <= rate_hz <= 50.0:
            raise InvalidRequest(f"rate_hz is {rate_hz}, should be 0.1 to 50")
        seen: int | None = None
        due = time.monotonic()
        while True:
            deadline = None if timeout_s is None else time.monotonic() + timeout_s
            while (count := self._wait_change(seen, deadline)) is None:
                if deadline is not None and time.monotonic() >= deadline:
                    return
            seen = count
            yield self.telemetry
            now = time.monotonic()
            due = max(due + 1.0 / rate_hz, now)
            time.sleep(due - now)

    def wait_until(
        self, condition: Callable[[Telemetry], bool], *, timeout_s: float | None, what: str = "the condition"
    ) -> Telemetry:
        """Wait until a function of the telemetry is true, and give back the snapshot that made it so.

        Raises
        ------
        CommandTimeout
            When it is not true in time.
        ClosedError
            When the station is closed meanwhile.
        """
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        seen = self._native.change_count()
        while not condition(telemetry := self.telemetry):
            if deadline is not None and time.monotonic() >= deadline:
                raise CommandTimeout(f"{what} did not come true within {timeout_s:g} s")
            count = self._wait_change(seen, deadline)
            seen = seen if count is None else count
        return telemetry

    def _wait_change(self, seen: int | None, deadline: float | None) -> int | None:
        """Wait a moment for something new; snapshots that grow old are looked at again as well."""
        rest_s = _LOOK_S if deadline is None else min(_LOOK_S, max(0.0, deadline - time.monotonic()))
        return self._native.wait_change(seen, rest_s)

    # Arming and modes ----------------------------------------------------------------------------------------------

    def arm(self, *, force: bool = False, confirm: Danger | None = None, despite_mixed_plan: bool = False) -> None:
        """Arm; returns when the vehicle shows it. `force` skips its own checks (``confirm="force-arm"``).

        Raises
        ------
        CommandRefused
            With the vehicle's pre-arm reasons.
        NotPossibleNow
            While the mission on board may be a mixture (`PlanState.may_be_mixed`), unless it is `despite_mixed_plan`, which
            is written among the vehicle's texts.
        ControlHeld
            When somebody else holds control; so does every act.
        ConfirmationNeeded
            When `force` is not confirmed.
        """
        self._wait(self._ask("arm", force=force, confirm=confirm, despite_mixed_plan=despite_mixed_plan))

    def disarm(self, *, force: bool = False, confirm: Danger | None = None) -> None:
        """Disarm; returns when the vehicle shows it.

        `force` stops the motor even in the air (``confirm="force-disarm"``). Without it a vehicle that flies, or does not say
        that it stands, is asked only with ``confirm="disarm-in-flight"``.
        """
        self._wait(self._ask("disarm", force=force, confirm=confirm))

    def set_mode(self, mode: str | int, *, despite_mixed_plan: bool = False) -> None:
        """Change the flight mode by name (``"AUTO"``, ``"fbwa"``…) or number; returns when the vehicle shows it.

        A mode that follows the mission is refused while that may be mixed, see `arm`.
        """
        self._wait(self._ask("mode", mode=mode, despite_mixed_plan=despite_mixed_plan))

    # Flying --------------------------------------------------------------------------------------------------------

    def takeoff(self, *, alt_rel_home_m: float) -> None:
        """Take off and climb to a height above home. Does not arm.

        An ArduPlane gets its take-off height and mode TAKEOFF: it begins to roll when it is armed.
        """
        self._wait(self._ask("takeoff", alt_rel_home_m=alt_rel_home_m))

    def goto(
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
    ) -> None:
        """Fly to a position and circle there (mode GUIDED, entered unless `change_mode` is false).

        Give the height once, by what it is counted from.
        """
        self._wait(
            self._ask(
                "goto",
                lat_deg=lat_deg,
                lon_deg=lon_deg,
                **_height(alt_rel_home_m, alt_amsl_m, alt_terrain_m),
                radius_m=loiter_radius_m,
                clockwise=clockwise,
                speed_m_s=speed_m_s,
                change_mode=change_mode,
            )
        )

    def set_airspeed(self, airspeed_m_s: float) -> None:
        """Change the airspeed target."""
        self._wait(self._ask("speed", kind="airspeed", speed_m_s=airspeed_m_s))

    def set_groundspeed(self, groundspeed_m_s: float) -> None:
        """Change the least ground speed."""
        self._wait(self._ask("speed", kind="groundspeed", speed_m_s=groundspeed_m_s))

    def set_altitude(self, *, alt_rel_home_m: float | None = None, alt_amsl_m: float | None = None) -> None:
        """Change the altitude of the present target. Not to 0, which ArduPlane takes for none.

        In AUTO it holds until the next item.

        Raises
        ------
        NotPossibleNow
            While an ArduPlane lands, or may do so in a mission that was not read: it would flare and stop its motor where it is.
        """
        self._wait(self._ask("altitude", **_height(alt_rel_home_m, alt_amsl_m)))

    def fly_course(self, course_deg: float, *, accel_m_s2: float = 5.0) -> None:
        """Turn to a course over ground and stay on it. Only for an ArduPlane that is in GUIDED.

        Parameters
        ----------
        course_deg : float
            Degrees from true north, 0 to below 360.
        accel_m_s2 : float, optional
            Centripetal acceleration of the turn at most, 0.05 to 20; 5 is a bank of 27 degrees.
        """
        self._wait(self._ask("course", course_deg=course_deg, accel_m_s2=accel_m_s2))

    def climb_to(
        self, *, alt_rel_home_m: float | None = None, alt_amsl_m: float | None = None, rate_m_s: float
    ) -> None:
        """Climb or sink to a height at a rate (above 0 to 50 m/s). Only for an ArduPlane that is in GUIDED."""
        self._wait(self._ask("climb", **_height(alt_rel_home_m, alt_amsl_m), rate_m_s=rate_m_s))

    def set_velocity(
        self,
        *,
        forward_m_s: float = 0.0,
        right_m_s: float = 0.0,
        down_m_s: float = 0.0,
        yaw_rate_rad_s: float = 0.0,
    ) -> None:
        """Fly at a velocity relative to the heading. Only for an ArduCopter in GUIDED or a PX4 in OFFBOARD.

        It has no answer: it returns when it is sent. Repeat it; the vehicle stops by itself when it hears no more of it,
        ArduCopter after 3 s (GUID_TIMEOUT), PX4 after 0.5 s.

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
        self._wait(
            self._ask(
                "velocity",
                forward_m_s=forward_m_s,
                right_m_s=right_m_s,
                down_m_s=down_m_s,
                yaw_rate_rad_s=yaw_rate_rad_s,
            )
        )

    def loiter(self) -> None:
        """Circle here (mode LOITER)."""
        self._wait(self._ask("loiter"))

    def return_to_launch(self) -> None:
        """Return home or to a rally point (mode RTL)."""
        self._wait(self._ask("return-to-launch"))

    def land(self, *, despite_mixed_plan: bool = False) -> None:
        """Land: an ArduPlane goes to the landing sequence of its mission, others to mode LAND.

        Nothing is sent to an ArduPlane that flies that sequence already. It is refused while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("land", despite_mixed_plan=despite_mixed_plan))

    def abort_landing(self, *, alt_rel_home_m: float | None = None) -> None:
        """Abort a landing and climb."""
        self._wait(self._ask("abort-landing", alt_rel_home_m=alt_rel_home_m))

    def set_home(self, home: Home | None = None) -> None:
        """Move home to a position, or to where the vehicle is."""
        from dataclasses import asdict

        place: dict[str, Any] = {} if home is None else asdict(home)
        self._wait(self._ask("home", **place))

    def switch_fence(self, on: bool, *, confirm: Danger | None = None) -> None:
        """Switch the fence on board on or off (``confirm="fence-off"``), until its parameters or a restart do.

        Raises
        ------
        CommandRefused
            When the vehicle has no fence to switch on: an ArduPlane also before it knows where it is, some 20 s after its start,
            since it loads its fence then.
        ConfirmationNeeded
            When it is switched off without `confirm`.
        """
        self._wait(self._ask("switch-fence", on=on, confirm=confirm))

    def set_up_signing(self, *, key: str | None = None, any_link: bool = False) -> SigningInfo:
        """Give a vehicle that does not sign a key, and wait until it signs with it, at most 5 s.

        The vehicle must be disarmed. From then on only what it signs is believed, except over USB and on this machine. Until it
        shows the key, nothing changes.

        Parameters
        ----------
        key : str, optional
            Name of a key of this machine (`Station.signing_keys`); a new one by default.
        any_link : bool, optional
            Allow the key, which goes over the link as it is, on one that others can listen to.

        Raises
        ------
        NotPossibleNow
            When it is armed or not heard, signs already, others can listen to the link, or it refuses.
        CommandTimeout
            When it did not show the key. It is talked to as before; if it shows it later, that is followed.
        """
        self._wait(self._native.change_signing("set_up", key=key, any_link=any_link))
        return self.signing

    def rotate_signing(self, *, key: str | None = None, any_link: bool = False) -> SigningInfo:
        """Give a vehicle that signs another key; both are believed until it shows the new one.

        Parameters and exceptions are those of `set_up_signing`.
        """
        self._wait(self._native.change_signing("rotate", key=key, any_link=any_link))
        return self.signing

    def remove_signing(self, *, any_link: bool = False) -> SigningInfo:
        """Take a vehicle's key away, and wait until it signs no more. The key stays on this machine.

        Parameters and exceptions are those of `set_up_signing`.
        """
        self._wait(self._native.change_signing("remove", key=None, any_link=any_link))
        return self.signing

    def reboot(self, *, confirm: Danger | None = None) -> None:
        """Restart the autopilot; only when it is disarmed, and with ``confirm="reboot"``."""
        self._wait(self._ask("reboot", confirm=confirm))

    # Missions ------------------------------------------------------------------------------------------------------

    def upload(
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
            Refuse a mission with errors before anything is sent.
        while_heard : bool, optional
            Give up when the vehicle is lost meanwhile, rather than wait for it as long as a transfer does.
        progress : function of (done, total), optional
            Called while it runs.

        Raises
        ------
        PlanRefused
            When the checks find an error.
        TransferError
            When it fails; what the vehicle holds is then unknown.
        Cancelled
            When it was given up.
        """
        pending = self._upload(plan, kind, check, while_heard)
        self._wait(pending, progress)
        return self._uploaded(kind, pending)

    def download(self, *, kinds: Sequence[PlanKind] = ("mission",), progress: ProgressCallback | None = None) -> Plan:
        """Read the mission (and fence, and rally points when asked) from the vehicle."""
        from vencejo.plan import Plan

        parts = {kind: Plan._from_native(self._wait(self._native.download(kind), progress)) for kind in kinds}
        return _joined(parts)

    def clear(self, *, kind: PlanKind = "mission", confirm: Danger | None = None) -> None:
        """Remove the mission (or fence, or rally points); returns when the vehicle says that it is gone.

        Confirmed by ``confirm="clear-mission"``, ``"clear-fence"`` or ``"clear-rally"``.
        """
        self._wait(self._native.clear(kind, confirm))

    def prepare_flight(self, *, despite_mixed_plan: bool = False) -> None:
        """Prepare a flight, on the ground and disarmed: a mode that arms, and the mission back at its beginning.

        After a landing an ArduPlane stands in AUTO at the landing of its mission, or in RTL when that was replaced; in
        neither it arms. `flight_preparation` tells what is changed, and a text of ours (`note`) says it before it is done.
        Nothing is armed or started.

        Raises
        ------
        NotPossibleNow
            When it is armed, or in the air; and while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("prepare-flight", despite_mixed_plan=despite_mixed_plan))

    def start_mission(self, *, from_item: int | None = None, despite_mixed_plan: bool = False) -> None:
        """Begin the mission (mode AUTO), at an item counted from 1 when given. Does not arm.

        Item 1 is the mission's beginning: jumps that were flown count anew. An ArduPlane that begins its mission anew at each
        change to AUTO (``MIS_RESTART`` 1) is set to ``from_item`` once more. Refused while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("mission/start", from_item=from_item, despite_mixed_plan=despite_mixed_plan))

    def pause_mission(self) -> None:
        """Interrupt the mission (mode LOITER)."""
        self._wait(self._ask("mission/pause"))

    def resume_mission(self, *, despite_mixed_plan: bool = False) -> None:
        """Go on with the mission where it stands (mode AUTO), also with ``MIS_RESTART`` 1; refused while it may be mixed, see `arm`."""
        self._wait(self._ask("mission/resume", despite_mixed_plan=despite_mixed_plan))

    def set_current_item(self, item: int, *, despite_mixed_plan: bool = False) -> None:
        """Make an item, counted from 1, the one in execution; refused while the mission may be mixed, see `arm`."""
        self._wait(self._ask("mission/current", item=item, despite_mixed_plan=despite_mixed_plan))

    def send_and_fly(self, plan: Plan, *, progress: ProgressCallback | None = None) -> None:
        """Upload a mission, verify it, prepare the flight, arm and start it at its first item: the one operation that does all.

        A vehicle that is armed already is neither prepared nor armed. One that was armed by this call is disarmed again when
        the mission does not start, whatever the reason: an error, Ctrl-C, a cancelled task.

        Raises
        ------
        VencejoError
            Whatever step fails; later steps are then not taken. Its text says so if the vehicle may still be armed.
        """
        self.upload(plan, progress=progress)
        if self.telemetry.is_armed:
            self.start_mission(from_item=1)
            return
        self.prepare_flight()
        may_be_armed = True
        try:
            try:
                self.arm()
            except (CommandRefused, ControlHeld, NotPossibleNow):
                may_be_armed = False
                raise
            self.start_mission(from_item=1)
        except BaseException as error:
            if may_be_armed:
                self._stand_down(error)
            raise

    def _stand_down(self, reason: BaseException) -> None:
        """Disarm a vehicle that was armed for a flight that did not begin; one that flies its mission already goes on."""
        from vencejo import modes

        telemetry = self.telemetry
        if telemetry.is_armed and telemetry.mode in modes.MISSION:
            return
        try:
            self.disarm()
        except VencejoError as error:
            why = f"{str(reason) or type(reason).__name__}; the vehicle MAY STILL BE ARMED: {error}"
            raise VencejoError(f"the mission was not started: {why}") from reason

    # Texts ---------------------------------------------------------------------------------------------------------

    def note(self, text: str, *, severity: int = 6) -> None:
        """Put a text of ours beside the vehicle's own, for whoever watches it through this station. Nothing is sent.

        Parameters
        ----------
        text : str
            Cut to 500 characters.
        severity : int, optional
            MAV_SEVERITY: 3 error, 4 warning, 5 notice, 6 info (default).
        """
        self._wait(self._ask("texts", severity=severity, text=text))

    # Parameters ----------------------------------------------------------------------------------------------------

    @property
    def params(self) -> Parameters:
        """The vehicle's parameters."""
        return Parameters(self)

    # Escape hatch --------------------------------------------------------------------------------------------------

    def ask(
        self,
        name: str,
        values: Mapping[str, Any] | None = None,
        *,
        confirm: Danger | None = None,
        despite_mixed_plan: bool = False,
    ) -> MavlinkMessage | None:
        """Ask for anything by its name and values as the HTTP API has them; returns when it is done, with the message that it brings.

        Examples
        --------
        >>> plane.ask("speed", {"kind": "airspeed", "speed_m_s": 18.0})  # doctest: +SKIP
        >>> plane.ask("request-message", {"message": "HOME_POSITION"}).fields["altitude"]  # doctest: +SKIP

        Raises
        ------
        InvalidRequest
            For a name that is none, naming those that are, and for a value that is wrong or lacks.
        ConfirmationNeeded
            When it is dangerous, and not confirmed by the name of that danger.
        """
        asked = self._native.request(name, dict(values or {}), confirm, despite_mixed_plan)
        return cast("MavlinkMessage | None", self._wait(asked))

    def command(
        self, command: int | str, *params: float, confirm: Danger | None = None, despite_mixed_plan: bool = False
    ) -> int:
        """Send any command by COMMAND_LONG and give back its ``result_param2``. Missing parameters are 0.

        A dangerous one is confirmed by its name, as the method for the same act would be.

        Raises
        ------
        CommandRefused, CommandTimeout
        NotPossibleNow
            For one that arms, follows the mission or jumps in it, while that may be mixed; see `arm`.
        """
        number, seven = _command_number(command), self._seven(params)
        return int(self._wait(self._native.command_long(number, seven, confirm, despite_mixed_plan)) or 0)

    def command_int(
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
        """Send any command by COMMAND_INT, its position as scaled integers of the frame (degE7 in a global one)."""
        asked = self._command_int(command, params, frame, x, y, z, confirm, despite_mixed_plan)
        return int(self._wait(asked) or 0)

    def request_message(self, name: str | int) -> MavlinkMessage:
        """Ask for one message once, by its name or its number, and give it back."""
        return cast("MavlinkMessage", self._wait(self._ask("request-message", message=name)))

    def set_message_rate(self, name: str | int, rate_hz: float | Literal["default", "stop"] | None) -> None:
        """Set how often the vehicle sends a message, now and after each of its restarts. It overrides other stations.

        Parameters
        ----------
        name : str or int
            The message's name, such as ``"ATTITUDE"``, or its number.
        rate_hz : float, "default", "stop" or None
            From one in 2,000 s (0.0005) to 50 a second; ``"default"``, or 0, for the vehicle's own rate; ``"stop"``, or ``None``,
            for none.

        Raises
        ------
        CommandRefused
            When the vehicle's firmware does not have the message, or cannot send it so often.
        """
        self._wait(self._ask("set-message-rate", message=name, rate_hz="stop" if rate_hz is None else rate_hz))


class Parameters:
    """The parameters of a vehicle, read and written one by one or all at once.

    Examples
    --------
    >>> plane.params["AIRSPEED_CRUISE"]  # doctest: +SKIP
    22.0
    >>> plane.params["AIRSPEED_CRUISE"] = 18  # doctest: +SKIP
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle

    def get(self, name: str) -> Parameter:
        """Read one.

        Raises
        ------
        ParameterError
            When the vehicle does not have it.
        """
        from vencejo.values import Parameter

        return Parameter(*self._vehicle._wait(self._vehicle._native.param_read(name)))

    def set(self, name: str, value: float, *, confirm: Danger | None = None) -> Parameter:
        """Write one; returns what the vehicle has then. Switching the fence off needs ``confirm="fence-off"``.

        Raises
        ------
        ParameterError
            When the vehicle does not have it, or keeps another value.
        """
        from vencejo.values import Parameter

        return Parameter(*self._vehicle._wait(self._vehicle._native.param_set(name, float(value), confirm)))

    def all(self, *, progress: ProgressCallback | None = None) -> dict[str, Parameter]:
        """Read all, by name."""
        from vencejo.values import Parameter

        found = self._vehicle._wait(self._vehicle._native.param_list(), progress)
        return {name: Parameter(name, value, kind) for name, value, kind in found}

    def __getitem__(self, name: str) -> float:
        return self.get(name).value

    def __setitem__(self, name: str, value: float) -> None:
        self.set(name, value)


def _command_number(command: int | str) -> int:
    if isinstance(command, str):
        number = _native.command_number(command)
        if number is None:
            raise InvalidRequest(f"'{command}' is no MAV_CMD; give its name, such as 'DO_CHANGE_SPEED', or number")
        return number
    if not 0 <= command <= 65_535:
        raise InvalidRequest(f"{command} is no MAV_CMD; they go from 0 to 65535")
    return int(command)


def _joined(parts: Mapping[PlanKind, Plan]) -> Plan:
    from vencejo.plan import Plan

    empty = Plan()
    mission, fence, rally = (parts.get(kind, empty) for kind in ("mission", "fence", "rally"))
    return Plan(items=mission.items, home=mission.home, fence=fence.fence, rally=rally.rally)

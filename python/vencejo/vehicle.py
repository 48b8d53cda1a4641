"""A vehicle: its telemetry, requests to it, and their results.

Uploading, arming, changing the mode and starting are separate acts: no method does another's as a side effect, except
`Vehicle.send_and_fly`, which says so. A method returns when the vehicle has done it, or shows it, and otherwise raises
an exception with the vehicle's own reasons.
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
    "check_request",
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
"""Requests that can end a flight or destroy data on board, by the names with which a program confirms them."""

PlanKind = Literal["mission", "fence", "rally"]
ProgressCallback = Callable[[int, int], None]

_LOOK_S = 0.2
_F32_MAX = 3.4028234663852886e38


def _event(kind: str, time_s: float, detail: dict[str, Any]) -> Event:
    from vencejo.values import Event

    return Event(kind, time_s, MappingProxyType(detail))


def _call_back(subscription: _native.Subscription, call: Callable[[Any], None]) -> None:
    """Call a function with each entry until the subscription ends, in a daemon thread."""

    def run() -> None:
        while (item := subscription.next()) is not None:
            try:
                call(item)
            except Exception:  # noqa: BLE001 - reported as for any thread; the next entry follows
                threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread())))
            del item

    threading.Thread(target=run, name="vencejo-callback", daemon=True).start()


def _height(
    alt_rel_home_m: float | None, alt_amsl_m: float | None, alt_terrain_m: float | None = None
) -> dict[str, Any]:
    heights = (("home", alt_rel_home_m), ("amsl", alt_amsl_m), ("terrain", alt_terrain_m))
    given = [{"alt_frame": frame, "alt_m": alt_m} for frame, alt_m in heights if alt_m is not None]
    if len(given) != 1:
        raise InvalidRequest("give the altitude once: as alt_rel_home_m, alt_amsl_m or alt_terrain_m")
    return given[0]


def _signing_info(info: dict[str, Any]) -> SigningInfo:
    from vencejo.signing import SigningInfo

    return SigningInfo(**{**info, "unproven": tuple(info["unproven"])})


class VehicleState:
    """State shared by `Vehicle` and `vencejo.aio.AsyncVehicle`. Nothing here waits for the vehicle."""

    def __init__(self, native: _native.Vehicle, station: Station) -> None:
        self._native = native
        self._station = station
        belongs_here(self)

    @property
    def system_id(self) -> int:
        """The vehicle's MAVLink system id; for a remote one of a fleet, this station's id for it, 256 to 65,535."""
        return self._native.system_id

    @property
    def station(self) -> Station:
        """The station that receives it."""
        return self._station

    @property
    def telemetry(self) -> Telemetry:
        """A snapshot of the newest telemetry; every value has its age."""
        # Imported lazily, as plans are: defining these classes takes longer than hearing the first vehicle.
        from vencejo.telemetry import Telemetry

        return Telemetry(self._native.telemetry())

    @property
    def change_count(self) -> int:
        """A counter that changes whenever something new has come from the vehicle."""
        return self._native.change_count()

    @property
    def texts(self) -> list[StatusText]:
        """The newest STATUSTEXT messages, oldest first."""
        from vencejo.values import StatusText

        return [StatusText(*text) for text in self._native.texts()]

    @property
    def mission_progress(self) -> MissionProgress:
        """Progress of its mission."""
        from vencejo.values import MissionProgress

        return MissionProgress(**self._native.progress())

    @property
    def flight_preparation(self) -> FlightPreparation | None:
        """What `Vehicle.prepare_flight` would change now; ``None`` before the first heartbeat."""
        found = self._native.flight_preparation()
        from vencejo.values import FlightPreparation

        return None if found is None else FlightPreparation(*found)

    def plan_state(self, kind: PlanKind = "mission") -> PlanState:
        """What is known about the mission, the fence or the rally points on board."""
        from vencejo.values import PlanState

        return PlanState(**self._native.plan_state(kind))

    def plan_on_board(self, kind: PlanKind = "mission") -> Plan | None:
        """The mission, the fence or the rally points on board as they were read; ``None`` while they are not known.

        Nothing is requested from the vehicle: the station reads unknown plans by itself (see `plan_state`). `download`
        reads it now.
        """
        from vencejo.plan import Plan

        found = self._native.plan_on_board(kind)
        return None if found is None else Plan._from_native(found)

    def compare_plan(self, plan: Plan, *, kind: PlanKind = "mission") -> tuple[PlanChange, ...] | None:
        """How the mission, the fence or the rally points of a plan differ from those on board, as this vehicle keeps items.

        Nothing is requested from the vehicle: the station reads unknown plans by itself (see `plan_state`). `download`
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
            The steps from the plan on board to the given one; empty when they are the same. ``None`` while the plan on
            board is not fully known.

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
        """The link over which it is reached, with the counters of this vehicle alone; ``None`` when no link receives it."""
        from vencejo.link import LinkInfo

        info = self._native.link()
        return None if info is None else LinkInfo(**info)

    @property
    def remote_name(self) -> str | None:
        """Its name in a fleet, for a remote vehicle: one reached by its station on board and not by a link of this station."""
        return self._native.remote_name()

    @property
    def is_reached(self) -> bool | None:
        """Whether it receives our messages; ``None`` when that is not known.

        ``False``: it is heard, but has not answered for 4.5 s in spite of repeated requests. The link works in one
        direction only, or the vehicle accepts nothing without a signing key that this station lacks.
        """
        return self._native.is_reached()

    @property
    def lacks_terrain(self) -> bool:
        """Whether it requests terrain altitudes at positions that no map of the station's server covers."""
        return self._native.lacks_terrain()

    @property
    def rival(self) -> str | None:
        """Where another vehicle with the same system id is heard, in words; ``None`` without one.

        The other one is not followed, and nothing is sent to it. For an aircraft of a fleet: where another computer
        uses its name; orders go only to the one that was heard first.
        """
        return self._native.rival()

    def follow_rival(self) -> bool:
        """From now on follow and command the `rival` instead of this vehicle; only for vehicles on a link.

        Returns
        -------
        bool
            Whether there is a rival.

        Raises
        ------
        ControlHeld
            When another operator holds control.
        """
        return self._native.follow_rival()

    @property
    def signing(self) -> SigningInfo:
        """State of its MAVLink signing: the key's name, and how many messages were verified and refused."""
        return _signing_info(self._native.signing())

    @property
    def mode_names(self) -> list[str]:
        """Names of the flight modes of this kind of vehicle."""
        heartbeat = self.telemetry.heartbeat
        return [] if heartbeat is None else _native.mode_names(heartbeat.mav_type, heartbeat.autopilot)

    def on_message(
        self, callback: Callable[[MavlinkMessage], None], *, names: Iterable[str] | None = None, capacity: int = 1024
    ) -> _native.Subscription:
        """Call a function for each raw message of this vehicle, in a thread of its own.

        Parameters
        ----------
        callback : function of a MavlinkMessage
            A slow one loses the oldest messages (`Subscription.dropped`) and never delays the link. Above 4,000
            messages a second they are delivered in batches, up to 2 ms later.
        names : iterable of str, optional
            Only these messages.
        capacity : int, optional
            Most messages queued for the callback.

        Returns
        -------
        Subscription
            Close it, or use it in a ``with`` statement, to end the calls; closing the station ends them too.
        """
        subscription = self._native.subscribe_messages(None if names is None else list(names), capacity)
        _call_back(subscription, callback)
        return subscription

    def on_event(self, callback: Callable[[Event], None], *, capacity: int = 1024) -> _native.Subscription:
        """Call a function for each event of this vehicle, in a thread of its own."""
        subscription = self._native.subscribe_events(capacity)
        _call_back(subscription, lambda item: callback(_event(*item)))
        return subscription

    def send_message(
        self, name: str, *, confirm: Danger | None = None, despite_mixed_plan: bool = False, **fields: Any
    ) -> None:
        """Send any message of the dialect: the escape hatch.

        Fields are named as in the message definition, in the units of the wire; missing ones are 0. ``target_system``
        and ``target_component`` default to the vehicle. There is no acknowledgement. Refused are values that no
        autopilot can accept: numbers beyond 32 bits, positions that are not on Earth, altitudes beyond -1,000 to
        100,000 m, and a new altitude of 0, which ArduPlane takes for none. A new altitude is also refused while an
        ArduPlane lands, or may be landing in a mission that was not read. Dangerous messages have to be confirmed.
        Those that arm, follow the mission or jump in it are refused while the mission may be mixed
        (`PlanState.may_be_mixed`), unless `despite_mixed_plan` is set.

        Raises
        ------
        InvalidRequest
            For a message or field that the dialect does not have, or a value that is refused.
        NotPossibleNow
            While the mission may be mixed, and for a new altitude during a landing.
        """
        self._native.send_message(name, fields, confirm, despite_mixed_plan)

    def check_plan(self, plan: Plan) -> tuple[Finding, ...]:
        """Check a plan for this vehicle in its present state; errors come first.

        The checks use the vehicle's position and home, whether it is on the ground, whether it can hover, and the
        parameters that were read.
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
        """Rehearse a plan with this plane in a wind (calm by default), from the ground at its home, else the plan's home.

        Parameters that were read are the plane's, missing ones have the values of ArduPilot's simulated plane: read
        them first, by ``vehicle.params.all()``. Battery and power are taken from its telemetry and the flight followed
        so far. ``airframe`` (:meth:`learned` has one), ``battery``, ``ground`` and ``clearance_m`` are those of
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
        """The airframe as learned from its flight, as by :func:`vencejo.rehearsal.learn`; ``None`` while there is too little data.

        From the last ten minutes in the air, as far as this station followed them.
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
        """What follows from triggers at moments of a plan, with this plane's failsafes: see :func:`vencejo.what_if.what_if`.

        Without a plan and a moment it starts from the present flight: its mission, or GUIDED, LOITER, CIRCLE or RTL to
        their end; in a mode that a pilot steers, straight on until a failsafe decides.

        Raises
        ------
        InvalidRequest
            As there; for a plan without a moment or a moment without a plan; and without both when the vehicle is not
            known to fly, or its mode is not known.
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
        """Refuse a plan with an error, checked as one that waits on board until the plane flies."""
        from vencejo.plan import findings_of, refuse_errors

        refuse_errors(findings_of(self._native.check_plan(plan._to_native(), True)))

    # Starts of operations, shared with vencejo.aio, which only waits differently for their end.

    def _ask(
        self, name: str, *, confirm: Danger | None = None, despite_mixed_plan: bool = False, **values: Any
    ) -> _native.Pending:
        """Start a request of the core by its name and values; ``None`` stands for a value that is not given."""
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

    Every method that waits can be interrupted with Ctrl-C, which cancels its operation.

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
        """Iterate over telemetry snapshots, each taken when something new has arrived, at `rate_hz` at most.

        Parameters
        ----------
        rate_hz : float, optional
            From 0.1 to 50.
        timeout_s : float, optional
            End the stream when nothing new has arrived for this long. By default it waits for ever.

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
        """Wait until a function of the telemetry is true, and return the snapshot for which it is.

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
        """Wait a moment for something new; it returns without, so that ageing values are looked at too."""
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
            While the mission on board may be a mixture of two (`PlanState.may_be_mixed`), unless `despite_mixed_plan`
            is set, which is noted among the vehicle's texts.
        ControlHeld
            When another operator holds control. Every request raises this.
        ConfirmationNeeded
            When `force` is not confirmed.
        """
        self._wait(self._ask("arm", force=force, confirm=confirm, despite_mixed_plan=despite_mixed_plan))

    def disarm(self, *, force: bool = False, confirm: Danger | None = None) -> None:
        """Disarm; returns when the vehicle shows it.

        `force` stops the motor even in the air (``confirm="force-disarm"``). Without it, a vehicle that flies or does
        not report that it is on the ground is disarmed only with ``confirm="disarm-in-flight"``.
        """
        self._wait(self._ask("disarm", force=force, confirm=confirm))

    def set_mode(self, mode: str | int, *, despite_mixed_plan: bool = False) -> None:
        """Change the flight mode by name (``"AUTO"``, ``"fbwa"``…) or number; returns when the vehicle shows it.

        A mode that follows the mission is refused while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("mode", mode=mode, despite_mixed_plan=despite_mixed_plan))

    # Flying --------------------------------------------------------------------------------------------------------

    def takeoff(self, *, alt_rel_home_m: float) -> None:
        """Take off and climb to an altitude above home. Does not arm.

        An ArduPlane gets its take-off altitude and mode TAKEOFF: it begins to roll when it is armed.
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

        Give the altitude once, in one of its three references.

        Raises
        ------
        InvalidRequest
            For a position that is not on Earth, or is 0/0; an altitude that is missing or given twice; a radius or
            speed out of its range.
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
        """Change the minimum ground speed."""
        self._wait(self._ask("speed", kind="groundspeed", speed_m_s=groundspeed_m_s))

    def set_altitude(self, *, alt_rel_home_m: float | None = None, alt_amsl_m: float | None = None) -> None:
        """Change the altitude of the present target. Not to 0, which ArduPlane takes for no altitude.

        In AUTO it holds until the next item.

        Raises
        ------
        NotPossibleNow
            While an ArduPlane is landing, or may be landing in a mission that was not read: it would flare and stop its
            motor in the air.
        """
        self._wait(self._ask("altitude", **_height(alt_rel_home_m, alt_amsl_m)))

    def fly_course(self, course_deg: float, *, accel_m_s2: float = 5.0) -> None:
        """Turn to a course over ground and stay on it. Only for an ArduPlane that is in GUIDED.

        Parameters
        ----------
        course_deg : float
            Degrees from true north, 0 to below 360.
        accel_m_s2 : float, optional
            Greatest centripetal acceleration of the turn, 0.05 to 20; 5 is a bank of 27 degrees.
        """
        self._wait(self._ask("course", course_deg=course_deg, accel_m_s2=accel_m_s2))

    def climb_to(
        self, *, alt_rel_home_m: float | None = None, alt_amsl_m: float | None = None, rate_m_s: float
    ) -> None:
        """Climb or sink to an altitude at a rate (above 0 to 50 m/s). Only for an ArduPlane that is in GUIDED."""
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
        """Circle at the present position (mode LOITER)."""
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
        """Move home to a position, or to where the vehicle is.

        Raises
        ------
        InvalidRequest
            For a position that is not on Earth, or is 0/0.
        """
        from dataclasses import asdict

        place: dict[str, Any] = {} if home is None else asdict(home)
        self._wait(self._ask("home", **place))

    def switch_fence(self, on: bool, *, confirm: Danger | None = None) -> None:
        """Switch the fence on board on or off (``confirm="fence-off"``), until a parameter or a restart changes it.

        Raises
        ------
        CommandRefused
            When the vehicle has no fence to switch on. An ArduPlane loads its fence only once it knows its position,
            some 20 s after its start.
        ConfirmationNeeded
            When it is switched off without `confirm`.
        """
        self._wait(self._ask("switch-fence", on=on, confirm=confirm))

    def set_up_signing(self, *, key: str | None = None, any_link: bool = False) -> SigningInfo:
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
        self._wait(self._native.change_signing("set_up", key=key, any_link=any_link))
        return self.signing

    def rotate_signing(self, *, key: str | None = None, any_link: bool = False) -> SigningInfo:
        """Replace the key of a vehicle that signs; both keys are accepted until it signs with the new one.

        Parameters and exceptions are those of `set_up_signing`.
        """
        self._wait(self._native.change_signing("rotate", key=key, any_link=any_link))
        return self.signing

    def remove_signing(self, *, any_link: bool = False) -> SigningInfo:
        """Remove a vehicle's key, and wait until it no longer signs. The key stays on this machine.

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
            Give up as soon as the vehicle is lost, instead of after the transfer's own timeout.
        progress : function of (done, total), optional
            Called during the transfer.

        Raises
        ------
        PlanRefused
            When the checks find an error.
        TransferError
            When it fails; the plan on board is then unknown.
        Cancelled
            When the vehicle was lost and `while_heard` is set.
        """
        pending = self._upload(plan, kind, check, while_heard)
        self._wait(pending, progress)
        return self._uploaded(kind, pending)

    def download(self, *, kinds: Sequence[PlanKind] = ("mission",), progress: ProgressCallback | None = None) -> Plan:
        """Read the mission from the vehicle, and the fence and the rally points if `kinds` names them."""
        from vencejo.plan import Plan

        parts = {kind: Plan._from_native(self._wait(self._native.download(kind), progress)) for kind in kinds}
        return _joined(parts)

    def clear(self, *, kind: PlanKind = "mission", confirm: Danger | None = None) -> None:
        """Remove the mission (or fence, or rally points); returns when the vehicle confirms it.

        Needs ``confirm="clear-mission"``, ``"clear-fence"`` or ``"clear-rally"``.
        """
        self._wait(self._native.clear(kind, confirm))

    def prepare_flight(self, *, despite_mixed_plan: bool = False) -> None:
        """Prepare a flight, on the ground and disarmed: change to a mode that arms, and rewind the mission.

        After a landing an ArduPlane is in AUTO at the landing of its mission, or in RTL if the mission was replaced; it
        arms in neither. `flight_preparation` says what will change, and a note among the vehicle's texts (`note`)
        announces it. Nothing is armed or started.

        Raises
        ------
        NotPossibleNow
            When the vehicle is armed or in the air, and while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("prepare-flight", despite_mixed_plan=despite_mixed_plan))

    def start_mission(self, *, from_item: int | None = None, despite_mixed_plan: bool = False) -> None:
        """Begin the mission (mode AUTO), at an item counted from 1 if given. Does not arm.

        Item 1 rewinds the mission: jump counters start again. If an ArduPlane restarts its mission at each change to
        AUTO (``MIS_RESTART`` 1), ``from_item`` is set once more. Refused while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("mission/start", from_item=from_item, despite_mixed_plan=despite_mixed_plan))

    def pause_mission(self) -> None:
        """Interrupt the mission (mode LOITER)."""
        self._wait(self._ask("mission/pause"))

    def resume_mission(self, *, despite_mixed_plan: bool = False) -> None:
        """Resume the mission at its current item (mode AUTO), also with ``MIS_RESTART`` 1.

        Refused while the mission may be mixed, see `arm`.
        """
        self._wait(self._ask("mission/resume", despite_mixed_plan=despite_mixed_plan))

    def set_current_item(self, item: int, *, despite_mixed_plan: bool = False) -> None:
        """Make an item, counted from 1, the current one; refused while the mission may be mixed, see `arm`."""
        self._wait(self._ask("mission/current", item=item, despite_mixed_plan=despite_mixed_plan))

    def send_and_fly(self, plan: Plan, *, progress: ProgressCallback | None = None) -> None:
        """Upload a mission, verify it, prepare the flight, arm and start it at its first item: the one operation that does all.

        A vehicle that is armed already is neither prepared nor armed. One that was armed by this call is disarmed again
        when the mission does not start, whatever the reason: an error, Ctrl-C, a cancelled task.

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
        """Add a note to the vehicle's texts, for everyone who uses this station. Nothing is sent to the vehicle.

        Parameters
        ----------
        text : str
            Truncated to 500 characters.
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
        """Make any request by its name and values as in the HTTP API; returns when it is done, with the message it requested, if any.

        Examples
        --------
        >>> plane.ask("speed", {"kind": "airspeed", "speed_m_s": 18.0})  # doctest: +SKIP
        >>> plane.ask("request-message", {"message": "HOME_POSITION"}).fields["altitude"]  # doctest: +SKIP

        Raises
        ------
        InvalidRequest
            For an unknown name, listing the known ones, and for a value that is wrong or missing.
        ConfirmationNeeded
            When it is dangerous and not confirmed by the name of its danger.
        """
        asked = self._native.request(name, dict(values or {}), confirm, despite_mixed_plan)
        return cast("MavlinkMessage | None", self._wait(asked))

    def command(
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
        """Send any command by COMMAND_INT, with its position as scaled integers of the frame (degE7 in a global frame)."""
        asked = self._command_int(command, params, frame, x, y, z, confirm, despite_mixed_plan)
        return int(self._wait(asked) or 0)

    def request_message(self, name: str | int) -> MavlinkMessage:
        """Request one message once, by its name or number, and return it."""
        return cast("MavlinkMessage", self._wait(self._ask("request-message", message=name)))

    def set_message_rate(self, name: str | int, rate_hz: float | Literal["default", "stop"] | None) -> None:
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
        """Read one parameter.

        Raises
        ------
        ParameterError
            When the vehicle does not have it.
        """
        from vencejo.values import Parameter

        return Parameter(*self._vehicle._wait(self._vehicle._native.param_read(name)))

    def set(self, name: str, value: float, *, confirm: Danger | None = None) -> Parameter:
        """Write one parameter and return the vehicle's new value. Switching the fence off needs ``confirm="fence-off"``.

        Raises
        ------
        ParameterError
            When the vehicle does not have it, or keeps a different value.
        """
        from vencejo.values import Parameter

        return Parameter(*self._vehicle._wait(self._vehicle._native.param_set(name, float(value), confirm)))

    def all(self, *, progress: ProgressCallback | None = None) -> dict[str, Parameter]:
        """Read all parameters, by name."""
        from vencejo.values import Parameter

        found = self._vehicle._wait(self._vehicle._native.param_list(), progress)
        return {name: Parameter(name, value, kind) for name, value, kind in found}

    def __getitem__(self, name: str) -> float:
        return self.get(name).value

    def __setitem__(self, name: str, value: float) -> None:
        self.set(name, value)


def check_request(name: str, values: Mapping[str, Any]) -> None:
    """Check a request of `Vehicle.ask` without a vehicle.

    Raises
    ------
    InvalidRequest
        For an unknown name, listing the known ones, and for a value that is wrong or missing.
    """
    _native.check_request(name, dict(values))


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

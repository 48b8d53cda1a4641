"""Everything about a vehicle that needs no waiting: what is known of it, subscriptions, checks, and the starts of requests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from vencejo import _native
from vencejo._calling_back import call_back
from vencejo._forking import belongs_here
from vencejo._native import MavlinkMessage
from vencejo.errors import InvalidRequest, ParameterError

if TYPE_CHECKING:
    from vencejo.findings import Finding
    from vencejo.items import Home
    from vencejo.landing import Wind
    from vencejo.link import LinkInfo
    from vencejo.plan import Plan
    from vencejo.rehearsal import Airframe, Battery, Ground, Learned, Rehearsal
    from vencejo.signing import SigningInfo
    from vencejo.station import Station
    from vencejo.telemetry import Telemetry
    from vencejo.values import (
        Event,
        FlightPreparation,
        MissionProgress,
        PlanChange,
        PlanState,
        StatusText,
        VehicleControl,
    )
    from vencejo.what_if import Trigger, WhatIf

    _Upload: TypeAlias = tuple[_native.Pending, tuple[Finding, ...]]

__all__ = ["Danger", "PlanKind", "VehicleState", "command_number", "event_of", "height_of", "joined", "place_of"]

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
    "move-home",
]
"""Requests that can end a flight or destroy data on board, by the names with which a program confirms them."""

PlanKind = Literal["mission", "fence", "rally"]

_F32_MAX = 3.4028234663852886e38


class VehicleState:
    """State shared by `Vehicle` and `vencejo.aio.AsyncVehicle`. Nothing here waits for the vehicle."""

    def __init__(self, native: _native.Vehicle, station: Station) -> None:
        self._native = native
        self._station = station
        self._param_names: tuple[str, ...] = ()
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
    def control(self) -> VehicleControl:
        """Who has control of it, and who asks for it; for a vehicle on a link, of its station."""
        from vencejo.values import VehicleControl

        return VehicleControl(*self._native.control())

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
        from vencejo.signing import SigningInfo

        return SigningInfo(**self._native.signing())

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
            messages a second they are delivered in batches, up to 2 ms later. An exception in it is printed once for
            each type and place, and counted (`Subscription.failed`).
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
        call_back(subscription, callback)
        return subscription

    def on_event(self, callback: Callable[[Event], None], *, capacity: int = 1024) -> _native.Subscription:
        """Call a function for each event of this vehicle, in a thread of its own; as `on_message`."""
        subscription = self._native.subscribe_events(capacity)
        call_back(subscription, lambda item: callback(event_of(item)))
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

        return findings_of(self._native.check_plan(plan._to_native()))

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
            When neither the vehicle nor the plan has a home, when an item has no latitude or longitude, and for a number
            out of its range.
        """
        from vencejo._rehearsing import a_plan, blowing, profile, within
        from vencejo.rehearsal import Rehearsal

        flown = self._native.rehearse(
            a_plan(plan)._to_native(),
            blowing(wind),
            profile(airframe, battery),
            ground,
            within("clearance_m", clearance_m, 0.0, 1_000.0),
        )
        return Rehearsal._from_native(flown)

    def learned(self) -> Learned | None:
        """The airframe as learned from its flight, as by :func:`vencejo.rehearsal.learn`; ``None`` while there is too little data.

        From the last ten minutes in the air, as far as this station followed them.
        """
        from vencejo.airframe import Learned

        learned = self._native.learned()
        return None if learned is None else Learned._from_native(learned)

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
        from vencejo._rehearsing import a_plan, blowing, profile
        from vencejo.what_if import TRIGGERS, WhatIf, moments_of, names_of

        if (plan is None) is not (at_s is None):
            raise InvalidRequest("a plan comes with at_s, a moment of it; now is asked for without both")
        found = self._native.what_if(
            None if plan is None or at_s is None else (a_plan(plan)._to_native(), moments_of(at_s)),
            names_of(TRIGGERS if triggers is None else triggers),
            blowing(wind),
            profile(airframe, battery),
            ground,
        )
        if found is None:
            raise InvalidRequest("nothing can be rehearsed: it is not known to fly, and how")
        return tuple(WhatIf._from_native(one) for one in found)

    def _require_sound(self, plan: Plan, kind: PlanKind = "mission") -> tuple[Finding, ...]:
        """Refuse a part with an error, checked as one that waits on board until the plane flies; the warnings."""
        from vencejo.plan import findings_of, refuse_errors

        return refuse_errors(findings_of(self._native.check_upload(kind, plan._to_native())))

    # Starts of operations, shared with vencejo.aio, which only waits differently for their end.

    def _ask(
        self, name: str, *, confirm: Danger | None = None, despite_mixed_plan: bool = False, **values: Any
    ) -> _native.Pending:
        """Start a request of the core by its name and values; ``None`` stands for a value that is not given."""
        return self._native.request(name, values, confirm, despite_mixed_plan)

    @contextmanager
    def _suggesting(self, name: str) -> Iterator[None]:
        """Add similar names to the error of a parameter that the vehicle is known not to have."""
        try:
            yield
        except ParameterError as error:
            from difflib import get_close_matches

            known = self._param_names
            near = [] if name in known else get_close_matches(name.upper(), known)
            if not near:
                raise
            raise ParameterError(f"{error}; it has {', '.join(near)}") from None

    def _upload(self, plan: Plan, kind: PlanKind, check: bool, while_heard: bool = False) -> _Upload:
        from vencejo.plan import Plan

        if not isinstance(plan, Plan):
            raise TypeError(f"a Plan is uploaded, not a {type(plan).__name__}; Plan.load reads one from a file")
        findings = self._require_sound(plan, kind) if check else ()
        pending = self._native.upload(kind, plan._to_native(), not check)
        if while_heard:
            watch = self.on_event(lambda event: pending.cancel() if event.kind == "lost" else None)
            pending.on_done(watch.close)
        return pending, findings

    def _uploaded(self, kind: PlanKind, upload: _Upload) -> PlanState:
        from dataclasses import replace

        pending, findings = upload
        return replace(self.plan_state(kind), position_error_m=pending.position_error_m(), findings=findings)

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
        number, four = command_number(command), self._seven(params)[:4]
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


def event_of(item: tuple[str, float, dict[str, Any]]) -> Event:
    from vencejo.values import Event

    kind, time_s, detail = item
    return Event(kind, time_s, MappingProxyType(detail))


def height_of(
    alt_rel_home_m: float | None, alt_amsl_m: float | None, alt_terrain_m: float | None = None
) -> dict[str, Any]:
    heights = (("home", alt_rel_home_m), ("amsl", alt_amsl_m), ("terrain", alt_terrain_m))
    given = [{"alt_frame": frame, "alt_m": alt_m} for frame, alt_m in heights if alt_m is not None]
    if len(given) != 1:
        raise InvalidRequest("give the altitude once: as alt_rel_home_m, alt_amsl_m or alt_terrain_m")
    return given[0]


def place_of(home: Home | None) -> dict[str, Any]:
    from dataclasses import asdict

    from vencejo._given import NONE, check_argument
    from vencejo.items import Home

    check_argument("home", home, Home, NONE)
    return {} if home is None else asdict(home)


def command_number(command: int | str) -> int:
    if isinstance(command, str):
        number = _native.command_number(command)
        if number is None:
            raise InvalidRequest(f"'{command}' is no MAV_CMD; give its name, such as 'DO_CHANGE_SPEED', or number")
        return number
    if not 0 <= command <= 65_535:
        raise InvalidRequest(f"{command} is no MAV_CMD; they go from 0 to 65535")
    return int(command)


def joined(parts: Mapping[PlanKind, Plan]) -> Plan:
    from vencejo.plan import Plan

    empty = Plan()
    mission, fence, rally = (parts.get(kind, empty) for kind in ("mission", "fence", "rally"))
    return Plan(items=mission.items, home=mission.home, fence=fence.fence, rally=rally.rally)

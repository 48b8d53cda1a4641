"""Slice module ``vencejo``: telemetry, missions and control without loss."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Final, cast

from vencejo.errors import InvalidRequest
from vencejo.jderobot.access import Gate, below_home, despite_mixed_plan
from vencejo.jderobot.faults import Faults
from vencejo.jderobot.feed import Feed
from vencejo.jderobot.runtime import Slices, tolerant
from vencejo.jderobot.states import States
from vencejo.jderobot.subject import Subject
from vencejo.plan import Circle, Fence, GeoPoint, Home, MissionItem, Plan, Polygon, RallyPoint
from vencejo.values import PlanState
from vencejo.vehicle import Danger, PlanKind, Vehicle

__all__ = ["Control", "Missions", "States", "TelemetryServant", "plan_from_slice", "plan_to_slice"]

_KINDS: Final[tuple[PlanKind, ...]] = ("mission", "fence", "rally")
_MAX_ITEMS: Final = 65_534
_MAX_COMMAND: Final = 65_535
_MAX_FRAME: Final = 255


class TelemetryServant:
    """Servant of ``vencejo::Telemetry``."""

    def __init__(self, subject: Subject, states: States, faults: Faults, feed: Feed, gate: Gate) -> None:
        self._subject = subject
        self._states = states
        self._faults = faults
        self._feed = feed
        self._gate = gate

    def vehicles(self, current: Any = None) -> list[int]:
        """System ids heard so far."""
        return self._faults.at_once(self._subject.vehicles)

    def getPose(self, systemId: int, current: Any = None) -> Any:
        """Position and attitude."""
        vehicle = self._faults.at_once(lambda: self._subject.need(systemId))
        return self._states.pose(vehicle, vehicle.telemetry)

    def getNavigation(self, systemId: int, current: Any = None) -> Any:
        """Everything else."""
        vehicle = self._faults.at_once(lambda: self._subject.need(systemId))
        return self._states.navigation(vehicle, vehicle.telemetry)

    def subscribe(self, systemId: int, observer: Any, rateHz: float, current: Any = None) -> int:
        """Call an observer elsewhere."""
        refusal = self._standing("subscribe", current)
        return self._faults.at_once(
            lambda: self._feed.subscribe(self._subject.need(systemId), observer, rateHz, current.con, refusal)
        )

    def subscribeHere(self, systemId: int, identity: str, rateHz: float, current: Any = None) -> int:
        """Call an observer over this connection."""
        refusal = self._standing("subscribeHere", current)
        return self._faults.at_once(
            lambda: self._feed.subscribe_here(self._subject.need(systemId), identity, rateHz, current.con, refusal)
        )

    def unsubscribe(self, subscription: int, current: Any = None) -> None:
        """End a subscription; one that has ended already is no error."""
        self._feed.unsubscribe(subscription)

    def _standing(self, operation: str, current: Any) -> Callable[[], str | None]:
        with tolerant():
            token = current.ctx.get("token", "")
        return self._gate.standing(current.con, operation, token)


def plan_from_slice(plan: Any, unset: Any) -> Plan:
    """A plan as a client sent it.

    Raises
    ------
    InvalidRequest
        For one with nulls in it, too long, or with numbers that MAVLink has no place for.
    """

    def known(value: Any) -> Any:
        return None if value is unset else value

    parts = () if plan is None else (*(plan.items or ()), *(plan.fence or ()), *(plan.rally or ()))
    if plan is None or any(part is None for part in parts):
        raise InvalidRequest("the plan, or a part of it, is null")
    if len(parts) > _MAX_ITEMS:
        raise InvalidRequest(f"the plan has {len(parts)} parts; no vehicle holds so many")
    for number, item in enumerate(plan.items, 1):
        if not (0 <= item.command <= _MAX_COMMAND and 0 <= item.frame <= _MAX_FRAME):
            raise InvalidRequest(
                f"item {number} has command {item.command} in frame {item.frame}: a MAV_CMD goes from 0 to "
                f"{_MAX_COMMAND}, a MAV_FRAME from 0 to {_MAX_FRAME}"
            )
    home, back = known(plan.plannedHome), known(plan.fenceReturn)
    for point in (*plan.rally, *([] if back is None else [back])):
        if not 0 <= point.frame <= _MAX_FRAME:
            raise InvalidRequest(
                f"a point to return to is in frame {point.frame}: a MAV_FRAME goes from 0 to {_MAX_FRAME}"
            )
    zones: list[Polygon | Circle] = []
    for number, zone in enumerate(plan.fence, 1):
        points = tuple(GeoPoint(point.latDeg, point.lonDeg) for point in zone.points)
        radius = known(zone.radiusM)
        if radius is None:
            zones.append(Polygon(points, zone.inclusion))
        elif len(points) == 1:
            zones.append(Circle(points[0], radius, zone.inclusion))
        else:
            raise InvalidRequest(f"fence zone {number} has a radius and {len(points)} points; a circle has one")
    return Plan(
        items=tuple(
            MissionItem(
                item.command,
                item.frame,
                tuple(
                    known(value)
                    for value in (item.param1, item.param2, item.param3, item.param4, item.x, item.y, item.z)
                ),
                item.autocontinue,
            )
            for item in plan.items
        ),
        home=None if home is None else Home(home.latDeg, home.lonDeg, home.altAmslM),
        fence=Fence(tuple(zones), None if back is None else _rally_from(back)),
        rally=tuple(_rally_from(point) for point in plan.rally),
    )


def _rally_from(point: Any) -> RallyPoint:
    return RallyPoint(point.latDeg, point.lonDeg, point.altM, point.frame)


def plan_to_slice(plan: Plan, slices: Slices) -> Any:
    """A plan for a client."""
    precise, unset = slices.precise, slices.ice.Unset

    def rally(point: RallyPoint) -> Any:
        return precise.RallyPoint(point.lat_deg, point.lon_deg, point.alt_m, int(point.frame))

    def zone(zone: Polygon | Circle) -> Any:
        points = (zone.center,) if isinstance(zone, Circle) else zone.points
        radius = zone.radius_m if isinstance(zone, Circle) else unset
        return precise.Zone(zone.inclusion, [precise.GeoPoint(p.lat_deg, p.lon_deg) for p in points], radius)

    home, back = plan.home, plan.fence.return_point
    return precise.Plan(
        [
            precise.MissionItem(
                int(item.command),
                int(item.frame),
                *(unset if value is None else value for value in item.params),
                item.autocontinue,
            )
            for item in plan.items
        ],
        unset if home is None else precise.Home(home.lat_deg, home.lon_deg, home.alt_amsl_m),
        [zone(one) for one in plan.fence.zones],
        unset if back is None else rally(back),
        [rally(point) for point in plan.rally],
    )


def _confirmed(current: Any) -> Danger | None:
    """What the request's context confirms, by name under ``confirm``."""
    if current is None:
        return None
    with tolerant():
        named = current.ctx.get("confirm")
    return cast("Danger | None", named or None)


class Missions:
    """Servant of ``vencejo::Missions``."""

    def __init__(self, slices: Slices, subject: Subject, faults: Faults) -> None:
        self._slices = slices
        self._precise = slices.precise
        self._unset = slices.ice.Unset
        self._subject = subject
        self._faults = faults

    def _later(self, systemId: int, work: Callable[[Vehicle], Any]) -> Future[Any]:
        return self._faults.later(lambda: work(self._subject.need(systemId)))

    def _kind(self, kind: Any) -> PlanKind:
        return _KINDS[int(kind.value)]

    def check(self, systemId: int, thePlan: Any, current: Any = None) -> Future[Any]:
        """What would make it fail or be refused."""

        def work(vehicle: Vehicle) -> list[Any]:
            found = vehicle.check_plan(plan_from_slice(thePlan, self._unset))
            return [self._faults.finding(finding) for finding in found]

        return self._later(systemId, work)

    def upload(self, systemId: int, kind: Any, thePlan: Any, current: Any = None) -> Future[Any]:
        """Replace a plan, read it back and compare."""
        return self._later(
            systemId,
            lambda vehicle: self._state(vehicle.upload(plan_from_slice(thePlan, self._unset), kind=self._kind(kind))),
        )

    def download(self, systemId: int, kind: Any, current: Any = None) -> Future[Any]:
        """Read a plan."""
        return self._later(
            systemId, lambda vehicle: plan_to_slice(vehicle.download(kinds=(self._kind(kind),)), self._slices)
        )

    def clear(self, systemId: int, kind: Any, current: Any = None) -> Future[Any]:
        """Remove a plan."""
        return self._later(systemId, lambda vehicle: vehicle.clear(kind=self._kind(kind), confirm=_confirmed(current)))

    def getPlanState(self, systemId: int, kind: Any, current: Any = None) -> Any:
        """What is known about a plan on board."""
        return self._faults.at_once(lambda: self._state(self._subject.need(systemId).plan_state(self._kind(kind))))

    def getProgress(self, systemId: int, current: Any = None) -> Any:
        """Where the vehicle stands in its mission."""
        progress = self._faults.at_once(lambda: self._subject.need(systemId).mission_progress)
        known = {
            "item": progress.item,
            "total": progress.total,
            "distanceM": progress.distance_m,
            "timeS": progress.time_s,
            "legDistanceM": progress.leg_distance_m,
            "targetOffM": progress.target_off_m,
        }
        return self._precise.Progress(
            reached=list(progress.reached),
            isComplete=progress.is_complete,
            **{name: value for name, value in known.items() if value is not None},
        )

    def prepareFlight(self, systemId: int, current: Any = None) -> Future[Any]:
        """Bring it into a mode that arms, and the mission to its beginning."""
        despite = despite_mixed_plan(current)
        return self._later(systemId, lambda vehicle: vehicle.prepare_flight(despite_mixed_plan=despite))

    def start(self, systemId: int, fromItem: int, current: Any = None) -> Future[Any]:
        """Begin; does not arm."""
        despite = despite_mixed_plan(current)
        return self._later(
            systemId, lambda vehicle: vehicle.start_mission(from_item=fromItem or None, despite_mixed_plan=despite)
        )

    def pause(self, systemId: int, current: Any = None) -> Future[Any]:
        """Interrupt."""
        return self._later(systemId, lambda vehicle: vehicle.pause_mission())

    def resume(self, systemId: int, current: Any = None) -> Future[Any]:
        """Go on."""
        despite = despite_mixed_plan(current)
        return self._later(systemId, lambda vehicle: vehicle.resume_mission(despite_mixed_plan=despite))

    def setCurrentItem(self, systemId: int, item: int, current: Any = None) -> Future[Any]:
        """Go to an item."""
        despite = despite_mixed_plan(current)
        return self._later(systemId, lambda vehicle: vehicle.set_current_item(item, despite_mixed_plan=despite))

    def _state(self, state: PlanState) -> Any:
        return self._precise.PlanState(
            state.state,
            self._unset if state.count is None else state.count,
            self._unset if state.hash is None else state.hash,
            state.detail,
            state.may_be_mixed,
        )


class Control:
    """Servant of ``vencejo::Control``."""

    def __init__(self, subject: Subject, faults: Faults) -> None:
        self._subject = subject
        self._faults = faults

    def _later(self, systemId: int, work: Callable[[Vehicle], Any]) -> Future[Any]:
        return self._faults.later(lambda: work(self._subject.need(systemId)))

    def arm(self, systemId: int, current: Any = None) -> Future[Any]:
        """Arm."""
        despite = despite_mixed_plan(current)
        return self._later(systemId, lambda vehicle: vehicle.arm(despite_mixed_plan=despite))

    def disarm(self, systemId: int, current: Any = None) -> Future[Any]:
        """Disarm."""
        return self._later(systemId, lambda vehicle: vehicle.disarm(confirm=_confirmed(current)))

    def modes(self, systemId: int, current: Any = None) -> list[str]:
        """Names of its modes."""
        return self._faults.at_once(lambda: self._subject.need(systemId).mode_names)

    def setMode(self, systemId: int, mode: str, current: Any = None) -> Future[Any]:
        """Change the mode."""
        despite = despite_mixed_plan(current)
        return self._later(systemId, lambda vehicle: vehicle.set_mode(mode, despite_mixed_plan=despite))

    def takeoff(self, systemId: int, altRelHomeM: float, current: Any = None) -> Future[Any]:
        """Take off; does not arm."""
        return self._later(systemId, lambda vehicle: vehicle.takeoff(alt_rel_home_m=altRelHomeM))

    def goTo(
        self,
        systemId: int,
        latDeg: float,
        lonDeg: float,
        altRelHomeM: float,
        changeMode: bool,
        current: Any = None,
    ) -> Future[Any]:
        """Fly to a position."""
        below = below_home(current)
        return self._later(
            systemId,
            lambda vehicle: vehicle.goto(
                latDeg, lonDeg, alt_rel_home_m=altRelHomeM, change_mode=changeMode, below_home=below
            ),
        )

    def loiter(self, systemId: int, current: Any = None) -> Future[Any]:
        """Circle here."""
        return self._later(systemId, lambda vehicle: vehicle.loiter())

    def returnToLaunch(self, systemId: int, current: Any = None) -> Future[Any]:
        """Return."""
        return self._later(systemId, lambda vehicle: vehicle.return_to_launch())

    def land(self, systemId: int, current: Any = None) -> Future[Any]:
        """Land."""
        despite = despite_mixed_plan(current)
        return self._later(systemId, lambda vehicle: vehicle.land(despite_mixed_plan=despite))

    def abortLanding(self, systemId: int, current: Any = None) -> Future[Any]:
        """Climb away."""
        return self._later(systemId, lambda vehicle: vehicle.abort_landing())

    def setAirspeed(self, systemId: int, airspeedMS: float, current: Any = None) -> Future[Any]:
        """Change the airspeed."""
        return self._later(systemId, lambda vehicle: vehicle.set_airspeed(airspeedMS))

    def setAltitude(self, systemId: int, altRelHomeM: float, current: Any = None) -> Future[Any]:
        """Change the height."""
        below = below_home(current)
        return self._later(systemId, lambda vehicle: vehicle.set_altitude(alt_rel_home_m=altRelHomeM, below_home=below))

    def flyCourse(
        self,
        systemId: int,
        courseDeg: float,
        accelMS2: float,
        current: Any = None,
    ) -> Future[Any]:
        """Turn to a course."""
        return self._later(systemId, lambda vehicle: vehicle.fly_course(courseDeg, accel_m_s2=accelMS2))

    def climbTo(self, systemId: int, altAmslM: float, rateMS: float, current: Any = None) -> Future[Any]:
        """Climb or sink."""
        below = below_home(current)
        return self._later(
            systemId,
            lambda vehicle: vehicle.climb_to(alt_amsl_m=altAmslM, rate_m_s=rateMS or None, below_home=below),
        )

    def setVelocity(
        self,
        systemId: int,
        forwardMS: float,
        rightMS: float,
        downMS: float,
        yawRateRadS: float,
        current: Any = None,
    ) -> Future[Any]:
        """Fly at a velocity."""
        return self._later(
            systemId,
            lambda vehicle: vehicle.set_velocity(
                forward_m_s=forwardMS, right_m_s=rightMS, down_m_s=downMS, yaw_rate_rad_s=yawRateRadS
            ),
        )

    def command(self, systemId: int, command: int, params: list[float], current: Any = None) -> Future[Any]:
        """Any command."""
        despite, confirm = despite_mixed_plan(current), _confirmed(current)
        return self._later(
            systemId, lambda vehicle: vehicle.command(command, *params, confirm=confirm, despite_mixed_plan=despite)
        )

"""Mission: a list of poses becomes a mission that the vehicle flies."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from vencejo.errors import Busy, Cancelled, InvalidRequest, ParameterError, VehicleLost, VencejoError
from vencejo.geodesy import distance_m
from vencejo.jderobot.access import despite_mixed_plan
from vencejo.jderobot.answers import Answer, answer_of
from vencejo.jderobot.marks import Marks, Taken
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.settings import MissionPolicy
from vencejo.jderobot.subject import Subject, stand_down
from vencejo.jderobot.workers import Workers
from vencejo.landing import LandingCaution, Wind, design_landing
from vencejo.plan import Frame, GeoPoint, MissionItem, Plan
from vencejo.values import PlanState
from vencejo.vehicle import Vehicle

__all__ = [
    "MAX_HEIGHT_M",
    "MAX_POSES",
    "Mission",
    "MissionOfPoses",
    "Situation",
    "check_poses",
    "mission_of",
    "poses_of",
]

MAX_POSES: Final = 700
"""An autopilot holds about as many (ArduPlane 724 items)."""
MIN_HEIGHT_M: Final = 1.0
"""A waypoint lower than this is on the ground."""
MAX_HEIGHT_M: Final = 10_000.0
TAKEOFF_PITCH_DEG: Final = 15.0
HOVERING: Final = frozenset({2, 3, 4, 13, 14, 15, 29, 35})
"""MAV_TYPE of what hovers: rotors of any number, coaxial, helicopter. The rest is taken for a plane, VTOL too."""
_NAV_LAST: Final = 95
"""MAV_CMD_NAV_LAST: commands above it are flown to nowhere."""
_APART_M: Final = 20.0
"""Poses nearer to each other than this give no landing direction."""
_ARDUPILOT: Final = 3
_WORRYING: Final = frozenset({"steep-approach", "tailwind"})
"""Cautions of a landing that a pilot must see; that the ground's height is taken to be home's is this interface's rule."""

Pose = tuple[float, float, float]
"""Latitude, longitude in degrees, height above home in metres."""
Sent = tuple[float, float, float, float, float, float, float, float]
"""A Pose3DData as a client sends it: x, y, z, h, q0 to q3."""


@dataclass(frozen=True)
class Situation:
    """What is known about the vehicle for which a mission is made.

    Attributes
    ----------
    hovers : bool
        Whether it lands without an approach.
    position : GeoPoint or None
        Where it is.
    wind : Wind or None
    has_land_start : bool
        Whether it flies with DO_LAND_START before a landing. An ArduPlane does not arm with one while RTL_AUTOLAND is
        0.
    """

    hovers: bool = False
    position: GeoPoint | None = None
    wind: Wind | None = None
    has_land_start: bool = True


def check_poses(poses: Sequence[Pose], marks: Taken) -> None:
    """Refuse poses that cannot be a mission, whatever the vehicle.

    Parameters
    ----------
    poses : sequence of (lat_deg, lon_deg, alt_rel_home_m)
    marks : Taken
        Whether the first is the take-off, and the last the landing.

    Raises
    ------
    InvalidRequest
        For a pose that cannot be, none, or too many.
    """
    if not poses:
        raise InvalidRequest("the mission has no pose")
    if len(poses) > MAX_POSES:
        raise InvalidRequest(f"the mission has {len(poses)} poses; a vehicle holds {MAX_POSES}")
    if marks.takeoff and marks.land and len(poses) < 2:
        raise InvalidRequest("one pose cannot be both take-off and landing; send at least two")
    last = len(poses) - 1
    for number, (lat, lon, height) in enumerate(poses):
        problem = _problem(lat, lon, height, is_landing=marks.land and number == last)
        if problem is not None:
            raise InvalidRequest(f"pose {number + 1} of {len(poses)}: {problem}")


def mission_of(
    poses: Sequence[Pose], marks: Taken, situation: Situation | None = None
) -> tuple[Plan, tuple[LandingCaution, ...]]:
    """The mission of some poses, and what should be said of its landing.

    Parameters
    ----------
    poses : sequence of (lat_deg, lon_deg, alt_rel_home_m)
    marks : Taken
        Whether the first is the take-off, and the last the landing. The height of a landing is home's; its approach is
        designed for it (`vencejo.landing`), in the direction that leads from the nearest pose before it that is another
        place, which is how whoever places the last poses chooses the runway's; else into the wind, else from where the
        vehicle is.
    situation : Situation, optional

    Raises
    ------
    InvalidRequest
        As `check_poses`; and when nothing says in which direction to land.
    """
    check_poses(poses, marks)
    situation = situation or Situation()
    items = [MissionItem.waypoint(lat, lon, alt_rel_home_m=height) for lat, lon, height in poses]
    if marks.takeoff:
        lat, lon, height = poses[0]
        items[0] = MissionItem.takeoff(lat, lon, alt_rel_home_m=height, pitch_deg=TAKEOFF_PITCH_DEG)
    if not marks.land:
        return Plan(items=tuple(items)), ()
    there = GeoPoint(*poses[-1][:2])
    if situation.hovers:
        items[-1] = MissionItem.land(there.lat_deg, there.lon_deg)
        return Plan(items=tuple(items)), ()
    before = (GeoPoint(lat, lon) for lat, lon, _ in reversed(poses[:-1]))
    coming_from = next((place for place in before if distance_m(place, there) >= _APART_M), None)
    if coming_from is None and (situation.wind is None or situation.wind.is_calm):
        coming_from = situation.position
    landing = design_landing(
        there, coming_from=coming_from, wind=situation.wind, has_land_start=situation.has_land_start
    )
    return Plan(items=(*items[:-1], *landing.items)), landing.cautions


def _problem(lat: float, lon: float, height: float, *, is_landing: bool) -> str | None:
    if not all(map(math.isfinite, (lat, lon, height))):
        return "x, y and h must be numbers"
    if not (-90.0 <= lat <= 90.0 and -180.0 <= lon <= 180.0):
        return f"x {lat:g}, y {lon:g} is off the globe; x is the latitude, y the longitude in degrees"
    if lat == 0.0 and lon == 0.0:
        return "x and y are 0, which is not a chosen position"
    if abs(height) > MAX_HEIGHT_M or (not is_landing and height < MIN_HEIGHT_M):
        return f"h is {height:g} m above home, should be {MIN_HEIGHT_M:g} to {MAX_HEIGHT_M:g}"
    return None


def poses_of(plan: Plan, home_alt_amsl_m: float | None) -> list[Pose]:
    """Positions of a mission with altitudes above home; those above terrain are left out, because their altitude is not known."""
    poses = []
    for item in plan.items:
        lat, lon, alt = item.lat_deg, item.lon_deg, item.alt_m
        if item.command > _NAV_LAST or lat is None or lon is None or alt is None or (lat == 0.0 and lon == 0.0):
            continue
        if item.frame == Frame.GLOBAL:
            if home_alt_amsl_m is None:
                continue
            alt -= home_alt_amsl_m
        elif item.frame != Frame.GLOBAL_RELATIVE_ALT:
            continue
        poses.append((lat, lon, alt))
    return poses


class Mission:
    """Servant of ``jderobot::Mission`` in the usual dialect; the other one's (`MissionOfPoses`) is a view of it."""

    def __init__(self, slices: Slices, subject: Subject, workers: Workers, marks: Marks, policy: MissionPolicy) -> None:
        self._slices = slices
        self._subject = subject
        self._workers = workers
        self._marks = marks
        self._policy = policy
        self._busy = threading.Lock()
        self._known: tuple[str, list[Sent]] | None = None
        """Fingerprint of a mission on board and its poses."""

    def getMissionData(self, current: Any = None) -> Any:
        """The mission on board, from any sender; the last known one while it cannot be read, empty before any."""
        return self.given(self._slices.jderobot.MissionData)

    def setMissionData(self, data: Any, current: Any = None) -> Any:
        """Send, verify, arm and start a mission, or only send and verify it, as the setting says."""
        return self.taken(getattr(data, "mission", None), despite_mixed_plan(current))

    def given(self, wrap: Callable[[list[Any]], Any]) -> Any:
        """The mission on board, its poses wrapped as a dialect passes them."""
        try:
            return self._workers.later(lambda: wrap(self._poses(self._on_board())))
        except Busy:
            return wrap(self._poses(self._last_known()))

    def taken(self, poses: Sequence[Any] | None, despite: bool = False) -> Any:
        """What becomes of the poses of a mission: an answer, or the future of one."""
        # Marks are for the mission that follows them, sound or not: they never act after it.
        marks = self._marks.take()
        try:
            return self._workers.later(lambda: int(self._fly(poses or (), marks, despite)))
        except Busy as error:
            self._subject.tell(f"a mission was refused: {error}")
            return int(Answer.BUSY)

    def _fly(self, poses: Sequence[Any], marks: Taken, despite: bool) -> Answer:
        if not self._busy.acquire(blocking=False):
            self._subject.tell("a mission was refused: another one is on its way")
            return Answer.BUSY
        step = "refused"
        try:
            if any(pose is None for pose in poses):
                raise InvalidRequest("a pose is null")
            sent: list[Sent] = [(p.x, p.y, p.z, p.h, p.q0, p.q1, p.q2, p.q3) for p in poses]
            places: list[Pose] = [(pose.x, pose.y, pose.h) for pose in poses]
            check_poses(places, marks)  # bad ones are refused whether or not there is a vehicle
            vehicle = self._subject.hear()
            telemetry = vehicle.telemetry
            stands = telemetry.is_on_ground
            if stands is None:  # it does not say: disarmed is on the ground
                stands = telemetry.is_armed is False
            if stands and not marks.takeoff and self._policy == "fly":
                raise InvalidRequest("the vehicle is on the ground; call takeoff() of ArDroneExtra before the mission")
            plan, cautions = mission_of(places, marks, self._situation(vehicle, marks))
            vehicle._require_sound(plan)
            for caution in cautions:
                self._subject.tell(f"a mission's landing: {caution.message}", is_problem=caution.code in _WORRYING)
            step = "not sent"
            state = self._upload(vehicle, plan)
            if state.hash is not None:
                self._known = (state.hash, sent)
            if self._policy == "upload":
                self._subject.tell(f"a mission of {len(plan)} items is on board; it was not started", is_problem=False)
                return Answer.DONE
            step = "not armed for"
            self._workers.go_on()
            if not vehicle.telemetry.is_armed:
                # A text in the station says before what it changes.
                vehicle.prepare_flight(despite_mixed_plan=despite)
                self._workers.go_on()
                vehicle.arm(despite_mixed_plan=despite)
                step = "not started"
                self._workers.go_on(otherwise=lambda: stand_down(vehicle))
            step = "not started, and the vehicle is armed"
            vehicle.start_mission(from_item=1, despite_mixed_plan=despite)
        except VencejoError as error:
            self._subject.tell(f"a mission was {step}: {error}")
            answer = answer_of(error)
            # A refusal before the upload is the sender's fault, a later one the vehicle's.
            return Answer.FAILED if answer is Answer.BAD_VALUE and step != "refused" else answer
        finally:
            self._busy.release()
        self._subject.tell(f"a mission of {len(plan)} items is being flown", is_problem=False)
        return Answer.DONE

    @staticmethod
    def _upload(vehicle: Vehicle, plan: Plan) -> PlanState:
        """Upload it while the vehicle is heard. One that is heard again later must not get a mission reported as failed."""
        try:
            return vehicle.upload(plan, while_heard=True)
        except Cancelled as error:
            raise VehicleLost("the vehicle was lost meanwhile, and it was given up") from error

    def _situation(self, vehicle: Vehicle, marks: Taken) -> Situation:
        telemetry = vehicle.telemetry
        heartbeat, position, wind = telemetry.heartbeat, telemetry.position, telemetry.wind
        hovers = heartbeat is not None and heartbeat.mav_type in HOVERING
        at = None
        if position is not None and position.lat_deg is not None and position.lon_deg is not None:
            at = GeoPoint(position.lat_deg, position.lon_deg)
        blows = None
        if wind is not None and wind.freshness != "lost" and wind.from_deg is not None and wind.speed_m_s is not None:
            blows = Wind(wind.from_deg, wind.speed_m_s)
        has_land_start = True
        if marks.land and not hovers and heartbeat is not None and heartbeat.autopilot == _ARDUPILOT:
            with contextlib.suppress(ParameterError):  # without the parameter nothing is in the way of DO_LAND_START
                has_land_start = vehicle.params["RTL_AUTOLAND"] != 0.0
            if not has_land_start:
                self._subject.tell(
                    "a mission's landing is flown at its end only: RTL_AUTOLAND is 0, so a return does not find it",
                    is_problem=False,
                )
        return Situation(hovers, at, blows, has_land_start)

    def _on_board(self) -> list[Sent]:
        try:
            vehicle = self._subject.need()
            state = vehicle.plan_state()
            if state.state == "unknown":
                plan = vehicle.download()
                state = vehicle.plan_state()
                self._remember(vehicle, state.hash, plan)
            elif state.state == "empty":
                self._known = None
            elif state.hash is not None and (self._known is None or self._known[0] != state.hash):
                self._remember(vehicle, state.hash, vehicle.download())
        except VencejoError:
            pass  # the last known one
        return self._last_known()

    def _last_known(self) -> list[Sent]:
        return [] if self._known is None else self._known[1]

    def _remember(self, vehicle: Vehicle, fingerprint: str | None, plan: Plan) -> None:
        home = vehicle.telemetry.home
        places = poses_of(plan, None if home is None else home.alt_amsl_m)
        self._known = (fingerprint or "", [(lat, lon, alt, alt, 1.0, 0.0, 0.0, 0.0) for lat, lon, alt in places])

    def _poses(self, poses: list[Sent]) -> list[Any]:
        return [self._slices.jderobot.Pose3DData(*pose) for pose in poses]


class MissionOfPoses:
    """Servant of ``jderobot::Mission`` in the other dialect, which passes the poses without an object around them."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission

    def getMissionData(self, current: Any = None) -> Any:
        """The mission on board."""
        return self._mission.given(list)

    def setMissionData(self, data: Any, current: Any = None) -> Any:
        """Send, verify, arm and start a mission, as in the other dialect."""
        return self._mission.taken(data, despite_mixed_plan(current))

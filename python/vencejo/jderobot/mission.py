"""Mission: a list of poses becomes a mission that the vehicle flies."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from typing import Any, Final

from vencejo.errors import InvalidRequest, VencejoError
from vencejo.jderobot.answers import Answer, answer_of
from vencejo.jderobot.landing import approach
from vencejo.jderobot.marks import Marks, Taken
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.settings import MissionPolicy
from vencejo.jderobot.subject import Subject
from vencejo.jderobot.workers import Workers
from vencejo.plan import Frame, GeoPoint, MissionItem, Plan
from vencejo.vehicle import Vehicle

__all__ = ["MAX_HEIGHT_M", "MAX_POSES", "Mission", "mission_of", "poses_of"]

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

Pose = tuple[float, float, float]
"""Latitude, longitude in degrees, height above home in metres."""


def mission_of(poses: Sequence[Pose], marks: Taken, *, hovers: bool = False) -> Plan:
    """The mission of some poses.

    Parameters
    ----------
    poses : sequence of (lat_deg, lon_deg, alt_rel_home_m)
    marks : Taken
        Whether the first is the take-off, and the last the landing. The height of a landing is home's, and its approach
        is made for it (`vencejo.jderobot.landing`).
    hovers : bool, optional
        For a vehicle that lands without an approach.

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
        is_landing = marks.land and number == last
        problem = _problem(lat, lon, height, is_landing=is_landing)
        if problem is not None:
            raise InvalidRequest(f"pose {number + 1} of {len(poses)}: {problem}")
    items: list[MissionItem] = []
    for number, (lat, lon, height) in enumerate(poses):
        if marks.takeoff and number == 0:
            items.append(MissionItem.takeoff(lat, lon, alt_rel_home_m=height, pitch_deg=TAKEOFF_PITCH_DEG))
        elif marks.land and number == last and hovers:
            items.append(MissionItem.land(lat, lon))
        elif marks.land and number == last:
            before = (poses[number - 1][0], poses[number - 1][1]) if number else None
            items += approach(before, (lat, lon))
        else:
            items.append(MissionItem.waypoint(lat, lon, alt_rel_home_m=height))
    return Plan(items=tuple(items))


def _problem(lat: float, lon: float, height: float, *, is_landing: bool) -> str | None:
    if not all(map(math.isfinite, (lat, lon, height))):
        return "x, y and h must be numbers"
    if not (-90.0 <= lat <= 90.0 and -180.0 <= lon <= 180.0):
        return f"x {lat:g}, y {lon:g} is off the globe; x is the latitude, y the longitude in degrees"
    if lat == 0.0 and lon == 0.0:
        return "x and y are 0, which is no place that was chosen"
    if abs(height) > MAX_HEIGHT_M or (not is_landing and height < MIN_HEIGHT_M):
        return f"h is {height:g} m above home; it goes from {MIN_HEIGHT_M:g} to {MAX_HEIGHT_M:g}"
    return None


def poses_of(plan: Plan, home_alt_amsl_m: float | None) -> list[Pose]:
    """The places that a mission flies to, with heights above home; those above terrain are left out: nobody knows them."""
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
    """Servant of ``jderobot::Mission``, in either dialect."""

    def __init__(self, slices: Slices, subject: Subject, workers: Workers, marks: Marks, policy: MissionPolicy) -> None:
        self._slices = slices
        self._subject = subject
        self._workers = workers
        self._marks = marks
        self._policy = policy
        self._busy = threading.Lock()
        self._known: tuple[str, list[Pose]] | None = None
        """Fingerprint of a mission on board and its poses."""

    def getMissionData(self, current: Any = None) -> Any:
        """The mission on board, whoever sent it; the last one known while it cannot be read, empty before any."""
        return self._workers.later(lambda: self._wrapped(self._on_board()))

    def setMissionData(self, data: Any, current: Any = None) -> Any:
        """Send, verify, arm and start a mission, or only send and verify it, as the setting says."""
        poses = data if self._slices.dialect == "sequence" else getattr(data, "mission", None)
        # Marks are for the mission that follows them, sound or not: they never act after it.
        marks = self._marks.take()
        return self._workers.later(lambda: int(self._fly(poses, marks)))

    def _fly(self, poses: Sequence[Any] | None, marks: Taken) -> Answer:
        if not self._busy.acquire(blocking=False):
            self._subject.tell("a mission was refused: another one is on its way")
            return Answer.BUSY
        step = "refused"
        try:
            if any(pose is None for pose in poses or ()):
                raise InvalidRequest("a pose is null")
            sent = [(pose.x, pose.y, pose.h) for pose in poses or ()]
            plan = mission_of(sent, marks)  # a bad one is refused whether or not there is a vehicle
            vehicle = self._subject.need()
            heartbeat = vehicle.telemetry.heartbeat
            if heartbeat is not None and heartbeat.mav_type in HOVERING:
                plan = mission_of(sent, marks, hovers=True)
            on_ground = vehicle.telemetry.is_on_ground
            if on_ground and not marks.takeoff and self._policy == "fly":
                raise InvalidRequest("the vehicle is on the ground; call takeoff() of ArDroneExtra before the mission")
            home = vehicle.telemetry.home
            plan.require_sound(position=None if home is None else GeoPoint(home.lat_deg, home.lon_deg))
            step = "not sent"
            state = vehicle.upload(plan)
            if state.hash is not None:
                self._known = (state.hash, sent)
            if self._policy == "upload":
                self._subject.tell(f"a mission of {len(plan)} items is on board; it was not started", is_problem=False)
                return Answer.DONE
            step = "not armed for"
            if not vehicle.telemetry.is_armed:
                vehicle.arm()
            step = "not started"
            vehicle.start_mission(from_item=1)
        except VencejoError as error:
            self._subject.tell(f"a mission was {step}: {error}")
            answer = answer_of(error)
            # What is refused before the vehicle has it is the sender's; later, the vehicle's.
            return Answer.FAILED if answer is Answer.BAD_VALUE and step != "refused" else answer
        finally:
            self._busy.release()
        self._subject.tell(f"a mission of {len(plan)} items is being flown", is_problem=False)
        return Answer.DONE

    def _on_board(self) -> list[Pose]:
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
        return [] if self._known is None else self._known[1]

    def _remember(self, vehicle: Vehicle, fingerprint: str | None, plan: Plan) -> None:
        home = vehicle.telemetry.home
        self._known = (fingerprint or "", poses_of(plan, None if home is None else home.alt_amsl_m))

    def _wrapped(self, poses: list[Pose]) -> Any:
        jderobot = self._slices.jderobot
        data = [jderobot.Pose3DData(x=lat, y=lon, z=alt, h=alt, q0=1.0) for lat, lon, alt in poses]
        return data if self._slices.dialect == "sequence" else jderobot.MissionData(data)

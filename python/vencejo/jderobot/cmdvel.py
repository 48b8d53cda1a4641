"""CMDVel: velocities for what hovers; speed, course and climb for a plane in GUIDED.

Commands come in ROS's axes (REP 103, which AR.Drone drivers keep): x forward, y left, z up, turns to the left positive.
A plane cannot stop: its targets are its airspeed (x), its turn (angular z, flown as a course that leads by the turn),
and its climb (z, flown as a height that rises with it). When no new command comes in time, what hovers stops, and
a plane flies straight and level on.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from vencejo.errors import VencejoError
from vencejo.jderobot.answers import Answer, answer_of
from vencejo.jderobot.subject import Subject
from vencejo.telemetry import Telemetry
from vencejo.vehicle import Vehicle

__all__ = ["CMDVel", "PlaneTargets", "Targets", "Velocity"]

_MAX_M_S: Final = 50.0
_MAX_RAD_S: Final = 10.0
_LEAD_S: Final = 4.0
"""How far the course leads the plane, and the height may: long enough to outlast a lost command, short enough to be
harmless."""
_MAX_LEAD_RAD: Final = math.radians(150.0)
"""Less than half a turn, so that the plane turns in the commanded direction."""
_REFRESH_S: Final = 0.5
_TICK_S: Final = 0.1
_SPEED_STEP_M_S: Final = 0.1
_MIN_SPEED_M_S: Final = 0.1
_MIN_CLIMB_M_S: Final = 0.05
_MIN_TURN_RAD_S: Final = 0.01
_COURSE_ACCEL_M_S2: Final = 5.0
_FIXED_WING: Final = 1


@dataclass(frozen=True)
class Velocity:
    """A command: m/s forward, left, up, and rad/s to the left."""

    forward_m_s: float = 0.0
    left_m_s: float = 0.0
    up_m_s: float = 0.0
    left_rad_s: float = 0.0

    @property
    def is_possible(self) -> bool:
        """Whether it may be sent to an aircraft."""
        speeds = (self.forward_m_s, self.left_m_s, self.up_m_s)
        return all(math.isfinite(v) and abs(v) <= _MAX_M_S for v in speeds) and (
            math.isfinite(self.left_rad_s) and abs(self.left_rad_s) <= _MAX_RAD_S
        )


@dataclass(frozen=True)
class Targets:
    """What to tell a plane now; ``None`` leaves it as it is.

    Attributes
    ----------
    airspeed_m_s : float or None
    course : (course_deg, accel_m_s2) or None
    alt_amsl_m : float or None
    """

    airspeed_m_s: float | None = None
    course: tuple[float, float] | None = None
    alt_amsl_m: float | None = None


def _course_deg(course_rad: float) -> float:
    """A course from 0 to below 360 degrees: what is a hair below 0 is 360 after one remainder."""
    return math.degrees(course_rad) % 360.0 % 360.0


class PlaneTargets:
    """Turns velocity commands into a plane's targets. Time comes in as an argument."""

    def __init__(self) -> None:
        self._speed_m_s: float | None = None
        self._turning = False
        self._climb: tuple[float, float, float] | None = None
        self._is_level = False
        self._straight = False
        self._refreshed_s = -math.inf

    def targets(
        self, wanted: Velocity | None, now_s: float, *, course_rad: float, groundspeed_m_s: float, alt_amsl_m: float
    ) -> Targets:
        """What to send now.

        Parameters
        ----------
        wanted : Velocity or None
            ``None`` when no new command came in time: straight and level.
        now_s : float
        course_rad, groundspeed_m_s, alt_amsl_m : float
            How the plane flies: course over ground from true north.
        """
        velocity = wanted or Velocity()
        turn = velocity.left_rad_s if abs(velocity.left_rad_s) >= _MIN_TURN_RAD_S else 0.0
        up = velocity.up_m_s if abs(velocity.up_m_s) >= _MIN_CLIMB_M_S else 0.0
        speed = velocity.forward_m_s if velocity.forward_m_s >= _MIN_SPEED_M_S else None
        airspeed = None
        if speed is not None and (self._speed_m_s is None or abs(speed - self._speed_m_s) >= _SPEED_STEP_M_S):
            airspeed = self._speed_m_s = speed
        is_due = now_s - self._refreshed_s >= _REFRESH_S
        course = height_m = None
        if turn and (is_due or not self._turning):
            lead = min(abs(turn) * _LEAD_S, _MAX_LEAD_RAD)
            # The bank that turns at this rate: centripetal acceleration = speed × turn rate.
            accel = min(20.0, max(0.05, abs(turn) * groundspeed_m_s))
            course = (_course_deg(course_rad - math.copysign(lead, turn)), accel)
        elif not turn and (self._turning or not self._straight):
            course = (_course_deg(course_rad), _COURSE_ACCEL_M_S2)
        if up and (is_due or self._climb is None):
            height_m = self._height_m(up, now_s, alt_amsl_m)
        elif not up and not self._is_level:
            self._climb, height_m = None, alt_amsl_m
        self._turning, self._straight, self._is_level = bool(turn), not turn, not up
        if is_due:
            self._refreshed_s = now_s
        return Targets(airspeed, course, height_m)

    def _height_m(self, up_m_s: float, now_s: float, alt_amsl_m: float) -> float:
        """The height at the next refresh. It rises from where the climb began: ArduPlane makes hardly a climb of a rate."""
        before = self._climb
        if before is None or before[2] * up_m_s < 0.0:
            before = (alt_amsl_m, now_s, up_m_s)
        lead_m = abs(up_m_s) * _LEAD_S
        due_m = before[0] + up_m_s * (now_s - before[1])
        due_m = max(alt_amsl_m - lead_m, min(alt_amsl_m + lead_m, due_m))
        self._climb = (due_m, now_s, up_m_s)
        return due_m + up_m_s * _REFRESH_S


class CMDVel:
    """Servant of ``jderobot::CMDVel``."""

    def __init__(self, subject: Subject, watchdog_s: float, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._subject = subject
        self._watchdog_s = watchdog_s
        self._clock = clock
        self._changed = threading.Condition()
        self._newest: tuple[Velocity, float] | None = None
        self._plane: PlaneTargets | None = None
        self._failed = Answer.DONE
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="vencejo-ice-velocity", daemon=True)
        self._thread.start()

    def setCMDVelData(self, data: Any, current: Any = None) -> int:
        """Accept a velocity. The vehicle must be in GUIDED already: velocities do not change its mode."""
        if data is None:
            return int(Answer.BAD_VALUE)
        velocity = Velocity(data.linearX, data.linearY, data.linearZ, data.angularZ)
        if not velocity.is_possible:
            return int(Answer.BAD_VALUE)
        vehicle = self._subject.find()
        heartbeat = None if vehicle is None else vehicle.telemetry.heartbeat
        if heartbeat is None or heartbeat.freshness == "lost":
            return int(Answer.NO_VEHICLE)
        if heartbeat.mode not in ("GUIDED", "OFFBOARD"):
            return int(Answer.WRONG_MODE)
        with self._changed:
            self._newest = (velocity, self._clock())
            failed, self._failed = self._failed, Answer.DONE
            self._changed.notify_all()
        return int(failed)

    def close(self) -> None:
        """End; a vehicle that moves is stopped first."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                if self._newest is None:
                    if self._closed:
                        return
                    self._changed.wait()
                    continue
                velocity, at_s = self._newest
                is_over = self._closed or self._clock() - at_s >= self._watchdog_s
                if is_over:
                    self._newest = None
            self._send(None if is_over else velocity)
            with self._changed:
                if self._newest is not None and self._newest == (velocity, at_s) and not self._closed:
                    rest = at_s + self._watchdog_s - self._clock()
                    self._changed.wait(max(0.0, min(_TICK_S, rest)))

    def _send(self, velocity: Velocity | None) -> None:
        """Send a velocity; ``None`` once they have ended."""
        self._attempt(lambda: self._send_velocity(velocity))

    def _attempt(self, send: Callable[[], None]) -> None:
        """Send something; what goes wrong is the next command's answer, which never says that nothing was sent."""
        try:
            send()
        except VencejoError as error:
            answer = answer_of(error)
            self._failed = Answer.FAILED if answer is Answer.BAD_VALUE else answer
            self._subject.tell(f"velocity: {error}")

    def _send_velocity(self, velocity: Velocity | None) -> None:
        vehicle = self._subject.need()
        telemetry = vehicle.telemetry
        if telemetry.mode not in ("GUIDED", "OFFBOARD"):
            self._plane = None  # the pilot, or somebody, took over
            return
        if telemetry.heartbeat is not None and telemetry.heartbeat.mav_type == _FIXED_WING:
            self._send_plane(vehicle, telemetry, velocity)
        else:
            wanted = velocity or Velocity()
            vehicle.set_velocity(
                forward_m_s=wanted.forward_m_s,
                right_m_s=-wanted.left_m_s,
                down_m_s=-wanted.up_m_s,
                yaw_rate_rad_s=-wanted.left_rad_s,
            )

    def _send_plane(self, vehicle: Vehicle, telemetry: Telemetry, velocity: Velocity | None) -> None:
        position = telemetry.position
        north = None if position is None else position.velocity_north_m_s
        east = None if position is None else position.velocity_east_m_s
        alt = None if position is None else position.alt_amsl_m
        if north is None or east is None or alt is None:
            return
        self._plane = self._plane or PlaneTargets()
        targets = self._plane.targets(
            velocity,
            self._clock(),
            course_rad=math.atan2(east, north),
            groundspeed_m_s=math.hypot(north, east),
            alt_amsl_m=alt,
        )
        if velocity is None:
            self._plane = None
        # Each by itself: a speed that is refused leaves the turn as it was asked for.
        airspeed_m_s, course, height_m = targets.airspeed_m_s, targets.course, targets.alt_amsl_m
        if airspeed_m_s is not None:
            self._attempt(lambda: vehicle.set_airspeed(airspeed_m_s))
        if course is not None:
            self._attempt(lambda: vehicle.fly_course(course[0], accel_m_s2=course[1]))
        if height_m is not None:
            self._attempt(lambda: vehicle.climb_to(alt_amsl_m=height_m))

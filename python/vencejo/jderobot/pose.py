"""Pose3D: position and attitude."""

from __future__ import annotations

import math
from typing import Any, Final

from vencejo.errors import Busy, VencejoError
from vencejo.jderobot.access import below_home
from vencejo.jderobot.answers import Answer, answer_of
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.subject import Held, Subject
from vencejo.jderobot.workers import Workers

__all__ = ["Pose3D", "quaternion"]

GOING_MODES: Final = ("GUIDED", "AUTO_LOITER")
"""Modes in which a vehicle goes where it is told: of ArduPilot, and of PX4."""


def quaternion(roll_rad: float, pitch_rad: float, yaw_rad: float) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of Tait-Bryan angles in the order yaw, pitch, roll (ZYX).

    Diebel, "Representing Attitude: Euler Angles, Unit Quaternions, and Rotation Vectors" (2006), eq. 290 for sequence
    (1, 2, 3).
    """
    cr, sr = math.cos(roll_rad / 2), math.sin(roll_rad / 2)
    cp, sp = math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
    cy, sy = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


class Pose3D:
    """Servant of ``jderobot::Pose3D``. It cannot express "unknown": the last value stays, zeros before the first."""

    def __init__(self, slices: Slices, subject: Subject, workers: Workers) -> None:
        self._slices = slices
        self._subject = subject
        self._workers = workers
        self._held = Held()

    def getPose3DData(self, current: Any = None) -> Any:
        """Where the vehicle is and how it lies."""
        held = self._held
        vehicle = self._subject.find()
        telemetry = None if vehicle is None else vehicle.telemetry
        position = None if telemetry is None else telemetry.position
        attitude = None if telemetry is None else telemetry.attitude
        lat = held("lat", None if position is None else position.lat_deg)
        lon = held("lon", None if position is None else position.lon_deg)
        alt = held("alt", None if position is None else position.alt_amsl_m)
        roll = held("roll", None if attitude is None else attitude.roll_rad)
        pitch = held("pitch", None if attitude is None else attitude.pitch_rad)
        yaw = held("yaw", None if attitude is None else attitude.yaw_rad)
        # Minus pitch: what existing viewers expect.
        return self._slices.jderobot.Pose3DData(lat, lon, alt, alt, *quaternion(roll, -pitch, yaw))

    def setPose3DData(self, data: Any, current: Any = None) -> Any:
        """Fly to a position, altitude above mean sea level in z, if the vehicle is in a mode for that; it is not changed."""
        below = below_home(current)
        try:
            return self._workers.later(lambda: int(self._goto(data, below)))
        except Busy as error:
            self._subject.tell(f"setPose3DData: {error}")
            return int(Answer.BUSY)

    def _goto(self, data: Any, below_home: bool) -> Answer:
        try:
            if data is None or not all(map(math.isfinite, (data.x, data.y, data.z))):
                return Answer.BAD_VALUE
            vehicle = self._subject.hear()
            if vehicle.telemetry.mode not in GOING_MODES:
                modes = " or ".join(GOING_MODES)
                self._subject.tell(f"setPose3DData: the vehicle is not in {modes}, and no pose changes its mode")
                return Answer.WRONG_MODE
            vehicle.goto(data.x, data.y, alt_amsl_m=data.z, change_mode=False, below_home=below_home)
        except VencejoError as error:
            self._subject.tell(f"setPose3DData: {error}")
            return answer_of(error)
        return Answer.DONE

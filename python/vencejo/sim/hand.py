"""A plane held by hand: its turns and moves, and the accelerations and rates that its sensors measure.

It owns the motion from one attitude to the next (one smooth rotation about one axis) and, for ``--by-hand``, the
sequence of attitudes. Everything is a function of simulated time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from .dynamics import G_M_S2, Dynamics

__all__ = ["BY_HAND", "CARRY_HEIGHT_M", "Hand", "HandSequence", "Pose"]

CARRY_HEIGHT_M = 1.2
"""Default height of a held plane, metres above its standing height."""
_METRES_PER_DEG = 111_132.0
_PICK_UP_S = 5.0
_TURN_S = 1.5
_REST_S = 2.5

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class Pose(NamedTuple):
    """An attitude of the sequence, degrees, and its description."""

    roll_deg: float
    pitch_deg: float
    turned_deg: float
    """Heading, clockwise from the initial one."""
    name: str


BY_HAND: tuple[Pose, ...] = (
    Pose(0, 0, 0, "level"),
    Pose(30, 0, 0, "right wing down 30"),
    Pose(-30, 0, 0, "left wing down 30"),
    Pose(0, 0, 0, "level"),
    Pose(0, 30, 0, "nose up 30"),
    Pose(0, -30, 0, "nose down 30"),
    Pose(0, 0, 0, "level"),
    Pose(0, 0, 90, "turned right 90"),
    Pose(0, 0, 180, "turned right 180"),
    Pose(0, 0, 270, "turned right 270"),
    Pose(0, 0, 0, "level, all round"),
    Pose(45, 20, 60, "all three axes"),
    Pose(-90, 0, 0, "on its left wing tip"),
    Pose(180, 0, 0, "on its back"),
)
"""The repeating sequence of ``vencejo sim --by-hand``: 1.5 s of turn and 2.5 s of hold each, from 5 s after boot."""


@dataclass(frozen=True, slots=True)
class _Way:
    """A turn and a move in progress."""

    start_s: float
    seconds: float
    attitude: Quaternion
    axis: Vector
    """Rotation axis in body axes; it is constant during the turn."""
    angle_rad: float
    offset_ned_m: Vector
    walk_ned_m: Vector


class Hand:
    """Holds one plane: it moves the body in place of :class:`Dynamics`.

    Parameters
    ----------
    body : Dynamics
        The plane, at rest on the ground.
    """

    def __init__(self, body: Dynamics) -> None:
        self._body = body
        self._from = (body.lat_deg, body.lon_deg, body.height_m, body.pressure_pa)
        self._attitude = _quaternion(body.roll_rad, body.pitch_rad, body.yaw_rad)
        self._offset: Vector = (0.0, 0.0, 0.0)
        self._way: _Way | None = None
        self._time_s = 0.0

    @property
    def moving(self) -> bool:
        """True until the target attitude is reached."""
        return self._way is not None

    def move(self, roll_rad: float, pitch_rad: float, yaw_rad: float, *, seconds: float, offset_ned_m: Vector) -> None:
        """Turn to an attitude and move to an offset (north, east, down) from the pick-up point, in ``seconds``."""
        self._put(self._time_s)
        target = _quaternion(roll_rad, pitch_rad, yaw_rad)
        w, x, y, z = _product(_conjugate(self._attitude), target)
        if w < 0.0:
            # The shorter rotation.
            w, x, y, z = -w, -x, -y, -z
        sine = math.sqrt(x * x + y * y + z * z)
        axis = (x / sine, y / sine, z / sine) if sine > 1e-12 else (1.0, 0.0, 0.0)
        walk = (
            offset_ned_m[0] - self._offset[0],
            offset_ned_m[1] - self._offset[1],
            offset_ned_m[2] - self._offset[2],
        )
        angle = 2.0 * math.atan2(sine, w)
        self._way = _Way(self._time_s, max(0.0, seconds), self._attitude, axis, angle, self._offset, walk)
        self._put(self._time_s)

    def step(self, dt_s: float) -> None:
        """Advance by one step."""
        self._time_s += dt_s
        self._put(self._time_s)

    def _put(self, time_s: float) -> None:
        rates: Vector = (0.0, 0.0, 0.0)
        velocity = accel = rates
        way = self._way
        if way is not None:
            part, speed, push = _gently(time_s - way.start_s, way.seconds)
            half = 0.5 * way.angle_rad * part
            turn = (math.cos(half), *(math.sin(half) * a for a in way.axis))
            self._attitude = _product(way.attitude, (turn[0], turn[1], turn[2], turn[3]))
            self._offset = _along(way.offset_ned_m, way.walk_ned_m, part)
            if part >= 1.0:
                self._way = None
            else:
                rates = _along((0.0, 0.0, 0.0), way.axis, way.angle_rad * speed)
                velocity = _along((0.0, 0.0, 0.0), way.walk_ned_m, speed)
                accel = _along((0.0, 0.0, 0.0), way.walk_ned_m, push)
        lat, lon, height, pressure = self._from
        north, east, down = self._offset
        body = self._body
        body.hold(
            _euler(self._attitude),
            rates_rad_s=rates,
            # Specific force: acceleration minus gravity.
            force_m_s2=_rotate(_conjugate(self._attitude), (accel[0], accel[1], accel[2] - G_M_S2)),
            lat_deg=lat + north / _METRES_PER_DEG,
            lon_deg=lon + east / (_METRES_PER_DEG * max(0.01, math.cos(math.radians(lat)))),
            height_m=height - down,
            velocity_ned_m_s=velocity,
            pressure_pa=pressure + body.density_kg_m3 * G_M_S2 * down,
        )


class HandSequence:
    """Repeats :data:`BY_HAND`."""

    def __init__(self, heading_deg: float) -> None:
        self._heading_deg = heading_deg
        self._shown = -1

    def due(self, time_s: float) -> tuple[Pose, float] | None:
        """The pose that starts now and the seconds to turn to it; None in between."""
        number = math.floor((time_s - _PICK_UP_S) / (_TURN_S + _REST_S) + 1e-9)
        if number < self._shown:
            self._shown = -1  # The plane has rebooted.
        if number <= self._shown:
            return None
        self._shown = number
        return self.pose(number), _TURN_S

    def pose(self, number: int) -> Pose:
        """Pose ``number``, counted from 0 through all rounds, with its true heading in ``turned_deg``."""
        pose = BY_HAND[number % len(BY_HAND)]
        return pose._replace(turned_deg=(self._heading_deg + pose.turned_deg) % 360.0)


def _gently(time_s: float, seconds: float) -> tuple[float, float, float]:
    """Position, rate and acceleration of a smooth motion: 10 s³ − 15 s⁴ + 6 s⁵, at rest at both ends.

    The minimum-jerk movement of a hand: Flash and Hogan, "The coordination of arm movements", J. Neuroscience 5 (1985),
    eq. 3.
    """
    if seconds <= 0.0 or time_s >= seconds:
        return 1.0, 0.0, 0.0
    s = max(0.0, time_s / seconds)
    return (
        s**3 * (10.0 - 15.0 * s + 6.0 * s * s),
        30.0 * (s * (1.0 - s)) ** 2 / seconds,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / seconds**2,
    )


def _along(start: Vector, way: Vector, part: float) -> Vector:
    return start[0] + way[0] * part, start[1] + way[1] * part, start[2] + way[2] * part


# Quaternions turn body axes into north, east, down (J. Diebel, "Representing Attitude", 2006, eq. 290 and 297).


def _quaternion(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    cr, sr = math.cos(roll_rad / 2), math.sin(roll_rad / 2)
    cp, sp = math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
    cy, sy = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def _euler(q: Quaternion) -> Vector:
    w, x, y, z = q
    pitch = math.asin(min(1.0, max(-1.0, 2.0 * (w * y - x * z))))
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        pitch,
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def _conjugate(q: Quaternion) -> Quaternion:
    return q[0], -q[1], -q[2], -q[3]


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def _rotate(q: Quaternion, v: Vector) -> Vector:
    _, x, y, z = _product(_product(q, (0.0, *v)), _conjugate(q))
    return x, y, z

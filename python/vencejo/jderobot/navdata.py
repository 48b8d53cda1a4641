"""Navdata: what the vehicle measures, in the units of the interface."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from typing import Any, Final, TypeVar

from vencejo import modes
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.subject import Held, Subject
from vencejo.telemetry import STALE_AFTER_S, Telemetry

__all__ = ["Navdata", "State", "state_of"]

_G = TypeVar("_G")
_MILLI: Final = 1000.0
_INT: Final = 2**31 - 1


class State(enum.IntEnum):
    """``NavdataData.state``, numbered as AR.Drone viewers know it."""

    UNKNOWN = 0
    LANDED = 2
    FLYING = 3
    HOVERING = 4
    TAKING_OFF = 6
    TO_POINT = 7
    LANDING = 8


_LANDED: Final = {"on ground": State.LANDED, "taking off": State.TAKING_OFF, "landing": State.LANDING}
_TAKING_OFF: Final = modes.TAKEOFF | {"AUTO_TAKEOFF", "AUTO_VTOL_TAKEOFF"}
_HOLDING: Final = modes.LOITER | {"CIRCLE", "POSHOLD", "BRAKE", "QHOVER", "QLOITER"}
_TO_POINT: Final = modes.MISSION | modes.GUIDED | modes.RETURN | {"SMART_RTL", "OFFBOARD"}


def state_of(telemetry: Telemetry) -> State:
    """What the vehicle does, from what it says of the ground and its mode."""
    extended = telemetry.extended
    if extended is not None and extended.landed in _LANDED:
        return _LANDED[extended.landed]
    if extended is None or extended.landed != "in air":
        return State.UNKNOWN
    mode = telemetry.mode
    if mode in _TAKING_OFF:
        return State.TAKING_OFF
    if mode in _HOLDING:
        return State.HOVERING
    return State.TO_POINT if mode in _TO_POINT else State.FLYING


def _of(group: _G | None, value: Callable[[_G], float | None], scale: float = 1.0) -> float | None:
    found = None if group is None else value(group)
    return None if found is None else found * scale


def _whole(value: float) -> int:
    return max(-_INT, min(_INT, round(value)))


class Navdata:
    """Servant of ``jderobot::Navdata``. It cannot express "unknown": the last value stays, zeros before the first."""

    def __init__(self, slices: Slices, subject: Subject) -> None:
        self._slices = slices
        self._subject = subject
        self._held = Held()

    def getNavdata(self, current: Any = None) -> Any:
        """Everything at once."""
        data = self._slices.jderobot.NavdataData(
            tagsType=[], tagsXc=[], tagsYc=[], tagsWidth=[], tagsHeight=[], tagsOrientation=[], tagsDistance=[]
        )
        vehicle = self._subject.find()
        if vehicle is not None:
            self._fill(data, vehicle.telemetry)
        return data

    def _fill(self, data: Any, telemetry: Telemetry) -> None:
        held = self._held
        heartbeat, attitude, position = telemetry.heartbeat, telemetry.attitude, telemetry.position
        data.vehicle = _whole(held("vehicle", _of(heartbeat, lambda group: group.mav_type)))
        data.state = int(state_of(telemetry))
        battery = _of(telemetry.sys_status, lambda group: group.battery_remaining_pct)
        data.batteryPercent = held("battery", battery)
        imu = telemetry.imu
        for axis, name in enumerate("XYZ"):
            field = None if imu is None or imu.mag_gauss is None else imu.mag_gauss[axis] * _MILLI
            setattr(data, f"mag{name}", _whole(held(f"mag{name}", field)))
            force = None if imu is None or imu.acc_g is None else imu.acc_g[axis]
            setattr(data, f"a{name.lower()}", held(f"a{name}", force))
        data.pressure = _whole(held("pressure", _of(telemetry.pressure, lambda group: group.absolute_pa)))
        data.temp = _whole(held("temp", _of(telemetry.pressure, lambda group: group.temperature_c)))
        data.windSpeed = held("wind speed", _of(telemetry.wind, lambda group: group.speed_m_s))
        data.windAngle = held("wind from", _of(telemetry.wind, lambda group: group.from_deg))
        data.rotX = held("roll", _of(attitude, lambda group: group.roll_rad, math.degrees(1)))
        data.rotY = held("pitch", _of(attitude, lambda group: group.pitch_rad, math.degrees(1)))
        data.rotZ = held("yaw", _of(attitude, lambda group: group.yaw_rad, math.degrees(1)))
        data.windCompAngle = (data.windAngle - data.rotZ + 180.0) % 360.0 - 180.0
        data.altd = _whole(held("height", _of(position, lambda group: group.alt_rel_home_m, _MILLI)))
        data.vx = held("vx", _of(position, lambda group: group.velocity_north_m_s, _MILLI))
        data.vy = held("vy", _of(position, lambda group: group.velocity_east_m_s, _MILLI))
        data.vz = held("vz", _of(position, lambda group: group.velocity_down_m_s, _MILLI))
        clock = telemetry.system_time
        data.tm = held("tm", None if clock is None else clock.boot_ms / _MILLI + min(clock.age_s, STALE_AFTER_S))

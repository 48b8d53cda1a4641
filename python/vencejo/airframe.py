"""Models of a plane for rehearsals: its airframe and its battery, given, or learned from a recorded flight.

`vencejo.rehearsal` has the same names.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from vencejo import _native
from vencejo.errors import InvalidRequest
from vencejo.landing import Wind

__all__ = ["Airframe", "AirframeOrigin", "Battery", "BatteryLeft", "Learned", "learn"]

AirframeOrigin = Literal["parameters", "simulator", "flight"]
"""Source of the airframe: a foam pusher adjusted by the parameters, the plane of ArduPilot's simulator, or one learned from a
recorded flight."""


@dataclass(frozen=True)
class Airframe:
    """A model of the airframe: lift, drag and thrust per mass, at airspeeds as the autopilot measures them.

    Attributes
    ----------
    cruise_m_s : float
        Reference airspeed of the other values.
    drag_m_s2 : float
        Drag per mass in level flight at ``cruise_m_s``.
    induced : float
        Lift-induced part of that drag, 0 to 1.
    thrust_full_m_s2 : float
        Thrust per mass at full throttle and ``cruise_m_s``.
    throttle_cruise : float
        Throttle of level flight at ``cruise_m_s``, 0 to 1.
    attack_rad, level_pitch_rad : float
        Angle of attack above zero lift, and pitch of the fuselage, in level flight at ``cruise_m_s``.
    pitot : float
        Ratio of the true airspeed to the one that the autopilot assumes.
    skid : float
        A bank turns the plane ``1 / (1 + skid)`` as fast as in a coordinated turn.
    power_cruise_w : float or None
        Electrical power of level flight at ``cruise_m_s``.
    is_simulated : bool
        Whether ArduPilot's simulator flies it, whose pitot and ground behave differently.
    power_exponent : float
        Exponent of the power as a function of the throttle.
    voltage_v : float or None
        Battery voltage in flight.
    thrust_static_m_s2 : float or None
        Static thrust per mass at full throttle, at least ``thrust_full_m_s2``; ``None``: not known, or not a propeller.
    ground_drag_m_s2 : float or None
        Deceleration on the ground beside its drag, by wheels, brakes or belly; ``None``: not known, and it slides.
    """

    cruise_m_s: float
    drag_m_s2: float
    induced: float
    thrust_full_m_s2: float
    throttle_cruise: float
    attack_rad: float
    level_pitch_rad: float
    pitot: float
    skid: float
    power_cruise_w: float | None
    is_simulated: bool = False
    power_exponent: float = 2.5
    voltage_v: float | None = None
    thrust_static_m_s2: float | None = None
    ground_drag_m_s2: float | None = None


@dataclass(frozen=True)
class Battery:
    """Battery values that replace those of the plane's parameters (``BATT_*``) and its monitor; ``None`` keeps theirs.

    Attributes
    ----------
    capacity_mah : float, optional
        Capacity, 1 to 1,000,000.
    voltage_v : float, optional
        Voltage while the engine runs, 1 to 1,000.
    charge_pct : float, optional
        Charge at the start, % of the capacity, 0 to 100; default 100.
    reserve_pct : float, optional
        Charge that should be left at the landing, % of the capacity, 0 to 100; default: the higher of ``BATT_LOW_MAH``
        and ``BATT_CRT_MAH``, else 20.
    power_cruise_w : float, optional
        Power drawn in level flight at cruise, 0.1 to 1,000,000; default: that of the airframe.
    """

    capacity_mah: float | None = None
    voltage_v: float | None = None
    charge_pct: float | None = None
    reserve_pct: float | None = None
    power_cruise_w: float | None = None


@dataclass(frozen=True)
class BatteryLeft:
    """State of the battery at the end of a flight.

    Attributes
    ----------
    capacity_wh : float
        Energy of the full battery: capacity times voltage.
    left_wh : float
        Energy at the end; negative by what the flight needs beyond it.
    reserve : float
        Part of the capacity that should be left, 0 to 1.
    empty_s : float or None
        Time at which it is empty, from the start; ``None`` if it is not.
    empty_item : int or None
        Item flown at that time, counted from 1; ``None`` in a return, and if it is not empty.
    """

    capacity_wh: float
    left_wh: float
    reserve: float
    empty_s: float | None
    empty_item: int | None

    @property
    def left(self) -> float:
        """Remaining part of the capacity, 1 at most; negative where :attr:`left_wh` is."""
        return self.left_wh / self.capacity_wh


@dataclass(frozen=True)
class Learned:
    """A plane learned from a recorded flight.

    Attributes
    ----------
    airframe : Airframe
    wind : Wind
        Wind of that flight.
    moments : int
        Number of samples used.
    airspeed_error_m_s : float
        RMS difference between measured and modelled airspeeds.
    """

    airframe: Airframe
    wind: Wind
    moments: int
    airspeed_error_m_s: float

    @classmethod
    def _from_native(cls, learned: dict[str, Any]) -> Learned:
        return cls(**{**learned, "airframe": Airframe(**learned["airframe"]), "wind": Wind(**learned["wind"])})


def learn(
    path: str | os.PathLike[str], *, parameters: Mapping[str, float] | None = None, system_id: int | None = None
) -> Learned:
    """Learn a plane from a recording of its flight (a ``.tlog``): its pitot, turns, lift, drag, thrust, power, and the wind.

    Values that the flight does not show are those of the parameters, or of a foam pusher. Two minutes are enough, with
    position, attitude and VFR_HUD at 10 Hz, turns in all directions and changes of speed and altitude.

    Parameters
    ----------
    path : path
    parameters : mapping of str to float, optional
        The vehicle's parameters.
    system_id : int, optional
        The vehicle in the recording; default: the first one with a position.

    Raises
    ------
    FileFormatError
        When the file cannot be read.
    InvalidRequest
        When the recording has no flight that is long enough and in more than one direction.
    """
    numbers = {name: float(value) for name, value in (parameters or {}).items()}
    learned = _native.learn_plane(os.fspath(path), parameters=numbers, system=system_id)
    if learned is None:
        raise InvalidRequest(
            f"{os.fspath(path)}: no flight to learn from: it takes a minute or two in the air, with position, attitude and airspeed, "
            "in more than one direction"
        )
    return Learned._from_native(learned)

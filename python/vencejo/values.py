"""Immutable value types of vehicles and stations.

In a module of their own because defining them takes longer than hearing the first vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from vencejo.findings import Finding

__all__ = [
    "Event",
    "FlightPreparation",
    "MissionProgress",
    "Parameter",
    "PlanChange",
    "PlanState",
    "RecorderInfo",
    "StatusText",
    "VehicleControl",
]

SEVERITIES = ("emergency", "alert", "critical", "error", "warning", "notice", "info", "debug")
"""Names of MAV_SEVERITY, 0 to 7."""


@dataclass(frozen=True)
class VehicleControl:
    """Who has control of a vehicle.

    Attributes
    ----------
    holder : str or None
        Name of the operator who has control, after that of the ground station; ``None`` when nobody has it.
    is_held_here : bool
        Whether that is an operator of this station.
    requested_by : str or None
        Name of the operator who asks for control; ``None`` without a request.
    is_requested_here : bool
        Whether that is an operator of this station.
    """

    holder: str | None
    is_held_here: bool
    requested_by: str | None
    is_requested_here: bool


@dataclass(frozen=True)
class FlightPreparation:
    """What `Vehicle.prepare_flight` would change in the vehicle's present state.

    Attributes
    ----------
    from_mode : str
        The present mode.
    mode : str or None
        The mode to change to; ``None`` when it arms in the present mode, and stays in place when armed.
    rewinds_mission : bool
        Whether the mission is set back to its beginning; false without a mission.
    is_needed : bool
        Whether a flight should not begin without it.
    text : str
        The preparation in words.
    """

    from_mode: str
    mode: str | None
    rewinds_mission: bool
    is_needed: bool
    text: str

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, kw_only=True)
class MissionProgress:
    """Progress of the vehicle's mission.

    Attributes
    ----------
    item : int or None
        Current item, counted from 1 as a plan's items are; ``None`` without one.
    total : int or None
        Items on board.
    reached : tuple of int
        Items reached since the mission began, each once, in ascending order.
    is_complete : bool
        Whether the mission was flown to its end.
    distance_m : float or None
        Distance to the end of the mission, metres.
    time_s : float or None
        Time to the end of the mission at the present ground speed, seconds.
    leg_distance_m : float or None
        Distance to the current item, metres.
    circled_turns : float or None
        Turns flown of the circle at the current item; ``None`` while it does not circle, and if the circle's beginning
        was not heard.
    circled_s : float or None
        Time on that circle by the vehicle's clock, seconds; ``None`` likewise.
    target_off_m : float or None
        An alarm: the vehicle's target is this far, in metres, from the current item of the plan that was read from it.
        ``None`` while it is not, and when it is unknown.
    """

    item: int | None
    total: int | None
    reached: tuple[int, ...]
    is_complete: bool
    distance_m: float | None
    time_s: float | None
    leg_distance_m: float | None
    circled_turns: float | None = None
    circled_s: float | None = None
    target_off_m: float | None = None


@dataclass(frozen=True)
class PlanChange:
    """One step from the plan on board to a given one; see `Vehicle.compare_plan`.

    Numbers count from 1, without the home of a mission. For a fence they count its corners and circles in order, then
    the return point.

    Attributes
    ----------
    kind : {"added", "removed", "changed"}
        What was done to the item.
    item : int or None
        Its number in the plan; ``None`` when it was removed.
    on_board : int or None
        The number of the one on board; ``None`` when it was added.
    fields : tuple of {"command", "place", "height", "parameters"}
        Parts of a changed item that differ, in this order.
    """

    kind: Literal["added", "removed", "changed"]
    item: int | None
    on_board: int | None
    fields: tuple[Literal["command", "place", "height", "parameters"], ...] = ()


@dataclass(frozen=True, kw_only=True)
class PlanState:
    """What is known about a plan on board; only reading it back makes it known.

    Attributes
    ----------
    state : {"unknown", "empty", "verified"}
    count : int or None
        Number of items, without home, if they were read.
    hash : str or None
        Fingerprint of the items as the vehicle holds them.
    detail : str
        The state in words.
    may_be_mixed : bool
        Whether it may be a mixture of two plans that an interrupted upload left behind: then arming, starting the
        mission and jumping in it are refused without ``despite_mixed_plan``.
    position_error_m : float or None
        After an upload to a vehicle that stores positions as 32-bit floats: the greatest distance between a position on
        board and the one that was sent, metres. ``None``: exact, or not known.
    findings : tuple of Finding
        After a mission was uploaded: the warnings of its checks. Two states with different findings are equal.
    """

    state: Literal["unknown", "empty", "verified"]
    count: int | None
    hash: str | None
    detail: str
    may_be_mixed: bool = False
    position_error_m: float | None = None
    findings: tuple[Finding, ...] = field(default=(), compare=False)


@dataclass(frozen=True)
class StatusText:
    """A text from the vehicle (STATUSTEXT).

    Attributes
    ----------
    time_s : float
        When it arrived, on the clock of `Telemetry.time_s`.
    severity : int
        MAV_SEVERITY: 0 emergency to 7 debug.
    text : str
    """

    time_s: float
    severity: int
    text: str

    @property
    def severity_name(self) -> str:
        """The severity in words."""
        return SEVERITIES[self.severity] if 0 <= self.severity < len(SEVERITIES) else "unknown"


@dataclass(frozen=True)
class Event:
    """Something that happened to a vehicle.

    Attributes
    ----------
    kind : str
        One of those below. A program passes over others: more may come.
    time_s : float
        On the clock of `Telemetry.time_s`.
    detail : mapping of str to object
        The values that the list names with each kind; empty for the others.

    Notes
    -----
    - ``lost``: nothing was heard for 5 s; ``regained``: it is heard again
    - ``unreached``: it is heard, but does not hear us; ``reached``: it does again
    - ``rebooted``: the autopilot restarted; telemetry begins anew, plans are unknown
    - ``mode``: detail ``mode``, and ``from``, the one before or ``None``
    - ``armed``, ``disarmed``: detail ``is_armed``; also when it is first heard
    - ``landed``: detail ``landed``, as in `ExtendedState`
    - ``text``: detail ``severity`` (MAV_SEVERITY) and ``text``
    - ``item``: the current item changed to detail ``item``, counted from 1; ``item_reached``: that was reached
    - ``mission_complete``: the mission was flown to its end
    - ``plan``: what is known of a plan on board changed; detail ``kind`` and ``state``
    - ``target_elsewhere``: in AUTO it flies somewhere else than to its item, detail ``item`` and ``distance_m``;
      ``target_as_planned``: no more
    - ``home``: the vehicle moved its home
    - ``param``: a parameter that was read has another value; detail ``name`` and ``value``
    - ``contested``: another vehicle uses the same system id; ``uncontested``: no more
    - ``terrain_unknown``: it asks for terrain that no map here has; ``terrain_known``: it has all
    - ``streams_fell_back``: it does not know SET_MESSAGE_INTERVAL; data streams were requested instead
    """

    kind: str
    time_s: float
    detail: Mapping[str, Any]


@dataclass(frozen=True)
class Parameter:
    """A parameter as the vehicle has it.

    Attributes
    ----------
    name : str
    value : float
    type : int
        MAV_PARAM_TYPE: 9 and 10 are floats, of 32 and 64 bits, the others integers.
    default : float or None
        Default value on this vehicle. ``None`` when it is not reported: only `Parameters.all` over MAVFTP from an
        ArduPilot since 4.2 has it.
    """

    name: str
    value: float
    type: int
    default: float | None = None


@dataclass(frozen=True, kw_only=True)
class RecorderInfo:
    """The recording of this session.

    Attributes
    ----------
    path : Path or None
        The ``.tlog`` being written.
    is_recording : bool
    frames, bytes, dropped : int
        Written so far; and frames dropped because the disk was too slow.
    problem : str or None
        Why nothing is recorded.
    """

    path: Path | None
    is_recording: bool
    frames: int
    bytes: int
    dropped: int
    problem: str | None

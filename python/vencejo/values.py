"""What a vehicle and its station tell of themselves, as values that do not change.

Apart from what tells them: to make these classes takes a program longer than to hear its first vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

__all__ = [
    "Event",
    "FlightPreparation",
    "MissionProgress",
    "Parameter",
    "PlanChange",
    "PlanState",
    "RecorderInfo",
    "StatusText",
]

SEVERITIES = ("emergency", "alert", "critical", "error", "warning", "notice", "info", "debug")
"""Names of MAV_SEVERITY, 0 to 7."""


@dataclass(frozen=True)
class FlightPreparation:
    """What a flight needs first: what `Vehicle.prepare_flight` does to the vehicle as it is now.

    Attributes
    ----------
    from_mode : str
        The mode that it is in.
    mode : str or None
        The mode to change to; ``None`` when it arms as it is, and stays where it is when armed.
    rewinds_mission : bool
        Whether the mission is set back to its beginning; false when there is none.
    is_needed : bool
        Whether a flight should not begin without it.
    text : str
        All of it in words.
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
    """Where the vehicle stands in its mission.

    Attributes
    ----------
    item : int or None
        Item in execution, counted from 1 as a plan's items are; ``None`` when there is none.
    total : int or None
        Items on board.
    reached : tuple of int
        Items reached since the mission began, each once, ascending.
    is_complete : bool
        Whether the mission was flown to its end.
    distance_m : float or None
        Way to go to the end of the mission.
    time_s : float or None
        Time to go at the present ground speed.
    leg_distance_m : float or None
        Way to go to the item in execution.
    circled_turns : float or None
        Turns that were flown of the circle at the item in execution; ``None`` while it circles at none, and where the
        beginning was not heard.
    circled_s : float or None
        Time on that circle by the vehicle's clock; ``None`` likewise.
    target_off_m : float or None
        An alarm: the vehicle flies to somewhere that is this far from the current item of the plan that was read from it.
        ``None`` while it does not, and where it cannot be told.
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
    """One step from the list on board to the one of a plan; see `Vehicle.compare_plan`.

    Numbers count from 1, home of a mission left out. Of a fence they count its corners and circles in order, then the return
    point.

    Attributes
    ----------
    kind : {"added", "removed", "changed"}
        What was done to the item.
    item : int or None
        Its number in the plan; ``None`` when it was removed.
    on_board : int or None
        The number of the one on board; ``None`` when it was added.
    fields : tuple of {"command", "place", "height", "parameters"}
        What of a changed item is another, in this order.
    """

    kind: Literal["added", "removed", "changed"]
    item: int | None
    on_board: int | None
    fields: tuple[Literal["command", "place", "height", "parameters"], ...] = ()


@dataclass(frozen=True, kw_only=True)
class PlanState:
    """What is known of a plan on board; only a read-back makes it known.

    Attributes
    ----------
    state : {"unknown", "empty", "verified"}
    count : int or None
        Items, without home, when they were read.
    hash : str or None
        Fingerprint of the items as the vehicle holds them.
    detail : str
        The state in words.
    may_be_mixed : bool
        Whether it may be a mixture of two that an upload left behind: then the vehicle is not armed, and its mission neither
        started nor jumped in, unless that is asked for ``despite_mixed_plan``.
    position_error_m : float or None
        What an upload gives back of a vehicle that keeps positions as 32-bit floats: how far the farthest place on board is
        from where it was sent to be. ``None``: exact, or not known.
    """

    state: Literal["unknown", "empty", "verified"]
    count: int | None
    hash: str | None
    detail: str
    may_be_mixed: bool = False
    position_error_m: float | None = None


@dataclass(frozen=True)
class StatusText:
    """A text that the vehicle wrote.

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
        Such as ``"mode"``, ``"armed"``, ``"disarmed"``, ``"text"``, ``"item_reached"``, ``"lost"``, ``"regained"``,
        ``"unreached"`` (heard, but it does not hear us), ``"reached"``.
    time_s : float
        On the clock of `Telemetry.time_s`.
    detail : mapping of str to object
        What the kind needs: ``{"mode": "AUTO"}``, ``{"item": 3}``…
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
        MAV_PARAM_TYPE: 9 is a float, others are integers.
    """

    name: str
    value: float
    type: int


@dataclass(frozen=True, kw_only=True)
class RecorderInfo:
    """The recording of this session.

    Attributes
    ----------
    path : Path or None
        The ``.tlog`` being written.
    is_recording : bool
    frames, bytes, dropped : int
        Written so far, and frames that the disk was too slow for.
    problem : str or None
        Why nothing is recorded.
    """

    path: Path | None
    is_recording: bool
    frames: int
    bytes: int
    dropped: int
    problem: str | None

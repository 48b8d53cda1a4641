"""What if: where the plane goes when the link, the battery or the engine fails, or a return is requested, at any moment of a plan.

The plan is rehearsed (:mod:`vencejo.rehearsal`); from that moment on the vehicle's failsafes decide, by its ``FS_*``,
``THR_FAILSAFE``, ``BATT_FS_*`` and ``RTL_*``. An ArduPlane with default parameters continues its mission.

Examples
--------
>>> from vencejo import Home, MissionItem, Plan
>>> from vencejo.what_if import what_if
>>> home = Home(40.3332, -3.7978, alt_amsl_m=600.0)
>>> items = (
...     MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=50.0),
...     MissionItem.waypoint(40.3532, -3.7978, alt_rel_home_m=80.0),
... )
>>> plan = Plan(home=home, items=items)
>>> lost, asked = what_if(plan, 60.0, ["link-lost", "return-asked"], parameters={"FS_GCS_ENABL": 1.0})
>>> lost.reaction, asked.reaction, asked.flown.ending
('goes-on', 'returns', 'returned')
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal, get_args

from vencejo import _native
from vencejo._rehearsing import a_plan, given
from vencejo.errors import InvalidRequest
from vencejo.landing import Wind
from vencejo.plan import GeoPoint, Plan
from vencejo.rehearsal import Airframe, Battery, Ground, Moment, Rehearsal

__all__ = ["TRIGGERS", "Decision", "Reaction", "Trigger", "WhatIf", "what_if"]

Trigger = Literal[
    "return-asked", "link-lost", "radio-lost", "battery-low", "battery-critical", "go-around", "engine-stopped"
]
"""What happens: RTL is selected; the vehicle loses the ground station's heartbeat; the remote control; its battery reaches the low
level; the critical level; a landing is aborted on its final leg; the engine stops."""

TRIGGERS: tuple[Trigger, ...] = get_args(Trigger)

Reaction = Literal["goes-on", "flies-mission", "returns", "lands", "goes-around", "circles", "glides", "not-rehearsed"]
"""What the vehicle does: continues as before, with its mission or otherwise; switches to its mission; returns, as RTL does with
``RTL_AUTOLAND`` and rally points; flies to the mission's nearest landing sequence; climbs away from a landing and
repeats it; circles where it is; glides straight ahead with the throttle closed; something that is not rehearsed (a
parachute, a termination, rotors, a mode
that needs a pilot)."""


@dataclass(frozen=True, slots=True)
class Decision:
    """A decision of the vehicle's failsafes.

    Attributes
    ----------
    time_s : float
        Time since the rehearsed flight's beginning, seconds.
    reaction : str
        See :data:`Reaction`.
    """

    time_s: float
    reaction: Reaction


@dataclass(frozen=True)
class WhatIf:
    """What follows from a trigger at a moment of a plan.

    Attributes
    ----------
    trigger : str
        See :data:`Trigger`.
    at : Moment
        The plane at that moment.
    decisions : tuple of Decision
        In order of time; empty if the vehicle's settings do not react.
    reaction : str
        The final reaction; see :data:`Reaction`.
    flown : Rehearsal or None
        The flight from there to its end, with times of the plan; distance and energy count from the plan's beginning.
        ``None`` if the mission continues as rehearsed.
    glide_range : tuple of GeoPoint
        Ground within gliding range: where the plane comes down without thrust when it turns into each of 72 directions,
        clockwise from north, and flies at its best-glide airspeed.
    """

    trigger: Trigger
    at: Moment
    decisions: tuple[Decision, ...]
    reaction: Reaction
    flown: Rehearsal | None
    glide_range: tuple[GeoPoint, ...]

    @classmethod
    def _from_native(cls, found: dict[str, Any]) -> WhatIf:
        flown = found["flown"]
        parts = {
            "at": Moment(**found["at"]),
            "decisions": tuple(Decision(**decision) for decision in found["decisions"]),
            "flown": None if flown is None else Rehearsal._from_native(flown),
            "glide_range": tuple(GeoPoint(*point) for point in found["glide_range"]),
        }
        return cls(**{**found, **parts})


def what_if(
    plan: Plan,
    at_s: float | Sequence[float],
    triggers: Sequence[Trigger] = TRIGGERS,
    *,
    parameters: Mapping[str, float] | None = None,
    airframe: Airframe | None = None,
    battery: Battery | None = None,
    wind: Wind | None = None,
    heading_deg: float | None = None,
    ground: Ground | None = None,
) -> tuple[WhatIf, ...]:
    """Rehearse a plan, and what follows from triggers at moments of it.

    Parameters
    ----------
    plan : Plan
        With a home.
    at_s : float or sequence of float
        Moments, seconds since the rehearsed flight's beginning, ascending. A moment on the ground gives no result.
    triggers : sequence of str, optional
        See :data:`Trigger`; all by default.
    parameters, airframe, battery, wind, heading_deg, ground
        As for :func:`vencejo.rehearsal.rehearse`.

    Returns
    -------
    tuple of WhatIf
        One for each moment in the air and each trigger, in that order.

    Raises
    ------
    InvalidRequest
        When the plan has no home, for an invalid moment or an unknown trigger, and for a number out of its range.
    """
    found = _native.what_if(
        a_plan(plan)._to_native(),
        given(parameters, airframe, battery, wind, heading_deg=heading_deg),
        ground,
        triggers=names_of(triggers),
        moments=moments_of(at_s),
    )
    return tuple(WhatIf._from_native(one) for one in found)


def names_of(triggers: Sequence[Trigger]) -> list[str]:
    """The triggers as the core takes them."""
    # the letters of one name are a sequence too
    return [triggers] if isinstance(triggers, str) else list(triggers)


def moments_of(at_s: Any) -> list[float]:
    """The moments as the core takes them; `InvalidRequest` for others than ascending ones."""
    given = list(at_s) if isinstance(at_s, Sequence) and not isinstance(at_s, str) else [at_s]
    moments = [float(one) if isinstance(one, Real) else math.nan for one in given]
    if not all(0.0 <= one < float("inf") for one in moments) or moments != sorted(moments):
        raise InvalidRequest(f"at_s is {at_s}: moments are seconds since the flight's beginning, 0 or more, growing")
    return moments

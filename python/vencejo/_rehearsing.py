"""What rehearsals take, checked and as the core takes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from vencejo.errors import InvalidRequest
from vencejo.plan import Plan

if TYPE_CHECKING:
    from vencejo.airframe import Airframe, Battery
    from vencejo.landing import Wind

__all__ = ["CLEARANCE_M", "a_plan", "blowing", "given", "profile", "within"]

CLEARANCE_M: Final = 30.0
"""Default clearance that a flight should keep above the ground, metres."""


def a_plan(plan: object) -> Plan:
    """The argument, if it is a plan; `TypeError` otherwise."""
    if not isinstance(plan, Plan):
        kind = type(plan).__name__
        raise TypeError(
            f"a Plan is wanted, not {kind}: Plan.load() reads one from a file, vehicle.download() from a vehicle"
        )
    return plan


def profile(airframe: Airframe | None, battery: Battery | None) -> dict[str, Any]:
    """The airframe and battery, as the core takes them."""
    return {"airframe": airframe, "battery": battery}


def given(
    parameters: Mapping[str, float] | None,
    airframe: Airframe | None,
    battery: Battery | None,
    wind: Wind | None,
    *,
    clearance_m: float = CLEARANCE_M,
    gust_m_s: float = 0.0,
    seed: int = 0,
    heading_deg: float | None = None,
) -> dict[str, Any]:
    """The conditions of a rehearsal, as the core takes them."""
    return {
        "parameters": {name: float(value) for name, value in (parameters or {}).items()},
        "profile": profile(airframe, battery),
        "wind": blowing(wind),
        "gust_m_s": within("gust_m_s", gust_m_s, 0.0, 20.0),
        "seed": int(within("seed", seed, 0, 2**64 - 1)),
        "heading_deg": None if heading_deg is None else within("heading_deg", heading_deg, -360.0, 360.0),
        "clearance_m": within("clearance_m", clearance_m, 0.0, 1_000.0),
    }


def within(name: str, value: float, least: float, most: float) -> float:
    """The number, if it is in its range; `InvalidRequest` otherwise, also for NaN."""
    if not least <= value <= most:
        raise InvalidRequest(f"{name} is {value}, should be {least:,} to {most:,}")
    return value


def blowing(wind: Wind | None) -> tuple[float, float]:
    """Direction and speed of a wind, calm by default."""
    if wind is None:
        return (0.0, 0.0)
    return (
        within("wind.from_deg", wind.from_deg, -360.0, 360.0),
        within("wind.speed_m_s", wind.speed_m_s, 0.0, 60.0),
    )

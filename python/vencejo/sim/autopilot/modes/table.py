"""Every mode of the simulated plane by its number."""

from __future__ import annotations

from vencejo.sim.autopilot.auto import mode as auto

from . import autoland, circles, guided, rtl, sticks, takeoff
from .base import Controls, FlightMode

__all__ = ["make_modes"]


def make_modes(controls: Controls) -> dict[int, FlightMode]:
    """The modes of one plane."""
    kinds: tuple[type[FlightMode], ...] = (
        *sticks.MODES,
        *circles.MODES,
        *rtl.MODES,
        *guided.MODES,
        *takeoff.MODES,
        *auto.MODES,
        *autoland.MODES,
    )
    return {int(kind.number): kind(controls) for kind in kinds}

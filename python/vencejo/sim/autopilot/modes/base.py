"""What every flight mode is, and the parts of the autopilot that modes use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from vencejo.sim.autopilot.auto.commands import Commands
from vencejo.sim.autopilot.auto.mission import MissionRunner
from vencejo.sim.autopilot.energy import Energy
from vencejo.sim.autopilot.interface import BY_STICK, Mode
from vencejo.sim.autopilot.landing import Landing
from vencejo.sim.autopilot.navigator import Navigator
from vencejo.sim.autopilot.plane import Plane
from vencejo.sim.autopilot.takeoff import Takeoff

__all__ = ["Controls", "FlightMode"]


@dataclass(frozen=True, slots=True)
class Controls:
    """The components that a flight mode uses."""

    plane: Plane
    nav: Navigator
    mission: MissionRunner
    climbout: Takeoff
    landing: Landing
    energy: Energy
    commands: Commands
    change_mode: Callable[[Mode, str], object]
    enter_auto_to_land: Callable[[], None]


class FlightMode:
    """One mode. ``navigate`` and ``update`` run 10 times a second, ``update`` 50 times in modes flown by stick."""

    number: Mode
    auto_throttle = False
    """Whether the autopilot controls the throttle."""
    navigates = False
    """Whether the autopilot navigates (ArduPlane's ``does_auto_navigation``)."""
    captures_direction = False
    """Whether AUTOLAND's direction may be taken in this mode (``allows_autoland_direction_capture``)."""

    def __init__(self, controls: Controls) -> None:
        self.stick = self.number in BY_STICK
        """Whether the mode is flown by stick."""
        self._plane = controls.plane
        self._nav = controls.nav
        self._mission = controls.mission
        self._climbout = controls.climbout
        self._landing = controls.landing
        self._energy = controls.energy
        self._commands = controls.commands
        self._change_mode = controls.change_mode
        self._enter_auto_to_land = controls.enter_auto_to_land

    def refusal(self) -> str | None:
        """Why the mode cannot be entered now, in ArduPlane's words; None when it can."""
        return None

    def enter(self) -> None:
        """Enter the mode."""

    def leave(self) -> None:
        """Leave the mode."""

    def navigate(self) -> None:
        """Guide the plane to its target."""

    def update(self) -> None:
        """Set the demands on the control laws."""

    def bank_max_deg(self, limit_deg: float) -> float:
        """The bank that the mode allows, at most ``limit_deg`` unless it is flown beyond by stick."""
        return limit_deg

    def adjust_altitude(self) -> None:
        """Set the target altitude."""
        self._nav.adjust_altitude()

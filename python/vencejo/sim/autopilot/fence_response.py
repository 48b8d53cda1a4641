"""The reaction to a fence breach, and the mode changes that are refused after one.

The rules are those of ArduPlane's ``fence.cpp`` and ``Plane::set_mode``. Breaches are detected by
:mod:`vencejo.sim.fence`.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

from .auto.mission import MissionRunner
from .geo import Spot
from .interface import FenceBreach, Mode, Severity
from .landing import Landing
from .plane import Plane

__all__ = ["RTL_COMPLETE_REASON", "FenceResponse"]

RTL_COMPLETE_REASON = "RTL complete"
"""Reason of the change from RTL to the mission's landing."""
_REASON = "fence breached"
_MANUAL_RECOVERY_S = 10.0
_NO_MODE_CHANGE = 1
"""FENCE_OPTIONS bit 0: mode changes are refused while the plane returns from a breach."""


class _Action(IntEnum):
    """FENCE_ACTION."""

    REPORT = 0
    RTL = 1
    GUIDED = 6
    GUIDED_THROTTLE = 7
    AUTOLAND_OR_RTL = 8


class FenceResponse:
    """The reaction of one plane to its fence.

    Parameters
    ----------
    plane, mission, landing
        The state that the reaction reads and acts on.
    change_mode : callable
        Changes the mode, with a reason.
    go_to : callable
        Sets the target of GUIDED.
    """

    def __init__(
        self,
        plane: Plane,
        mission: MissionRunner,
        landing: Landing,
        change_mode: Callable[[Mode, str], bool],
        go_to: Callable[[Spot], None],
    ) -> None:
        self._plane = plane
        self._mission = mission
        self._landing = landing
        self._change_mode = change_mode
        self._go_to = go_to
        self._breach: FenceBreach | None = None
        self._checks_from_s = 0.0

    def denies_mode_change(self, reason: str) -> bool:
        """Whether a mode change is refused: while the plane returns from a breach, except to land after RTL."""
        plane = self._plane
        is_locked = (
            plane.armed and self._breach is not None and bool(int(plane.tune["FENCE_OPTIONS"]) & _NO_MODE_CHANGE)
        )
        return is_locked and self._is_recovering and reason != RTL_COMPLETE_REASON

    def mode_entered(self) -> None:
        """A mode change during a breach suspends the checks for a while (AC_Fence::manual_recovery_start)."""
        if self._breach is not None:
            self._checks_from_s = self._plane.time_s + _MANUAL_RECOVERY_S
            self._plane.say(Severity.INFO, "Manual recovery started")

    def breached(self, kind: FenceBreach | None, return_point: tuple[float, float] | None) -> None:
        """React to a breach, or to the end of one (None)."""
        if kind is self._breach:
            return
        self._breach = kind
        plane = self._plane
        # A flare is not interrupted, and further breaches are ignored while the plane returns from one.
        if not plane.armed or self._landing.flaring or self._is_recovering:
            return
        if kind is None:
            plane.say(Severity.NOTICE, "Fence breach cleared")
            return
        if plane.time_s < self._checks_from_s:
            return
        plane.say(Severity.NOTICE, f"{kind.value} fence breached")
        action = int(plane.tune["FENCE_ACTION"])
        if action in (_Action.GUIDED, _Action.GUIDED_THROTTLE):
            self._change_mode(Mode.GUIDED, _REASON)
            self._go_to(self._return_spot(return_point))
        elif action in (_Action.RTL, _Action.AUTOLAND_OR_RTL):
            lands = plane.in_auto and self._mission.in_landing_sequence and plane.tune["RTL_AUTOLAND"] in (1, 2)
            if lands or plane.flight_mode is Mode.AUTOLAND:
                return
            if action != _Action.AUTOLAND_OR_RTL or not self._change_mode(Mode.AUTOLAND, _REASON):
                self._change_mode(Mode.RTL, _REASON)

    def disabled(self) -> None:
        """No fence is enabled: the return from a breach is over, in GUIDED with the mode before it (fence_check)."""
        plane = self._plane
        self._breach = None
        if plane.mode_reason == _REASON and plane.flight_mode is Mode.GUIDED:
            self._change_mode(plane.previous_mode, "fence disabled")
        if plane.mode_reason == _REASON:
            plane.mode_reason = "fence disabled"
        if plane.previous_mode_reason == _REASON:
            plane.previous_mode_reason = "fence disabled"

    @property
    def _is_recovering(self) -> bool:
        """Plane::in_fence_recovery: the present mode, or the RTL before this landing, is due to a breach."""
        plane = self._plane
        if plane.in_auto and not self._mission.in_landing_sequence:
            return False
        lands_after = plane.previous_mode_reason == _REASON and plane.mode_reason == RTL_COMPLETE_REASON
        return plane.mode_reason == _REASON or lands_after

    def _return_spot(self, return_point: tuple[float, float] | None) -> Spot:
        """Target of FENCE_ACTION 6 and 7, at FENCE_RET_ALT or half way between floor and ceiling."""
        plane, tune = self._plane, self._plane.tune
        if tune["FENCE_RET_RALLY"] != 0:
            return plane.return_spot()
        low_m, high_m = (
            tune["FENCE_ALT_MIN"] + tune["FENCE_MARGIN"],
            tune["FENCE_ALT_MAX"] - tune["FENCE_MARGIN"],
        )
        altitude_m = tune["RTL_ALTITUDE"] if low_m >= high_m else (low_m + high_m) / 2.0
        if tune["FENCE_RET_ALT"] > 0:
            altitude_m = tune["FENCE_RET_ALT"]
        n_m, e_m = (plane.home.n_m, plane.home.e_m) if return_point is None else plane.frame.to_plane(*return_point)
        return Spot(n_m, e_m, plane.home.alt_m + altitude_m)

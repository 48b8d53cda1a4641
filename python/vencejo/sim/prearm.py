"""Pre-arm checks in ArduPlane's words, without the prefix "PreArm: " or "Arm: "."""

from __future__ import annotations

from collections.abc import Callable

from vencejo.sim.autopilot.interface import EkfFlag, Severity, Snapshot
from vencejo.sim.fence import FenceMonitor
from vencejo.sim.params import ParamStore
from vencejo.sim.plan_store import PlanStore
from vencejo.sim.terrain import Terrain

__all__ = ["PrearmChecks", "PrearmTexts"]

_MIN_AIRSPEED_MIN_M_S = 5
_SETTLED = EkfFlag.ATTITUDE | EkfFlag.VELOCITY_HORIZ | EkfFlag.POS_HORIZ_ABS | EkfFlag.POS_VERT_ABS

_REQUIRED_ITEMS = (
    (1 << 0, (21,), "Land"),
    (1 << 1, (85,), "VTOL Land"),
    (1 << 2, (189,), "DO_LAND_START"),
    (1 << 3, (22,), "Takeoff"),
    (1 << 4, (84,), "VTOL Takeoff"),
)
"""Bits of ARMING_MIS_ITEMS, the commands that satisfy them, and how a missing one is named."""


_TEXT_S = 30.0
_SOON_S = 4.0
_OF_THE_VEHICLE = ("mode not armable", "In landing sequence")
"""Checks that AP_Arming_Plane adds to those of AP_Arming."""
_EVERYTHING = -1
"""ARMING_SKIPCHK that skips all but the mandatory checks."""


class _Skip:
    """Bits of ARMING_SKIPCHK."""

    BARO = 1 << 1
    GPS = 1 << 3
    INS = 1 << 4
    PARAMETERS = 1 << 5
    RC = 1 << 6
    BATTERY = 1 << 8
    MISSION = 1 << 14


class PrearmChecks:
    """The checks of one plane; a call returns the failing ones, in ArduPlane's order.

    Parameters
    ----------
    params, plans, fence, terrain
        The state that is checked.
    snapshot : callable
        Returns the present state.
    """

    def __init__(
        self,
        params: ParamStore,
        plans: PlanStore,
        fence: FenceMonitor,
        terrain: Terrain,
        snapshot: Callable[[], Snapshot],
    ) -> None:
        self._params = params
        self._plans = plans
        self._fence = fence
        self._terrain = terrain
        self._snapshot = snapshot

    def __call__(self) -> list[str]:
        """The failing checks; the plane arms when the list is empty."""
        if self._params.integer("ARMING_REQUIRE") == 0:
            return []
        now = self._snapshot()
        mandatory = ["Waiting for RC"] if now.waits_for_radio else []
        skip = self._params.integer("ARMING_SKIPCHK")
        if skip == _EVERYTHING:
            return mandatory
        found: list[str] = []
        if not skip & _Skip.BATTERY:
            found += self._battery(now)
        if not skip & _Skip.INS and now.ekf_flags & _SETTLED != _SETTLED:
            found.append("AHRS: not using configured AHRS type")
        if not skip & _Skip.GPS and now.gps_fix_type < 3:
            found.append("GPS 1: Bad fix")
        if not skip & _Skip.RC and now.radio_lost:
            found.append("Radio failsafe on")
        if not skip & _Skip.MISSION:
            found += self._mission()
        found += self._fence.prearm()
        if not skip & _Skip.PARAMETERS:
            found += self._parameters() + self._ground()
        found += mandatory
        if now.mission_in_landing:
            found.append("In landing sequence")
        return found + now.mode.failing_checks

    def _battery(self, now: Snapshot) -> list[str]:
        arm_volt = self._params.get("BATT_ARM_VOLT")
        if arm_volt > 0 and now.battery_voltage_v < arm_volt:
            return ["Battery 1 below minimum arming voltage"]
        arm_mah = self._params.get("BATT_ARM_MAH")
        if arm_mah > 0 and self._params.get("BATT_CAPACITY") - now.battery_consumed_mah < arm_mah:
            return ["Battery 1 below minimum arming capacity"]
        for kind, text in (("CRT", "critical"), ("LOW", "low")):
            volt, mah = self._params.get(f"BATT_{kind}_VOLT"), self._params.get(f"BATT_{kind}_MAH")
            if volt > 0 and now.battery_voltage_v < volt:
                return [f"Battery 1 {text} voltage failsafe"]
            if mah > 0 and self._params.get("BATT_CAPACITY") - now.battery_consumed_mah < mah:
                return [f"Battery 1 {text} capacity failsafe"]
        return []

    def _mission(self) -> list[str]:
        found: list[str] = []
        commands = {item.command for item in self._plans.mission[1:]}
        wanted = self._params.integer("ARMING_MIS_ITEMS")
        for bit, accepted, name in _REQUIRED_ITEMS:
            if wanted & bit and not commands.intersection(accepted):
                found.append(f"Missing mission item: {name}")
                break
        if wanted & (1 << 5) and not self._plans.rally:
            found.append("No rally points")
        if self._params.integer("RTL_AUTOLAND") == 0:
            if 189 in commands:
                found.append("DO_LAND_START set and RTL_AUTOLAND disabled")
            if 188 in commands:
                found.append("DO_RETURN_PATH_START set and RTL_AUTOLAND disabled")
        return found

    def _ground(self) -> list[str]:
        """AP_Arming::terrain_checks: TERRAIN_FOLLOW and items above terrain need terrain data."""
        counts_from_it = any(item.frame == 10 for item in self._plans.mission[1:])
        if not counts_from_it and self._params.integer("TERRAIN_FOLLOW") == 0:
            return []
        reason = self._terrain.prearm()
        return [] if reason is None else [reason]

    def _parameters(self) -> list[str]:
        get = self._params.get
        found: list[str] = []
        if get("ROLL_LIMIT_DEG") < 3:
            found.append(f"ROLL_LIMIT_DEG too small ({get('ROLL_LIMIT_DEG'):.1f})")
        if get("PTCH_LIM_MAX_DEG") < 3:
            found.append(f"PTCH_LIM_MAX_DEG too small ({get('PTCH_LIM_MAX_DEG'):.1f})")
        if get("PTCH_LIM_MIN_DEG") > -3:
            found.append(f"PTCH_LIM_MIN_DEG too large ({get('PTCH_LIM_MIN_DEG'):.1f})")
        if get("AIRSPEED_MIN") < _MIN_AIRSPEED_MIN_M_S:
            found.append(f"AIRSPEED_MIN too low ({get('AIRSPEED_MIN'):.0f} < {_MIN_AIRSPEED_MIN_M_S})")
        return found


class PrearmTexts:
    """Tells the failing checks of one plane every half minute, and after 4 s when one began to fail.

    As AP_Arming::update. Those of the mode and of the landing sequence come with the next half minute only.
    """

    def __init__(self, say: Callable[[Severity, str], None]) -> None:
        self._say = say
        self._told_s = 0.0
        self._failed, self._fell = True, False
        self.passed = False
        """Whether no check failed at last."""

    def tick(self, now: Snapshot, reasons: list[str]) -> None:
        """Take the failing checks, none while the plane is armed; ten times a second."""
        self.passed = not reasons
        fails = any(not reason.endswith(_OF_THE_VEHICLE) for reason in reasons)
        self._fell = fails and (self._fell or not self._failed)
        self._failed = fails
        since_s = now.time_s - self._told_s
        if since_s >= _TEXT_S or (self._fell and since_s > _SOON_S):
            self._told_s, self._fell = now.time_s, False
            for reason in reasons:
                self._say(Severity.CRITICAL, f"PreArm: {reason}")

"""Failsafes of the ground station, the remote control and the battery.

The rules are those of ArduPlane's ``events.cpp``, ``system.cpp`` (``check_short_rc_failsafe``, ``check_long_failsafe``)
and ``radio.cpp``, and of ``AP_BattMonitor``; parachute, rotors and flight termination are not simulated.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, IntEnum

from .auto.mission import MissionRunner, RunState
from .interface import BY_STICK, MavResult, Mode, Severity
from .landing import Landing
from .plane import Plane

__all__ = ["BATTERY_REASON", "RADIO_REASON", "BatteryLevel", "Failsafes"]

RADIO_REASON = "radio failsafe"
BATTERY_REASON = "battery failsafe"
_LOST_S = 0.2
"""Duration of a lost signal or a throttle below THR_FS_VALUE that triggers the failsafe: ten readings at 50 Hz."""
_GOING_ON = (Mode.AUTO, Mode.AUTOLAND, Mode.AVOID_ADSB, Mode.GUIDED, Mode.LOITER)
"""Modes in which the short action "best guess" does nothing."""


class _State(Enum):
    """The active failsafe of radio or ground station."""

    NONE = ""
    SHORT = "RC Short"
    LONG = "RC Long"
    STATION = "GCS"


class BatteryLevel(IntEnum):
    """The battery threshold that was crossed."""

    FINE = 0
    LOW = 1
    CRITICAL = 2


class _ShortAction(IntEnum):
    """FS_SHORT_ACTN."""

    BEST_GUESS = 0
    CIRCLE = 1
    GLIDE = 2
    OFF = 3
    FBWB = 4


class _LongAction(IntEnum):
    """FS_LONG_ACTN."""

    CONTINUE = 0
    RTL = 1
    GLIDE = 2
    PARACHUTE = 3
    AUTO = 4
    AUTOLAND = 5


class _BatteryAction(IntEnum):
    """BATT_FS_LOW_ACT and BATT_FS_CRT_ACT; the VTOL landings act as LAND on a plane without rotors."""

    NONE = 0
    RTL = 1
    LAND = 2
    TERMINATE = 3
    QLAND = 4
    PARACHUTE = 5
    LOITER_QLAND = 6
    AUTOLAND_OR_RTL = 7


_GRAVEST_FIRST = (
    _BatteryAction.TERMINATE,
    _BatteryAction.PARACHUTE,
    _BatteryAction.QLAND,
    _BatteryAction.LAND,
    _BatteryAction.RTL,
    _BatteryAction.NONE,
)
"""Order of severity: a second threshold never triggers a less severe action than the first.

Actions that are not listed, as in Plane::_failsafe_priorities, come after all others.
"""


class Failsafes:
    """The failsafes of one plane; call :meth:`check` ten times a simulated second.

    Parameters
    ----------
    plane, mission, landing
        The state that the failsafes read and act on.
    change_mode : callable
        Changes the mode, with a reason.
    land : callable
        Enters AUTO, once the mission has been set to a landing, with a reason.
    climbing_out : callable
        Whether the plane is in the climb of a take-off.
    """

    def __init__(
        self,
        plane: Plane,
        mission: MissionRunner,
        landing: Landing,
        change_mode: Callable[[Mode, str], bool],
        land: Callable[[str], object],
        climbing_out: Callable[[], bool],
    ) -> None:
        self._plane = plane
        self._mission = mission
        self._landing = landing
        self._change_mode = change_mode
        self._land = land
        self._climbing_out = climbing_out
        self.battery = BatteryLevel.FINE
        self.radio_lost = False
        self._has_heard = False
        self._state = _State.NONE
        self._is_pending = False
        self._station_lost = False
        self._heard_s = 0.0
        self._bad_since_s: float | None = None
        self._mode_before = Mode.MANUAL
        self._below_since_s: dict[BatteryLevel, float] = {}
        self._gravest = len(_GRAVEST_FIRST)

    @property
    def is_on(self) -> bool:
        """Whether any failsafe is active."""
        return self._state is not _State.NONE or self.battery is not BatteryLevel.FINE

    @property
    def waits_for_radio(self) -> bool:
        """Whether arming, forced arming included, is refused because no RC frame has arrived since the boot."""
        return not self._has_heard and int(self._plane.tune["THR_FAILSAFE"]) == 1

    @property
    def station_is_lost(self) -> bool:
        """Whether the ground station failsafe is active."""
        return self._state is _State.STATION

    def station(self, *, is_lost: bool) -> None:
        """Report that the ground station's heartbeat is lost, or back."""
        self._station_lost = is_lost
        self._check_long()

    def mode_changed(self) -> None:
        """Cancel a failsafe action that is postponed to the end of a climb."""
        self._is_pending = False

    def check(self) -> None:
        """Check radio and battery, and act."""
        self._check_radio()
        self._check_short()
        self._check_long()
        if self._is_pending and not self._climbing_out():
            self._is_pending = False
            self._long(self._state)
        self._check_battery()

    # the remote control

    def _check_radio(self) -> None:
        plane, tune = self._plane, self._plane.tune
        plane.rc.failure = int(tune["SIM_RC_FAIL"])
        kind = int(tune["THR_FAILSAFE"])
        is_low = kind != 0 and plane.rc.throttle_us <= tune["THR_FS_VALUE"]
        self._has_heard |= plane.rc.is_heard
        if plane.rc.is_heard and not is_low:
            self._heard_s = plane.time_s
        is_bad = is_low or plane.time_s - self._heard_s > tune["RC_FS_TIMEOUT"]
        plane.rc.is_believed = not is_bad
        if not (self._has_heard or plane.armed or plane.is_flying):
            return
        if not is_bad or kind != 1:
            self._bad_since_s = None
        elif self._bad_since_s is None:
            self._bad_since_s = plane.time_s
        is_lost = self._bad_since_s is not None and plane.time_s - self._bad_since_s >= _LOST_S
        if is_lost is not self.radio_lost:
            self.radio_lost = is_lost
            plane.say(Severity.WARNING, f"Throttle failsafe {'on' if is_lost else 'off'}")

    def _check_short(self) -> None:
        is_off = int(self._plane.tune["FS_SHORT_ACTN"]) == _ShortAction.OFF
        if self._state is _State.NONE and self.radio_lost and not is_off and not self._landing.active:
            self._short()
        elif self._state is _State.SHORT and (is_off or not self.radio_lost):
            self._state = _State.NONE
            self._plane.say(Severity.WARNING, "RC Short Failsafe Cleared")
            if self._plane.mode_reason == RADIO_REASON:
                self._change_mode(self._mode_before, "radio failsafe recovery")
                self._plane.say(Severity.INFO, f"Flight mode {self._mode_before.full_name} restored")

    def _short(self) -> None:
        plane = self._plane
        self._state = _State.SHORT
        self._mode_before = mode = plane.flight_mode
        action = int(plane.tune["FS_SHORT_ACTN"])
        goes_on = mode in _GOING_ON and action == _ShortAction.BEST_GUESS
        if (mode in BY_STICK or mode in _GOING_ON) and not goes_on and not self._lands_already():
            other = {_ShortAction.GLIDE: Mode.FBWA, _ShortAction.FBWB: Mode.FBWB}
            self._change_mode(other.get(action, Mode.CIRCLE), RADIO_REASON)  # type: ignore[call-overload]
        if plane.flight_mode is mode:
            plane.say(Severity.WARNING, "RC Short Failsafe On")
        else:
            plane.say(Severity.WARNING, f"RC Short Failsafe: switched to {plane.flight_mode.full_name}")

    # the long failsafe, of the remote control or of the ground station

    def _check_long(self) -> None:
        plane = self._plane
        if self._state in (_State.NONE, _State.SHORT):
            if self._landing.active:
                return
            if self.radio_lost and plane.time_s - self._heard_s > plane.tune["FS_LONG_TIMEOUT"]:
                self._long(_State.LONG)
            elif self._station_lost:
                self._long(_State.STATION)
        elif self._state is _State.STATION and not self._station_lost:
            self._end_long("GCS Failsafe Cleared")
        elif self._state is _State.LONG and not self.radio_lost:
            self._end_long("RC Long Failsafe Cleared")

    def _end_long(self, text: str) -> None:
        self._state = _State.NONE
        self._is_pending = False
        self._plane.say(Severity.WARNING, text)

    def _long(self, state: _State) -> None:
        """Act by FS_LONG_ACTN; the effect of "continue" depends on the mode."""
        plane = self._plane
        plane.rc.clear()
        self._state = state
        action = int(plane.tune["FS_LONG_ACTN"])
        actions: dict[int, Mode] = {
            _LongAction.RTL: Mode.RTL,
            _LongAction.GLIDE: Mode.FBWA,
            _LongAction.AUTO: Mode.AUTO,
            _LongAction.AUTOLAND: Mode.AUTOLAND,
        }
        target = actions.get(action)
        mode = plane.flight_mode
        if mode in (Mode.INITIALISING, Mode.AUTOLAND, Mode.LOITER_ALT_QLAND) or self._lands_already():
            target = None
        elif mode is Mode.RTL:
            target = target if action in (_LongAction.AUTO, _LongAction.AUTOLAND) else None
        elif mode not in (Mode.AUTO, Mode.AVOID_ADSB, Mode.GUIDED):
            waits = action not in (_LongAction.GLIDE, _LongAction.PARACHUTE)
            if mode is Mode.TAKEOFF and self._climbing_out() and waits:
                self._is_pending = True
                target = None
            elif action == _LongAction.CONTINUE:
                target = Mode.RTL
        if target is not None:
            reason = "GCS failsafe" if state is _State.STATION else RADIO_REASON
            if not self._change_mode(target, reason) and target is Mode.AUTOLAND and mode is not Mode.RTL:
                self._change_mode(Mode.RTL, reason)
        plane.say(Severity.WARNING, f"{state.value} Failsafe On: switched to {plane.flight_mode.full_name}")

    def _lands_already(self) -> bool:
        """Plane::failsafe_in_landing_sequence, which counts in AUTO and AUTOLAND only."""
        by_itself = self._plane.flight_mode in (Mode.AUTO, Mode.AUTOLAND)
        return by_itself and (self._landing.active or self._mission.in_landing_sequence)

    def terminate(self, *, wanted: bool) -> MavResult:
        """Terminate the flight, or abort that (AP_AdvancedFailsafe::gcs_terminate); no termination is configured."""
        if not int(self._plane.tune["AFS_ENABLE"]):
            text, result = "AFS not enabled, can't terminate the vehicle", MavResult.FAILED
        elif wanted:
            text, result = "Unable to terminate, termination is not configured", MavResult.FAILED
        else:
            text, result = "Aborting termination due to GCS request", MavResult.ACCEPTED
        self._plane.say(Severity.INFO, text)
        return result

    # the battery

    def _check_battery(self) -> None:
        if not self._plane.armed:
            return
        level = self._battery_level()
        if level <= self.battery:
            return
        self.battery = level
        word, name = ("low", "LOW") if level is BatteryLevel.LOW else ("critical", "CRT")
        pack = self._plane.battery
        text = f"Battery 1 is {word} {pack.voltage_v:.2f}V used {pack.consumed_mah:.0f} mAh"
        self._plane.say(Severity.WARNING, text)
        action = int(self._plane.tune[f"BATT_FS_{name}_ACT"])
        rank = len(_GRAVEST_FIRST) if action not in _GRAVEST_FIRST else [*_GRAVEST_FIRST].index(_BatteryAction(action))
        if rank <= self._gravest:
            self._gravest = rank
            self._act_on_battery(action)

    def _battery_level(self) -> BatteryLevel:
        """The most severe threshold crossed: of charge at once, of voltage after BATT_LOW_TIMER below it."""
        tune, pack, now_s = self._plane.tune, self._plane.battery, self._plane.time_s
        if int(tune["BATT_MONITOR"]) == 0:
            return BatteryLevel.FINE
        volts = pack.resting_v if int(tune["BATT_FS_VOLTSRC"]) == 1 else pack.voltage_v
        timer_s = tune["BATT_LOW_TIMER"]
        for level, name in ((BatteryLevel.CRITICAL, "CRT"), (BatteryLevel.LOW, "LOW")):
            if volts >= tune[f"BATT_{name}_VOLT"]:
                self._below_since_s.pop(level, None)
            elif 0 < timer_s < now_s - self._below_since_s.setdefault(level, now_s):
                return level
            least_mah = tune[f"BATT_{name}_MAH"]
            if least_mah > 0 and tune["BATT_CAPACITY"] - pack.consumed_mah < least_mah:
                return level
        return BatteryLevel.FINE

    def _act_on_battery(self, action: int) -> None:
        plane, mission = self._plane, self._mission
        if action == _BatteryAction.TERMINATE:
            self.terminate(wanted=True)
            return
        lands = action in (_BatteryAction.LAND, _BatteryAction.QLAND, _BatteryAction.LOITER_QLAND)
        if self._landing.active or not (lands or action in (_BatteryAction.RTL, _BatteryAction.AUTOLAND_OR_RTL)):
            return
        lands_already = mission.state is RunState.RUNNING and mission.in_landing_sequence
        if lands_already and (lands or int(plane.tune["RTL_AUTOLAND"]) == 2):
            return
        if lands and mission.jump_to_landing(plane.distance_to_item):
            self._land(BATTERY_REASON)
        elif plane.flight_mode is not Mode.AUTOLAND:
            by_itself = action == _BatteryAction.AUTOLAND_OR_RTL and self._change_mode(Mode.AUTOLAND, BATTERY_REASON)
            if not by_itself:
                self._change_mode(Mode.RTL, BATTERY_REASON)

"""The autopilot's view of the parameters: by ArduPlane's names, cached until one changes."""

from __future__ import annotations

from .interface import Parameters

__all__ = ["PILOT_NAMES", "Tuning"]

PILOT_NAMES: tuple[str, ...] = (
    "NAVL1_PERIOD",
    "NAVL1_DAMPING",
    "NAVL1_XTRACK_I",
    "TECS_TIME_CONST",
    "TECS_LAND_TCONST",
    "TECS_CLMB_MAX",
    "TECS_SINK_MIN",
    "TECS_SINK_MAX",
    "TECS_SPDWEIGHT",
    "TECS_LAND_SPDWGT",
    "TECS_INTEG_GAIN",
    "TECS_THR_DAMP",
    "TECS_PTCH_DAMP",
    "TECS_LAND_DAMP",
    "TECS_RLL2THR",
    "TECS_VERT_ACC",
    "TECS_HDEM_TCONST",
    "TECS_LAND_SINK",
    "TRIM_THROTTLE",
    "THR_SLEWRATE",
    "AIRSPEED_MIN",
    "AIRSPEED_MAX",
    "RLL2SRV_TCONST",
    "RLL2SRV_RMAX",
    "PTCH2SRV_TCONST",
    "PTCH2SRV_RMAX_UP",
    "PTCH2SRV_RLL",
    "KFF_RDDRMIX",
    "YAW2SRV_DAMP",
    "SCALING_SPEED",
    "RLL_RATE_FF",
    "RLL_RATE_P",
    "RLL_RATE_I",
    "RLL_RATE_D",
    "RLL_RATE_IMAX",
    "PTCH_RATE_FF",
    "PTCH_RATE_P",
    "PTCH_RATE_I",
    "PTCH_RATE_D",
    "PTCH_RATE_IMAX",
)
"""Parameters passed to the control laws unchanged."""

_DEFAULTS = {
    "ACRO_PITCH_RATE": 180.0,
    "ACRO_ROLL_RATE": 180.0,
    "AFS_ENABLE": 0.0,
    "AIRSPEED_CRUISE": 22.0,
    "AIRSPEED_MAX": 30.0,
    "AIRSPEED_MIN": 10.0,
    "ALT_SLOPE_MAXHGT": 5.0,
    "ALT_SLOPE_MIN": 15.0,
    "AUTOLAND_CLIMB": 0.0,
    "AUTOLAND_DIR_OFF": 0.0,
    "AUTOLAND_OPTIONS": 0.0,
    "AUTOLAND_WP_ALT": 55.0,
    "AUTOLAND_WP_DIST": 400.0,
    "AUTOTUNE_AXES": 7.0,
    "BATT_CAPACITY": 3300.0,
    "BATT_CRT_MAH": 0.0,
    "BATT_CRT_VOLT": 0.0,
    "BATT_FS_CRT_ACT": 0.0,
    "BATT_FS_LOW_ACT": 0.0,
    "BATT_FS_VOLTSRC": 0.0,
    "BATT_LOW_MAH": 0.0,
    "BATT_LOW_TIMER": 10.0,
    "BATT_LOW_VOLT": 0.0,
    "BATT_MONITOR": 4.0,
    "FBWB_CLIMB_RATE": 2.0,
    "FENCE_ACTION": 1.0,
    "FENCE_ALT_MAX": 100.0,
    "FENCE_ALT_MIN": -10.0,
    "FENCE_MARGIN": 2.0,
    "FENCE_OPTIONS": 1.0,
    "FENCE_RET_ALT": 0.0,
    "FENCE_RET_RALLY": 0.0,
    "FLTMODE_GCSBLOCK": 0.0,
    "FS_LONG_ACTN": 0.0,
    "FS_LONG_TIMEOUT": 5.0,
    "FS_SHORT_ACTN": 0.0,
    "GRIP_ENABLE": 0.0,
    "GUIDED_TIMEOUT": 3.0,
    "LAND_DISARMDELAY": 20.0,
    "LAND_FLARE_AIM": 50.0,
    "LAND_FLARE_ALT": 3.0,
    "LAND_FLARE_SEC": 3.0,
    "LAND_PF_ALT": 10.0,
    "LAND_PF_ARSPD": 0.0,
    "LAND_PF_SEC": 6.0,
    "LAND_PITCH_DEG": 1.0,
    "LAND_WIND_COMP": 50.0,
    "LEVEL_ROLL_LIMIT": 5.0,
    "MIN_GROUNDSPEED": 0.0,
    "MIS_RESTART": 0.0,
    "PTCH_LIM_MAX_DEG": 25.0,
    "PTCH_LIM_MIN_DEG": -20.0,
    "RALLY_INCL_HOME": 0.0,
    "RALLY_LIMIT_KM": 5.0,
    "RC_FS_TIMEOUT": 1.0,
    "ROLL_LIMIT_DEG": 65.0,
    "RTL_ALTITUDE": 100.0,
    "RTL_AUTOLAND": 0.0,
    "RTL_RADIUS": 0.0,
    "SIM_RC_FAIL": 0.0,
    "STALL_PREVENTION": 1.0,
    "TECS_CLMB_MAX": 5.0,
    "TECS_FLARE_HGT": 1.0,
    "TECS_LAND_ARSPD": -1.0,
    "TECS_LAND_PMAX": 10.0,
    "TECS_LAND_SINK": 0.25,
    "TECS_PITCH_MAX": 15.0,
    "TECS_PITCH_MIN": 0.0,
    "TERRAIN_FOLLOW": 0.0,
    "TERRAIN_LOOKAHD": 2000.0,
    "TERRAIN_SPACING": 100.0,
    "THR_FAILSAFE": 1.0,
    "THR_FS_VALUE": 950.0,
    "THR_MAX": 100.0,
    "THR_MIN": 0.0,
    "TKOFF_ACCEL_CNT": 1.0,
    "TKOFF_ALT": 50.0,
    "TKOFF_DIST": 200.0,
    "TKOFF_LVL_ALT": 10.0,
    "TKOFF_LVL_PITCH": 15.0,
    "TKOFF_PLIM_SEC": 2.0,
    "TKOFF_ROTATE_SPD": 0.0,
    "TKOFF_THR_DELAY": 2.0,
    "TKOFF_THR_MAX": 0.0,
    "TKOFF_THR_MINACC": 0.0,
    "TKOFF_THR_MINSPD": 0.0,
    "TRIM_THROTTLE": 50.0,
    "WP_LOITER_RAD": 80.0,
    "WP_MAX_RADIUS": 0.0,
    "WP_RADIUS": 50.0,
}
"""ArduPlane's defaults, for names that the store lacks."""


class Tuning:
    """Cached view of a parameter store."""

    __slots__ = ("_cache", "_params", "_revision")

    def __init__(self, params: Parameters) -> None:
        self._params = params
        self._revision = params.revision
        self._cache: dict[str, float] = {}

    def __getitem__(self, name: str) -> float:
        value = self._cache.get(name)
        if value is None:
            try:
                value = float(self._params.get(name))
            except KeyError:
                value = _DEFAULTS[name]
            self._cache[name] = value
        return value

    def set_unsaved(self, name: str, value: float) -> None:
        """Set a parameter without saving it; in effect from the next :meth:`refresh` on."""
        self._params.set_unsaved(name, value)

    def load(self, *names: str) -> None:
        """Restore saved values."""
        for name in names:
            self._params.load(name)

    def refresh(self) -> bool:
        """Drop the cached values when the store has changed; True when it has."""
        revision = self._params.revision
        if revision == self._revision:
            return False
        self._revision = revision
        self._cache.clear()
        return True

    def for_pilot(self) -> dict[str, float]:
        """The parameters of the control laws that the store has."""
        found: dict[str, float] = {}
        for name in PILOT_NAMES:
            try:
                found[name] = float(self._params.get(name))
            except KeyError:
                continue
        return found

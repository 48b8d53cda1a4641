"""ArduPlane's start: its texts and estimates in the first twenty seconds, as functions of the time since boot.

The times are those of tests/fixtures/captures/arduplane-takeoff-to-landing.tlog, which begins at boot. Before the
receiver has a fix the vehicle dead-reckons from latitude and longitude 0, and until home is set its heights are those
of the barometer alone, so the telemetry of these seconds is wrong.
"""

from __future__ import annotations

import math

from .interface import EkfFlag, Severity

__all__ = [
    "FIX_S",
    "HEIGHT_S",
    "HOME_S",
    "MEASURED_S",
    "ORIGIN_S",
    "READY_S",
    "TEXTS",
    "drift_m",
    "ekf_flags",
    "gps_before_fix",
]

READY_S = 1.5
"""End of initialisation; until then only the heartbeat is sent."""
MEASURED_S = 1.6
"""First measurement of battery and heading, shortly after their telemetry begins."""
_DRIFT_S = 3.2
"""Dead reckoning begins, with the first airspeed."""
_DETECTED_S = 8.8
"""The GPS receiver is detected."""
FIX_S = 9.1
"""First GPS fix: the position is known."""
HOME_S = 9.9
"""Home is first set, from the fixes received since :data:`FIX_S`."""
HEIGHT_S = 9.92
"""From here on altitudes are above mean sea level, just after home is set."""
_EKF_INIT_S = 11.1
_EKF_ALIGNED_S = 12.0
ORIGIN_S = 19.2
"""The estimator sets its origin, and the vehicle its home again."""
_EKF_READY_S = 20.3

TEXTS: tuple[tuple[float, Severity, str], ...] = (
    (READY_S, Severity.INFO, "Barometer 1 calibration complete"),
    (READY_S, Severity.INFO, "Airspeed 1 calibration started"),
    (READY_S, Severity.INFO, "ArduPilot Ready"),
    (READY_S, Severity.INFO, "AHRS: DCM active"),
    (3.2, Severity.INFO, "Airspeed 1 calibrated"),
    (_DETECTED_S, Severity.INFO, "GPS 1: detected u-blox"),
    (10.0, Severity.INFO, "EKF3 IMU0 initialised"),
    (11.9, Severity.INFO, "EKF3 IMU0 tilt alignment complete"),
    (12.0, Severity.INFO, "EKF3 IMU0 MAG0 initial yaw alignment complete"),
    (ORIGIN_S, Severity.INFO, "EKF3 IMU0 origin set"),
    (_EKF_READY_S, Severity.INFO, "EKF3 IMU0 is using GPS"),
    (_EKF_READY_S, Severity.INFO, "AHRS: EKF3 active"),
)
"""STATUSTEXT messages of the start: time since boot in seconds, severity, text."""

_DRIFT_LENGTH_M = 35.0
_DRIFT_DECAY_S = 0.6
"""Fit of the recorded drift, due west (its heading): 24 m after 0.6 s, 34 m after 2.4 s, 35.6 m at the end."""


def gps_before_fix(time_s: float) -> tuple[int, int]:
    """GPS_FIX_TYPE (0 no receiver, 1 no fix) and satellites before :data:`FIX_S`."""
    return (0, 0) if time_s < _DETECTED_S else (1, 3)


def drift_m(time_s: float) -> float:
    """Estimated distance ahead of latitude and longitude 0 before :data:`FIX_S`, metres."""
    return _DRIFT_LENGTH_M * -math.expm1(-max(0.0, time_s - _DRIFT_S) / _DRIFT_DECAY_S)


def ekf_flags(time_s: float) -> int:
    """EKF_STATUS_REPORT flags, during the start and afterwards."""
    if time_s < _EKF_INIT_S:
        return int(EkfFlag.UNINITIALIZED)
    if time_s < _EKF_ALIGNED_S:
        return 0
    flags = int(EkfFlag.ATTITUDE) | EkfFlag.VELOCITY_HORIZ | EkfFlag.VELOCITY_VERT | EkfFlag.POS_VERT_ABS
    if time_s < _EKF_READY_S:
        return flags | EkfFlag.CONST_POS_MODE
    horizontal = int(EkfFlag.POS_HORIZ_REL) | EkfFlag.POS_HORIZ_ABS
    return flags | horizontal | EkfFlag.PRED_POS_HORIZ_REL | EkfFlag.PRED_POS_HORIZ_ABS

"""Commands for equipment, and which of it the simulated plane has: a camera, the relays and free servo outputs.

Refusals are those of ArduPlane 4.8-dev in its own simulator with the same parameters (no gripper, mount, engine or
vertical lift), measured in November 2026.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from vencejo.sim.autopilot.interface import MavResult, Severity
from vencejo.sim.params import ParamStore

__all__ = ["Refusal", "refusal"]

_RELAYS = 6


class Refusal(NamedTuple):
    """A refused command: its result, and ArduPlane's text."""

    result: MavResult
    severity: Severity = Severity.INFO
    text: str = ""


_FAILED = Refusal(MavResult.FAILED)
_DENIED = Refusal(MavResult.DENIED)
_NO_VTOL = Refusal(MavResult.FAILED, Severity.NOTICE, "VTOL not available")


def _without(*names: str) -> Callable[[ParamStore, float], Refusal | None]:
    """Refused unless one of the parameters is not 0."""

    def check(params: ParamStore, _p1: float) -> Refusal | None:
        return None if any(params.integer(name) for name in names) else _FAILED

    return check


def _servo(params: ParamStore, p1: float) -> Refusal | None:
    """AP_ServoRelayEvents: outputs with a function, and those above 16 (SERVO_32_ENABLE 0), are in use."""
    channel = int(p1)
    if not 1 <= channel <= 32:
        return _FAILED
    if channel <= 16 and not params.integer(f"SERVO{channel}_FUNCTION"):
        return None
    return Refusal(MavResult.FAILED, Severity.INFO, f"ServoRelayEvent: Channel {channel} is already in use")


def _relay(params: ParamStore, p1: float) -> Refusal | None:
    number = int(p1) + 1
    return None if 1 <= number <= _RELAYS and params.integer(f"RELAY{number}_FUNCTION") == 1 else _FAILED


def _auxiliary(_params: ParamStore, p1: float) -> Refusal | None:
    number = int(p1)
    return None if number else Refusal(MavResult.FAILED, Severity.INFO, f"Invalid channel option ({number})")


def _always(refused: Refusal) -> Callable[[ParamStore, float], Refusal | None]:
    return lambda _params, _p1: refused


_CHECKS: dict[int, Callable[[ParamStore, float], Refusal | None]] = {
    181: _relay,  # DO_SET_RELAY
    182: _relay,  # DO_REPEAT_RELAY
    183: _servo,  # DO_SET_SERVO
    184: _servo,  # DO_REPEAT_SERVO
    204: _always(_FAILED),  # DO_MOUNT_CONFIGURE
    205: _without("MNT1_TYPE", "MNT2_TYPE"),  # DO_MOUNT_CONTROL
    209: _always(_FAILED),  # DO_MOTOR_TEST
    211: _without("GRIP_ENABLE"),  # DO_GRIPPER
    216: _always(_FAILED),  # DO_SPRAYER
    218: _auxiliary,  # DO_AUX_FUNCTION
    223: _without("ICE_ENABLE"),  # DO_ENGINE_CONTROL
    531: _always(Refusal(MavResult.UNSUPPORTED)),  # SET_CAMERA_ZOOM
    532: lambda _params, p1: _FAILED if 1 <= p1 <= 4 else _DENIED,  # SET_CAMERA_FOCUS
    534: _always(_DENIED),  # SET_CAMERA_SOURCE
    1000: _without("MNT1_TYPE", "MNT2_TYPE"),  # DO_GIMBAL_MANAGER_PITCHYAW
    2500: _always(_FAILED),  # VIDEO_START_CAPTURE
    2501: _always(_FAILED),  # VIDEO_STOP_CAPTURE
    3000: _always(_NO_VTOL),  # DO_VTOL_TRANSITION
}


def refusal(number: int, p1: float, params: ParamStore) -> Refusal | None:
    """Why a command for equipment is refused; None when the plane can do it, or when it is another command."""
    check = _CHECKS.get(number)
    return None if check is None else check(params, p1 if abs(p1) < 2**31 else 0.0)

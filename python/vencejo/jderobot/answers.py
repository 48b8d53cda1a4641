"""The numbers that the JdeRobot interfaces answer with, and which error gives which."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Final

from vencejo import errors

__all__ = ["ANSWERS", "Answer", "answer_of"]


class Answer(enum.IntEnum):
    """What ``setMissionData``, ``setPose3DData`` and ``setCMDVelData`` return."""

    DONE = 0
    """The vehicle does it."""
    BAD_VALUE = 1
    """A bad pose or value, or a mission that the checks refuse; nothing was sent."""
    NO_VEHICLE = 2
    """No vehicle has been heard, or it is lost."""
    BUSY = 3
    """Another mission or transfer is under way."""
    NOT_SENT = 4
    """The mission could not be sent or verified; what the vehicle holds is unknown."""
    REFUSED = 5
    """The vehicle refused, such as arming by its pre-arm checks; or another operator holds control of the driver."""
    NO_ANSWER = 6
    """The vehicle did not answer, or does not show what was asked for."""
    WRONG_MODE = 7
    """The vehicle must be in GUIDED, and this operation does not change the mode."""
    FAILED = 8
    """Anything else; the log says what."""


ANSWERS: Final[Mapping[type[errors.VencejoError], Answer]] = {
    errors.VencejoError: Answer.FAILED,
    errors.LinkError: Answer.NO_VEHICLE,
    errors.InvalidLink: Answer.NO_VEHICLE,
    errors.NoVehicleError: Answer.NO_VEHICLE,
    errors.VehicleLost: Answer.NO_VEHICLE,
    errors.ClosedError: Answer.NO_VEHICLE,
    errors.Busy: Answer.BUSY,
    errors.Cancelled: Answer.FAILED,
    errors.ControlHeld: Answer.REFUSED,
    errors.ConfirmationNeeded: Answer.REFUSED,
    errors.InvalidRequest: Answer.BAD_VALUE,
    errors.NotPossibleNow: Answer.NOT_SENT,
    errors.CommandRefused: Answer.REFUSED,
    errors.CommandTimeout: Answer.NO_ANSWER,
    errors.TransferError: Answer.NOT_SENT,
    errors.PlanMismatch: Answer.NOT_SENT,
    errors.ParameterError: Answer.REFUSED,
    errors.FileFormatError: Answer.FAILED,
    errors.PlanRefused: Answer.BAD_VALUE,
}
"""The answer for each exception; a test walks them all."""


def answer_of(error: errors.VencejoError) -> Answer:
    """The answer for an error; that of the nearest base for one that is not in the table."""
    return next(ANSWERS[kind] for kind in type(error).__mro__ if kind in ANSWERS)

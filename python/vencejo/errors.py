"""Exceptions of the package.

Every exception of this package is a `VencejoError`. The messages say what was wrong, where, and what to do.

Examples
--------
>>> import vencejo
>>> issubclass(vencejo.CommandRefused, vencejo.VencejoError)
True
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vencejo.findings import Finding


class VencejoError(Exception):
    """Base of all exceptions of this package."""


class LinkError(VencejoError):
    """A link that cannot be opened or used."""


class InvalidLink(LinkError):
    """A link string that cannot be read."""


class NoVehicleError(VencejoError):
    """No autopilot was heard in time, or the one asked for is not there."""


class VehicleLost(VencejoError):
    """The vehicle has not been heard for too long to go on."""


class ClosedError(VencejoError):
    """The station, the link or the operator behind this object has been closed."""


class Busy(VencejoError):
    """The vehicle is occupied by another command or transfer of this station."""


class ControlHeld(VencejoError):
    """Another operator holds control of the station, or of the aircraft: nothing was sent.

    Ask for it and wait until it is given up: with `Operator.request` for the station, which can also be taken over by
    the holder's name (`Operator.take`), and with `Vehicle.request_control` for an aircraft of a fleet.

    Attributes
    ----------
    holder : str
        Who holds it.
    """

    def __init__(self, message: str, holder: str = "") -> None:
        super().__init__(message)
        self.holder = holder


class ConfirmationNeeded(VencejoError):
    """A request that can end a flight or destroy data on board, and was not confirmed: nothing was sent.

    A program confirms it by repeating the call with ``confirm=`` this exception's `act`.

    Attributes
    ----------
    act : str
        What is dangerous, such as ``"force-arm"``.
    """

    def __init__(self, message: str, act: str = "") -> None:
        super().__init__(message)
        self.act = act


class Cancelled(VencejoError):
    """The caller cancelled the operation. The state on board is unknown until it is read again."""


class InvalidRequest(VencejoError, ValueError):
    """A request that must not be sent to an aircraft: nothing was sent.

    A value that is not finite, out of range or unknown to this vehicle. Repeating it does not help.
    """


class NotPossibleNow(VencejoError):
    """A request that the vehicle's present state rules out: nothing was sent.

    Such as a restart while it is armed, arming or starting while the plan on board is not known, or an upload before it
    has reported its home. The message says what has to come first.
    """


class CommandRefused(VencejoError):
    """The vehicle answered a command with a refusal.

    Attributes
    ----------
    command : str
        Name of the MAV_CMD.
    result : str
        Name of the MAV_RESULT, such as ``"DENIED"``.
    reasons : tuple[str, ...]
        What the vehicle said about it in STATUSTEXT messages, for instance its pre-arm failures.
    cure_mode : str or None
        The mode that cures a refusal to arm, where a mode does; `Vehicle.prepare_flight` changes to it.
    remedies : tuple[str, ...]
        What to do about the reasons, in English, where that is known.
    """

    def __init__(
        self,
        message: str,
        command: str = "",
        result: str = "",
        reasons: tuple[str, ...] = (),
        cure_mode: str | None = None,
        remedies: tuple[str, ...] = (),
    ) -> None:
        super().__init__(message)
        self.command = command
        self.result = result
        self.reasons = reasons
        self.cure_mode = cure_mode
        self.remedies = remedies


class CommandTimeout(VencejoError, TimeoutError):
    """The vehicle did not answer, or did not reach the requested state in time.

    Attributes
    ----------
    command : str
        Name of the MAV_CMD; empty if the wait was not for a single command.
    reasons : tuple[str, ...]
        What the vehicle wrote in STATUSTEXT messages meanwhile; of a remote vehicle that did not answer, what its
        station on board reports of the autopilot's silence.
    """

    def __init__(self, message: str, command: str = "", reasons: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.command = command
        self.reasons = reasons


class TransferError(VencejoError):
    """A plan, parameter or file transfer failed. The state on board is unknown until it is read again."""


class PlanMismatch(TransferError):
    """The vehicle accepted the plan, but what it reads back differs.

    Attributes
    ----------
    differences : tuple[str, ...]
        One line for each field that differs: item, field, sent and kept value.
    """

    def __init__(self, message: str, differences: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.differences = differences


class ParameterError(VencejoError):
    """A parameter that the vehicle does not have, an invalid name or value, or a value that it did not accept."""


class FileFormatError(VencejoError, ValueError):
    """A plan or parameter file that cannot be read; the message names the line or the JSON path."""


class PlanRefused(VencejoError):
    """A plan that the checks found unsafe or impossible, refused before anything was sent.

    Attributes
    ----------
    findings : tuple[Finding, ...]
        All findings, warnings included.
    """

    def __init__(self, message: str, findings: tuple[Finding, ...] = ()) -> None:
        super().__init__(message)
        self.findings = findings

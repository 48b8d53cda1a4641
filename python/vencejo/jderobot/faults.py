"""One table from the package's exceptions to those of Slice module ``vencejo``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Final, TypeVar

from vencejo import errors
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.workers import Workers
from vencejo.plan import Finding

__all__ = ["FAULTS", "Faults"]

_T = TypeVar("_T")

FAULTS: Final[Mapping[type[errors.VencejoError], str]] = {
    errors.VencejoError: "VencejoException",
    errors.LinkError: "NoLink",
    errors.InvalidLink: "NoLink",
    errors.NoVehicleError: "NoVehicle",
    errors.VehicleLost: "VehicleLost",
    errors.ClosedError: "NoLink",
    errors.Busy: "Busy",
    errors.Cancelled: "Cancelled",
    errors.ControlHeld: "Busy",
    errors.ConfirmationNeeded: "InvalidRequest",
    errors.InvalidRequest: "InvalidRequest",
    errors.NotPossibleNow: "InvalidRequest",
    errors.CommandRefused: "CommandRefused",
    errors.CommandTimeout: "CommandTimeout",
    errors.TransferError: "TransferFailed",
    errors.PlanMismatch: "PlanMismatch",
    errors.ParameterError: "InvalidRequest",
    errors.FileFormatError: "InvalidRequest",
    errors.PlanRefused: "PlanRefused",
}
"""Name of the Slice exception for each of ours; a test walks them all."""


class Faults:
    """Gives errors to clients as the exceptions of the Slice file."""

    def __init__(self, slices: Slices, workers: Workers) -> None:
        self._precise = slices.precise
        self._unset = slices.ice.Unset
        self._workers = workers

    def fault(self, error: errors.VencejoError) -> Exception:
        """The Slice exception for one of ours."""
        name = next(FAULTS[kind] for kind in type(error).__mro__ if kind in FAULTS)
        details: tuple[Any, ...] = ()
        if isinstance(error, errors.CommandRefused):
            details = (error.command, error.result, list(error.reasons))
        elif isinstance(error, errors.CommandTimeout):
            details = (error.command, list(error.reasons))
        elif isinstance(error, errors.PlanMismatch):
            details = (list(error.differences),)
        elif isinstance(error, errors.PlanRefused):
            details = ([self.finding(finding) for finding in error.findings],)
        exception: Exception = getattr(self._precise, name)(str(error), *details)
        return exception

    def finding(self, finding: Finding) -> Any:
        """A finding of the checks."""
        item = self._unset if finding.item is None else finding.item
        return self._precise.Finding(finding.severity == "error", finding.code, item, finding.message, finding.remedy)

    def at_once(self, work: Callable[[], _T]) -> _T:
        """Do something that does not wait."""
        try:
            return work()
        except errors.VencejoError as error:
            raise self.fault(error) from error

    def later(self, work: Callable[[], _T]) -> Future[_T]:
        """Do something that waits for the vehicle, in a thread of its own."""
        return self.at_once(lambda: self._workers.later(lambda: self.at_once(work)))

"""Each kind of error of the core becomes one exception of `vencejo.errors`, and says in attributes what it says in words."""

from __future__ import annotations

import copy
import pickle

import pytest
import vencejo
from vencejo import _native

CLASSES = {
    "Station.Address": vencejo.InvalidLink,
    "Station.Link": vencejo.LinkError,
    "Station.CannotRecord": vencejo.VencejoError,
    "Station.NoVehicle": vencejo.NoVehicleError,
    "Station.Control": vencejo.ControlHeld,
    "Station.NeedsConfirmation": vencejo.ConfirmationNeeded,
    "Station.BadConfirmation": vencejo.ConfirmationNeeded,
    "Station.RemoteRefused": vencejo.NotPossibleNow,
    "Station.Replayed": vencejo.NotPossibleNow,
    "Station.BadRecording": vencejo.FileFormatError,
    "Station.TooManyReplays": vencejo.Busy,
    "Station.TooManyVehicles": vencejo.Busy,
    "Station.Closed": vencejo.ClosedError,
    "Station.Dismissed": vencejo.ClosedError,
    "Signing.BadName": vencejo.InvalidRequest,
    "Signing.NameTaken": vencejo.InvalidRequest,
    "Signing.NoSuchKey": vencejo.InvalidRequest,
    "Signing.KeyInUse": vencejo.NotPossibleNow,
    "Signing.WrongState": vencejo.NotPossibleNow,
    "Signing.NotDisarmed": vencejo.NotPossibleNow,
    "Signing.NotPrivate": vencejo.NotPossibleNow,
    "Signing.Refused": vencejo.NotPossibleNow,
    "Signing.Busy": vencejo.Busy,
    "Signing.Unproven": vencejo.CommandTimeout,
    "Signing.Storage": vencejo.VencejoError,
    "Signing.NoFolder": vencejo.VencejoError,
    "Vehicle.CommandRefused": vencejo.CommandRefused,
    "Vehicle.CommandTimeout": vencejo.CommandTimeout,
    "Vehicle.NotConfirmed": vencejo.CommandTimeout,
    "Vehicle.CommandBusy": vencejo.Busy,
    "Vehicle.TransferBusy": vencejo.Busy,
    "Vehicle.TooManyRequests": vencejo.Busy,
    "Vehicle.UnknownMode": vencejo.InvalidRequest,
    "Vehicle.NoModeFor": vencejo.InvalidRequest,
    "Vehicle.InvalidValue": vencejo.InvalidRequest,
    "Vehicle.Plan": vencejo.InvalidRequest,
    "Vehicle.PlanUnknown": vencejo.NotPossibleNow,
    "Vehicle.OutOfReach": vencejo.NotPossibleNow,
    "Vehicle.Armed": vencejo.NotPossibleNow,
    "Vehicle.InTheAir": vencejo.NotPossibleNow,
    "Vehicle.NotFlying": vencejo.NotPossibleNow,
    "Vehicle.Landing": vencejo.NotPossibleNow,
    "Vehicle.HomeUnknown": vencejo.NotPossibleNow,
    "Vehicle.TooOld": vencejo.InvalidRequest,
    "Vehicle.NotHeard": vencejo.VehicleLost,
    "Vehicle.Rebooted": vencejo.VehicleLost,
    "Vehicle.MessageNotReceived": vencejo.CommandTimeout,
    "Vehicle.Cancelled": vencejo.Cancelled,
    "Transfer.Timeout": vencejo.TransferError,
    "Transfer.FtpAbsent": vencejo.TransferError,
    "Transfer.NoProgress": vencejo.TransferError,
    "Transfer.Unreached": vencejo.TransferError,
    "Transfer.Refused": vencejo.TransferError,
    "Transfer.NotAsSent": vencejo.PlanMismatch,
    "Transfer.Rejected": vencejo.TransferError,
    "Transfer.Unverified": vencejo.TransferError,
    "Transfer.NotCleared": vencejo.TransferError,
    "Transfer.TooMany": vencejo.TransferError,
    "Transfer.BadList": vencejo.InvalidRequest,
    "Transfer.Item": vencejo.InvalidRequest,
    "Transfer.OnlyMission": vencejo.InvalidRequest,
    "Transfer.IntegerItemsIgnored": vencejo.TransferError,
    "Transfer.Ftp": vencejo.TransferError,
    "Transfer.FtpBusy": vencejo.TransferError,
    "Transfer.BadFile": vencejo.TransferError,
    "Transfer.Param": vencejo.ParameterError,
    "Transfer.UnknownParam": vencejo.ParameterError,
    "Transfer.ParamRefused": vencejo.ParameterError,
    "Transfer.ParamNotKept": vencejo.ParameterError,
    "Transfer.Cancelled": vencejo.Cancelled,
}


def example(name: str) -> Exception:
    (found,) = (error for kind, error in _native.error_examples() if kind == name)
    return found


def test_every_kind_of_error_is_in_the_table() -> None:
    examples = _native.error_examples()
    kinds = {name for name, _ in examples}
    assert {"Vehicle.Cancelled", "Transfer.Cancelled"} <= kinds
    # A transfer's error inside a vehicle's is listed once for itself.
    assert kinds == set(CLASSES)


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_its_exception(name: str) -> None:
    errors = [error for kind, error in _native.error_examples() if kind == name]
    assert errors
    for error in errors:
        assert type(error) is CLASSES[name]
        assert len(str(error)) > 5
        for again in (copy.copy(error), pickle.loads(pickle.dumps(error))):
            assert (type(again), str(again), vars(again)) == (type(error), str(error), vars(error))


def test_attributes() -> None:
    refused = example("Vehicle.CommandRefused")
    assert isinstance(refused, vencejo.CommandRefused)
    assert refused.command == "COMPONENT_ARM_DISARM"
    assert refused.result == "FAILED"
    assert refused.reasons == ("PreArm: GPS 1: not healthy",)
    assert refused.remedies == ("wait until the GPS has a 3D fix, under open sky",)
    assert refused.cure_mode is None
    late = example("Vehicle.NotConfirmed")
    assert isinstance(late, vencejo.CommandTimeout)
    assert late.command == refused.command
    assert late.reasons == ("Throttle not zero",)
    silent = example("Vehicle.CommandTimeout")
    assert isinstance(silent, vencejo.CommandTimeout)
    assert (silent.command, silent.reasons) == (refused.command, ())
    mismatch = example("Transfer.NotAsSent")
    assert isinstance(mismatch, vencejo.PlanMismatch)
    (difference,) = mismatch.differences
    assert "item 3" in difference
    assert "80" in difference
    assert "70" in difference

"""Vencejo: send a fixed-wing autonomous plane to positions, over MAVLink.

Examples
--------
Fly a mission file on a simulated or real plane:

>>> import vencejo
>>> with vencejo.connect("tcp:127.0.0.1:5760") as plane:  # doctest: +SKIP
...     plan = vencejo.Plan.load("mission.waypoints")
...     plane.upload(plan)  # sent, read back and compared
...     plane.prepare_flight()  # a mode that arms, the mission at its beginning
...     plane.arm()  # raises with the pre-arm reasons
...     plane.start_mission()  # AUTO: the pilot's radio can take over at any time
...     for telemetry in plane.stream(rate_hz=1):
...         print(telemetry.position, plane.mission_progress)

For asyncio see `vencejo.aio`.
"""

import os as _os
from typing import TYPE_CHECKING, Any

# A fleet's sessions over TLS are read and written by one thread: Zenoh reads and writes them at the same time without a
# lock otherwise, which has ended a ground station (docs/adr/0036). Before anything starts a thread; Zenoh reads it
# once, when it is first used.
_os.environ.setdefault("ZENOH_RUNTIME", "(rx: (handover: tx))")

from vencejo._native import MavlinkMessage, Subscription, __version__
from vencejo.control import Operator
from vencejo.errors import (
    Busy,
    Cancelled,
    ClosedError,
    CommandRefused,
    CommandTimeout,
    ConfirmationNeeded,
    ControlHeld,
    FileFormatError,
    InvalidLink,
    InvalidRequest,
    LinkError,
    NotPossibleNow,
    NoVehicleError,
    ParameterError,
    PlanMismatch,
    PlanRefused,
    TransferError,
    VehicleLost,
    VencejoError,
)
from vencejo.station import Station, connect, default_record_dir, default_signing_dir
from vencejo.vehicle import Parameters, Vehicle

if TYPE_CHECKING:
    from vencejo.findings import Finding
    from vencejo.link import LinkInfo, SerialPort, serial_ports
    from vencejo.params import load_params, save_params
    from vencejo.plan import (
        Circle,
        Command,
        Fence,
        Frame,
        GeoPoint,
        Home,
        MissionItem,
        Plan,
        PlanNote,
        PlanSettings,
        Polygon,
        RallyPoint,
    )
    from vencejo.signing import SigningInfo, SigningKeyInfo
    from vencejo.storage import Floors, StorageProblem
    from vencejo.telemetry import Telemetry
    from vencejo.values import (
        Event,
        FlightPreparation,
        MissionProgress,
        Parameter,
        PlanChange,
        PlanState,
        RecorderInfo,
        StatusText,
        VehicleControl,
    )

# Imported lazily: defining all these classes takes longer than hearing the first vehicle.
_LATER = {
    "findings": {"Finding"},
    "link": {"LinkInfo", "SerialPort", "serial_ports"},
    "params": {"load_params", "save_params"},
    "plan": {
        "Circle", "Command", "Fence", "Frame", "GeoPoint", "Home", "MissionItem", "Plan", "PlanNote", "PlanSettings", "Polygon",
        "RallyPoint",
    },
    "signing": {"SigningInfo", "SigningKeyInfo"},
    "storage": {"Floors", "StorageProblem"},
    "telemetry": {"Telemetry"},
    "values": {
        "Event",
        "FlightPreparation",
        "MissionProgress",
        "Parameter",
        "PlanChange",
        "PlanState",
        "RecorderInfo",
        "StatusText",
        "VehicleControl",
    },
}  # fmt: skip

if not TYPE_CHECKING:  # which would take any name for one that there is

    def __getattr__(name: str) -> Any:
        from importlib import import_module

        for module, names in _LATER.items():
            if name == module or name in names:
                found = import_module(f"vencejo.{module}")
                return found if name == module else globals().setdefault(name, getattr(found, name))
        raise AttributeError(f"module 'vencejo' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__all__ = [
    "Busy",
    "Cancelled",
    "Circle",
    "ClosedError",
    "Command",
    "CommandRefused",
    "CommandTimeout",
    "ConfirmationNeeded",
    "ControlHeld",
    "Event",
    "Fence",
    "FileFormatError",
    "Finding",
    "FlightPreparation",
    "Floors",
    "Frame",
    "GeoPoint",
    "Home",
    "InvalidLink",
    "InvalidRequest",
    "LinkError",
    "LinkInfo",
    "MavlinkMessage",
    "MissionItem",
    "MissionProgress",
    "NoVehicleError",
    "NotPossibleNow",
    "Operator",
    "Parameter",
    "ParameterError",
    "Parameters",
    "Plan",
    "PlanChange",
    "PlanMismatch",
    "PlanNote",
    "PlanRefused",
    "PlanSettings",
    "PlanState",
    "Polygon",
    "RallyPoint",
    "RecorderInfo",
    "SerialPort",
    "SigningInfo",
    "SigningKeyInfo",
    "Station",
    "StatusText",
    "StorageProblem",
    "Subscription",
    "Telemetry",
    "TransferError",
    "Vehicle",
    "VehicleControl",
    "VehicleLost",
    "VencejoError",
    "__version__",
    "connect",
    "default_record_dir",
    "default_signing_dir",
    "load_params",
    "save_params",
    "serial_ports",
]

"""The vehicle that the interfaces serve, and its last values."""

from __future__ import annotations

import logging
import threading
from typing import TypeVar

from vencejo.control import Operator
from vencejo.errors import NoVehicleError, VehicleLost, VencejoError
from vencejo.station import Station
from vencejo.vehicle import Vehicle

__all__ = ["LOG", "Held", "Subject"]

LOG = logging.getLogger("vencejo.jderobot")
_T = TypeVar("_T")


class Subject:
    """Chooses among the vehicles of a station.

    Parameters
    ----------
    station : Station
    system_id : int, optional
        The default vehicle. If not given, the first that was heard, and of several heard by the first call that needs
        it the one with the lowest system id; it then stays the default, whichever vehicles are asked for by their ids.
    operator : Operator, optional
        The operator that acts on them; by default the program's own.
    """

    def __init__(self, station: Station, system_id: int | None = None, operator: Operator | None = None) -> None:
        self._station = station
        self._operator = operator
        self._system_id = system_id
        self._lock = threading.Lock()
        self._vehicles: dict[int, Vehicle] = {}

    @property
    def station(self) -> Station:
        """The station."""
        return self._station

    def vehicles(self) -> list[int]:
        """System ids of the vehicles heard so far."""
        return [vehicle.system_id for vehicle in self._station.vehicles]

    def find(self, system_id: int = 0) -> Vehicle | None:
        """A vehicle by its system id, 0 for the default one; ``None`` while it has not been heard."""
        with self._lock:
            wanted = system_id or self._system_id
            if wanted in self._vehicles:
                return self._vehicles[wanted]
            for vehicle in self._station.vehicles:
                if wanted is None or vehicle.system_id == wanted:
                    if wanted is None:
                        self._system_id = vehicle.system_id
                    if self._operator is not None:
                        vehicle = self._operator.vehicle(vehicle)
                    self._vehicles[vehicle.system_id] = vehicle
                    return vehicle
            return None

    def need(self, system_id: int = 0) -> Vehicle:
        """As `find`, but raises while the vehicle has not been heard.

        Raises
        ------
        NoVehicleError
        """
        vehicle = self.find(system_id)
        if vehicle is None:
            which = f"vehicle {system_id}" if system_id else "no vehicle"
            raise NoVehicleError(
                f"{which} has {'not ' if system_id else ''}been heard yet; see the links of the driver"
            )
        return vehicle

    def hear(self) -> Vehicle:
        """The default vehicle, if it is heard now: a request to a lost one would wait for its return.

        Raises
        ------
        NoVehicleError
        VehicleLost
        """
        vehicle = self.need()
        heartbeat = vehicle.telemetry.heartbeat
        if heartbeat is None or heartbeat.freshness == "lost":
            since = "" if heartbeat is None else f" for {heartbeat.age_s:.0f} s"
            raise VehicleLost(f"vehicle {vehicle.system_id} has not been heard{since}; nothing was sent")
        return vehicle

    def tell(self, text: str, *, is_problem: bool = True) -> None:
        """Write a text to the log and to the vehicle's texts in the station."""
        LOG.log(logging.WARNING if is_problem else logging.INFO, "%s", text)
        try:
            vehicle = self.find()
            if vehicle is not None:
                vehicle.note(f"JdeRobot: {text}", severity=4 if is_problem else 6)
        except VencejoError:
            pass  # the station is closing; the log has it


def stand_down(vehicle: Vehicle) -> None:
    """Disarm what was armed for a flight that does not begin.

    Raises
    ------
    VencejoError
        When it stays armed.
    """
    try:
        vehicle.disarm()
    except VencejoError as error:
        raise VencejoError(f"the driver is ending, and THE VEHICLE IS STILL ARMED: {error}") from error


class Held:
    """Last known values by name, for interfaces that cannot express "unknown"."""

    def __init__(self) -> None:
        self._values: dict[str, float] = {}

    def __call__(self, name: str, value: float | None) -> float:
        """The value; the last known one if it is ``None``, 0 before any."""
        if value is not None:
            self._values[name] = value
        return self._values.get(name, 0.0)

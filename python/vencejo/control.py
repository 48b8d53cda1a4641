"""Who acts: the control lease that all doors of a station share.

One operator at a time holds control of a station: the program itself, a browser, the Ice interfaces, or another operator of
this program. The first who acts has it; acts of the others are refused with `vencejo.errors.ControlHeld` until it is given up.
Watching needs none of that. A station of another process is another ground station, with a lease of its own.

Examples
--------
>>> import vencejo
>>> with vencejo.Station(record=False, operator="survey") as station:
...     station.operator.name, station.operator.has_control, station.operator.holder
('survey', False, None)
"""

from __future__ import annotations

from typing import TypeVar

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.vehicle import VehicleState

__all__ = ["Operator"]

_V = TypeVar("_V", bound=VehicleState)


class Operator(Closing):
    """Somebody who may act on a station's vehicles.

    Made by `Station.operator` (the program itself), `Station.add_operator` and `Server.operator`.
    """

    def __init__(self, native: _native.Operator) -> None:
        self._native = native
        belongs_here(self)

    @property
    def name(self) -> str:
        """What the others are shown."""
        return self._native.name()

    @property
    def has_control(self) -> bool:
        """Whether this operator holds control."""
        return self._native.has_control()

    @property
    def holder(self) -> str | None:
        """Name of the operator that holds control, ``None`` when nobody does."""
        return self._native.holder()

    @property
    def requested_by(self) -> str | None:
        """Name of the operator that asks for control, ``None`` when nobody does."""
        return self._native.requested_by()

    def vehicle(self, vehicle: _V) -> _V:
        """The same vehicle, acted on in this operator's name."""
        return type(vehicle)(vehicle._native.acting_as(self._native), vehicle._station)

    def take(self, *, over: str | None = None) -> bool:
        """Take control if nobody else has it; returns whether it is held now.

        Parameters
        ----------
        over : str, optional
            Take it from the holder of this name, without being asked for.

        Raises
        ------
        ControlHeld
            When another holder than the one named has it.
        """
        if over is None:
            return self._native.take()
        self._native.take_over(over)
        return True

    def request(self) -> bool:
        """Ask the holder for control, or take it when nobody has it; returns whether it is held now."""
        return self._native.request()

    def release(self) -> None:
        """Give control up: to the operator that asks for it, else to nobody."""
        self._native.release()

    def attach(self) -> None:
        """Show that it is there, until `detach` has been called as often: what it stands for is connected."""
        self._native.attach()

    def detach(self) -> None:
        """One thing less shows that it is there; without any, control is free after 5 s."""
        self._native.detach()

    def close(self) -> None:
        """Give control up; a session of a server ends. Can be called again."""
        self._native.close()

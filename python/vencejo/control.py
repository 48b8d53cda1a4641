"""The control lease that all front ends of a station share.

One operator at a time holds control of a station: the program itself, a browser, the Ice interfaces, or another
operator of this program. The first to act gets it; requests of the others raise `vencejo.errors.ControlHeld` until it
is given up. Watching needs no control. A station in another process is another ground station, with a lease of its own.

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
from vencejo._vehicle_state import VehicleState

__all__ = ["Operator"]

_V = TypeVar("_V", bound=VehicleState)


class Operator(Closing):
    """An operator: a person or program that may command a station's vehicles.

    Made by `Station.operator` (the program itself), `Station.add_operator` and `Server.operator`.
    """

    def __init__(self, native: _native.Operator) -> None:
        self._native = native
        belongs_here(self)

    @property
    def name(self) -> str:
        """The name shown to the other operators."""
        return self._native.name()

    @property
    def has_control(self) -> bool:
        """Whether this operator holds control."""
        return self._native.has_control()

    @property
    def holder(self) -> str | None:
        """Name of the operator that holds control; ``None`` while it is free."""
        return self._native.holder()

    @property
    def requested_by(self) -> str | None:
        """Name of the operator that asks for control; ``None`` without a request."""
        return self._native.requested_by()

    def vehicle(self, vehicle: _V) -> _V:
        """The same vehicle, acted on in this operator's name."""
        return type(vehicle)(vehicle._native.acting_as(self._native), vehicle._station)

    def take(self, *, over: str | None = None) -> bool:
        """Take control if it is free; returns whether this operator holds it now.

        Parameters
        ----------
        over : str, optional
            Take it over from the holder of this name, without asking.

        Raises
        ------
        ControlHeld
            When the holder is not the one named.
        """
        if over is None:
            return self._native.take()
        self._native.take_over(over)
        return True

    def request(self) -> bool:
        """Ask the holder for control, or take it if it is free; returns whether this operator holds it now."""
        return self._native.request()

    def keep(self, *, requested_by: str | None = None) -> None:
        """Decline a request for the control that this operator holds; without control it does nothing.

        An operator that asks by acting (JdeRobot, ROS 2, ``transient``) does not ask again for 5 min, or until control
        changes hands.

        Parameters
        ----------
        requested_by : str, optional
            Name of the operator whose request is declined, even if another's has taken its place since; by default the
            present request.
        """
        self._native.keep(requested_by)

    def release(self) -> None:
        """Give up control: it goes to the operator that asks for it, or is free."""
        self._native.release()

    def attach(self) -> None:
        """Mark the operator as present until `detach` has been called as often."""
        self._native.attach()

    def detach(self) -> None:
        """Undo one `attach`. After the last one control becomes free within 5 s."""
        self._native.detach()

    def close(self) -> None:
        """Give up control and end the session, if it is one of a server. Can be called again."""
        self._native.close()

"""The station: links, recording, and the vehicles that are heard on them."""

from __future__ import annotations

import atexit
import contextlib
import os
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo._native import MavlinkMessage, Subscription
from vencejo._whereabouts import data_dir, program
from vencejo.control import Operator
from vencejo.errors import InvalidRequest, VencejoError
from vencejo.vehicle import Vehicle, _call_back, _signing_info

if TYPE_CHECKING:
    from pathlib import Path

    from vencejo.link import LinkInfo
    from vencejo.signing import SigningInfo, SigningKeyInfo
    from vencejo.storage import Floors
    from vencejo.values import RecorderInfo

__all__ = ["Station", "connect", "default_record_dir", "default_signing_dir"]


def default_history_dir() -> Path:
    """Where fleets' histories are: ``history`` in the data folder, ``board`` of the aircraft here, ``ground/ORG`` of those far away."""
    from pathlib import Path

    return Path(data_dir("history"))


def default_record_dir() -> Path:
    """Where telemetry logs go: ``$VENCEJO_DATA/telemetry``, else the user's data folder (XDG base directories)."""
    from pathlib import Path

    return Path(data_dir("telemetry"))


def default_signing_dir() -> Path:
    """Where signing keys are: ``$VENCEJO_DATA/signing``, else in the user's data folder (XDG base directories)."""
    from pathlib import Path

    return Path(data_dir("signing"))


class Station(Closing):
    """A ground station: some links, and the vehicles on them.

    Parameters
    ----------
    *links : str
        Link strings, such as ``"udpin:0.0.0.0:14550"``, ``"tcp:127.0.0.1:5760"`` or ``"/dev/ttyACM0,115200"``.
    system_id, component_id : int, optional
        Our MAVLink address; 255/190 is a ground station, component 191 of the vehicle's system id a computer on board.
    rate_hz : float, optional
        How often each vehicle is asked to send its state, 4 to 50, default 10.
    message_rates : mapping of str to float, optional
        Other rates for single messages by name, such as ``{"ATTITUDE": 50}``.
    request_streams : bool, optional
        Whether to ask for rates at all; ``False`` only listens: until you ask a vehicle for something, nothing goes to it but our
        heartbeat, and whether it hears us (``is_reached``) stays unknown.
    heartbeat : bool, optional
        Whether to send our heartbeat each second. The vehicle's ground-station failsafe counts it: on board it comes from the system
        id that an ArduPilot counts (``MAV_GCS_SYSID``, 255 until that is read).
    record : bool or path, optional
        Record every frame to a ``.tlog``: ``True`` in the user's data folder, a path for another folder.
    forward_to : iterable of str, optional
        More links, for other ground stations: what the vehicles and they say is passed on untouched.
    floors : Floors, optional
        Free space of the disk below which nothing is recorded; default 500 MB for telemetry.
    signing : bool or path, optional
        Where signing keys are kept: ``True`` in the user's data folder, a path for another folder; with ``False`` nothing is
        signed and nothing is checked.
    operator : str, optional
        Name of the operator in whose name this program acts; by default what the program is called.

    Notes
    -----
    Close it, or use it in a ``with`` statement; one that nobody holds any more closes by itself, and so does each at the
    end of the program. A process that is forked off has none of its parent's stations: `ClosedError` says so.

    Raises
    ------
    LinkError
        For a link string that cannot be read, or an address that cannot be listened on.
    InvalidRequest
        For an id or a rate out of its range, and a message that the dialect does not have.

    Examples
    --------
    >>> import vencejo
    >>> with vencejo.Station("udpin:127.0.0.1:0", record=False) as station:
    ...     station.vehicles
    []
    """

    def __init__(
        self,
        *links: str,
        system_id: int = 255,
        component_id: int = 190,
        rate_hz: float = 10.0,
        message_rates: Mapping[str, float] | None = None,
        request_streams: bool = True,
        heartbeat: bool = True,
        record: bool | str | os.PathLike[str] = True,
        forward_to: Iterable[str] = (),
        floors: Floors | None = None,
        signing: bool | str | os.PathLike[str] = True,
        operator: str | None = None,
    ) -> None:
        for name, id in (("system_id", system_id), ("component_id", component_id)):
            if not 1 <= id <= 255:
                raise InvalidRequest(f"our own {name} is {id}, should be 1 to 255")
        if record is True:
            record_dir: str | None = data_dir("telemetry")
        elif record is False:
            record_dir = None
        else:
            record_dir = os.fspath(record)
        if signing is True:
            signing_dir: str | None = data_dir("signing")
        else:
            signing_dir = None if signing is False else os.fspath(signing)
        self._native = _native.Station(
            system_id=system_id,
            component_id=component_id,
            heartbeat=heartbeat,
            rate_hz=rate_hz,
            message_rates=dict(message_rates or {}),
            record_dir=record_dir,
            # Where it is kept from run to run whether a vehicle's mission may be mixed.
            missions_dir=data_dir("missions"),
            signing_dir=signing_dir,
            request_streams=request_streams,
            floors_mb=None if floors is None else floors._mb,
            operator=program() if operator is None else operator,
        )
        # Weak, so that a station that is no longer used is not kept by its own vehicles.
        self._vehicles: weakref.WeakValueDictionary[int, Vehicle] = weakref.WeakValueDictionary()
        _open_stations.add(self)
        belongs_here(self)
        try:
            for link in links:
                self.open_link(link)
            for link in forward_to:
                self.open_link(link, forward=True)
        except BaseException:
            self.close()
            raise

    def open_link(
        self, address: str, *, forward: bool = False, name: str | None = None, accept_unsigned: bool | None = None
    ) -> int:
        """Open one more link and give back its id. It reconnects by itself for ever.

        With `forward`, frames between it and the other links are passed on, for another ground station. `accept_unsigned` says
        whether a vehicle that has to sign is believed there without; by default on USB and on this machine, nowhere else.
        """
        return self._native.open_link(address, forward=forward, name=name, accept_unsigned=accept_unsigned)

    def close_link(self, link: int) -> None:
        """Close a link by its id."""
        self._native.close_link(link)

    @property
    def links(self) -> list[LinkInfo]:
        """The links and their counters."""
        from vencejo.link import LinkInfo

        return [LinkInfo(**info) for info in self._native.links()]

    @property
    def recorder(self) -> RecorderInfo | None:
        """The recording, ``None`` when it is off."""
        from vencejo.values import RecorderInfo

        info = self._native.recorder()
        return None if info is None else RecorderInfo(**info)

    def recorder_changes(self, timeout_s: float | None = None) -> Iterator[RecorderInfo]:
        """Follow the recording: as it is now, and again each time that it stops, goes on, or stops for another reason.

        It ends when the station is closed; at once when nothing is recorded.

        Parameters
        ----------
        timeout_s : float or None, optional
            How long to wait for each change; the iteration ends when none comes. ``None`` waits for ever.

        Examples
        --------
        >>> import vencejo
        >>> with vencejo.Station(record=False) as station:
        ...     [info.problem for info in station.recorder_changes(0.1)]
        []
        """
        from vencejo.values import RecorderInfo

        changes = self._native.recorder_changes()
        while changes is not None and (state := changes.next(timeout_s)) is not None:
            info = RecorderInfo(**state)
            if info.problem == "closed":
                return
            yield info

    @property
    def vehicles(self) -> list[Vehicle]:
        """The vehicles heard so far, by system id."""
        vehicles = []
        for id in self._native.vehicle_ids():
            # One that is forgotten at this very moment is left out.
            with contextlib.suppress(VencejoError):
                vehicles.append(self._vehicle(self._native.wait_vehicle(id).wait(0.0)))
        return vehicles

    def wait_vehicle(self, system_id: int | None = None, *, timeout_s: float | None = 30.0) -> Vehicle:
        """Wait for a vehicle's heartbeat.

        Parameters
        ----------
        system_id : int, optional
            Which one; the first that is heard when not given.
        timeout_s : float or None
            ``None`` waits for ever.

        Raises
        ------
        NoVehicleError
            When none is heard in time.
        """
        return self._vehicle(self._native.wait_vehicle(system_id).wait(timeout_s))

    def on_message(
        self, callback: Callable[[MavlinkMessage], None], *, names: Iterable[str] | None = None, capacity: int = 8192
    ) -> Subscription:
        """Call a function for each raw message of all vehicles at links, also of those not heard yet, in one thread and in the order they come.

        For many vehicles at once: one thread costs a fraction of those of a `Vehicle.on_message` for each.

        Parameters
        ----------
        callback : function of a MavlinkMessage
            Its ``system_id`` tells the vehicle. A slow one loses the oldest messages (`Subscription.dropped`), it never delays a link.
            While more than 4,000 come a second it is called with several at a time, up to 2 ms later.
        names : iterable of str, optional
            Only these messages.
        capacity : int, optional
            Messages that wait for the callback at most.

        Returns
        -------
        Subscription
            Close it, or use it in a ``with`` statement, to end the calls; closing the station ends them too.
        """
        subscription = self._native.subscribe_messages(None if names is None else list(names), capacity)
        _call_back(subscription, callback)
        return subscription

    def _vehicle(self, native: _native.Vehicle) -> Vehicle:
        vehicle = self._vehicles.get(native.system_id)
        if vehicle is None:
            vehicle = self._vehicles.setdefault(native.system_id, Vehicle(native, self))
        return vehicle

    def signing_of(self, system_id: int) -> SigningInfo:
        """How a vehicle signs, heard or not."""
        return _signing_info(self._native.signing_of(system_id))

    @property
    def signing_vehicles(self) -> list[int]:
        """System ids of the vehicles that have keys, heard or not."""
        return list(self._native.signing_vehicles())

    @property
    def signing_keys(self) -> list[SigningKeyInfo]:
        """The signing keys of this machine, without what is secret of them."""
        from datetime import datetime, timezone

        from vencejo.signing import SigningKeyInfo

        return [
            SigningKeyInfo(name=name, made=datetime.fromtimestamp(made_s, timezone.utc), vehicles=tuple(vehicles))
            for name, made_s, vehicles in self._native.signing_keys()
        ]

    def add_signing_key(self, name: str, *, key: bytes | None = None, passphrase: str | None = None) -> None:
        """Keep a signing key under a name: a new random one, 32 bytes, or the one that a passphrase stands for.

        A passphrase gives the same key as in QGroundControl, Mission Planner and MAVProxy.

        Raises
        ------
        InvalidRequest
            When the name cannot be one or is taken, or the key has not 32 bytes.
        """
        if key is not None and passphrase is not None:
            raise InvalidRequest("give a key or a passphrase, not both")
        if key is not None and len(key) != 32:
            raise InvalidRequest(f"a signing key has 32 bytes, not {len(key)}")
        self._native.add_signing_key(name, key=None if key is None else list(key), passphrase=passphrase)

    def export_signing_key(self, name: str) -> bytes:
        """A key with its secret, to carry it to another ground station. Keep it as secret as the vehicle is dear."""
        return bytes.fromhex(self._native.export_signing_key(name))

    def forget_signing_key(self, name: str) -> None:
        """Delete a key that no vehicle has."""
        self._native.forget_signing_key(name)

    def use_signing_key(self, system_id: int, name: str | None) -> None:
        """Say that a vehicle has a key already, given by another ground station; ``None``: that it has none.

        Nothing is sent. From then on only what it signs is believed.
        """
        self._native.use_signing_key(system_id, name)

    @property
    def operator(self) -> Operator:
        """In whose name this program acts: it takes control with its first act, unless somebody else has it.

        It gives control to whoever asks for it; a program that wants to be asked takes part with `Server.operator`.
        """
        return Operator(self._native.operator())

    def add_operator(self, name: str, *, transient: bool = False) -> Operator:
        """One more operator of this program, that takes control only when it acts or asks.

        Parameters
        ----------
        name : str
            What the others are shown, up to 40 characters.
        transient : bool, optional
            It stands for clients that come and go and cannot ask: it is there from `Operator.attach` to `Operator.detach` and
            for 5 s after what it does, and to be refused is to ask for control.
        """
        return Operator(self._native.enlist(name, transient))

    def set_heartbeat(self, enabled: bool) -> None:
        """Start or stop our heartbeat, which the vehicle's ground-station failsafe counts."""
        self._native.set_heartbeat(enabled)

    def close(self) -> None:
        """Close all links and end the recording. What is under way ends with `ClosedError`. Can be called again."""
        self._native.close()


_open_stations: weakref.WeakSet[Station] = weakref.WeakSet()


def _end() -> None:
    """End in order what the program left open: what is under way, the links, the recordings."""
    _native.end_waits()
    for station in list(_open_stations):
        station.close()


atexit.register(_end)


def connect(
    link: str,
    *,
    system_id: int | None = None,
    timeout_s: float | None = 30.0,
    rate_hz: float = 10.0,
    message_rates: Mapping[str, float] | None = None,
    record: bool | str | os.PathLike[str] = True,
    own_system_id: int = 255,
    own_component_id: int = 190,
    forward_to: Iterable[str] = (),
    signing: bool | str | os.PathLike[str] = True,
) -> Vehicle:
    """Connect to a vehicle and wait for its heartbeat.

    Nothing is armed, started or changed by it; the vehicle is asked to send its state.

    Parameters
    ----------
    link : str
        A link string, such as ``"udpin:0.0.0.0:14550"``, ``"tcp:127.0.0.1:5760"`` or ``"/dev/ttyACM0,115200"``.
    system_id : int, optional
        Which vehicle; the first that is heard when not given.
    timeout_s : float or None, optional
        How long to wait for it, default 30 s; ``None`` for ever.
    rate_hz, message_rates, record, forward_to, signing
        See `Station`.
    own_system_id, own_component_id : int, optional
        Our MAVLink address, default 255/190.

    Returns
    -------
    Vehicle
        Close it, or use it in a ``with`` statement.

    Raises
    ------
    LinkError
        For a link string that cannot be read.
    InvalidRequest
        For an id or a rate out of its range, and a message that the dialect does not have.
    NoVehicleError
        When no vehicle is heard in time.
    """
    station = Station(
        link,
        system_id=own_system_id,
        component_id=own_component_id,
        rate_hz=rate_hz,
        message_rates=message_rates,
        record=record,
        forward_to=forward_to,
        signing=signing,
    )
    try:
        return station.wait_vehicle(system_id, timeout_s=timeout_s)
    except BaseException:
        station.close()
        raise

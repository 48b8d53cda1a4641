"""The station: links, recording, and the vehicles that are heard on them."""

from __future__ import annotations

import atexit
import contextlib
import os
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from vencejo import _native
from vencejo._calling_back import call_back
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo._native import MavlinkMessage, Subscription
from vencejo._whereabouts import data_dir, program
from vencejo.control import Operator
from vencejo.errors import InvalidRequest, VencejoError
from vencejo.vehicle import Vehicle

if TYPE_CHECKING:
    from pathlib import Path

    from vencejo.link import LinkInfo
    from vencejo.signing import SigningInfo, SigningKeyInfo
    from vencejo.storage import Floors
    from vencejo.values import RecorderInfo

__all__ = ["Station", "connect", "default_record_dir", "default_signing_dir"]


def default_history_dir() -> Path:
    """Folder of fleet histories: ``history`` in the data folder, with ``board`` for aircraft here and ``ground/ORG`` for remote ones."""
    from pathlib import Path

    return Path(data_dir("history"))


def default_record_dir() -> Path:
    """Folder of telemetry logs: ``$VENCEJO_DATA/telemetry``, else the user's data folder (XDG base directories)."""
    from pathlib import Path

    return Path(data_dir("telemetry"))


def default_signing_dir() -> Path:
    """Folder of signing keys: ``$VENCEJO_DATA/signing``, else in the user's data folder (XDG base directories)."""
    from pathlib import Path

    return Path(data_dir("signing"))


class Station(Closing):
    """A ground station: some links, and the vehicles on them.

    Parameters
    ----------
    *links : str
        Link strings, such as ``"udpin:0.0.0.0:14550"``, ``"tcp:127.0.0.1:5760"`` or ``"/dev/ttyACM0,115200"``.
    system_id, component_id : int, optional
        The station's MAVLink address: 255/190 for a ground station; the vehicle's system id and component 191 on board.
    rate_hz : float, optional
        Rate at which each vehicle is asked to send its state, 4 to 50, default 10.
    message_rates : mapping of str to float, optional
        Other rates for single messages by name, such as ``{"ATTITUDE": 50}``.
    request_streams : bool, optional
        Whether to request message rates at all. ``False`` only listens: until the first request nothing but the
        heartbeat is sent to a vehicle, and whether it receives us (``is_reached``) stays unknown.
    heartbeat : bool, optional
        Whether to send the station's heartbeat each second, which the vehicle's ground-station failsafe monitors. On
        board it is sent from the system id that ArduPilot monitors (``MAV_GCS_SYSID``, 255 until that is read).
    record : bool or path, optional
        Record every frame to a ``.tlog``: ``True`` in the user's data folder, a path for another folder.
    forward_to : iterable of str, optional
        Links to other ground stations: messages between them and the vehicles are forwarded unchanged.
    floors : Floors, optional
        Free disk space below which recording stops; default 500 MB for telemetry.
    signing : bool or path, optional
        Where signing keys are kept: ``True`` in the user's data folder, a path for another folder; ``False`` neither
        signs nor verifies.
    operator : str, optional
        Name of the operator that this program acts as; default: the program's name.

    Notes
    -----
    Close it, or use it in a ``with`` statement; it also closes when it is garbage-collected and at the end of the program. In a
    forked process the parent's stations raise `ClosedError`.

    Raises
    ------
    LinkError
        For a link string that cannot be read (`InvalidLink`), or an address that cannot be listened on.
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
        """Open one more link and return its id. It reconnects for ever.

        With `forward`, frames between it and the other links are forwarded, for another ground station.
        `accept_unsigned` says whether unsigned messages of a vehicle that has to sign are accepted there; by default
        only on USB and this machine.
        """
        return self._native.open_link(address, forward=forward, name=name, accept_unsigned=accept_unsigned)

    def close_link(self, link: int) -> None:
        """Close the link with this id."""
        self._native.close_link(link)

    @property
    def links(self) -> list[LinkInfo]:
        """The links and their counters."""
        from vencejo.link import LinkInfo

        return [LinkInfo(**info) for info in self._native.links()]

    @property
    def recorder(self) -> RecorderInfo | None:
        """State of the recording; ``None`` when it is off."""
        from vencejo.values import RecorderInfo

        info = self._native.recorder()
        return None if info is None else RecorderInfo(**info)

    def recorder_changes(self, timeout_s: float | None = None) -> Iterator[RecorderInfo]:
        """Iterate over states of the recording: the present one, then each change (stopped, resumed, another reason).

        Ends when the station is closed, and at once when nothing is recorded.

        Parameters
        ----------
        timeout_s : float or None, optional
            How long to wait for each change before the iteration ends. ``None`` waits for ever.

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

    def wait_vehicle(
        self, system_id: int | None = None, *, name: str | None = None, timeout_s: float | None = 30.0
    ) -> Vehicle:
        """Wait for a vehicle's heartbeat.

        Parameters
        ----------
        system_id : int, optional
            Which one; the first that is heard when not given.
        name : str, optional
            Which one by its name, for an aircraft of a fleet (`Vehicle.remote_name`).
        timeout_s : float or None
            ``None`` waits for ever.

        Raises
        ------
        NoVehicleError
            When it is not heard in time; the message lists those that are.
        InvalidRequest
            When both an id and a name are given.
        """
        return self._vehicle(self._awaited(system_id, name).wait(timeout_s))

    def _awaited(self, system_id: int | None, name: str | None) -> _native.Pending:
        if name is None:
            return self._native.wait_vehicle(system_id)
        if system_id is not None:
            raise InvalidRequest("give a vehicle's id or its name, not both")
        return self._native.wait_named(name)

    def on_message(
        self, callback: Callable[[MavlinkMessage], None], *, names: Iterable[str] | None = None, capacity: int = 8192
    ) -> Subscription:
        """Call a function for each raw message of all vehicles on links, also those heard later, in one thread and in order.

        For many vehicles one thread costs a fraction of a `Vehicle.on_message` each.

        Parameters
        ----------
        callback : function of a MavlinkMessage
            Its ``system_id`` identifies the vehicle. A slow callback loses the oldest messages (`Subscription.dropped`)
            and never delays a link. Above 4,000 messages a second they are delivered in batches, up to 2 ms later.
        names : iterable of str, optional
            Only these messages.
        capacity : int, optional
            Most messages queued for the callback.

        Returns
        -------
        Subscription
            Close it, or use it in a ``with`` statement, to end the calls; closing the station ends them too.
        """
        subscription = self._native.subscribe_messages(None if names is None else list(names), capacity)
        call_back(subscription, callback)
        return subscription

    def _vehicle(self, native: _native.Vehicle) -> Vehicle:
        vehicle = self._vehicles.get(native.system_id)
        if vehicle is None:
            vehicle = self._vehicles.setdefault(native.system_id, Vehicle(native, self))
        return vehicle

    def signing_of(self, system_id: int) -> SigningInfo:
        """Signing state of a vehicle, whether it has been heard or not."""
        from vencejo.signing import SigningInfo

        return SigningInfo(**self._native.signing_of(system_id))

    @property
    def signing_vehicles(self) -> list[int]:
        """System ids of the vehicles with keys, whether heard or not."""
        return list(self._native.signing_vehicles())

    @property
    def signing_keys(self) -> list[SigningKeyInfo]:
        """The signing keys of this machine, without their secrets."""
        from datetime import datetime, timezone

        from vencejo.signing import SigningKeyInfo

        return [
            SigningKeyInfo(name=name, made=datetime.fromtimestamp(made_s, timezone.utc), vehicles=tuple(vehicles))
            for name, made_s, vehicles in self._native.signing_keys()
        ]

    def add_signing_key(self, name: str, *, key: bytes | None = None, passphrase: str | None = None) -> None:
        """Store a signing key under a name: the given 32 bytes, the key derived from a passphrase, or a new random one.

        A passphrase gives the same key as in QGroundControl, Mission Planner and MAVProxy.

        Raises
        ------
        InvalidRequest
            For an invalid name or one that is in use, and a key that is not 32 bytes long.
        """
        if key is not None and passphrase is not None:
            raise InvalidRequest("give a key or a passphrase, not both")
        if key is not None and len(key) != 32:
            raise InvalidRequest(f"a signing key has 32 bytes, not {len(key)}")
        self._native.add_signing_key(name, key=None if key is None else list(key), passphrase=passphrase)

    def export_signing_key(self, name: str) -> bytes:
        """The secret of a key, 32 bytes, to carry it to another ground station. Whoever has it can command the vehicle."""
        return bytes.fromhex(self._native.export_signing_key(name))

    def forget_signing_key(self, name: str) -> None:
        """Delete a key that no vehicle uses."""
        self._native.forget_signing_key(name)

    def use_signing_key(self, system_id: int, name: str | None) -> None:
        """Record that a vehicle has a key already, given by another ground station; ``None``: that it has none.

        Nothing is sent. From then on only its signed messages are accepted.
        """
        self._native.use_signing_key(system_id, name)

    @property
    def operator(self) -> Operator:
        """The operator that this program acts as. It takes control with its first request, unless another operator has it.

        It hands control over on request; a program that wants to be asked joins with `Server.operator` instead, and
        answers with `Operator.release` or `Operator.keep`.
        """
        return Operator(self._native.operator())

    def add_operator(self, name: str, *, transient: bool = False) -> Operator:
        """Add an operator to this program. It takes control only when it acts or asks for it.

        Parameters
        ----------
        name : str
            Name shown to the other operators, up to 40 characters.
        transient : bool, optional
            For clients that come and go and cannot ask for control: it is present from `Operator.attach` to
            `Operator.detach` and for 5 s after each request. A refused request asks for control, unless another
            operator asks for it already or the holder has declined that within 5 min (`Operator.keep`).
        """
        return Operator(self._native.enlist(name, transient))

    def set_heartbeat(self, enabled: bool) -> None:
        """Start or stop the station's heartbeat, which the vehicle's ground-station failsafe monitors."""
        self._native.set_heartbeat(enabled)

    def close(self) -> None:
        """Close all links and end the recording. Pending operations raise `ClosedError`. Can be called again."""
        self._native.close()


_open_stations: weakref.WeakSet[Station] = weakref.WeakSet()


def _end() -> None:
    """Close in order what the program left open: operations, links, recordings."""
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

    Nothing is armed, started or changed; the vehicle is only asked to send its state.

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
        The station's MAVLink address, default 255/190.

    Returns
    -------
    Vehicle
        Close it, or use it in a ``with`` statement.

    Raises
    ------
    InvalidLink
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

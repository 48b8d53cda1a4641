"""Serves a station's vehicle over ZeroC Ice: the communicator, one adapter for each interface, and the end of all that."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.errors import InvalidRequest, VencejoError
from vencejo.jderobot.access import ConnectionLimit, Gate, Presence, raise_file_limit
from vencejo.jderobot.camera import Camera, FrameSource
from vencejo.jderobot.cmdvel import CMDVel
from vencejo.jderobot.dispatch import SHAPES, Answering, Checked, Dialects, Locator
from vencejo.jderobot.extra import Extra
from vencejo.jderobot.faults import Faults
from vencejo.jderobot.feed import Feed
from vencejo.jderobot.marks import Marks
from vencejo.jderobot.mission import Mission, MissionOfPoses
from vencejo.jderobot.navdata import Navdata
from vencejo.jderobot.pose import Pose3D
from vencejo.jderobot.precise import Control, Missions, TelemetryServant
from vencejo.jderobot.runtime import Dialect, Slices, load
from vencejo.jderobot.settings import INTERFACES, IceSettings, is_loopback
from vencejo.jderobot.states import States
from vencejo.jderobot.subject import Subject
from vencejo.jderobot.workers import Workers
from vencejo.serve import Tokens
from vencejo.station import Station

__all__ = ["IceServer"]

OPERATOR: Final = "JdeRobot"
"""Operator of all clients of these interfaces: the old protocol has no identity for them."""
_DISPATCH_THREADS: Final = 4
"""Requests are short; what takes long has threads of its own (`vencejo.jderobot.workers`)."""


class IceServer(Closing):
    """The Ice interfaces of a station, from their making until they are closed. The station goes on afterwards.

    Parameters
    ----------
    station : Station
        What to serve.
    settings : IceSettings, optional
    cameras : sequence of FrameSource, optional
    jpeg : function of an RGB picture, optional
        Encodes pictures of format ``"JPEG"``.
    tokens : Tokens or function that gives them, optional
        What requests need when others than this machine are let in. A function is asked at each request: `lambda:
        server.tokens` are those that the browser's server has at that time.

    Raises
    ------
    VencejoError
        When Ice is not installed, an address is taken, or a property is wrong.
    InvalidRequest
        When others are let in and there are no tokens.

    Notes
    -----
    In a forked process the parent's server raises `ClosedError`.
    """

    def __init__(
        self,
        station: Station,
        settings: IceSettings | None = None,
        *,
        cameras: Sequence[FrameSource] = (),
        jpeg: Callable[[NDArray[np.uint8]], bytes] | None = None,
        tokens: Tokens | Callable[[], Tokens | None] | None = None,
    ) -> None:
        self._settings = settings = settings or IceSettings()
        slices = load()
        raise_file_limit(settings.max_connections)
        self._ice = slices.ice
        self._closing = contextlib.ExitStack()
        try:
            self._communicator = self._closing.enter_context(_communicator(slices, settings))
            self._adapters = self._serve(slices, station, cameras, jpeg, tokens if callable(tokens) else lambda: tokens)
        except BaseException:
            self._closing.close()
            raise
        belongs_here(self, "_communicator", "_adapters", "_closing")

    def _serve(
        self,
        slices: Slices,
        station: Station,
        cameras: Sequence[FrameSource],
        jpeg: Callable[[NDArray[np.uint8]], bytes] | None,
        tokens: Callable[[], Tokens | None],
    ) -> dict[str, Any]:
        settings, closing = self._settings, self._closing
        endpoints = {interface: settings.endpoint(interface) for interface in INTERFACES}
        adapters = {interface: self._adapter(interface, where) for interface, where in endpoints.items() if where}
        gates = {interface: self._gate(adapter, tokens) for interface, adapter in adapters.items()}
        operator = station.add_operator(OPERATOR, transient=True)
        closing.callback(operator.close)
        presence = Presence(operator)
        closing.callback(presence.close)
        subject = Subject(station, settings.system_id, operator)
        workers, pictures = Workers(), Workers()
        marks = Marks(settings.alone_after_s)
        jderobot, precise = slices.jderobot, slices.precise
        # Each servant is a class of ours with the skeleton of the Slice file behind it.
        camera = slices.servant(Camera, jderobot.Camera)(slices, cameras, settings, pictures, jpeg)
        extra = slices.servant(Extra, jderobot.ArDroneExtra)(subject, workers, marks, settings, camera)
        closing.callback(extra.close)
        velocity = slices.servant(CMDVel, jderobot.CMDVel)(subject, settings.watchdog_s)
        closing.callback(velocity.close)
        states = States(slices)
        feed = Feed(slices, states)
        closing.callback(feed.close)
        # Ended first: pending operations begin no further step while the others close.
        closing.callback(workers.close)
        closing.callback(pictures.close)
        faults = Faults(slices, workers)
        mission = slices.servant(Mission, jderobot.Mission)(slices, subject, workers, marks, settings.missions)
        bare = slices.servant(MissionOfPoses, jderobot.MissionOfPoses)(mission)
        pose = slices.servant(Pose3D, jderobot.Pose3D)(slices, subject, workers)
        missions = slices.servant(Missions, precise.Missions)(slices, subject, faults)
        telemetry = slices.servant(TelemetryServant, precise.Telemetry)(
            subject, states, faults, feed, gates.get("Precise", Gate(None))
        )
        dialects = Dialects(settings.dialect)
        inside = self._communicator.createObjectAdapter("")
        inside.activate()

        def answering(interface: str, servants: dict[Dialect, object]) -> Answering:
            return self._answering(slices, inside, dialects, interface, servants)

        servants: dict[str, dict[str, Answering]] = {
            "Camera": {"": answering("Camera", {"data": camera})},
            "Pose3D": {"": answering("Pose3D", {"data": pose})},
            "Navdata": {"": answering("Navdata", {"data": slices.servant(Navdata, jderobot.Navdata)(slices, subject)})},
            "CMDVel": {"": answering("CMDVel", {"data": velocity})},
            "Extra": {"": answering("ArDroneExtra", {"data": extra})},
            "Mission": {"": answering("Mission", {"data": mission, "sequence": bare})},
            "Precise": {
                "_telemetry": answering("Telemetry", {"data": telemetry}),
                "_missions": answering("Missions", {"data": missions}),
                "_control": answering("Control", {"data": slices.servant(Control, precise.Control)(subject, faults)}),
            },
        }
        locator = slices.servant(Locator, slices.ice.ServantLocator)
        for interface, adapter in adapters.items():
            names, objects = settings.identities(interface), servants[interface]
            named = {name + suffix: servant for name in names for suffix, servant in objects.items()}
            adapter.addServantLocator(locator(slices, gates[interface], named, presence), "")
        ports = {port for adapter in adapters.values() for _, port in _listening(adapter)}
        limit = ConnectionLimit(ports, settings.max_connections)
        closing.callback(limit.close)
        for adapter in adapters.values():
            adapter.activate()
        return adapters

    @staticmethod
    def _answering(
        slices: Slices, inside: Any, dialects: Dialects, interface: str, servants: dict[Dialect, object]
    ) -> Answering:
        """What answers for an object. Where objects come in, its servants stand behind the check, in an adapter without endpoints."""
        shapes = SHAPES.get(interface)
        if shapes is None:
            return Answering(servants, dialects)
        behind = {
            dialect: inside.add(servant, slices.ice.Identity(f"{interface} {dialect}", ""))
            for dialect, servant in servants.items()
        }
        checked = slices.servant(Checked, slices.ice.BlobjectAsync)(slices, shapes, behind, dialects)
        return Answering(servants, dialects, checked, shapes)

    def _adapter(self, interface: str, endpoints: str) -> Any:
        ice = self._ice
        try:
            adapter = self._communicator.createObjectAdapterWithEndpoints(f"Vencejo.{interface}", endpoints)
            if any(endpoint.getInfo().datagram() for endpoint in adapter.getEndpoints()):
                raise InvalidRequest(
                    f"{interface}.Endpoints is {endpoints!r}: datagrams have no answer and no sender that could be "
                    "trusted; use tcp, ssl, ws or wss"
                )
            return adapter
        except (ice.SocketException, ice.DNSException) as error:
            why = os.strerror(error.error) if getattr(error, "error", 0) > 0 else type(error).__name__
            raise VencejoError(f"{interface} cannot listen on {endpoints!r}: {why}") from error
        except ice.EndpointParseException as error:
            raise InvalidRequest(f"{interface}.Endpoints is {endpoints!r}: {error.str}") from error

    def _gate(self, adapter: Any, tokens: Callable[[], Tokens | None]) -> Gate:
        takes_pages = self._takes_pages(adapter)
        if all(is_loopback(host) for host, _ in _listening(adapter)):
            return Gate(None, takes_pages=takes_pages)
        if tokens() is None:
            raise InvalidRequest("others than this machine are let in, and there are no tokens that they could need")
        return Gate(tokens, self._settings.allow, takes_pages=takes_pages)

    def _takes_pages(self, adapter: Any) -> bool:
        """Whether pages in a browser reach an adapter: they speak WebSocket only."""
        kinds = (self._ice.WSEndpointType, self._ice.WSSEndpointType)
        return any(endpoint.getInfo().type() in kinds for endpoint in adapter.getEndpoints())

    @property
    def endpoints(self) -> dict[str, str]:
        """Where each interface listens, with the ports that were taken."""
        return {interface: ":".join(map(str, adapter.getEndpoints())) for interface, adapter in self._adapters.items()}

    @property
    def proxies(self) -> dict[str, str]:
        """The proxy of each interface's object, as a client's configuration has it."""
        suffix = {"Precise": "_telemetry"}
        return {
            interface: f"{self._settings.identity(interface)}{suffix.get(interface, '')}:{endpoints}"
            for interface, endpoints in self.endpoints.items()
        }

    def close(self) -> None:
        """End all connections; a vehicle that flies by velocity is stopped. Can be called again."""
        self._closing.close()


def _listening(adapter: Any) -> list[tuple[str, int]]:
    """Addresses and ports of an adapter."""
    found = []
    for endpoint in adapter.getEndpoints():
        info = endpoint.getInfo()
        while info is not None and not hasattr(info, "port"):
            info = info.underlying
        if info is not None:
            found.append((info.host, info.port))
    return found


@contextlib.contextmanager
def _communicator(slices: Slices, settings: IceSettings) -> Any:
    ice = slices.ice
    properties = ice.createProperties()
    ours = {
        "Ice.ThreadPool.Server.Size": str(_DISPATCH_THREADS),
        "Ice.ThreadPool.Server.SizeMax": str(_DISPATCH_THREADS),
        "Ice.MessageSizeMax": str(settings.max_message_kib),
        # An idle connection is closed after a minute; clients reconnect by themselves.
        "Ice.ACM.Server.Timeout": "60",
        "Ice.Warn.Connections": "0",
        "Ice.Warn.Dispatch": "0",
        # A closing server does not wait for clients that do not read.
        "Ice.ACM.Server.Close": "3",
    }
    for name, value in {**ours, **settings.properties}.items():
        properties.setProperty(name, value)
    data = ice.InitializationData()
    data.properties = properties
    try:
        communicator = ice.initialize(data)
    except (ice.Exception, RuntimeError) as error:
        raise InvalidRequest(f"Ice does not start with these properties: {error}") from error
    try:
        yield communicator
    finally:
        communicator.destroy()


assert set(INTERFACES) == {"Camera", "Pose3D", "Navdata", "CMDVel", "Extra", "Mission", "Precise"}

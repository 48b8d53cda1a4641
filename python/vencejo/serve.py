"""The ground station in the browser: serves a station's vehicles over HTTP and WebSocket.

Examples
--------
>>> import vencejo
>>> from vencejo.serve import Server
>>> with vencejo.Station(record=False) as station, Server(station, port=0) as server:
...     server.url.startswith("http://127.0.0.1:")
True
"""

from __future__ import annotations

import ipaddress
import os
import socket
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.control import Operator
from vencejo.errors import InvalidRequest
from vencejo.station import Station, default_history_dir, default_record_dir
from vencejo.storage import Floors, StorageProblem
from vencejo.video import VideoFeed, default_video_dir

__all__ = [
    "Operator",
    "Server",
    "Tokens",
    "default_draft_file",
    "default_maps_folder",
    "default_token_file",
    "has_app",
    "own_addresses",
    "renew_tokens",
]


@dataclass(frozen=True, kw_only=True)
class Tokens:
    """What proves that somebody may use a server that others can reach.

    Attributes
    ----------
    viewer, operator : str
        For those who look, and for those who command as well.
    """

    viewer: str = field(repr=False)
    operator: str = field(repr=False)


def default_token_file() -> Path:
    """Where the tokens are kept: `server-tokens.json` in the data folder, readable by its owner alone."""
    return default_record_dir().parent / "server-tokens.json"


def default_maps_folder() -> Path:
    """Where map sources, their cache and offline areas are kept: `maps` in the data folder."""
    return default_record_dir().parent / "maps"


def renew_tokens(path: str | os.PathLike[str] | None = None, *, viewer: bool = True, operator: bool = True) -> Tokens:
    """Make new tokens. A running server takes them within seconds, and ends the sessions that the old ones opened.

    Parameters
    ----------
    path : path, optional
        Their file. Default `default_token_file`.
    viewer, operator : bool, optional
        Which of the two is to be another.

    Raises
    ------
    VencejoError
        When the file cannot be read or written.
    """
    file = os.fspath(path) if path is not None else str(default_token_file())
    viewers, operators = _native.renew_tokens(file, viewer, operator)
    return Tokens(viewer=viewers, operator=operators)


def default_draft_file() -> Path:
    """Where the draft of the plan is kept: `plan-draft.json` in the data folder."""
    return default_record_dir().parent / "plan-draft.json"


def has_app() -> bool:
    """Whether the web app is in this build; without it the server serves its API alone."""
    return _native.has_app()


class Server(Closing):
    """A station's server, from its making until it is closed. The station goes on afterwards.

    One operator at a time holds control of the station (`vencejo.control`); others watch and may ask for it.

    Parameters
    ----------
    station : Station
        What to serve.
    host : str, optional
        Address or name to listen on, default ``"127.0.0.1"``. Any that others can reach demands tokens.
    port : int, optional
        Default 8765; 0 takes a free one.
    tokens : bool, optional
        Whether to demand tokens even on a loopback address, where everybody on this machine is an operator without.
    token_file : path, optional
        Where they are kept; made at the first start. Default `default_token_file`.
    allow_hosts : iterable of str, optional
        Names of this machine by which browsers reach it, beside addresses, ``localhost`` and, where others are let in, its
        own host name.
    allow_origins : iterable of str, optional
        Other web pages' origins that may use the API, such as ``"http://localhost:5173"``.
    certificate, key : path, optional
        PEM files of a certificate chain and its key, for TLS.
    plain_http : bool, optional
        Whether others may be let in without TLS, where whoever is in the network reads along, tokens too. Default False: an
        address that others can reach needs ``certificate`` and ``key``.
    on_board : bool, optional
        On board a vehicle: our heartbeat is sent only while an operator's session is alive, because the autopilot's
        ground-station failsafe counts it.
    maps_folder : path, optional
        Where map sources, their cache and offline areas are kept; made when it is not there. Default
        `default_maps_folder`.
    video_folder : path, optional
        Where the recordings and pictures of cameras are, to be listed and downloaded. Default
        `vencejo.video.default_video_dir`.
    history_folder : path, optional
        Where the history of aircraft far away is, to be listed and downloaded. Default `vencejo.station.default_history_dir`.
    draft_file : path, optional
        Where the draft of the plan is kept for all browsers. Default `default_draft_file`.
    floors : Floors, optional
        Free space of the disk below which no maps are kept; default 2 GB.

    Raises
    ------
    InvalidRequest
        For an address that is none, or a certificate without key.
    VencejoError
        When the address is taken or not to be listened on without TLS, or the certificate or the tokens' file cannot be used. A disk that cannot be written is
        no error: `storage_problems` tells.
    """

    def __init__(
        self,
        station: Station,
        *,
        host: str = "127.0.0.1",
        port: int = 8765,
        tokens: bool = False,
        token_file: str | os.PathLike[str] | None = None,
        allow_hosts: Iterable[str] = (),
        allow_origins: Iterable[str] = (),
        certificate: str | os.PathLike[str] | None = None,
        key: str | os.PathLike[str] | None = None,
        plain_http: bool = False,
        on_board: bool = False,
        maps_folder: str | os.PathLike[str] | None = None,
        video_folder: str | os.PathLike[str] | None = None,
        history_folder: str | os.PathLike[str] | None = None,
        draft_file: str | os.PathLike[str] | None = None,
        floors: Floors | None = None,
    ) -> None:
        address = _address(host)
        if not 0 <= port <= 65535:
            raise InvalidRequest(f"port is {port}, should be 0, which takes a free one, to 65535")
        tls = (os.fspath(certificate), os.fspath(key)) if certificate is not None and key is not None else None
        if tls is None and not (certificate is None and key is None):
            raise InvalidRequest("TLS needs both a certificate and its key")
        is_loopback = ipaddress.ip_address(address).is_loopback
        needs_tokens = tokens or token_file is not None or not is_loopback
        own_names = [] if is_loopback else [socket.gethostname(), f"{socket.gethostname()}.local"]
        kept = os.fspath(token_file) if token_file is not None else str(default_token_file())
        self._native = _native.Server(
            station._native,
            address=address,
            port=port,
            token_file=kept if needs_tokens else None,
            hosts=[*own_names, *allow_hosts],
            origins=list(allow_origins),
            tls=tls,
            plain_http=plain_http,
            on_board=on_board,
            maps_folder=os.fspath(maps_folder if maps_folder is not None else default_maps_folder()),
            video_folder=os.fspath(video_folder if video_folder is not None else default_video_dir()),
            history_folder=os.fspath(history_folder if history_folder is not None else default_history_dir()),
            draft_file=os.fspath(draft_file if draft_file is not None else default_draft_file()),
            floors_mb=None if floors is None else floors._mb,
        )
        self._station = station
        belongs_here(self)

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return self._native.address()[1]

    @property
    def url(self) -> str:
        """Its address for a browser on this machine, without a token."""
        return self._url(self._native.address()[0])

    @property
    def urls(self) -> list[str]:
        """Its addresses for browsers on this and other machines, without a token; the likeliest first."""
        host = self._native.address()[0]
        if not ipaddress.ip_address(host).is_unspecified:
            return [self._url(host)]
        return [self._url(address) for address in (*own_addresses(), host)]

    @property
    def tokens(self) -> Tokens | None:
        """Its tokens; ``None`` when everybody on this machine is an operator."""
        tokens = self._native.tokens()
        return None if tokens is None else Tokens(viewer=tokens[0], operator=tokens[1])

    @property
    def storage_problems(self) -> list[StorageProblem]:
        """What of the disk does not work, the flight recorder first; empty when all is well. As pages show it."""
        return [
            StorageProblem(what=what, name=name, fault=fault, text=text)
            for what, name, fault, text in self._native.storage_problems()
        ]

    @property
    def clients(self) -> int:
        """How many browsers and programs have the WebSocket open."""
        return self._native.clients

    def operator(self, name: str) -> Operator:
        """Take part as one more operator, for a program that flies while people watch.

        It is a session like a browser's: it has control from the start when nobody else does. Act in its name with
        `Operator.vehicle`.

        Parameters
        ----------
        name : str
            What the others are shown, up to 40 characters.

        Raises
        ------
        Busy
            When all places for sessions are taken.
        """
        return Operator(self._native.operator(name))

    @property
    def station(self) -> Station:
        """Whose vehicles it shows."""
        return self._station

    def add_camera(self, name: str, source: str) -> VideoFeed:
        """Show one more camera; it is there until its feed is closed. `vencejo.camera.ServedCamera` does all the rest.

        Parameters
        ----------
        name : str
            1 to 32 letters, digits, ``-`` or ``_``.
        source : str
            What people are shown of where it comes from: no passwords.

        Raises
        ------
        InvalidRequest
            For a name that cannot be one, or that is taken.
        VencejoError
            When there are as many as there may be.
        """
        return VideoFeed(self._native.add_camera(name, source))

    def close(self) -> None:
        """End all connections. Can be called again."""
        self._native.close()

    def _url(self, host: str) -> str:
        address = ipaddress.ip_address(host)
        if address.is_unspecified:
            address = ipaddress.ip_address("127.0.0.1" if address.version == 4 else "::1")
        shown = f"[{address}]" if address.version == 6 else str(address)
        return f"{'https' if self._native.is_tls else 'http'}://{shown}:{self.port}"


def _address(host: str) -> str:
    """The address of a host: itself, or the first that its name has, IPv4 before IPv6."""
    try:
        return str(ipaddress.ip_address(host))
    except ValueError:
        pass
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except OSError as error:
        raise InvalidRequest(f"host {host!r} has no address ({error.strerror}); give one such as 127.0.0.1") from error
    return str(min(found, key=lambda entry: entry[0] != socket.AF_INET)[4][0])


def own_addresses() -> list[str]:
    """Addresses of this machine in its networks, the one of the default route first. Nothing is sent."""
    addresses = []
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect(("192.0.2.1", 9))
            addresses.append(str(probe.getsockname()[0]))
    except OSError:
        pass  # no network, no address in it
    try:
        entries = socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET, socket.SOCK_STREAM)
    except OSError:
        entries = []  # a host that does not know its own name
    addresses += [str(entry[4][0]) for entry in entries]
    return [address for address in dict.fromkeys(addresses) if not ipaddress.ip_address(address).is_loopback]

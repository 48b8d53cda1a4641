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
    """The secrets that give access to a server that other machines can reach.

    Attributes
    ----------
    viewer, operator : str
        For watching only; for watching and commanding.
    """

    viewer: str = field(repr=False)
    operator: str = field(repr=False)


def default_token_file() -> Path:
    """Path of the token file: `server-tokens.json` in the data folder, readable by its owner alone."""
    return default_record_dir().parent / "server-tokens.json"


def default_maps_folder() -> Path:
    """Folder of map sources, their cache and offline areas: `maps` in the data folder."""
    return default_record_dir().parent / "maps"


def renew_tokens(path: str | os.PathLike[str] | None = None, *, viewer: bool = True, operator: bool = True) -> Tokens:
    """Make new tokens. A running server loads them within seconds and ends the sessions opened with the old ones.

    Parameters
    ----------
    path : path, optional
        Their file. Default `default_token_file`.
    viewer, operator : bool, optional
        Which of the two to replace.

    Raises
    ------
    VencejoError
        When the file cannot be read or written.
    """
    file = os.fspath(path) if path is not None else str(default_token_file())
    viewers, operators = _native.renew_tokens(file, viewer, operator)
    return Tokens(viewer=viewers, operator=operators)


def default_draft_file() -> Path:
    """Path of the plan's draft: `plan-draft.json` in the data folder."""
    return default_record_dir().parent / "plan-draft.json"


def has_app() -> bool:
    """Whether this build contains the web app; without it the server serves its API alone."""
    return _native.has_app()


class Server(Closing):
    """A web server for a station. It runs from construction until it is closed; the station outlives it.

    One operator at a time holds control of the station (`vencejo.control`); others watch and may ask for it.

    Parameters
    ----------
    station : Station
        What to serve.
    host : str, optional
        Address or name to listen on, default ``"127.0.0.1"``. One that other machines can reach demands tokens.
    port : int, optional
        Default 8765; 0 picks a free port.
    tokens : bool, optional
        Whether to demand tokens even on a loopback address, where all users of this machine are operators otherwise.
    token_file : path, optional
        File of the tokens; created at the first start. Default `default_token_file`.
    allow_hosts : iterable of str, optional
        Names of this machine that browsers use, beside addresses, ``localhost`` and, if other machines are let in, its
        own host name.
    allow_origins : iterable of str, optional
        Other web pages' origins that may use the API, such as ``"http://localhost:5173"``.
    certificate, key : path, optional
        PEM files of a certificate chain and its key, for TLS.
    plain_http : bool, optional
        Whether to let other machines in without TLS, so that anyone in the network can read the traffic, tokens
        included. Default False: an address that others can reach needs ``certificate`` and ``key``.
    on_board : bool, optional
        Run on board a vehicle: the station's heartbeat is sent only while an operator's page or program has its
        WebSocket open, and 5 s longer, because the autopilot's ground-station failsafe monitors it. Single HTTP
        requests do not count.
    maps_folder : path, optional
        Folder of map sources, their cache and offline areas; created if missing. Default `default_maps_folder`.
    video_folder : path, optional
        Folder of camera recordings and pictures, which pages list and download. Default
        `vencejo.video.default_video_dir`.
    history_folder : path, optional
        Folder of the histories of remote aircraft, which pages list and download. Default
        `vencejo.station.default_history_dir`.
    draft_file : path, optional
        File of the plan's draft, which all browsers share. Default `default_draft_file`.
    floors : Floors, optional
        Free space of the disk below which no maps are kept; default 2 GB.

    Raises
    ------
    InvalidRequest
        For an invalid address, host or origin, or a certificate without a key.
    VencejoError
        When the address is in use or needs TLS, or the certificate or the token file cannot be used. An unwritable disk
        does not raise; see `storage_problems`.
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
        """Its tokens; ``None`` when all users of this machine are operators."""
        tokens = self._native.tokens()
        return None if tokens is None else Tokens(viewer=tokens[0], operator=tokens[1])

    @property
    def storage_problems(self) -> list[StorageProblem]:
        """Storage faults as the web app shows them, the flight recorder's first; empty when there are none."""
        return [
            StorageProblem(what=what, name=name, fault=fault, text=text)
            for what, name, fault, text in self._native.storage_problems()
        ]

    @property
    def clients(self) -> int:
        """How many browsers and programs have the WebSocket open."""
        return self._native.clients

    def operator(self, name: str) -> Operator:
        """Join as one more operator, for a program that flies while people watch.

        It is a session like a browser's: it gets control at once if control is free. Act in its name with
        `Operator.vehicle`.

        Parameters
        ----------
        name : str
            Name shown to the other operators, up to 40 characters.

        Raises
        ------
        Busy
            When the server has its maximum of sessions.
        """
        return Operator(self._native.operator(name))

    @property
    def station(self) -> Station:
        """The station that it serves."""
        return self._station

    def add_camera(self, name: str, source: str) -> VideoFeed:
        """Add a camera, which the pages show until its feed is closed. `vencejo.camera.ServedCamera` does this and feeds it.

        Parameters
        ----------
        name : str
            1 to 32 letters, digits, ``-`` or ``_``.
        source : str
            Where the pictures come from, as people are shown it: without passwords.

        Raises
        ------
        InvalidRequest
            For an invalid name, or one that is in use.
        VencejoError
            When the server has its maximum of cameras.
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

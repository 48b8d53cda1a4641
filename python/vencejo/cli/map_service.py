"""The maps' API for the `vencejo maps` commands: of a station that runs, or of the maps folder opened here for as long as a command runs.

Both are the server's own code behind the same HTTP interface, so that a command does what the browser's dialog does.
"""

from __future__ import annotations

import contextlib
import http.client
import json
import ssl
import urllib.parse
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, BinaryIO, Final

import typer

from vencejo.cli.common import Exit, Failed, told_when_long

CONNECT_S: Final = 10.0
"""How long a connection may take, seconds."""
PATIENCE_S: Final = 120.0
"""How long an answer may take: some make the station ask a slow map service."""
PIECE: Final = 1 << 20

COMMANDS: Final = {
    "GET /api/v1/maps/sources": "`vencejo maps list`",
    "POST /api/v1/maps/capabilities": "`vencejo maps layers`",
}
"""The commands that do what the server names as a remedy."""

StationOption = Annotated[
    str | None,
    typer.Option(
        "--station",
        metavar="URL",
        envvar="VENCEJO_STATION",
        help="A running ground station, such as http://192.168.1.20:8765; by default the maps folder of this machine is opened.",
    ),
]
TokenOption = Annotated[
    str | None,
    typer.Option("--token", metavar="TOKEN", envvar="VENCEJO_TOKEN", help="The station's token for operators."),
]
FolderOption = Annotated[
    Path | None,
    typer.Option("--maps", metavar="FOLDER", help="The maps folder, without --station; by default in the data folder."),
]


@dataclass
class Answer:
    """What the station answered."""

    status: int
    kind: str
    headers: dict[str, str]
    body: bytes


@dataclass
class MapService:
    """A session with a station's maps.

    Parameters
    ----------
    url : str
        Where the station is: scheme, host and port.
    name : str
        What it is to a person.
    """

    url: str
    name: str
    _cookie: str | None = field(default=None, repr=False)

    def open(self, token: str | None) -> None:
        """Open a session; control of the vehicles, which a first operator is given, is handed back at once."""
        answer = self.request("POST", "session", json.dumps({"name": "vencejo maps", "token": token}).encode())
        session = self._read(answer.body)
        if not isinstance(session, dict) or "role" not in session:
            raise self._no_vencejo()
        self._cookie = answer.headers.get("set-cookie", "").partition(";")[0] or None
        self.request("POST", "control/release")

    def close(self) -> None:
        """End the session."""
        with contextlib.suppress(OSError, Failed):
            self.request("DELETE", "session")

    def ask(self, method: str, path: str, body: Any = None) -> Any:
        """One request with JSON; what came back.

        Raises
        ------
        Failed
            With the station's own words; for a number that is none, before it is asked.
        """
        try:
            sent = None if body is None else json.dumps(body, allow_nan=False).encode()
        except ValueError:
            raise Failed("inf and nan are no numbers that a map has: give finite ones", Exit.USAGE) from None
        answer = self.request(method, path, sent)
        return self._read(answer.body) if answer.body else None

    def send_file(self, path: str, file: BinaryIO) -> Any:
        """Send a file as it is; what came back."""
        return self._read(self.request("POST", path, file, kind="application/octet-stream").body)

    def save(self, path: str, target: Path) -> int:
        """Write an answer to a file, a piece at a time; its bytes."""
        connection, response = self._send("GET", path, None, "")
        with contextlib.closing(connection):
            if response.status >= 300:
                raise _failure(response.status, response.read())
            from vencejo.storage import install_file

            partial = target.with_name(f".{target.name}.part")
            try:
                with partial.open("wb") as file:
                    while piece := self._piece(response):
                        file.write(piece)
                install_file(partial, target)
            finally:
                partial.unlink(missing_ok=True)
        return target.stat().st_size

    def request(
        self, method: str, path: str, body: bytes | BinaryIO | None = None, *, kind: str = "application/json"
    ) -> Answer:
        """One request that must succeed."""
        connection, response = self._send(method, path, body, kind)
        with contextlib.closing(connection):
            try:
                data = response.read()
            except (OSError, http.client.HTTPException) as error:
                raise self._silent(error) from error
        if response.status >= 300:
            raise _failure(response.status, data)
        headers = {name.lower(): value for name, value in response.getheaders()}
        return Answer(response.status, headers.get("content-type", ""), headers, data)

    def _send(
        self, method: str, path: str, body: bytes | BinaryIO | None, kind: str
    ) -> tuple[http.client.HTTPConnection, http.client.HTTPResponse]:
        connection = self._connection()
        headers = {"Content-Type": kind} if body is not None else {}
        if body is not None and not isinstance(body, bytes):
            headers["Content-Length"] = str(body.seek(0, 2))
            body.seek(0)
        if self._cookie:
            headers["Cookie"] = self._cookie
        target = path if path.startswith("/") else f"/api/v1/{path}"
        try:
            connection.connect()
            connection.sock.settimeout(PATIENCE_S)
            with told_when_long(f"Still waiting for {self.name}"):
                try:
                    connection.request(method, target, body, headers)
                except (BrokenPipeError, ConnectionResetError):
                    if body is None:
                        raise
                    # It is refused before it came whole: why may be here already.
                return connection, connection.getresponse()
        # A name that cannot be one is a ValueError (UnicodeError).
        except (OSError, ValueError, http.client.HTTPException) as error:
            connection.close()
            raise self._silent(error) from error

    def _connection(self) -> http.client.HTTPConnection:
        try:
            parts = urllib.parse.urlsplit(self.url)
            host, port = parts.hostname, parts.port
        except ValueError:  # an invalid IPv6 address or port
            host = port = None
        if not host or parts.scheme not in ("http", "https"):
            raise Failed(f"--station {self.url}: takes an address such as http://192.168.1.20:8765", Exit.USAGE)
        if parts.scheme == "http":
            return http.client.HTTPConnection(host, port, timeout=CONNECT_S)
        return http.client.HTTPSConnection(host, port, timeout=CONNECT_S, context=ssl.create_default_context())

    def _piece(self, response: http.client.HTTPResponse) -> bytes:
        """The next piece of an answer; empty at its end."""
        try:
            piece = response.read(PIECE)
            if not piece and response.length:
                raise http.client.IncompleteRead(piece, response.length)
        except (OSError, http.client.HTTPException) as error:
            raise self._silent(error) from error
        return piece

    def _read(self, body: bytes) -> Any:
        try:
            return json.loads(body)
        except ValueError:
            raise self._no_vencejo() from None

    def _silent(self, error: Exception) -> Failed:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        return Failed(f"{self.name} does not answer: {reason}")

    def _no_vencejo(self) -> Failed:
        return Failed(f"what answers at {self.url} is no Vencejo")


def _failure(status: int, body: bytes) -> Failed:
    try:
        problem = json.loads(body)
        text = str(problem.get("detail") or problem.get("title") or status)
        remedy = problem.get("remedy")
    except (ValueError, AttributeError):
        return Failed(f"the station answers with {status}; is a Vencejo there?")
    if status == 401:
        remedy = "give the token that `vencejo serve` shows, with --token or in VENCEJO_TOKEN"
    told = f"{text}; {remedy}" if remedy else text
    for route, command in COMMANDS.items():
        told = told.replace(route, command)
    return Failed(told)


def quoted(text: str) -> str:
    """A text as one part of a path or query."""
    return urllib.parse.quote(text, safe="", errors="replace")


def opened(path: Path) -> BinaryIO:
    """A file to be sent. A pipe or a device has no length, and may keep us waiting without an end."""
    if path.exists() and not path.is_file():
        raise Failed(f"{path} is not a file", Exit.USAGE)
    return path.open("rb")


@contextlib.contextmanager
def map_service(station: str | None, token: str | None, folder: Path | None) -> Iterator[MapService]:
    """A session with the station at an address, or with one that serves the maps folder here until the end."""
    with contextlib.ExitStack() as stack:
        if folder is not None and folder.exists() and not folder.is_dir():
            raise Failed(f"--maps {folder} is not a folder", Exit.USAGE)
        if station is None:
            from vencejo import Station
            from vencejo.serve import Server

            # No link: this station knows of no vehicle.
            alone = stack.enter_context(Station(record=False, heartbeat=False))
            server = stack.enter_context(Server(alone, port=0, tokens=True, maps_folder=folder))
            tokens = server.tokens
            url, token = server.url, None if tokens is None else tokens.operator
            name = "the maps of this machine"
        else:
            if folder is not None:
                raise Failed("--maps is for this machine's folder; with --station it is the station's", Exit.USAGE)
            url = station if "://" in station else f"http://{station}"
            name = f"the station at {url}"
        service = MapService(url, name)
        service.open(token)
        stack.callback(service.close)
        yield service

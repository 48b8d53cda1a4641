"""A client of the HTTP API and its WebSocket, independent of the server: standard library only (RFC 9112, RFC 6455)."""

from __future__ import annotations

import base64
import contextlib
import http.client
import json
import os
import socket
import struct
import subprocess
import sys
import time
import urllib.parse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

PATIENCE_S = 120.0
"""Time limit of a wait; longer ones are failures."""


@dataclass
class Answer:
    """An answer of the server."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        """Return the body parsed as JSON."""
        return json.loads(self.body)


@dataclass
class Client:
    """One session with a server."""

    url: str
    cookie: str | None = None
    headers: dict[str, str] = field(default_factory=dict)

    @property
    def authority(self) -> str:
        """Host and port."""
        return urllib.parse.urlsplit(self.url).netloc

    def ask(self, method: str, path: str, body: Any = None, **headers: str) -> Answer:
        """Send a request; `body` is sent as JSON, or unchanged if bytes."""
        connection = http.client.HTTPConnection(self.authority, timeout=PATIENCE_S)
        sent = {**self.headers, **{name.replace("_", "-"): value for name, value in headers.items()}}
        if self.cookie:
            sent["Cookie"] = self.cookie
        payload = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
        if payload is not None and not isinstance(body, bytes):
            sent["Content-Type"] = "application/json"
        try:
            connection.request(method, path if path.startswith("/") else f"/api/v1/{path}", payload, sent)
            response = connection.getresponse()
            return Answer(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
        finally:
            connection.close()

    def done(self, method: str, path: str, body: Any = None, **headers: str) -> Any:
        """Send a request that must succeed; return its JSON."""
        answer = self.ask(method, path, body, **headers)
        assert answer.status < 300, f"{method} {path}: {answer.status} {answer.body.decode()}"
        return answer.json if answer.body else None

    def open_session(self, **session: str) -> Any:
        """Open a session and keep its cookie."""
        answer = self.ask("POST", "session", session)
        assert answer.status == 200, answer.body
        self.cookie = answer.headers["set-cookie"].partition(";")[0]
        return answer.json

    def operation(self, method: str, path: str, body: Any = None, **headers: str) -> Any:
        """Start an operation and wait for its end; return its result."""
        operation = self.done(method, path, body, **headers)
        deadline = time.monotonic() + PATIENCE_S
        while operation["state"] == "running":
            assert time.monotonic() < deadline, operation
            time.sleep(0.02)
            operation = self.done("GET", f"operations/{operation['id']}")
        assert operation["state"] == "done", operation
        return operation.get("result")


def frame(opcode: int, payload: bytes) -> bytes:
    """Return a client's frame, which is masked."""
    size = len(payload)
    if size < 126:
        head = bytes([0x80 | opcode, 0x80 | size])
    elif size < 1 << 16:
        head = bytes([0x80 | opcode, 0x80 | 126]) + struct.pack(">H", size)
    else:
        head = bytes([0x80 | opcode, 0x80 | 127]) + struct.pack(">Q", size)
    mask = os.urandom(4)
    masked = bytes(byte ^ mask[index % 4] for index, byte in enumerate(payload))
    return head + mask + masked


class WebSocket:
    """A WebSocket (RFC 6455) for texts that answers pings."""

    def __init__(
        self,
        client: Client,
        *,
        path: str = "/api/v1/ws",
        receive_buffer: int | None = None,
        origin: str | None = None,
    ) -> None:
        host, _, port = client.authority.rpartition(":")
        self._socket = socket.socket()
        self._socket.settimeout(PATIENCE_S)
        if receive_buffer is not None:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self._socket.connect((host, int(port)))
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [
            f"GET {path} HTTP/1.1",
            f"Host: {client.authority}",
            "Connection: Upgrade",
            "Upgrade: websocket",
            "Sec-WebSocket-Version: 13",
            f"Sec-WebSocket-Key: {key}",
            *([f"Cookie: {client.cookie}"] if client.cookie else []),
            *([f"Origin: {origin}"] if origin else []),
        ]
        self._socket.sendall("\r\n".join([*lines, "", ""]).encode())
        self._pending = b""
        while b"\r\n\r\n" not in self._pending:
            part = self._socket.recv(4096)
            assert part, "the server hung up"
            self._pending += part
        head, _, self._pending = self._pending.partition(b"\r\n\r\n")
        self.status = int(head.split(b" ", 2)[1])
        self.closed: tuple[int, str] | None = None

    def say(self, **message: Any) -> None:
        """Send a message."""
        self._send(0x1, json.dumps(message).encode())

    def take(self) -> Any | None:
        """Return the next message; ``None`` when the connection has ended."""
        while True:
            try:
                opcode, payload = self._frame()
                if opcode == 0x9:
                    self._send(0xA, payload)
            except (ConnectionError, EOFError):
                return None
            if opcode == 0x1:
                return json.loads(payload)
            if opcode == 0x8:
                self.closed = (struct.unpack(">H", payload[:2])[0], payload[2:].decode())
                return None

    def until(self, kind: str, /, **values: Any) -> Any:
        """Return the next message of a type with these values."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            message = self.take()
            assert message is not None, f"the connection ended before {kind} {values}: {self.closed}"
            if message["type"] == kind and all(message.get(name) == value for name, value in values.items()):
                return message
        raise AssertionError(f"no {kind} {values}")

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()

    def __enter__(self) -> WebSocket:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def put(self, data: bytes) -> None:
        """Send raw bytes."""
        self._socket.sendall(data)

    def skim(self, most: int) -> int:
        """Discard up to `most` received bytes; return how many. OSError or EOFError when the connection has ended."""
        self._socket.setblocking(False)
        try:
            forgotten = len(self._socket.recv(most))
        except BlockingIOError:
            return 0
        finally:
            self._socket.settimeout(PATIENCE_S)
        if not forgotten:
            raise EOFError
        return forgotten

    def _send(self, opcode: int, payload: bytes) -> None:
        self.put(frame(opcode, payload))

    def _frame(self) -> tuple[int, bytes]:
        first, length = self._exactly(2)
        if length == 126:
            (length,) = struct.unpack(">H", self._exactly(2))
        elif length == 127:
            (length,) = struct.unpack(">Q", self._exactly(8))
        assert first & 0x80, "the server sends whole messages"
        return first & 0x0F, self._exactly(length)

    def _exactly(self, count: int) -> bytes:
        while len(self._pending) < count:
            part = self._socket.recv(65536)
            if not part:
                raise EOFError
            self._pending += part
        taken, self._pending = self._pending[:count], self._pending[count:]
        return taken


@dataclass
class Served:
    """A running `vencejo serve`."""

    process: subprocess.Popen[str]
    said: dict[str, Any]

    @property
    def url(self) -> str:
        """Its address."""
        return str(self.said["url"])

    def token(self, role: str) -> str:
        """Return the token of a role."""
        return str(self.said[f"{role}_url"]).partition("#token=")[2]

    def client(self, **session: str) -> Client:
        """Return a client with a session."""
        client = Client(self.url)
        client.open_session(**session)
        return client


@contextlib.contextmanager
def serving(
    *options: str, data: Path, under: Sequence[str] = (), env: Mapping[str, str] | None = None
) -> Iterator[Served]:
    """Run `vencejo serve` as a process, on a free port, with its own data folder, optionally `under` a program."""
    command = [*under, sys.executable, "-m", "vencejo.cli", "serve", "--port=0", "--json", "--no-record", *options]
    env = {**os.environ, "VENCEJO_DATA": str(data), **(env or {})}
    # Otherwise a new installation begins with maps from the network, which tests cannot reach.
    sources = data / "maps" / "sources.toml"
    if not sources.exists():
        sources.parent.mkdir(parents=True, exist_ok=True)
        sources.write_text("# none\n", encoding="utf-8")
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        try:
            line = process.stdout.readline()
            assert line, f"the server did not start: {process.stderr.read()}"
            yield Served(process, json.loads(line))
        finally:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(20)
            process.kill()

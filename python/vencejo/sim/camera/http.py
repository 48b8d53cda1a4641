"""Serves the pictures like a network camera: Motion JPEG over HTTP, and single pictures.

=========================  =====================================================================================
``/stream.mjpg``           ``multipart/x-mixed-replace``, one JPEG a part; ``X-Timestamp`` is when it was taken, in
                           seconds since 1970, as mjpg-streamer writes it
``/snapshot.jpg``          one JPEG with the same header
``/<system id>/…``         both, of that plane; of the first plane without it
=========================  =====================================================================================

It listens on loopback only, because like most such cameras it has no authentication.
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import threading
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from .nose import Frame, NoseCamera

__all__ = ["BOUNDARY", "CameraServer", "parse_address"]

BOUNDARY = "vencejoframe"
_MAX_VIEWERS = 16
_SILENCE_S = 10.0
"""Time-out of a client that neither sends nor receives."""


def parse_address(text: str) -> tuple[str, int]:
    """Read ``HOST:PORT`` of a loopback address; ``[::1]:8554`` for IPv6.

    Raises
    ------
    ValueError
        It has another form, or is not loopback.

    Examples
    --------
    >>> parse_address("127.0.0.1:8554")
    ('127.0.0.1', 8554)
    """
    host, separator, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not separator or not host or not port.isdecimal() or int(port) > 65535:
        raise ValueError(f"camera {text!r}: write HOST:PORT as in 127.0.0.1:8554 (port 0 takes a free one)")
    with contextlib.suppress(ValueError):
        if ipaddress.ip_address(host).is_loopback:
            return host, int(port)
    if host == "localhost":
        return "127.0.0.1", int(port)
    raise ValueError(f"camera {text!r}: the simulated camera listens on this machine only: write 127.0.0.1:{port}")


class CameraServer:
    """The cameras of all planes on one port.

    Parameters
    ----------
    address : tuple of str and int
        Loopback address and port; port 0 takes a free one.
    cameras : mapping of int to NoseCamera
        By system id; the first is also served without one.

    Raises
    ------
    OSError
        The port is not available; the message names it.
    """

    def __init__(self, address: tuple[str, int], cameras: Mapping[int, NoseCamera]) -> None:
        self._cameras = dict(cameras)
        try:
            self._server = _Server(address, _Handler)
        except OSError as error:
            raise OSError(error.errno, f"camera {address[0]}:{address[1]}: {error.strerror or error}") from error
        self._server.cameras = {"": next(iter(self._cameras.values()))}
        self._server.cameras |= {f"/{number}": camera for number, camera in self._cameras.items()}
        self._thread = threading.Thread(target=self._server.serve_forever, name="vencejo-sim-http", daemon=True)
        self._thread.start()

    def stream_url(self, system_id: int) -> str:
        """URL of a plane's stream."""
        return self._url(system_id, "stream.mjpg")

    def snapshot_url(self, system_id: int) -> str:
        """URL of a plane's single pictures."""
        return self._url(system_id, "snapshot.jpg")

    def close(self) -> None:
        """Stop, and end every stream."""
        for camera in self._cameras.values():
            camera.close()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def _url(self, system_id: int, name: str) -> str:
        host, port = self._server.server_address[:2]
        shown = f"[{host!s}]" if ":" in str(host) else str(host)
        first = next(iter(self._cameras))
        return f"http://{shown}:{port}/" + (name if system_id == first else f"{system_id}/{name}")


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    cameras: dict[str, NoseCamera]

    def __init__(self, address: tuple[str, int], handler: type[BaseHTTPRequestHandler]) -> None:
        if ":" in address[0]:
            self.address_family = socket.AF_INET6
        super().__init__(address, handler)
        self.places = threading.BoundedSemaphore(_MAX_VIEWERS)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore errors: only a disconnected viewer raises one."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_version = "VencejoSim"
    sys_version = ""
    timeout = _SILENCE_S
    server: _Server

    def do_GET(self) -> None:
        """Serve the stream or a snapshot; other paths are refused with a list of the valid ones."""
        place, _, name = self.path.partition("?")[0].rpartition("/")
        camera = self.server.cameras.get(place)
        serve = {"stream.mjpg": self._stream, "snapshot.jpg": self._snapshot}.get(name)
        if camera is None or serve is None:
            known = " ".join(f"{p}/stream.mjpg {p}/snapshot.jpg" for p in self.server.cameras)
            self._say(HTTPStatus.NOT_FOUND, f"{self.path!r} does not exist. Available: {known}\n")
            return
        if not self.server.places.acquire(blocking=False):
            self._say(HTTPStatus.SERVICE_UNAVAILABLE, f"There are {_MAX_VIEWERS} viewers already: try again later.\n")
            return
        try:
            with camera:
                serve(camera)
        finally:
            self.server.places.release()

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing to the terminal."""

    def _stream(self, camera: NoseCamera) -> None:
        self.close_connection = True
        self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.send_response(HTTPStatus.OK)
        self._headers(f"multipart/x-mixed-replace;boundary={BOUNDARY}")
        self.send_header("Connection", "close")
        self.end_headers()
        shown = 0
        while (frame := camera.next_frame(shown)) is not None:
            head = (
                f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(frame.jpeg)}\r\n"
                f"X-Timestamp: {frame.unix_s:.6f}\r\n\r\n"
            )
            self.wfile.write(head.encode("ascii") + frame.jpeg + b"\r\n")
            shown = frame.number

    def _snapshot(self, camera: NoseCamera) -> None:
        frame: Frame | None = camera.next_frame()
        if frame is None:
            self._say(HTTPStatus.SERVICE_UNAVAILABLE, "The simulator does not run.\n")
            return
        self.send_response(HTTPStatus.OK)
        self._headers("image/jpeg")
        self.send_header("Content-Length", str(len(frame.jpeg)))
        self.send_header("X-Timestamp", f"{frame.unix_s:.6f}")
        self.end_headers()
        self.wfile.write(frame.jpeg)

    def _headers(self, content_type: str) -> None:
        self.send_header("Content-Type", content_type)
        self.send_header("Cache-Control", "no-store")

    def _say(self, status: HTTPStatus, text: str) -> None:
        data = text.encode("utf-8")
        self.send_response(status)
        self._headers("text/plain; charset=utf-8")
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

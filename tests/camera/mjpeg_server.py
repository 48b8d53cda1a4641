"""A network camera for the tests: MJPEG over HTTP, as the cameras that are sold do it, with faults on demand."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator
from types import TracebackType

import numpy as np
from vencejo.camera import jpeg


def picture(number: int, *, width: int = 64, height: int = 48) -> bytes:
    """A picture of one grey, whose level is its number."""
    return jpeg.encode(np.full((height, width, 3), number % 256, np.uint8))


ALIVE_S = 0.5
"""So often a camera without a new picture sends an empty line between two parts (RFC 2046): it is slow, and not gone."""


class MjpegServer:
    """Serves pictures to whoever connects; `send` decides when the next one goes out.

    Attributes
    ----------
    has_lengths : bool
        Whether parts say their length.
    headers : dict
        Further headers of each part.
    """

    def __init__(self, port: int = 0) -> None:
        self.has_lengths = True
        self.headers: dict[str, str] = {}
        self.password: str | None = None
        self._pictures: list[bytes] = []
        self._changed = threading.Condition()
        self._has_ended = False
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def log_message(self, *_: object) -> None:
                pass

            def do_GET(self) -> None:
                if self.path == "/page":
                    self.send_response(200)
                    self.send_header("Content-Type", "text/html")
                    self.end_headers()
                    return
                if outer.password is not None and self.headers.get("Authorization") != outer.password:
                    self.send_error(401)
                    return
                self.send_response(200)
                self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
                self.end_headers()
                for data in outer._next():
                    part = b"\r\n"
                    if data:
                        part = b"--frame\r\nContent-Type: image/jpeg\r\n"
                        if outer.has_lengths:
                            part += f"Content-Length: {len(data)}\r\n".encode()
                        for name, value in outer.headers.items():
                            part += f"{name}: {value}\r\n".encode()
                        part += b"\r\n" + data + b"\r\n"
                    try:
                        self.wfile.write(part)
                    except OSError:
                        return

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", port), Handler)
        self._server.daemon_threads = True
        self.port = self._server.server_address[1]
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,), daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    def send(self, data: bytes) -> None:
        with self._changed:
            self._pictures.append(data)
            self._changed.notify_all()

    def _next(self) -> Iterator[bytes]:
        """Picture by picture; nothing while there is none, so that whoever reads knows that the camera is there."""
        sent = 0
        while True:
            with self._changed:
                if not self._has_ended and len(self._pictures) <= sent:
                    self._changed.wait(ALIVE_S)
                if self._has_ended:
                    return
                data = self._pictures[sent] if len(self._pictures) > sent else b""
            sent += bool(data)
            yield data

    def close(self) -> None:
        """End it, and every connection; may be called again."""
        with self._changed:
            if self._has_ended:
                return
            self._has_ended = True
            self._changed.notify_all()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join(5.0)

    def __enter__(self) -> MjpegServer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

"""Streams over HTTP.

MJPEG (``multipart/x-mixed-replace``, as most network cameras and the simulated plane's send it) is read here, one JPEG
picture a part; other video goes to FFmpeg.
"""

from __future__ import annotations

import contextlib
import http.client
import ipaddress
import re
import time
import urllib.error
import urllib.request
from base64 import b64encode
from collections.abc import Callable, Iterator
from typing import Any, Final
from urllib.parse import unquote, urlsplit, urlunsplit

from vencejo.camera import jpeg
from vencejo.camera.address import SourceAddress
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame
from vencejo.camera.sources.source import Source

__all__ = ["MjpegSource", "open_http"]

TIMEOUT_S: Final = 5.0
"""A camera that sends nothing for this long is gone, s."""
MAX_PICTURE: Final = 16 << 20
"""Bytes of one picture at most."""
MAX_LINE: Final = 4096
MAX_HEADERS: Final = 32
MAX_CLOCK_ERROR_S: Final = 60.0
"""A time of capture that differs more from ours is ignored, s."""


def open_http(address: SourceAddress) -> Source:
    """Open a stream over HTTP, whatever it holds.

    Raises
    ------
    CameraError
        When the server is not there or refuses.
    """
    response = _get(address.location)
    kind = response.headers.get_content_type()
    if kind == "multipart/x-mixed-replace":
        boundary = response.headers.get_boundary("") or ""
        return MjpegSource(response, boundary, is_local=_is_local(address.location))
    response.close()
    if kind.startswith(("text/", "image/")):
        what = "a page" if kind.startswith("text/") else "a single picture"
        raise CameraError(
            f"{address.shown} gives {what} ({kind}), not video; look up the camera's address for MJPEG or RTSP"
        )
    from vencejo.camera.child import ChildSource

    return ChildSource(address)


class _Digest(urllib.request.HTTPDigestAuthHandler):
    """Some cameras write the algorithm in small letters."""

    def get_algorithm_impls(self, algorithm: str) -> Any:
        return super().get_algorithm_impls(algorithm.upper())


def _get(url: str) -> http.client.HTTPResponse:
    parts = urlsplit(url)
    bare = urlunsplit(parts._replace(netloc=parts.netloc.rpartition("@")[2]))
    user, password = unquote(parts.username or ""), unquote(parts.password or "")
    # User and password go to this address alone, wherever it redirects to; in the clear only to who knows nothing
    # better.
    passwords = urllib.request.HTTPPasswordMgrWithDefaultRealm()
    if user:
        passwords.add_password(None, bare, user, password)
    opener = urllib.request.build_opener(_Digest(passwords))

    def ask(*, is_basic: bool) -> http.client.HTTPResponse:
        request = urllib.request.Request(bare, headers={"Accept": "*/*", "User-Agent": "vencejo"})
        if is_basic:
            secret = b64encode(f"{user}:{password}".encode()).decode()
            request.add_unredirected_header("Authorization", f"Basic {secret}")
        response = opener.open(request, timeout=TIMEOUT_S)
        assert isinstance(response, http.client.HTTPResponse)
        return response

    try:
        try:
            return ask(is_basic=False)
        except urllib.error.HTTPError as error:
            error.close()
            challenge = error.headers.get("WWW-Authenticate", "")
            if error.code != 401 or not user or challenge.lower().startswith("digest"):
                raise
            return ask(is_basic=True)
    except urllib.error.HTTPError as error:
        error.close()
        if error.code == 401:
            raise CameraError(
                "the camera refuses this user or password (401)"
                if user
                else "the camera asks for user and password (401); give them as http://USER:PASSWORD@…"
            ) from error
        raise CameraError(f"the camera answers {error.code} {error.reason}") from error
    except (OSError, http.client.HTTPException, ValueError) as error:
        raise CameraError(f"no answer from {parts.hostname}: {_why(error)}") from error


def _why(error: Exception) -> str:
    inner = error.reason if isinstance(error, urllib.error.URLError) else error
    if isinstance(inner, TimeoutError):
        return f"nothing for {TIMEOUT_S:g} s"
    return (inner.strerror if isinstance(inner, OSError) else None) or str(inner) or type(inner).__name__


def _is_local(url: str) -> bool:
    host = urlsplit(url).hostname or ""
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


class MjpegSource:
    """Pictures of a ``multipart/x-mixed-replace`` answer.

    Parameters
    ----------
    response : HTTPResponse
        What the server answered.
    boundary : str
        What stands between the parts.
    is_local : bool
        Whether the server is on this machine, so that its clock is ours: then the time in ``X-Timestamp`` (seconds
        since 1970) is the time of capture. Otherwise a picture is as old as its way through the network, which nobody
        knows.
    unix_s : callable, optional
        The time of day.
    """

    def __init__(
        self,
        response: http.client.HTTPResponse,
        boundary: str,
        *,
        is_local: bool,
        unix_s: Callable[[], float] = time.time,
    ) -> None:
        self._response = response
        # Some write the dashes into the boundary, some do not.
        self._boundary = b"--" + boundary.strip().removeprefix("--").encode("latin-1", "replace")
        self._is_local = is_local
        self._unix_s = unix_s
        self._is_closed = False

    def frames(self) -> Iterator[EncodedFrame]:
        """Pictures as they come. See `Source`."""
        try:
            while (headers := self._part_headers()) is not None:
                data = self._picture(headers)
                size = jpeg.size(data)
                if size is None:
                    continue  # cut short, or no picture: the next one may be whole
                yield EncodedFrame(
                    data=data,
                    codec="jpeg",
                    captured_unix_s=self._captured_unix_s(headers),
                    is_key=True,
                    width=size[0],
                    height=size[1],
                )
        except (OSError, http.client.HTTPException, ValueError, AttributeError) as error:
            if not self._is_closed:  # closing takes the socket away from under the reader
                raise CameraError(f"the stream broke off: {_why(error)}") from error
        finally:
            self.close()

    def close(self) -> None:
        """End it. See `Source`."""
        self._is_closed = True
        with contextlib.suppress(OSError, ValueError):
            self._response.close()

    def _line(self) -> bytes:
        line = self._response.readline(MAX_LINE)
        if len(line) >= MAX_LINE:
            raise ValueError("a line of a header is too long")
        return line

    def _part_headers(self) -> dict[str, str] | None:
        """Headers of the next part, in small letters; ``None`` at the end."""
        while not (line := self._line()).startswith(self._boundary):
            if not line:
                return None
        if line.rstrip().endswith(b"--") and line.rstrip() != self._boundary:
            return None
        headers: dict[str, str] = {}
        for _ in range(MAX_HEADERS):
            line = self._line().strip()
            if not line:
                return headers
            name, _, value = line.decode("latin-1").partition(":")
            headers[name.strip().lower()] = value.strip()
        raise ValueError("a part has too many headers")

    def _picture(self, headers: dict[str, str]) -> bytes:
        length = headers.get("content-length", "")
        if length.isdecimal():
            count = int(length)
            if not 0 < count <= MAX_PICTURE:
                raise ValueError(f"a picture of {count} bytes")
            data = self._response.read(count)
            if len(data) < count:
                raise ValueError("it ended inside a picture")
            return data
        # Without a length the picture ends at its end mark: no line of it can hold a boundary before.
        data_parts = bytearray()
        while not data_parts.rstrip(b"\r\n").endswith(jpeg.END):
            line = self._response.readline(MAX_LINE)
            if not line:
                raise ValueError("it ended inside a picture")
            data_parts += line
            if len(data_parts) > MAX_PICTURE:
                raise ValueError("a picture does not end")
        return bytes(data_parts.rstrip(b"\r\n"))

    def _captured_unix_s(self, headers: dict[str, str]) -> float:
        now = self._unix_s()
        said = headers.get("x-timestamp", "")
        if self._is_local and re.fullmatch(r"\d{1,12}(\.\d{1,9})?", said):
            at = float(said)
            if now - MAX_CLOCK_ERROR_S <= at <= now + 0.1:
                return min(at, now)
        return now

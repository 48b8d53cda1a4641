"""Why a server gives no video. FFmpeg does not report it, so the server is asked once more directly.

Only after FFmpeg has failed: there are cameras that serve one connection, and end when it does.
"""

from __future__ import annotations

import socket
from typing import Final
from urllib.parse import urlsplit, urlunsplit

__all__ = ["why_not"]

TIMEOUT_S: Final = 5.0
MAX_ANSWER: Final = 4096
PORTS: Final = {"rtsp": 554, "rtsps": 322, "rtmp": 1935, "http": 80, "https": 443}


def why_not(url: str) -> str | None:
    """What is wrong with a server, as a sentence; ``None`` if it is not known.

    Parameters
    ----------
    url : str
        ``rtsp://`` servers are asked for their video (RFC 2326, DESCRIBE), others only whether they are there. User and
        password in it are not sent.
    """
    parts = urlsplit(url)
    port = parts.port or PORTS.get(parts.scheme)
    if parts.scheme not in {*PORTS, "tcp"} or not parts.hostname or port is None:
        return None
    shown = f"[{parts.hostname}]" if ":" in parts.hostname else parts.hostname
    try:
        with socket.create_connection((parts.hostname, port), TIMEOUT_S) as connection:
            if parts.scheme != "rtsp":
                return None
            connection.settimeout(TIMEOUT_S)
            bare = urlunsplit(parts._replace(netloc=f"{shown}:{port}"))
            question = f"DESCRIBE {bare} RTSP/1.0\r\nCSeq: 1\r\nAccept: application/sdp\r\nUser-Agent: vencejo\r\n\r\n"
            connection.sendall(question.encode("utf-8", "replace"))
            try:
                answer = connection.recv(MAX_ANSWER)
            except TimeoutError:
                return f"{shown}:{port} takes the connection and does not answer"
    except OSError as error:
        return f"no answer from {shown}:{port}: {error.strerror or error}"
    version, _, rest = answer.partition(b"\r\n")[0].decode("latin-1").partition(" ")
    code = rest.partition(" ")[0]
    if not version.startswith("RTSP/") or not code.isdecimal():
        return f"{shown}:{port} does not speak RTSP"
    if code == "200":
        return f"{shown}:{port} has something at {parts.path or '/'}, but no video came that can be read"
    if code == "401":
        if parts.username is None:
            return "the camera asks for user and password (401); give them as rtsp://USER:PASSWORD@…"
        return "the camera refuses this user or password (401)"
    if code == "404":
        return f"the camera has nothing at {parts.path or '/'} (404): its manual names the path"
    said = "".join(character for character in rest if character.isprintable())
    return f"the camera answers {said[:80]}"

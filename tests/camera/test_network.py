"""Cameras in the network that refuse, ask for a password, or serve one connection only: what people are told, and what nobody is."""

from __future__ import annotations

import hashlib
import http.server
import re
import socket
import threading
from collections.abc import Callable, Iterator

import pytest
from vencejo.camera import Camera, CameraError, CameraState
from vencejo.camera.address import SourceKind, parse_source
from vencejo.camera.sources.http import open_http
from vencejo.camera.sources.reasons import why_not

from tests.support import reserved_ports, wait_for


@pytest.fixture
def rtsp() -> Iterator[Callable[[bytes], str]]:
    """Starts a server that answers each question alike; gives its address."""
    listeners: list[socket.socket] = []
    asked: list[bytes] = []

    def serve(answer: bytes) -> str:
        listener = socket.create_server(("127.0.0.1", 0))
        listeners.append(listener)

        def run() -> None:
            while True:
                try:
                    connection, _ = listener.accept()
                except OSError:
                    return
                with connection:
                    asked.append(connection.recv(4096))
                    connection.sendall(answer)

        threading.Thread(target=run, daemon=True).start()
        return f"127.0.0.1:{listener.getsockname()[1]}"

    yield serve
    for listener in listeners:
        listener.close()
    assert b"s3cret" not in b"".join(asked)


@pytest.mark.parametrize(
    ("answer", "user", "words"),
    [
        (b"RTSP/1.0 401 Unauthorized\r\n\r\n", "", "give them as rtsp://USER:PASSWORD@"),
        (b"RTSP/1.0 401 Unauthorized\r\n\r\n", "me:s3cret@", "refuses this user or password"),
        (b"RTSP/1.0 404 Not Found\r\n\r\n", "me:s3cret@", "nothing at /live"),
        (b"RTSP/1.0 453 Not Enough\x1b[31m Bandwidth\r\n\r\n", "", "453 Not Enough[31m Bandwidth"),
        (b"RTSP/1.0 200 OK\r\n\r\n", "", "no video came"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "", "does not speak RTSP"),
        (b"", "", "does not speak RTSP"),
    ],
)
def test_an_rtsp_server_is_asked_why_it_gives_no_video(
    rtsp: Callable[[bytes], str], answer: bytes, user: str, words: str
) -> None:
    address = rtsp(answer)
    reason = why_not(f"rtsp://{user}{address}/live")
    assert reason is not None
    assert words in reason
    assert "s3cret" not in reason
    assert reason.isprintable()


def test_a_camera_says_what_its_server_answers(rtsp: Callable[[bytes], str]) -> None:
    address = rtsp(b"RTSP/1.0 404 Not Found\r\nCSeq: 1\r\n\r\n")
    with Camera(f"rtsp://me:s3cret@{address}/live") as camera:
        wait_for(lambda: camera.status.state is CameraState.DEAD, "dead")
        assert "nothing at /live" in str(camera.status.reason)
        assert "s3cret" not in repr(camera) + str(camera.status)


def test_a_server_that_is_not_there_or_of_which_nothing_is_known() -> None:
    with reserved_ports() as (port,):
        assert "refused" in str(why_not(f"tcp://127.0.0.1:{port}"))
        assert "refused" in str(why_not(f"rtsp://127.0.0.1:{port}/"))
    assert why_not("udp://127.0.0.1:5600") is None


class Guarded(http.server.BaseHTTPRequestHandler):
    """Asks for a user in one of two ways; sends others elsewhere."""

    authorizations: list[str | None]

    def log_message(self, *_: object) -> None:
        pass

    def do_GET(self) -> None:
        said = self.headers.get("Authorization")
        self.authorizations.append(said)
        if self.path == "/elsewhere":
            self.send_response(302)
            port = self.server.server_address[1]  # type: ignore[index]
            self.send_header("Location", f"http://localhost:{port}/digest")
            self.end_headers()
            return
        is_let_in = self.path == "/open" or (
            self._is_digest(said) if self.path == "/digest" else said == "Basic bWU6czNjcmV0"
        )
        if not is_let_in:
            self.send_response(401)
            if self.path == "/digest":
                self.send_header("WWW-Authenticate", 'Digest realm="camera", nonce="abc", qop="auth", algorithm="md5"')
            elif self.path == "/basic":
                self.send_header("WWW-Authenticate", 'Basic realm="camera"')
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.end_headers()

    def _is_digest(self, said: str | None) -> bool:
        # RFC 2617, section 3.2.2.
        fields = dict(re.findall(r'(\w+)="?([^",]+)"?', said or ""))
        if not (said or "").startswith("Digest "):
            return False

        def md5(text: str) -> str:
            return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()

        secret, asked = md5("me:camera:s3cret"), md5(f"GET:{fields['uri']}")
        parts = (secret, fields["nonce"], fields["nc"], fields["cnonce"], fields["qop"], asked)
        return bool(fields["response"] == md5(":".join(parts)))


@pytest.fixture
def guarded() -> Iterator[int]:
    Guarded.authorizations = []
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Guarded)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    yield server.server_address[1]
    server.shutdown()
    server.server_close()
    thread.join(5.0)


@pytest.mark.parametrize("path", ["basic", "digest", "mute"])
def test_a_password_is_given_the_way_it_is_asked_for(guarded: int, path: str) -> None:
    open_http(parse_source(f"http://me:s3cret@127.0.0.1:{guarded}/{path}")).close()
    sent = [said.partition(" ")[0] for said in Guarded.authorizations if said is not None]
    assert sent == ["Digest" if path == "digest" else "Basic"]
    with pytest.raises(CameraError, match="refuses this user or password"):
        open_http(parse_source(f"http://me:wrong@127.0.0.1:{guarded}/{path}"))
    with pytest.raises(CameraError, match="asks for user and password"):
        open_http(parse_source(f"http://127.0.0.1:{guarded}/{path}"))


def test_a_password_does_not_follow_a_redirect_to_another_host(guarded: int) -> None:
    with pytest.raises(CameraError):
        open_http(parse_source(f"http://me:s3cret@127.0.0.1:{guarded}/elsewhere"))
    assert not any(Guarded.authorizations)


def test_nobody_is_asked_before_ffmpeg_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """`rpicam-vid --listen` and the like serve one connection, and end with it."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = parse_source(f"tcp://127.0.0.1:{listener.getsockname()[1]}")
        assert address.kind is SourceKind.STREAM
        connections: list[int] = []

        def serve() -> None:
            connection, peer = listener.accept()
            connections.append(peer[1])
            with connection:
                connection.sendall(b"no video")

        threading.Thread(target=serve, daemon=True).start()
        monkeypatch.setattr("vencejo.camera.sources.ffmpeg.why_not", lambda _: f"after {len(connections)}")
        from vencejo.camera.sources.ffmpeg import open_stream

        with pytest.raises(CameraError, match="after 1"):
            open_stream(address)

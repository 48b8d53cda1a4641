"""Many connections to the server while a plane's link has to recover: few descriptors, one client taking them."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import wait_for

pytestmark = pytest.mark.e2e

HALF = (
    b"POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{"
)


@pytest.mark.fault(47, figure="245 half-sent bodies at 256 descriptors: the link comes back, people are answered")
def test_half_sent_bodies_leave_the_planes_link_its_descriptors(tmp_path: Path) -> None:
    """256 descriptors, 245 incomplete bodies: the link to the plane recovers, and other clients are answered."""
    with contextlib.ExitStack() as stack:
        plane = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        plane.settimeout(120.0)
        command = [sys.executable, "-m", "vencejo.cli", "serve", "--json", "--port", "0", "--no-record"]
        command += ["--link", f"tcp:127.0.0.1:{plane.getsockname()[1]}"]
        served = stack.enter_context(
            subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                env={**os.environ, "VENCEJO_DATA": str(tmp_path)},
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256)),
            )
        )
        stack.callback(served.terminate)
        assert served.stdout is not None
        url = json.loads(served.stdout.readline())["url"]
        port = int(url.rsplit(":", 1)[1])
        first, _ = plane.accept()
        halves = [stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=120.0)) for _ in range(245)]
        for half in halves:
            with contextlib.suppress(OSError):  # it may have been closed for another already
                half.sendall(HALF)
        first.close()
        again, _ = plane.accept()
        stack.enter_context(again)

        def answered() -> bool:
            with socket.create_connection(("127.0.0.1", port), timeout=120.0) as asking:
                asking.sendall(b"GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                return asking.recv(12) == b"HTTP/1.1 200"

        wait_for(answered, "an answer")
        held = len(list(Path(f"/proc/{served.pid}/fd").iterdir()))
        assert held < 200, f"{held} descriptors of 256 are taken"

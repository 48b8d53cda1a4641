"""A router that speaks in the clear and TLS, and somebody of ROS 2 at it who reads and asks: `ros2_witness`, as tests use it."""

from __future__ import annotations

import contextlib
import itertools
import os
import struct
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vencejo.enrolment import Organisation

from tests.fleet.ros2_lines import Asked, asked
from tests.fleet.ros2_offered import key
from tests.fleet.ros2_types import Types
from tests.support import reserved_ports

__all__ = ["Witness", "a_witness"]


class Witness:
    """A router, and somebody at it."""

    def __init__(self, program: Asked, port: int, tls_port: int, ca: Path) -> None:
        self.ask = program.ask
        self.ca = ca
        self.port = port
        self.router = f"tcp/127.0.0.1:{port}"
        self.tls = f"tls/127.0.0.1:{tls_port}"
        self.types = Types()
        self._numbers = itertools.count(1)

    def hear(self, name: str, kind: str, domain: int = 0, count: int = 1) -> list[tuple[Any, int, int]]:
        """Messages, each with its number and when it was sent, ns."""
        found = []
        for sample in self.ask("hear", key=key(self.types, domain, name, kind), count=count):
            number, sent_ns, length, _gid = struct.unpack("<qqB16s", bytes.fromhex(sample["attachment"]))
            assert length == 16
            found.append((self.types.read(bytes.fromhex(sample["payload"]), kind), number, sent_ns))
        return found

    def heard(self, name: str, kind: str, domain: int = 0, count: int = 1) -> list[Any]:
        """All messages of a topic since it listens, so many at least."""
        [samples] = self.ask("heard", keys=[key(self.types, domain, name, kind)], count=count)
        return [self.types.read(bytes.fromhex(sample["payload"]), kind) for sample in samples]

    def offered(self, domain: int) -> set[str]:
        """Tokens of a domain, without sessions and numbers."""
        found = set()
        for token in self.ask("tokens"):
            _, of, _session, _node, _id, *rest = token.split("/")
            if of == str(domain):
                found.add(f"{domain} {'/'.join(rest)}")
        return found

    def said(self, name: str, kind: str, domain: int = 0) -> bytes:
        """The bytes of the newest message of a topic since it listens."""
        [[*_, sample]] = self.ask("heard", keys=[key(self.types, domain, name, kind)], count=1)
        return bytes.fromhex(sample["payload"])

    def answer(self, name: str, kind: str, domain: int, payload: bytes) -> bytes:
        """The bytes of the one answer of a service."""
        number, gid = next(self._numbers), bytes(range(16))
        attachment = struct.pack("<qqB", number, time.time_ns(), 16) + gid
        at = key(self.types, domain, name, kind)
        [reply] = self.ask("call", key=at, payload=payload.hex(), attachment=attachment.hex())
        echoed = struct.unpack("<qqB16s", bytes.fromhex(reply["attachment"]))
        assert (echoed[0], echoed[2:]) == (number, (16, gid))
        return bytes.fromhex(reply["payload"])

    def call(self, name: str, kind: str, domain: int = 0, **request: object) -> Any:
        """The one answer of a service."""
        answer = self.answer(name, kind, domain, self.types.write(f"{kind}_Request", **request))
        return self.types.read(answer, f"{kind}_Response")


@contextlib.contextmanager
def a_witness() -> Iterator[Witness]:
    """One, whose router has a robot's certificate for TLS."""
    Organisation("robot").init(hosts=["127.0.0.1"])
    papers = Path(os.environ["VENCEJO_DATA"]) / "fleet" / "robot"
    with (
        reserved_ports(2) as [port, tls_port],
        asked("tests.fleet.ros2_witness", port, tls_port, papers / "station.crt", papers / "station.key") as program,
    ):
        yield Witness(program, port, tls_port, papers / "ca.crt")

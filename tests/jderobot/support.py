"""A driver with its Ice interfaces as a process of its own, and a client that knows only the Slice files."""

from __future__ import annotations

import bz2
import contextlib
import os
import re
import resource
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.server.client import Served, serving
from tests.support import ROOT, wait_for

SLICE = ROOT / "slice"
INTERFACES = ("Camera", "Pose3D", "Navdata", "CMDVel", "Extra", "Mission", "Precise")
ANY_PORT = {f"{name}.Endpoints": "tcp -h 127.0.0.1 -p 0" for name in INTERFACES}
READY_S = 120.0
NODE = ROOT / "examples" / "jderobot"


@contextlib.contextmanager
def driver(link: str, *options: str, data: Path, ports: Mapping[str, str] = ANY_PORT) -> Iterator[Served]:
    """`vencejo serve --ice` on free ports."""
    settings = [part for name, value in ports.items() for part in ("--ice-set", f"{name}={value}")]
    with serving("--link", link, "--ice", *settings, *options, data=data) as served:
        yield served


@dataclass
class Client:
    """A client: types that Ice made of the Slice files, and proxies as a configuration has them."""

    ice: Any
    jderobot: Any
    precise: Any
    communicator: Any
    proxies: Mapping[str, str]

    def proxy(self, interface: str, type_name: str | None = None, *, facet: str = "") -> Any:
        """A proxy of an interface, checked by asking the server what it is."""
        text = self.proxies[interface]
        if interface == "Precise":
            module, type_name = self.precise, type_name or "Telemetry"
            text = text.replace("_telemetry", f"_{type_name.lower()}")
        else:
            module, type_name = self.jderobot, {"Extra": "ArDroneExtra"}.get(interface, interface)
        found = getattr(module, f"{type_name}Prx").checkedCast(self.communicator.stringToProxy(text))
        assert found is not None, f"{text} is no {type_name}"
        return found

    @property
    def pose(self) -> Any:
        """Pose3D."""
        return self.proxy("Pose3D")

    @property
    def navdata(self) -> Any:
        """Navdata."""
        return self.proxy("Navdata")

    @property
    def extra(self) -> Any:
        """ArDroneExtra."""
        return self.proxy("Extra")

    @property
    def velocity(self) -> Any:
        """CMDVel."""
        return self.proxy("CMDVel")

    @property
    def mission(self) -> Any:
        """Mission."""
        return self.proxy("Mission")

    @property
    def camera(self) -> Any:
        """Camera."""
        return self.proxy("Camera")

    @property
    def telemetry(self) -> Any:
        """Precise telemetry."""
        return self.proxy("Precise", "Telemetry")

    @property
    def missions(self) -> Any:
        """Precise missions."""
        return self.proxy("Precise", "Missions")

    @property
    def control(self) -> Any:
        """Precise control."""
        return self.proxy("Precise", "Control")

    def mission_data(self, *poses: tuple[float, float, float]) -> Any:
        """A mission of latitudes, longitudes and heights above home."""
        return self.jderobot.MissionData(
            [self.jderobot.Pose3DData(x=lat, y=lon, h=height, q0=1.0) for lat, lon, height in poses]
        )

    def wait_ready(self) -> None:
        """Wait until the vehicle is heard and its own checks pass."""
        control, jderobot_ready = self.control, self.telemetry
        wait_for(lambda: 1 in jderobot_ready.vehicles(), "a vehicle", READY_S)

        def passes() -> bool:
            navigation = jderobot_ready.getNavigation(0)
            return navigation.isReadyToArm is True and navigation.homeLatDeg is not self.ice.Unset

        wait_for(passes, "the vehicle's own checks", READY_S)
        assert control.modes(0), "its modes are known"


def load_slices(*names: str) -> tuple[Any, Any, Any]:
    """What any Python client does: ``Ice.loadSlice``. Gives Ice, module jderobot and module vencejo."""
    import Ice

    files = [str(SLICE / "jderobot" / f"{name}.ice") for name in names]
    Ice.loadSlice("", ["--all", f"-I{SLICE}", *files, str(SLICE / "vencejo" / "vencejo.ice")])
    return Ice, sys.modules["jderobot"], sys.modules["vencejo_ice.vencejo"]


@contextlib.contextmanager
def client_of(proxies: Mapping[str, str], **properties: str) -> Iterator[Client]:
    """A client in this process."""
    ice, jderobot, precise = load_slices("camera", "pose3d", "navdata", "ardroneextra", "cmdvel", "mission")
    data = ice.InitializationData()
    data.properties = ice.createProperties()
    for name, value in properties.items():
        data.properties.setProperty(name.replace("_", "."), value)
    with ice.initialize(data) as communicator:
        yield Client(ice, jderobot, precise, communicator, proxies)


def javascript(folder: Path) -> None:
    """Bring a folder to where a program in it can say ``require("ice")`` and ``require("jderobot/mission")``."""
    modules = folder / "node_modules"
    modules.mkdir()
    (folder / "package.json").write_text("{}")
    (modules / "ice").symlink_to(NODE / "node_modules" / "ice")
    subprocess.run(["node", str(NODE / "slices.js"), str(modules)], check=True, timeout=60)


def example(language: str, proxies: Mapping[str, str], folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run the example client of a language, its proxies from the environment."""
    named = {"Pose3D": "pose3d", "Navdata": "navdata", "Extra": "extra", "Mission": "mission"}
    env = {**os.environ, **{f"ardrone_{name}": proxies[interface] for interface, name in named.items()}}
    if language == "python":
        command = [sys.executable, str(NODE / "client.py")]
    else:
        javascript(folder)
        (folder / "client.js").write_text((NODE / "client.js").read_text(encoding="utf-8"), encoding="utf-8")
        command = ["node", str(folder / "client.js")]
    return subprocess.run([*command, *options], env=env, capture_output=True, text=True, timeout=120, check=False)


OPERATION = re.compile(
    r'^\s*(?:\["amd"\]\s*)?(?:idempotent\s+)?(?:void|int|string|\w+)\s+(\w+)\(([^)]*)\)', re.MULTILINE
)


def operations() -> set[str]:
    """Every operation of the Slice files, as ``Interface.operation``; callbacks that clients implement left out."""
    found = set()
    for path in sorted(SLICE.rglob("*.ice")):
        text = re.sub(r"/\*.*?\*/|//[^\n]*", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        for interface, body in re.findall(r"interface (\w+)[^{]*\{(.*?)\n    \}", text, re.DOTALL):
            if interface != "Observer":
                found |= {f"{interface}.{name}" for name, _ in OPERATION.findall(body)}
    return found


def raw(address: tuple[str, int]) -> socket.socket:
    """A connection by Ice's protocol alone, its greeting read."""
    connection = socket.create_connection(address, timeout=120)
    greeting = connection.recv(14)
    assert greeting == b"IceP\x01\x00\x01\x00\x03\x00" + struct.pack("<I", 14), "ValidateConnection (Ice protocol 1.0)"
    return connection


def message(
    kind: int, body: bytes = b"", *, size: int | None = None, magic: bytes = b"IceP", compressed: bool = False
) -> bytes:
    """A message of Ice's protocol; 0 is a request."""
    size = 14 + len(body) if size is None else size
    return magic + bytes([1, 0, 1, 0, kind, 2 if compressed else 0]) + struct.pack("<I", size) + body


@contextlib.contextmanager
def many_files(count: int) -> Iterator[None]:
    """Let this process open so many files for the length of a block."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < count:
        assert hard == resource.RLIM_INFINITY or hard >= count, "this machine allows too few open files for the test"
        resource.setrlimit(resource.RLIMIT_NOFILE, (count, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


REQUEST = struct.pack("<I", 1) + b"\x0eardrone_pose3d\x00" + b"\x00" + b"\x0dgetPose3DData" + b"\x02" + b"\x00"
"""Request 1: identity, no facet, operation, idempotent, no context; the encapsulation follows."""
EMPTY = struct.pack("<I", 6) + b"\x01\x01"
MALFORMED = {
    "http": b"GET / HTTP/1.1\r\nHost: x\r\n\r\n",
    "magic": message(0, REQUEST + EMPTY, magic=b"IceQ"),
    "small": message(0, b"", size=3),
    "huge": message(0, REQUEST + EMPTY, size=0x7FFFFFFF),
    "oversize": message(0, REQUEST + EMPTY, size=2 * 1024 * 1024),
    "type": message(99, b"?" * 32),
    "string": message(0, struct.pack("<I", 1) + b"\xff" + struct.pack("<I", 0x7FFFFFFF) + b"a" * 64),
    "batch": message(1, struct.pack("<i", -5) + b"x" * 64),
    "encapsulation": message(0, REQUEST + struct.pack("<I", 0x0FFFFFFF) + b"\x01\x01"),
    # Eight megabytes in a few bytes, under their own size and under that of a small message.
    "bomb": message(0, struct.pack("<I", 8 * 2**20) + bz2.compress(bytes(8 * 2**20)), compressed=True),
    "disguised bomb": message(0, struct.pack("<I", 64 * 1024) + bz2.compress(bytes(8 * 2**20)), compressed=True),
    "no bzip2": message(0, struct.pack("<I", 2**31 - 1) + b"BZh9" + bytes(64), compressed=True),
}
"""Messages that no client sends, by what is wrong with them."""


class Relay:
    """A network between two programs that can be cut: what is connected through it hangs up, and nobody gets in."""

    def __init__(self, to: tuple[str, int]) -> None:
        self._to = to
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._lock = threading.Lock()
        self._open: list[socket.socket] = []
        self._is_cut = False
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def port(self) -> int:
        """Where to connect to."""
        return int(self._listener.getsockname()[1])

    def cut(self) -> None:
        """Cut it."""
        with self._lock:
            self._is_cut = True
            for end in self._open:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
            self._open.clear()

    def restore(self) -> None:
        """Bring it back."""
        with self._lock:
            self._is_cut = False

    def close(self) -> None:
        """End it."""
        self.cut()
        self._listener.close()

    def __enter__(self) -> Relay:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _accept(self) -> None:
        while True:
            try:
                here, _ = self._listener.accept()
            except OSError:
                return
            with self._lock:
                if self._is_cut:
                    here.close()
                    continue
                try:
                    there = socket.create_connection(self._to)
                except OSError:
                    here.close()
                    continue
                self._open += [here, there]
            for one, other in ((here, there), (there, here)):
                threading.Thread(target=self._pass_on, args=(one, other), daemon=True).start()

    @staticmethod
    def _pass_on(one: socket.socket, other: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := one.recv(65536):
                other.sendall(data)
        with contextlib.suppress(OSError):
            other.shutdown(socket.SHUT_RDWR)
        with contextlib.suppress(OSError):
            one.close()


def address_of(link: str) -> tuple[str, int]:
    """Host and port of a link string or an Ice proxy."""
    ice = re.search(r"-h (\S+) -p (\d+)", link)
    if ice is not None:
        return ice[1], int(ice[2])
    host, _, port = link.removeprefix("tcp:").rpartition(":")
    return host, int(port)

"""What can be set about the Ice interfaces, and where it is read from.

Every setting has one name in all three places: ``Pose3D.Endpoints`` is ``--ice-set Pose3D.Endpoints=…`` on the command
line, ``Vencejo.Pose3D.Endpoints=…`` in an Ice ``.cfg`` file, and ``[ice.Pose3D]`` with ``Endpoints = "…"`` in Vencejo's
own configuration (TOML). The command line comes before the ``.cfg`` file, and that before the configuration.
"""

from __future__ import annotations

import contextlib
import ipaddress
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from vencejo._files import read_small
from vencejo.errors import InvalidRequest
from vencejo.jderobot.runtime import Dialect

__all__ = [
    "INTERFACES",
    "IceSettings",
    "Interface",
    "MissionPolicy",
    "OldPictures",
    "default_config_file",
    "read_cfg",
    "read_config",
]

OldPictures: TypeAlias = Literal["mark", "raise"]
"""What a camera that gives nothing new is answered with: its last picture, marked with its age, or an exception."""
MissionPolicy: TypeAlias = Literal["fly", "upload"]
"""What a mission over the JdeRobot interfaces does: fly it, or stop before arming."""
Network: TypeAlias = ipaddress.IPv4Network | ipaddress.IPv6Network


@dataclass(frozen=True)
class Interface:
    """One of the interfaces.

    Attributes
    ----------
    port : int
        TCP port that existing configurations use.
    identity : str
        Name of its object.
    also : tuple of str
        Other names that it answers to, which clients in use have in their configurations.
    """

    port: int
    identity: str
    also: tuple[str, ...] = ()


INTERFACES: Final[Mapping[str, Interface]] = {
    "Camera": Interface(9999, "cameraA", also=("ardrone_camera",)),
    "Pose3D": Interface(9998, "ardrone_pose3d"),
    "Navdata": Interface(9996, "ardrone_navdata"),
    "CMDVel": Interface(9995, "ardrone_cmdvel"),
    "Extra": Interface(9994, "ardrone_extra"),
    "Mission": Interface(10008, "ardrone_mission"),
    "Precise": Interface(10009, "vencejo"),
}
"""The interfaces by the names of their settings. ``Precise`` is module ``vencejo``: three objects at one port, their
identities ``vencejo_telemetry``, ``vencejo_missions`` and ``vencejo_control``."""

_ENDPOINTS: Final = re.compile(r":(?=\s*(?:default|tcp|ssl|ws|wss|udp)\b)")
"""Between two endpoints: IPv6 addresses have colons too."""
_COMMENT: Final = re.compile(r"(?<!\\)#.*")
_SEPARATOR: Final = re.compile(r"(?<!\\)=")
_ESCAPED: Final = re.compile(r"\\([#=\\ ])")
"""In a ``.cfg`` file of Ice, where a backslash makes ``#``, ``=``, itself and a space mean themselves."""
_CFG_PREFIXES: Final = ("Vencejo.", "ArDrone.", "APMServer.")
"""Whose properties a ``.cfg`` file may hold: ours, and those that configurations of older drivers use."""


@dataclass(frozen=True, kw_only=True)
class IceSettings:
    """Settings of the Ice interfaces.

    Attributes
    ----------
    host : str
        Address or name to listen on, default ``"127.0.0.1"``.
    endpoints : mapping of str to str
        Ice endpoints of single interfaces in place of ``tcp -h HOST -p PORT``; an empty one switches the interface off.
    names : mapping of str to str
        Identities of single interfaces.
    dialect : {"data", "sequence"}
        Of Mission for clients that have sent none yet, default ``"data"``; both are served.
    missions : {"fly", "upload"}
        Whether a mission is flown, or only sent. Default ``"fly"``, which existing programs rely on.
    system_id : int or None
        Which vehicle; ``None``, the default, is the first that is heard.
    alone_after_s : float
        When take-off or landing of ArDroneExtra act without a mission, 0.5 to 600 s, default 5.
    takeoff_alt_m : float
        Height above home of such a take-off, 5 to 500 m, default 50.
    watchdog_s : float
        How long a velocity holds without a new one, 0.1 to 5 s, default 0.5.
    allow : tuple of networks
        Who needs no token when others than this machine are let in.
    max_connections : int
        Connections at once over all interfaces, 1 to 65,536, default 2,048; those beyond are closed.
    max_message_kib : int
        The largest message that is taken, 16 to 65,536 KiB, default 1,024.
    camera_width, camera_height : int
        The largest picture that is given, default 640 by 480, which Ice's own message limit lets through.
    camera_rate_hz : float
        Pictures a second at most, 0.1 to 60, default 30.
    old_pictures : {"mark", "raise"}
        What is given while a camera fails: its last picture, marked with its age (the default, because an exception
        ends the thread of viewers in use for good), or an exception.
    properties : mapping of str to str
        Other Ice properties, such as ``Ice.Trace.Network`` or those of IceSSL.
    """

    host: str = "127.0.0.1"
    endpoints: Mapping[str, str] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    dialect: Dialect = "data"
    missions: MissionPolicy = "fly"
    system_id: int | None = None
    alone_after_s: float = 5.0
    takeoff_alt_m: float = 50.0
    watchdog_s: float = 0.5
    allow: tuple[Network, ...] = ()
    max_connections: int = 2048
    max_message_kib: int = 1024
    camera_width: int = 640
    camera_height: int = 480
    camera_rate_hz: float = 30.0
    old_pictures: OldPictures = "mark"
    properties: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in (*self.endpoints, *self.names):
            if name not in INTERFACES:
                raise InvalidRequest(f"{name!r} is no interface; they are {', '.join(INTERFACES)}")
        for name, low, high in _RANGES:
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise InvalidRequest(f"{name} is {value}, should be {low:g} to {high:g}")
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise InvalidRequest(f"{name} is {getattr(self, name)!r}: it is {' or '.join(choices)}")

    def endpoint(self, interface: str) -> str:
        """Ice endpoints of an interface; empty when it is off."""
        own = self.endpoints.get(interface)
        return f"tcp -h {self.host} -p {INTERFACES[interface].port}" if own is None else own

    @property
    def lets_others_in(self) -> bool:
        """Whether an interface listens on more than this machine's own address, as far as the endpoints say."""
        return any(not _is_local(self.endpoint(interface)) for interface in INTERFACES)

    def identity(self, interface: str) -> str:
        """Name of an interface's object."""
        return self.names.get(interface, INTERFACES[interface].identity)

    def identities(self, interface: str) -> tuple[str, ...]:
        """All names that an interface's object answers to, its own first."""
        return tuple(dict.fromkeys((self.identity(interface), *INTERFACES[interface].also)))

    def with_settings(self, given: Mapping[str, str], *, where: str) -> IceSettings:
        """These settings with others by their names.

        Parameters
        ----------
        given : mapping of str to str
            Such as ``{"Pose3D.Endpoints": "tcp -p 9998", "Missions": "upload"}``.
        where : str
            Where they stand, for the text of an error.

        Raises
        ------
        InvalidRequest
            For a name that is none, or a value that cannot be.
        """
        known = {name.lower(): name for name in INTERFACES}
        endpoints, names, simple = dict(self.endpoints), dict(self.names), {}
        for key, value in given.items():
            interface, _, what = key.rpartition(".")
            if interface.lower() in known and what.lower() in ("endpoints", "name"):
                target = endpoints if what.lower() == "endpoints" else names
                target[known[interface.lower()]] = value.strip()
                continue
            if interface.lower() in known and what.lower() == "proxy":
                raise InvalidRequest(
                    f"{where}: {key} is a client's setting; a driver has {interface}.Endpoints, such as "
                    f"'tcp -h 127.0.0.1 -p {INTERFACES[known[interface.lower()]].port}', and {interface}.Name"
                )
            setting = _SETTINGS.get(key.lower())
            if setting is None:
                raise InvalidRequest(f"{where}: {key!r} is not a setting; they are {', '.join(setting_names())}")
            name, read = setting
            try:
                simple[name] = read(value.strip())
            except ValueError as error:
                raise InvalidRequest(f"{where}: {key} is {value!r}: {error}") from None
        try:
            return replace(self, endpoints=endpoints, names=names, **simple)
        except InvalidRequest as error:
            raise InvalidRequest(f"{where}: {error}") from None


def _is_local(endpoints: str) -> bool:
    """Whether each of some Ice endpoints names a loopback address; without ``-h`` Ice listens on all."""
    hosts = [re.search(r"(?:^|\s)-h\s+(\S+)", endpoint) for endpoint in _ENDPOINTS.split(endpoints) if endpoint.strip()]
    return all(host is not None and is_loopback(host[1].strip("\"'")) for host in hosts)


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach an address or name."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def _system(text: str) -> int | None:
    return int(text) or None


def _networks(text: str) -> tuple[Network, ...]:
    return tuple(ipaddress.ip_network(part.strip(), strict=False) for part in text.split(",") if part.strip())


_SETTINGS: Final[Mapping[str, tuple[str, Callable[[str], Any]]]] = {
    "host": ("host", str),
    "dialect": ("dialect", str),
    "missions": ("missions", str),
    "system": ("system_id", _system),
    "aloneafter": ("alone_after_s", float),
    "takeoffaltitude": ("takeoff_alt_m", float),
    "watchdog": ("watchdog_s", float),
    "allow": ("allow", _networks),
    "maxconnections": ("max_connections", int),
    "maxmessagekib": ("max_message_kib", int),
    "camera.width": ("camera_width", int),
    "camera.height": ("camera_height", int),
    "camera.rate": ("camera_rate_hz", float),
    "camera.oldpictures": ("old_pictures", str),
}

_NAMES: Final = (
    "Host", "Dialect", "Missions", "System", "AloneAfter", "TakeoffAltitude", "Watchdog", "Allow", "MaxConnections",
    "MaxMessageKiB", "Camera.Width", "Camera.Height", "Camera.Rate", "Camera.OldPictures",
)  # fmt: skip
assert {name.lower() for name in _NAMES} == set(_SETTINGS)

_RANGES: Final[tuple[tuple[str, float, float], ...]] = (
    ("system_id", 1, 255),
    ("alone_after_s", 0.5, 600.0),
    ("takeoff_alt_m", 5.0, 500.0),
    ("watchdog_s", 0.1, 5.0),
    ("max_connections", 1, 65_536),
    ("max_message_kib", 16, 65_536),
    ("camera_width", 16, 7680),
    ("camera_height", 16, 4320),
    ("camera_rate_hz", 0.1, 60.0),
)
_CHOICES: Final[Mapping[str, tuple[str, ...]]] = {
    "dialect": ("data", "sequence"),
    "missions": ("fly", "upload"),
    "old_pictures": ("mark", "raise"),
}


def setting_names() -> list[str]:
    """Names of all settings."""
    return [*_NAMES, *(f"{name}.{what}" for name in INTERFACES for what in ("Endpoints", "Name"))]


def read_cfg(path: Path, base: IceSettings) -> IceSettings:
    """Settings of an Ice ``.cfg`` file: ``NAME=VALUE`` lines, ``#`` begins a comment, a backslash escapes.

    What begins with ``Vencejo.``, or with ``ArDrone.`` or ``APMServer.`` as in the configurations of older drivers, are
    our settings; of the older ones what we do not have is passed over. The rest are properties of Ice.

    Raises
    ------
    InvalidRequest
        When it cannot be read.
    """
    ours: dict[str, str] = {}
    properties = dict(base.properties)
    for number, line in enumerate(_text(path).splitlines(), 1):
        line = _COMMENT.sub("", line).strip()
        if not line:
            continue
        parts = [_ESCAPED.sub(r"\1", part.strip()) for part in _SEPARATOR.split(line, maxsplit=1)]
        if len(parts) != 2 or not parts[0]:
            raise InvalidRequest(f"{path}, line {number}: write NAME=VALUE")
        key, value = parts
        prefix = next((prefix for prefix in _CFG_PREFIXES if key.startswith(prefix)), None)
        if prefix is None:
            properties[key] = value
        elif prefix == _CFG_PREFIXES[0] or key.removeprefix(prefix) in setting_names():
            ours[key.removeprefix(prefix)] = value
    return replace(base.with_settings(ours, where=str(path)), properties=properties)


def default_config_file() -> Path:
    """Vencejo's configuration: ``$VENCEJO_CONFIG``, else ``vencejo/config.toml`` in the user's configuration folder."""
    own = os.environ.get("VENCEJO_CONFIG")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CONFIG_HOME")
    return (Path(base) if base else Path.home() / ".config") / "vencejo" / "config.toml"


def read_config(path: Path, base: IceSettings) -> IceSettings:
    """Settings of table ``[ice]`` of Vencejo's configuration.

    Raises
    ------
    InvalidRequest
        When it cannot be read.
    """
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        table = tomllib.loads(_text(path)).get("ice", {})
    except tomllib.TOMLDecodeError as error:
        raise InvalidRequest(f"{path}: {error}") from None
    if not isinstance(table, dict):
        raise InvalidRequest(f"{path}: ice is a table; write [ice]")
    return base.with_settings(dict(_flat(table)), where=f"{path}, [ice]")


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, str]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        elif isinstance(value, list):
            yield prefix + key, ",".join(map(str, value))
        else:
            yield prefix + key, str(value)


def _text(path: Path) -> str:
    with contextlib.suppress(UnicodeDecodeError):
        try:
            return read_small(path).decode()
        except OSError as error:
            raise InvalidRequest(f"{path}: {error.strerror or error}") from error
    raise InvalidRequest(f"{path}: it is not a text file")


assert {name for name, _ in _SETTINGS.values()} <= {entry.name for entry in fields(IceSettings)}

"""Planes in ROS 2, without ROS: each vehicle of a station gets the topics and services that MAVROS would give it.

`Gateway` speaks Eclipse Zenoh as ``rmw_zenoh_cpp`` does, so that nodes of ROS 2 Jazzy and newer that use it see the
planes. ROS need not be installed here, but a router has to run: ``ros2 run rmw_zenoh_cpp rmw_zenohd``; `Router`
describes one that is reached over TLS. `examine` lists the nodes at a router, and finds out why they do not receive
each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike, fspath
from typing import Final, Literal

from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.enrolment import native
from vencejo.errors import LinkError
from vencejo.station import Station

__all__ = ["ROUTER", "Examined", "Finding", "Gateway", "GatewayStatus", "Node", "Router", "Unreached", "examine"]

ROUTER: Final = "tcp/127.0.0.1:7447"
"""Default address of the ROS 2 router on this machine."""


class Unreached(LinkError):
    """A router that is not there, does not let us in, or is not believed.

    Attributes
    ----------
    code : str
        Its stable name: ``"no-router"``, ``"tls-spoken"``, ``"tls-missing"``, ``"tls-failed"``, ``"other-authority"``,
        ``"other-name"``, ``"certificate-ended"``, ``"own-certificate-ended"``, ``"certificate-wanted"`` or
        ``"certificate-refused"``.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code

    def __reduce__(self) -> tuple[type[Unreached], tuple[str, str]]:
        return type(self), (self.code, str(self))


def _path(file: str | PathLike[str] | None) -> str | None:
    return None if file is None else fspath(file)


class Router:
    """A router of ROS 2: its address, and the certificates for it.

    The files (PEM) are read now; nothing is dialled yet.

    Parameters
    ----------
    address : str
        ``"tls/HOST:PORT"``, ``"quic/HOST:PORT"``, or ``"tcp/HOST:PORT"`` without encryption.
    ca : path-like, optional
        Certificates of the authorities, one of which must have signed the router's for the dialled host. Needed with
        ``tls/`` and ``quic/``.
    certificate, key : path-like, optional
        Client certificate, followed by its intermediates, and its private key without a password, if the router asks
        for one (mutual TLS).
    plain : bool, optional
        Accept an unencrypted address on another machine: anyone in between can read and change the traffic.

    Raises
    ------
    InvalidRequest
        For an invalid address, an unencrypted one on another machine, and files that are missing or superfluous.
    VencejoError
        For a file that cannot be read or lacks its contents; the message names it.
    """

    def __init__(
        self,
        address: str = ROUTER,
        *,
        ca: str | PathLike[str] | None = None,
        certificate: str | PathLike[str] | None = None,
        key: str | PathLike[str] | None = None,
        plain: bool = False,
    ) -> None:
        self._address = address
        self._native = native("Ros2Router")(
            address, ca=_path(ca), certificate=_path(certificate), key=_path(key), is_plain_meant=plain
        )

    @property
    def address(self) -> str:
        """Its address."""
        return self._address

    def __repr__(self) -> str:
        return f"Router({self._address!r})"


def _router(router: str | Router) -> Router:
    return Router(router) if isinstance(router, str) else router


@dataclass(frozen=True, kw_only=True)
class GatewayStatus:
    """State of a gateway.

    Attributes
    ----------
    is_connected : bool
        Whether it is connected to the router.
    problem : str or None
        Why it is not.
    planes : dict of int to str
        Prefix of each plane's topics, by its id in this station.
    messages : int
        Number of messages sent.
    """

    is_connected: bool
    problem: str | None
    planes: dict[int, str]
    messages: int


class Gateway(Closing):
    """Shows every vehicle of a station in ROS 2 as soon as it is heard.

    It is read-only, unless its role is ``"operator"``: then its services act, under the station's control lease like
    any operator. Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        The station whose vehicles are shown.
    router : str or Router, optional
        The router, dialled for ever; a `Router` for one with certificates. Default: the one on this machine,
        ``"tcp/127.0.0.1:7447"``.
    domain : int, optional
        ``ROS_DOMAIN_ID``, 0 to 232.
    names : {"mavros", "ap"}, optional
        Topics by the names of MAVROS (``/vencejo_1/mavros/imu/data``) or of ArduPilot
        (``/ap/v1/imu/experimental/data``).
    namespace : str, optional
        The namespace of each plane: ``{name}`` stands for its name in a fleet or ``vencejo_SYSTEM``, ``{system}`` for
        the number by which the station knows it, its system id for one on a link. Without effect on the names of
        ``ap``.
    role : {"reader", "operator"}, optional
        Whether services act. ``"operator"`` needs a router on this machine, because anyone who reaches it can call
        them.

    Raises
    ------
    InvalidRequest
        For an invalid address, domain or name.
    """

    def __init__(
        self,
        station: Station,
        *,
        router: str | Router = ROUTER,
        domain: int = 0,
        names: Literal["mavros", "ap"] = "mavros",
        namespace: str = "{name}",
        role: Literal["reader", "operator"] = "reader",
    ) -> None:
        self._native = native("Ros2Gateway")(
            station._native,
            router=_router(router)._native,
            domain=domain,
            names=names,
            namespace=namespace,
            is_operator=role == "operator",
        )
        belongs_here(self)

    @property
    def status(self) -> GatewayStatus:
        """The present state."""
        is_connected, problem, planes, messages = self._native.status()
        return GatewayStatus(is_connected=is_connected, problem=problem, planes=dict(planes), messages=messages)

    def close(self) -> None:
        """Remove the planes from ROS 2."""
        self._native.close()


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node at a router.

    Attributes
    ----------
    domain : int
        Its ``ROS_DOMAIN_ID``.
    name : str
        Its full name.
    publishers, subscriptions, services : int
        Numbers of topics that it publishes, topics that it subscribes to, and services.
    """

    domain: int
    name: str
    publishers: int
    subscriptions: int
    services: int


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A finding about the nodes at a router.

    Attributes
    ----------
    is_wrong : bool
        Whether messages do not arrive because of it.
    code : str
        Its stable name, such as ``"hash-differs"``.
    text : str
        What was found, and what to do.
    """

    is_wrong: bool
    code: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Examined:
    """Nodes and findings at a router.

    Attributes
    ----------
    nodes : list of Node
        The nodes of all domains.
    findings : list of Finding
        The findings, the worst first.
    """

    nodes: list[Node]
    findings: list[Finding]


def examine(router: str | Router = ROUTER, *, domain: int = 0) -> Examined:
    """List the nodes at a router, and find out why those of a domain do not receive each other.

    Parameters
    ----------
    router : str or Router, optional
        The router.
    domain : int, optional
        ``ROS_DOMAIN_ID``, 0 to 232.

    Raises
    ------
    Unreached
        When the router is not reached; it says why, and what to do.
    InvalidRequest
        For an address or a domain that cannot be.
    """
    nodes, findings, unreached = native("ros2_examine")(_router(router)._native, domain)
    if unreached is not None:
        raise Unreached(*unreached)
    names = ("domain", "name", "publishers", "subscriptions", "services")
    return Examined(
        nodes=[Node(**dict(zip(names, node, strict=True))) for node in nodes],
        findings=[Finding(is_wrong=is_wrong, code=code, text=text) for is_wrong, code, text in findings],
    )

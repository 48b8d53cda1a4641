"""Planes in ROS 2, without ROS: each vehicle of a station has the topics and services that MAVROS would give it.

`Gateway` speaks Eclipse Zenoh as ``rmw_zenoh_cpp`` does, so that nodes of ROS 2 Jazzy and newer which use that see the planes; nothing
of ROS has to be here. A router has to be there: ``ros2 run rmw_zenoh_cpp rmw_zenohd``; `Router` is one that is reached over TLS.
`examine` looks who is at a router, and why somebody there sees nothing.
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
"""Where the router of ROS 2 on this machine is."""


class Unreached(LinkError):
    """A router that is not there, does not let us in, or is not believed.

    Attributes
    ----------
    code : str
        Its stable name: ``"no-router"``, ``"tls-spoken"``, ``"tls-missing"``, ``"tls-failed"``, ``"other-authority"``, ``"other-name"``,
        ``"certificate-ended"``, ``"own-certificate-ended"``, ``"certificate-wanted"`` or ``"certificate-refused"``.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code

    def __reduce__(self) -> tuple[type[Unreached], tuple[str, str]]:
        return type(self), (self.code, str(self))


def _path(file: str | PathLike[str] | None) -> str | None:
    return None if file is None else fspath(file)


class Router:
    """A router of ROS 2: where it is, and by which certificates it is known.

    The files (PEM) are read here, and once; nothing is dialled yet.

    Parameters
    ----------
    address : str
        ``"tls/HOST:PORT"``, ``"quic/HOST:PORT"``, or ``"tcp/HOST:PORT"`` in the clear.
    ca : path-like, optional
        Certificates of the authorities of which one has to have signed the router's, for the host that is dialled. Needed with ``tls/``
        and ``quic/``.
    certificate, key : path-like, optional
        A certificate that the router is shown, followed by those between it and the authority, and its private key, without a password:
        where the router asks for one (mutual TLS).
    plain : bool, optional
        Take an address in the clear that is not of this machine: whoever is on the way reads and changes what goes over it.

    Raises
    ------
    InvalidRequest
        For an address that cannot be, one in the clear elsewhere, or files that are missing or too many.
    VencejoError
        For a file that cannot be read, or has not in it what it should; it says which.
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
        """Where it is."""
        return self._address

    def __repr__(self) -> str:
        return f"Router({self._address!r})"


def _router(router: str | Router) -> Router:
    return Router(router) if isinstance(router, str) else router


@dataclass(frozen=True, kw_only=True)
class GatewayStatus:
    """How a gateway goes.

    Attributes
    ----------
    is_connected : bool
        Whether the router is reached.
    problem : str or None
        Why it is not.
    planes : dict of int to str
        What the topics of each plane begin with, by its id in this station.
    messages : int
        Messages that were sent.
    """

    is_connected: bool
    problem: str | None
    planes: dict[int, str]
    messages: int


class Gateway(Closing):
    """Shows every vehicle of a station in ROS 2, from when it is heard.

    It reads only, unless its role is ``"operator"``: then its services act, through the station's control lease like everybody else.
    Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        Whose vehicles are shown.
    router : str or Router, optional
        The router, dialled for ever. By default the one of this machine, ``"tcp/127.0.0.1:7447"``; a `Router` where there is more to say
        than an address.
    domain : int, optional
        ``ROS_DOMAIN_ID``, 0 to 232.
    names : {"mavros", "ap"}, optional
        Topics by the names of MAVROS (``/vencejo_1/mavros/imu/data``) or of ArduPilot (``/ap/v1/imu/experimental/data``).
    namespace : str, optional
        The namespace of each plane: ``{name}`` stands for its name in a fleet or ``vencejo_SYSTEM``, ``{system}`` for
        the number by which the station knows it, its system id for one on a link. Without effect on the names of ``ap``.
    role : {"reader", "operator"}, optional
        Whether services act. Only with a router of this machine: whoever reaches that may call them.

    Raises
    ------
    InvalidRequest
        For an address, a domain or a name that cannot be.
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
        """How it goes."""
        is_connected, problem, planes, messages = self._native.status()
        return GatewayStatus(is_connected=is_connected, problem=problem, planes=dict(planes), messages=messages)

    def close(self) -> None:
        """Take the planes out of ROS 2."""
        self._native.close()


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node that is there.

    Attributes
    ----------
    domain : int
        Its ``ROS_DOMAIN_ID``.
    name : str
        Its whole name.
    publishers, subscriptions, services : int
        Topics that it sends and hears, services that it answers.
    """

    domain: int
    name: str
    publishers: int
    subscriptions: int
    services: int


@dataclass(frozen=True, kw_only=True)
class Finding:
    """Something that was found.

    Attributes
    ----------
    is_wrong : bool
        Whether nothing arrives because of it.
    code : str
        Its stable name, such as ``"hash-differs"``.
    text : str
        In words, with what to do.
    """

    is_wrong: bool
    code: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Examined:
    """Who is at a router.

    Attributes
    ----------
    nodes : list of Node
        The nodes of all domains.
    findings : list of Finding
        What is wrong or worth knowing; the worst first.
    """

    nodes: list[Node]
    findings: list[Finding]


def examine(router: str | Router = ROUTER, *, domain: int = 0) -> Examined:
    """Look who is at a router, and why those of a domain see nothing of each other.

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

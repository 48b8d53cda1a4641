"""Planes in ROS 2, without ROS: each vehicle of a station has the topics and services that MAVROS would give it.

`Gateway` speaks Eclipse Zenoh as ``rmw_zenoh_cpp`` does, so that nodes of ROS 2 Jazzy and newer which use that see the planes; nothing
of ROS has to be here. A router has to be there: ``ros2 run rmw_zenoh_cpp rmw_zenohd``. `examine` looks who is at a router, and why
somebody there sees nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from vencejo._closing import Closing
from vencejo.enrolment import native
from vencejo.station import Station

__all__ = ["ROUTER", "Examined", "Finding", "Gateway", "GatewayStatus", "Node", "examine"]

ROUTER: Final = "tcp/127.0.0.1:7447"
"""Where the router of ROS 2 on this machine is."""


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
    router : str, optional
        The router, ``"tcp/HOST:PORT"``; dialled for ever. By default the one of this machine, port 7447.
    domain : int, optional
        ``ROS_DOMAIN_ID``, 0 to 232.
    names : {"mavros", "ap"}, optional
        Topics by the names of MAVROS (``/vencejo_1/mavros/imu/data``) or of ArduPilot (``/ap/v1/imu/experimental/data``).
    namespace : str, optional
        The namespace of each plane: ``{name}`` stands for its name in a fleet or ``vencejo_SYSTEM``, ``{system}`` for its system id.
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
        router: str = ROUTER,
        domain: int = 0,
        names: Literal["mavros", "ap"] = "mavros",
        namespace: str = "{name}",
        role: Literal["reader", "operator"] = "reader",
    ) -> None:
        self._native = native("Ros2Gateway")(
            station._native,
            router=router,
            domain=domain,
            names=names,
            namespace=namespace,
            is_operator=role == "operator",
        )

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


def examine(router: str = ROUTER, *, domain: int = 0) -> Examined:
    """Look who is at a router, and why those of a domain see nothing of each other.

    Parameters
    ----------
    router : str, optional
        The router, ``"tcp/HOST:PORT"``.
    domain : int, optional
        ``ROS_DOMAIN_ID``, 0 to 232.

    Raises
    ------
    LinkError
        When the router is not reached; it says why.
    InvalidRequest
        For an address or a domain that cannot be.
    """
    nodes, findings = native("ros2_examine")(router, domain)
    names = ("domain", "name", "publishers", "subscriptions", "services")
    return Examined(
        nodes=[Node(**dict(zip(names, node, strict=True))) for node in nodes],
        findings=[Finding(is_wrong=is_wrong, code=code, text=text) for is_wrong, code, text in findings],
    )

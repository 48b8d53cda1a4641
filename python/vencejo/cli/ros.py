"""The commands `vencejo ros …`, and the options by which planes are shown in ROS 2."""

from __future__ import annotations

import contextlib
from dataclasses import asdict, dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vencejo.cli.common import Exit, Failed, JsonOption, clean, put_json, say, stdout, table, warn_of_open_key

if TYPE_CHECKING:
    from vencejo.ros2 import Gateway, Router
    from vencejo.station import Station

ros_app = typer.Typer(
    no_args_is_help=True, help="List the nodes in ROS 2.\n\nExample: vencejo ros doctor --ros2-domain 0"
)

ROUTER: Final = "tcp/127.0.0.1:7447"


class Names(str, Enum):
    """By whose names topics go."""

    MAVROS = "mavros"
    AP = "ap"


class Role(str, Enum):
    """Whether services act."""

    READER = "reader"
    OPERATOR = "operator"


Ros2CaOption = Annotated[
    Path | None,
    typer.Option(
        "--ros2-ca",
        metavar="FILE",
        help="Certificates (PEM) of the authorities trusted for that router, for tls/ and quic/.",
    ),
]
Ros2CertOption = Annotated[
    Path | None,
    typer.Option("--ros2-cert", metavar="FILE", help="Client certificate chain (PEM), if that router asks for one."),
]
Ros2KeyOption = Annotated[Path | None, typer.Option("--ros2-key", metavar="FILE", help="Its key (PEM).")]
Ros2PlainOption = Annotated[
    bool, typer.Option("--ros2-plain", help="Connect without TLS to a router (tcp/…) on another machine.")
]
Ros2DomainOption = Annotated[int, typer.Option("--ros2-domain", metavar="N", min=0, max=232, help="ROS_DOMAIN_ID.")]


def router_of(address: str, ca: Path | None, cert: Path | None, key: Path | None, *, plain: bool) -> Router:
    """A router of ROS 2, its files read."""
    from vencejo.ros2 import Router

    warn_of_open_key(key)
    return Router(address, ca=ca, certificate=cert, key=key, plain=plain)


@dataclass(frozen=True)
class Ros2Options:
    """The options by which planes are shown in ROS 2."""

    ros2: Annotated[
        bool, typer.Option("--ros2", help="Show the planes in ROS 2 (rmw_zenoh_cpp), by a router on this machine.")
    ] = False
    ros2_router: Annotated[
        str | None,
        typer.Option(
            "--ros2-router",
            metavar="ADDRESS",
            help=f"The router of ROS 2 to use, with --ros2 or in its place: tls/HOST:PORT (with --ros2-ca), quic/…, or tcp/… "
            f"in the clear; {ROUTER} when not given.",
        ),
    ] = None
    ros2_ca: Ros2CaOption = None
    ros2_cert: Ros2CertOption = None
    ros2_key: Ros2KeyOption = None
    ros2_plain: Ros2PlainOption = False
    ros2_domain: Ros2DomainOption = 0
    ros2_names: Annotated[
        Names, typer.Option("--ros2-names", help="Topics by the names of MAVROS or of ArduPilot's own ROS 2 interface.")
    ] = Names.MAVROS
    ros2_namespace: Annotated[
        str,
        typer.Option(
            "--ros2-namespace",
            metavar="TEXT",
            help="Namespace of each plane: {name} stands for its name in a fleet or vencejo_SYSTEM, {system} for "
            "its id in this station, which is the system id on a link. Without effect on the names of ap.",
        ),
    ] = "{name}"
    ros2_role: Annotated[
        Role,
        typer.Option(
            "--ros2-role", help="reader: services refuse. operator: they act, for whoever reaches the router."
        ),
    ] = Role.READER

    @property
    def is_at_default(self) -> bool:
        """Whether the router at its usual address is used."""
        return self.ros2 and self.ros2_router is None

    def router(self) -> Router | None:
        """The router that was given, its files read; ``None`` when planes are not to be shown.

        Raises
        ------
        Failed
            For options of a router without one.
        """
        if self.ros2_router is not None or self.ros2:
            return router_of(
                self.ros2_router or ROUTER, self.ros2_ca, self.ros2_cert, self.ros2_key, plain=self.ros2_plain
            )
        if self.ros2_plain or not (self.ros2_ca is self.ros2_cert is self.ros2_key is None):
            raise Failed(
                "--ros2-ca, --ros2-cert, --ros2-key and --ros2-plain are for --ros2-router ADDRESS", Exit.USAGE
            )
        return None

    def gateway(self, station: Station, router: Router | None) -> contextlib.AbstractContextManager[Gateway | None]:
        """Show a station's planes by a router; without one nothing is done."""
        if router is None:
            return contextlib.nullcontext()
        from vencejo.ros2 import Gateway

        return Gateway(
            station,
            router=router,
            domain=self.ros2_domain,
            names=self.ros2_names.value,
            namespace=self.ros2_namespace,
            role=self.ros2_role.value,
        )


class Ros2News:
    """Reports changes of a gateway."""

    def __init__(self, gateway: Gateway | None) -> None:
        self._gateway = gateway
        self._told: tuple[str | None, frozenset[str]] = (None, frozenset())

    def tell(self) -> None:
        """Report on standard error what has changed since the last call."""
        if self._gateway is None:
            return
        status = self._gateway.status
        problem, planes = self._told
        if status.problem != problem:
            say(f"ROS 2: {status.problem}" if status.problem else "ROS 2: the router is there")
        for prefix in sorted(set(status.planes.values()) - planes):
            say(f"ROS 2: a plane is at {prefix}")
        self._told = (status.problem, planes | set(status.planes.values()))


@ros_app.command()
def doctor(
    ros2_router: Annotated[
        str, typer.Option("--ros2-router", metavar="ADDRESS", help="The router to look at.")
    ] = ROUTER,
    ros2_ca: Ros2CaOption = None,
    ros2_cert: Ros2CertOption = None,
    ros2_key: Ros2KeyOption = None,
    ros2_plain: Ros2PlainOption = False,
    ros2_domain: Ros2DomainOption = 0,
    json: JsonOption = False,
) -> None:
    """List the nodes in ROS 2, and find out why some receive nothing.

    It asks the router for all nodes of all domains, and compares what each of ours hears with what is sent: domain,
    name, type, type hash, and quality of service. Where the router does not let it in it says why: certificates, names,
    TLS or none. It ends with 1 where something is wrong.

    Example: vencejo ros doctor

    Example: vencejo ros doctor --ros2-router tls/robot.local:7447 --ros2-ca ca.crt --ros2-domain 5 --json
    """
    from vencejo.ros2 import Examined, Finding, Unreached, examine

    router = router_of(ros2_router, ros2_ca, ros2_cert, ros2_key, plain=ros2_plain)
    try:
        examined = examine(router, domain=ros2_domain)
    except Unreached as error:
        finding = Finding(is_wrong=True, code=error.code, text=str(error))
        examined = Examined(nodes=[], findings=[finding])
    is_wrong = any(finding.is_wrong for finding in examined.findings)
    if json:
        put_json({"is_well": not is_wrong, **asdict(examined)})
    else:
        if examined.nodes:
            shown = table(
                "domain",
                "node",
                "topics sent",
                "heard",
                "services",
                right=("domain", "topics sent", "heard", "services"),
            )
            for node in examined.nodes:
                counts = (node.publishers, node.subscriptions, node.services)
                shown.add_row(str(node.domain), clean(node.name), *map(str, counts))
            stdout().print(shown)
        for finding in examined.findings:
            print(f"{'Wrong' if finding.is_wrong else 'Note'}: {clean(finding.text)}")
        if not examined.findings:
            print("Nothing is wrong.")
    if is_wrong:
        raise typer.Exit(Exit.FAILED)

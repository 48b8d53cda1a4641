"""The options `--ice…` of `vencejo serve`: the JdeRobot interfaces beside the browser's."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vencejo.cli.common import say

if TYPE_CHECKING:
    from vencejo import Station
    from vencejo.jderobot import IceServer, IceSettings
    from vencejo.serve import Tokens

_PANEL = "JdeRobot (ZeroC Ice)"


@dataclass(frozen=True)
class IceOptions:
    """The options of the JdeRobot interfaces."""

    ice: Annotated[
        bool,
        typer.Option("--ice", rich_help_panel=_PANEL, help="Serve the JdeRobot interfaces too; needs vencejo[ice]."),
    ] = False
    ice_host: Annotated[
        str | None,
        typer.Option(
            "--ice-host",
            metavar="ADDRESS",
            rich_help_panel=_PANEL,
            help="Address to listen on (default 127.0.0.1); another one lets other machines in, with a token.",
        ),
    ] = None
    ice_missions: Annotated[
        str | None,
        typer.Option(
            "--ice-missions",
            metavar="fly|upload",
            rich_help_panel=_PANEL,
            help="Whether a mission is flown at once, as JdeRobot programs expect (the default), or only sent.",
        ),
    ] = None
    ice_dialect: Annotated[
        str | None,
        typer.Option(
            "--ice-dialect",
            metavar="data|sequence",
            rich_help_panel=_PANEL,
            help="Dialect in which a client that has not sent a mission yet reads one.",
        ),
    ] = None
    ice_allow: Annotated[
        list[str] | None,
        typer.Option(
            "--ice-allow",
            metavar="NETWORK",
            rich_help_panel=_PANEL,
            help="Network that needs no token, such as 192.168.1.0/24, for programs that cannot send one; repeatable.",
        ),
    ] = None
    ice_config: Annotated[
        Path | None,
        typer.Option("--ice-config", metavar="FILE", rich_help_panel=_PANEL, help="An Ice .cfg file with settings."),
    ] = None
    ice_set: Annotated[
        list[str] | None,
        typer.Option(
            "--ice-set",
            metavar="NAME=VALUE",
            rich_help_panel=_PANEL,
            help="Any setting of docs/jderobot.md, such as Pose3D.Endpoints='tcp -p 9998' or Mission.Name=m; repeatable.",
        ),
    ] = None

    def settings(self) -> IceSettings | None:
        """The settings: these options over the `.cfg` file over the configuration; ``None`` without `--ice`.

        Raises
        ------
        InvalidRequest
            For options without ``--ice``, and for a setting that is wrong.
        """
        from vencejo import InvalidRequest

        if not self.ice:
            if self != IceOptions():
                raise InvalidRequest("the options --ice-… need --ice")
            return None
        from vencejo.jderobot import IceSettings, default_config_file, read_cfg, read_config

        settings = IceSettings()
        if default_config_file().is_file():
            settings = read_config(default_config_file(), settings)
        if self.ice_config is not None:
            settings = read_cfg(self.ice_config, settings)
        given = {"Host": self.ice_host, "Missions": self.ice_missions, "Dialect": self.ice_dialect}
        if self.ice_allow:
            given["Allow"] = ",".join(self.ice_allow)
        for text in self.ice_set or ():
            name, separator, value = text.partition("=")
            if not separator:
                raise InvalidRequest(f"--ice-set {text!r}: write NAME=VALUE")
            given[name.strip()] = value
        known = {name: value for name, value in given.items() if value is not None}
        return settings.with_settings(known, where="the command line")


@contextlib.contextmanager
def ice_server(
    station: Station, settings: IceSettings | None, tokens: Callable[[], Tokens | None], **cameras: Any
) -> Iterator[IceServer | None]:
    """The interfaces while the server runs; ``None`` without `--ice`."""
    if settings is None:
        yield None
        return
    from vencejo.jderobot import IceServer

    with IceServer(station, settings, tokens=tokens, **cameras) as server:
        yield server


def tell_ice(proxies: Mapping[str, str] | None) -> None:
    """Say where the interfaces are."""
    if proxies is not None:
        say("The JdeRobot interfaces (ZeroC Ice) are at")
        for proxy in proxies.values():
            identity, colon, endpoints = proxy.partition(":")
            # module `vencejo` has three objects at its port
            parts = ("telemetry", "missions", "control") if identity.endswith("_telemetry") else ()
            for name in [f"{identity.removesuffix('telemetry')}{part}" for part in parts] or [identity]:
                say(f"  {name}{colon}{endpoints}")

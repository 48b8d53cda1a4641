"""All commands under their names."""

from __future__ import annotations

from typing import Annotated

import typer

from vencejo.cli.ask import ask
from vencejo.cli.camera import camera
from vencejo.cli.common import RootGroup
from vencejo.cli.demo import demo
from vencejo.cli.fleet import fleet_app
from vencejo.cli.fly import fly
from vencejo.cli.history import fleet_history
from vencejo.cli.links import links
from vencejo.cli.maps import maps_app
from vencejo.cli.mission import mission_app
from vencejo.cli.onboard import onboard
from vencejo.cli.params import params_app
from vencejo.cli.plan import plan_app
from vencejo.cli.record import record, replay
from vencejo.cli.ros import ros_app
from vencejo.cli.serve import serve
from vencejo.cli.signing import signing_app
from vencejo.cli.sim import SIM_CONTEXT, sim
from vencejo.cli.telemetry import telemetry
from vencejo.cli.tokens import tokens

__all__ = ["app"]

app = typer.Typer(
    name="vencejo",
    cls=RootGroup,
    no_args_is_help=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["--help", "-h"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from vencejo import __version__

        print(f"vencejo {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def root(
    ctx: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", help="Show the traceback of an error; may be given anywhere.")
    ] = False,
) -> None:
    """Send a fixed-wing autonomous plane to positions, over MAVLink.

    The link is given with --link or in VENCEJO_LINK. Nothing is armed, started or changed unless a command says so.

    Exit codes: 0 done, 1 could not, 2 wrong usage, 3 compared and not the same, 130 interrupted with Ctrl-C, 143 ended
    by SIGTERM.

    Example: vencejo demo
    """
    if ctx.invoked_subcommand is None:
        print(ctx.get_help())


app.command()(demo)
app.command()(serve)
app.command()(onboard)
app.command()(tokens)
app.command()(camera)
app.command()(fly)
app.command()(telemetry)
app.add_typer(mission_app, name="mission")
app.add_typer(plan_app, name="plan")
app.add_typer(params_app, name="params")
app.command()(ask)
app.command()(links)
app.add_typer(fleet_app, name="fleet")
fleet_app.command("history")(fleet_history)
app.add_typer(ros_app, name="ros")
app.add_typer(signing_app, name="signing")
app.add_typer(maps_app, name="maps")
app.command()(record)
app.command()(replay)
app.command(add_help_option=False, context_settings=SIM_CONTEXT)(sim)

"""The command `vencejo sim`: passes everything on to the simulated plane's own command line."""

from __future__ import annotations

import typer

SIM_CONTEXT = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}
"""The simulator reads its options itself, --help included."""


def sim(ctx: typer.Context) -> None:
    """Run the simulated plane, a peer on a MAVLink link, until Ctrl-C.

    Its options are told by: vencejo sim --help

    Example: vencejo sim --wind 5 --wind-from 270 --speedup 4
    """
    from vencejo.sim.__main__ import main

    raise typer.Exit(main(ctx.args, prog="vencejo sim"))

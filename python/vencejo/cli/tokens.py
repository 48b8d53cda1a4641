"""The command `vencejo tokens`: revoking what lets others in."""

from __future__ import annotations

import enum
from typing import Annotated

import typer

from vencejo.cli.common import Exit, Failed, JsonOption, put_json, say


class Whose(str, enum.Enum):
    """Whose token."""

    ALL = "all"
    VIEWER = "viewer"
    OPERATOR = "operator"


def tokens(
    new: Annotated[
        Whose | None,
        typer.Option("--new", help="Make new tokens, and end the sessions opened with the old ones."),
    ] = None,
    json: JsonOption = False,
) -> None:
    """Revoke the tokens of `vencejo serve`. A running server takes the new ones within seconds.

    Example: vencejo tokens --new all

    Example: vencejo tokens --new viewer
    """
    from vencejo.serve import renew_tokens

    if new is None:
        raise Failed("say whose tokens are to be new: --new all, --new viewer or --new operator", Exit.USAGE)
    made = renew_tokens(viewer=new is not Whose.OPERATOR, operator=new is not Whose.VIEWER)
    if json:
        put_json({"viewer": made.viewer, "operator": made.operator})
        return
    print(f"To command:  #token={made.operator}")
    print(f"To look:     #token={made.viewer}")
    say("They stand at the end of the address of the page. Sessions of the old ones end within 5 s.")

"""The command `vencejo ask`: one request to the vehicle, by its name and values, as the HTTP API has them."""

from __future__ import annotations

import json as json_
import math
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    YesOption,
    confirm,
    grouped,
    put_json,
)
from vencejo.cli.connecting import OnVehicle

if TYPE_CHECKING:
    from vencejo.vehicle import Danger


@grouped
def ask(
    on: OnVehicle,
    request: Annotated[
        str,
        typer.Argument(
            metavar="REQUEST",
            help="Its name, as in POST /api/v1/vehicles/{id}/NAME; a wrong one lists them.",
        ),
    ],
    values: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME=VALUE…", help="Its values, by the names of the API; a text of digits as '\"5\"'."),
    ] = None,
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Make one request to the vehicle, such as a mode, and wait until it is done. It asks before dangerous ones.

    Example: vencejo ask mode mode=LOITER

    Example: vencejo ask set-message-rate message=ATTITUDE rate_hz=20

    Example: vencejo ask return-to-launch --plane plane7 --fleet acme

    Example: vencejo ask goto lat_deg=40.333 lon_deg=-3.797 alt_m=80 alt_frame=home --link tcp:127.0.0.1:5760
    """
    from vencejo import ConfirmationNeeded
    from vencejo.vehicle import check_request

    given: dict[str, Any] = {}
    for name, value in map(_value, values or ()):
        if name in given:
            raise Failed(f"{name} is given twice", Exit.USAGE)
        given[name] = value
    check_request(request, given)  # before anything is waited for
    with on.vehicle() as vehicle:
        try:
            message = vehicle.ask(request, given)
        except ConfirmationNeeded as needed:
            danger = cast("Danger", needed.act)
            if not confirm(f"{request} is dangerous here ({danger}). Do it?", yes=yes):
                raise Failed(f"{request} was not asked for") from needed
            message = vehicle.ask(request, given, confirm=danger)
    fields = {} if message is None else {name: _finite(value) for name, value in message.fields.items()}
    if json:
        brought = {} if message is None else {"message": message.name, "fields": fields}
        put_json({"request": request, "values": given, "done": True, **brought})
    else:
        print(f"{request}: done", *(f"{name} {value}" for name, value in fields.items()), sep="\n")


def _finite(value: Any) -> Any:
    """A field of a message, with NaN and infinity as ``None``."""
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _value(text: str) -> tuple[str, Any]:
    """A value and its name: a number, true, false, null or a text in quotes as in JSON, else a text."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise Failed(f"'{text}' is no value: write NAME=VALUE", Exit.USAGE)
    try:
        read = json_.loads(value)
    except ValueError:
        return name, value
    return name, value if isinstance(read, (dict, list)) else read

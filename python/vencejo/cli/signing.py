"""The commands `vencejo signing …`: how vehicles sign, and the keys of this machine."""

from __future__ import annotations

import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vencejo.cli.common import (
    Exit,
    Failed,
    JsonOption,
    YesOption,
    confirm,
    grouped,
    number,
    put_json,
    stdout,
    table,
)
from vencejo.cli.connecting import OnLink

if TYPE_CHECKING:
    from vencejo.signing import SigningInfo
    from vencejo.station import Station

signing_app = typer.Typer(
    no_args_is_help=True,
    help="Show and change how vehicles sign their messages. Keys are never shown.\n\nExample: vencejo signing status",
)

KeyOption = Annotated[
    str | None, typer.Option("--key", metavar="NAME", help="A key of this machine; by default a new one.")
]
AnyLinkOption = Annotated[
    bool, typer.Option("--any-link", help="Allow sending the key unencrypted over a link that others can listen to.")
]
NameArgument = Annotated[str, typer.Argument(metavar="NAME", help="The key's name.")]


def _keys() -> Station:
    """A station without links, for the keys alone."""
    from vencejo import Station

    return Station(record=False, heartbeat=False)


def _put(system_id: int, info: SigningInfo, *, json: bool) -> None:
    if json:
        put_json({"system_id": system_id, **asdict(info), "refused": info.refused})
        return
    print(f"Vehicle {system_id}: {_state(info)}")
    shown = table("frames", "count", "newest", right=("count", "newest"))
    shown.add_row("verified", str(info.verified), number(info.verified_age_s, "s", 1))
    shown.add_row("unsigned, accepted", str(info.unsigned_accepted), "")
    shown.add_row("refused", str(info.refused), number(info.refused_age_s, "s", 1))
    for name in ("unsigned", "wrong_key", "replayed", "old", "future"):
        if count := getattr(info, f"refused_{name}"):
            shown.add_row(f"  {name.replace('_', ' ')}", str(count), "")
    stdout().print(shown)


def _state(info: SigningInfo) -> str:
    if info.key_missing:
        return "has to sign, and its key is not on this machine: nothing of it is believed"
    if not info.must_sign:
        state = "does not sign, as far as this machine can tell"
    elif info.verified or not info.unsigned_accepted:
        state = f"signs with '{info.key}'"
    else:
        # By USB everything is believed: with a wrong key the vehicle would be deaf over any other link.
        state = f"is said to have '{info.key}', and no frame of it was signed with that"
    if info.unproven:
        state += f"; sent and not shown yet: {', '.join(info.unproven)}"
    return state


@signing_app.command()
@grouped
def status(
    on: OnLink,
    json: JsonOption = False,
) -> None:
    """Show how a vehicle signs and what was refused in its name.

    Example: vencejo signing status --link /dev/ttyUSB0,57600
    """
    with on.vehicle() as vehicle:
        _put(vehicle.system_id, vehicle.signing, json=json)


@signing_app.command()
def keys(json: JsonOption = False) -> None:
    """List the keys of this machine by name.

    Example: vencejo signing keys
    """
    with _keys() as station:
        found = station.signing_keys
    if json:
        put_json([{"name": key.name, "made": key.made.isoformat(), "vehicles": list(key.vehicles)} for key in found])
        return
    shown = table("name", "made (UTC)", "vehicles")
    for key in found:
        shown.add_row(key.name, f"{key.made:%Y-%m-%d %H:%M}", ", ".join(map(str, key.vehicles)) or "–")
    stdout().print(shown)


@signing_app.command("new-key")
def new_key(
    name: NameArgument,
    file: Annotated[
        Path | None, typer.Option("--file", metavar="FILE", help="Take the key from a file: 32 bytes, or 64 digits.")
    ] = None,
    passphrase: Annotated[
        bool, typer.Option("--passphrase", help="Ask for the passphrase of another ground station.")
    ] = False,
) -> None:
    """Keep a key under a name: a new random one, one from a file, or that of a passphrase.

    Example: vencejo signing new-key bixler
    """
    if file is not None and passphrase:
        raise Failed("give --file or --passphrase, not both", Exit.USAGE)
    with _keys() as station:
        if passphrase:
            station.add_signing_key(name, passphrase=_ask_passphrase())
        else:
            station.add_signing_key(name, key=None if file is None else _read_key(file))
    print(f"The key '{name}' is kept.")


def _ask_passphrase() -> str:
    import getpass

    if sys.stdin.isatty():
        passphrase = getpass.getpass("Passphrase: ")
        # A mistake would be noticed where the vehicle is deaf: in the field.
        if passphrase and getpass.getpass("The same again: ") != passphrase:
            raise Failed("the two differ: no key was kept", Exit.USAGE)
    else:
        passphrase = sys.stdin.readline().rstrip("\n")
    if not passphrase:
        raise Failed("an empty passphrase makes a key that everybody knows: no key was kept", Exit.USAGE)
    return passphrase


def _read_key(file: Path) -> bytes:
    from vencejo._files import read_small

    data = read_small(file)
    if len(data) == 32:
        return data
    try:
        return bytes.fromhex(data.decode("ascii").strip())
    except ValueError:
        # Its contents are not repeated: they might be a key.
        raise Failed(f"{file} holds no key: 32 bytes, or 64 hexadecimal digits", Exit.USAGE) from None


@signing_app.command("export-key")
def export_key(name: NameArgument, file: Annotated[Path, typer.Argument(metavar="FILE", help="A new file.")]) -> None:
    """Write a key to a file that only you can read, for another ground station.

    Example: vencejo signing export-key bixler bixler.key
    """
    with _keys() as station:
        key = station.export_signing_key(name)
    with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as out:
        out.write(key.hex() + "\n")
    print(f"{file} holds the key '{name}': whoever reads it can command the vehicle.")


@signing_app.command("forget-key")
def forget_key(name: NameArgument, yes: YesOption = False) -> None:
    """Delete a key that no vehicle has.

    Example: vencejo signing forget-key bixler-old
    """
    if not confirm(f"Delete the key '{name}' for good?", yes=yes):
        raise Failed("nothing was changed")
    with _keys() as station:
        station.forget_signing_key(name)
    print(f"The key '{name}' is deleted.")


@signing_app.command()
def use(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The key's name, or 'none'.")],
    system: Annotated[int, typer.Option("--system", metavar="ID", min=1, max=255, help="MAVLink system id.")] = 1,
) -> None:
    """Say that a vehicle has a key already, given by another ground station. Nothing is sent.

    Example: vencejo signing use bixler --system 1
    """
    with _keys() as station:
        station.use_signing_key(system, None if name == "none" else name)
    print(f"Vehicle {system} has no key here." if name == "none" else f"Vehicle {system} has the key '{name}' here.")


@signing_app.command()
@grouped
def setup(
    on: OnLink,
    key: KeyOption = None,
    any_link: AnyLinkOption = False,
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Give a vehicle that does not sign a key, over USB. It must be disarmed.

    Example: vencejo signing setup --link /dev/ttyACM0
    """
    _change("set_up_signing", "Have vehicle {} sign from now on?", on, yes=yes, json=json, key=key, any_link=any_link)


@signing_app.command()
@grouped
def rotate(
    on: OnLink,
    key: KeyOption = None,
    any_link: AnyLinkOption = False,
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Give a vehicle that signs another key; both are believed until it shows the new one.

    Example: vencejo signing rotate --link /dev/ttyACM0
    """
    _change("rotate_signing", "Give vehicle {} another key?", on, yes=yes, json=json, key=key, any_link=any_link)


@signing_app.command()
@grouped
def off(
    on: OnLink,
    any_link: AnyLinkOption = False,
    yes: YesOption = False,
    json: JsonOption = False,
) -> None:
    """Take a vehicle's key away: anybody whom it hears can command it then. The key stays on this machine.

    Example: vencejo signing off --link /dev/ttyACM0
    """
    question = "Have vehicle {} sign no more, so that anybody whom it hears can command it?"
    _change("remove_signing", question, on, yes=yes, json=json, any_link=any_link)


def _change(
    act: str,
    question: str,
    on: OnLink,
    *,
    yes: bool,
    json: bool,
    **signing: Any,
) -> None:
    with on.vehicle() as vehicle:
        if not confirm(question.format(vehicle.system_id), yes=yes):
            raise Failed("nothing was changed")
        info = getattr(vehicle, act)(**signing)
        _put(vehicle.system_id, info, json=json)

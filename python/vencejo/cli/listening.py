"""The default link: who may send to it is chosen at the first start, kept in the data folder, and changed with ``--listen``."""

from __future__ import annotations

import enum
import json
import sys
from pathlib import Path
from typing import Annotated, Final

import typer

from vencejo.cli.common import Failed, say

DEFAULT_PORT: Final = 14550


class Listening(str, enum.Enum):
    """Who may send to the default link."""

    MACHINE = "machine"
    NETWORK = "network"
    EVERYONE = "everyone"

    @property
    def link(self) -> str:
        """Its link string."""
        host = {Listening.MACHINE: "127.0.0.1", Listening.NETWORK: "lan", Listening.EVERYONE: "0.0.0.0"}[self]
        return f"udpin:{host}:{DEFAULT_PORT}"

    @property
    def means(self) -> str:
        """The choice in words."""
        return {
            Listening.MACHINE: "this machine alone",
            Listening.NETWORK: "this machine and the private networks it is in",
            Listening.EVERYONE: "everyone who can reach this machine",
        }[self]


ListenOption = Annotated[
    Listening | None,
    typer.Option(
        "--listen",
        help="Who may send to UDP port 14550 without --link; kept for later starts.",
    ),
]


def kept_file() -> Path:
    """Where the choice is kept."""
    from vencejo.station import default_record_dir

    return default_record_dir().parent / "listen.json"


def kept() -> Listening | None:
    """The choice of an earlier start; ``None`` without a readable one."""
    try:
        return Listening(json.loads(kept_file().read_text(encoding="utf-8"))["listen"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def keep(choice: Listening) -> None:
    """Keep a choice; a data folder that cannot be written to keeps none, and says so."""
    from vencejo.storage import make_folder, write_file

    path = kept_file()
    try:
        make_folder(path.parent)
        write_file(path, (json.dumps({"listen": choice.value}) + "\n").encode())
    except OSError as error:
        say(f"The choice is not kept: {error.filename or path}: {error.strerror or error}")


def default_link(choice: Listening | None = None, *, ask: bool = False) -> str:
    """The default link, and a line that describes it.

    Parameters
    ----------
    choice : Listening, optional
        What ``--listen`` said; it is kept.
    ask : bool, optional
        Whether to ask on the terminal when nothing was chosen yet. Without a terminal it is this machine alone.
    """
    chosen = choice or kept()
    if chosen is None and ask and sys.stdin.isatty() and sys.stderr.isatty():
        choice = chosen = asked()
    if choice is not None:
        keep(choice)
    if chosen is None:
        chosen = Listening.MACHINE
    others = "" if chosen is not Listening.MACHINE else "; --listen network hears a Wi-Fi radio or another computer too"
    say(f"Vehicles are heard on UDP port {DEFAULT_PORT} from {chosen.means}{others}.")
    return chosen.link


def asked() -> Listening:
    """Ask who may send to us."""
    say(
        f"No link is named, so vehicles are awaited on UDP port {DEFAULT_PORT}. MAVLink has no passwords: whoever may send"
    )
    say("there can pose as a vehicle. Who may?")
    choices = list(Listening)
    for number, each in enumerate(choices, 1):
        say(f"  {number}  {each.means}" + (" (a simulator here)" if each is Listening.MACHINE else ""))
    try:
        answer = typer.prompt("1, 2 or 3", default=1, type=int, err=True)
    except typer.Abort as abort:
        if isinstance(abort.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        return Listening.MACHINE
    if not 1 <= answer <= len(choices):
        raise Failed(f"{answer} is none of 1 to {len(choices)}")
    chosen: Listening = choices[answer - 1]
    return chosen

"""Parses a `vencejo` command line with the real parser, without running anything."""

from __future__ import annotations

import functools
import re
import shlex
from typing import Any

import typer
from vencejo.cli.commands import app
from vencejo.sim.__main__ import _parser as sim_parser

USAGE_FAULT: Any = typer.BadParameter.__mro__[1]
"""Exception for wrong arguments; Typer may vendor its own Click."""


@functools.cache
def commands() -> dict[str, Any]:
    """Return every command by its full name, such as ``vencejo maps add``, including groups and the root."""
    found: dict[str, Any] = {}

    def walk(name: str, command: Any) -> None:
        found[name] = command
        for child, inner in getattr(command, "commands", {}).items():
            walk(f"{name} {child}", inner)

    walk("vencejo", typer.main.get_command(app))
    return found


def parse(line: str) -> None:
    """Parse `vencejo …`; a trailing comment is allowed.

    Raises
    ------
    ValueError
        When the command does not exist, or does not have an option, argument or value.
    """
    known = commands()
    words = shlex.split(line, comments=True)
    path = words.pop(0)
    while words and f"{path} {words[0]}" in known:
        path = f"{path} {words.pop(0)}"
    if path not in known or (hasattr(known[path], "commands") and words and not words[0].startswith("-")):
        raise ValueError(f"{line}: not a vencejo command")
    if {"--help", "-h"} & set(words):
        return
    try:
        if path == "vencejo sim":
            sim_parser(path).parse_args(words)
        else:
            known[path].make_context(path, words)
    except (USAGE_FAULT, SystemExit, typer.Exit) as error:
        if path == "vencejo" and words == ["--version"]:
            return
        raise ValueError(f"{line}: {error}") from error


def check_mention(text: str) -> None:
    """Check that a mentioned command, such as ``vencejo serve --link … --ice``, exists and has these options.

    Raises
    ------
    ValueError
        When the command or an option does not exist.
    """
    known = commands()
    words = text.split()
    path = words.pop(0)
    while words and f"{path} {words[0]}" in known:
        path = f"{path} {words.pop(0)}"
    if path == "vencejo" and words and re.fullmatch(r"[a-z-]+", words[0]):
        raise ValueError(f"{text}: no such command")
    named = {word.partition("=")[0] for word in words if re.match(r"--?[a-z]", word)}
    has = {"--help", "-h", "--debug"}
    if path == "vencejo sim":
        has |= {option for action in sim_parser(path)._actions for option in action.option_strings}
    for parameter in getattr(known[path], "params", ()):
        has |= {*parameter.opts, *parameter.secondary_opts}
    if named - has:
        raise ValueError(f"{text}: no option {', '.join(sorted(named - has))}")

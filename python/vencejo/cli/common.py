"""Shared parts of the commands: options, consoles, and the exit code of every error.

Exit codes: 0 done, 1 could not, 2 wrong usage, 130 interrupted with Ctrl-C, 143 ended by SIGTERM.
Results go to standard output, everything else (status, errors, questions) to standard error.
"""

from __future__ import annotations

import contextlib
import dataclasses
import enum
import errno
import functools
import inspect
import io
import json
import math
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeVar, get_type_hints

import typer
from typer.core import TyperGroup

if TYPE_CHECKING:
    from pathlib import Path
    from types import FrameType

    from rich.console import Console
    from rich.table import Table

    from vencejo.plan import Finding, PlanNote

_T = TypeVar("_T")

DEFAULT_LINK: Final = "default"
"""Stands for the default link, which `vencejo.cli.listening` determines."""

LinkOption = Annotated[
    str,
    typer.Option(
        "--link",
        "-l",
        metavar="LINK",
        envvar="VENCEJO_LINK",
        help="Link to the vehicle, such as udpin:0.0.0.0:14550, tcp:127.0.0.1:5760 or /dev/ttyACM0,115200; the default "
        "listens on UDP port 14550 for the senders chosen by `vencejo serve --listen`, at first this machine alone.",
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Write JSON, for scripts.")]
YesOption = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")]
RecordOption = Annotated[
    bool, typer.Option("--record/--no-record", help="Write all frames to a .tlog in the data folder.")
]
HistoryOption = Annotated[
    bool,
    typer.Option(
        "--history/--no-history", help="Store states, events and orders of the fleet's aircraft as .mcap files."
    ),
]
ForwardOption = Annotated[
    list[str] | None,
    typer.Option(
        "--forward",
        metavar="LINK",
        help="Forward to another ground station, such as udpout:127.0.0.1:14551; repeatable.",
    ),
]


LONG_S: Final = 5.0
"""Time after which a command says what it waits for, s."""


class Exit(enum.IntEnum):
    """What the command's exit code means."""

    OK = 0
    FAILED = 1
    USAGE = 2
    DIFFERS = 3
    INTERRUPTED = 130


EXIT_CODES: Final[Mapping[str, Exit]] = {
    "VencejoError": Exit.FAILED,
    "LinkError": Exit.FAILED,
    "InvalidLink": Exit.USAGE,
    "NoVehicleError": Exit.FAILED,
    "VehicleLost": Exit.FAILED,
    "ClosedError": Exit.FAILED,
    "Busy": Exit.FAILED,
    "Cancelled": Exit.INTERRUPTED,
    "ControlHeld": Exit.FAILED,
    "ConfirmationNeeded": Exit.FAILED,
    "InvalidRequest": Exit.USAGE,
    "NotPossibleNow": Exit.FAILED,
    "CommandRefused": Exit.FAILED,
    "CommandTimeout": Exit.FAILED,
    "TransferError": Exit.FAILED,
    "PlanMismatch": Exit.FAILED,
    "ParameterError": Exit.FAILED,
    "FileFormatError": Exit.FAILED,
    "PlanRefused": Exit.FAILED,
}
"""The exit code of each exception of `vencejo.errors` by its name; a subclass that is not here has its base's."""


class Failed(Exception):
    """A command could not do what it was asked to; its text is the reason."""

    def __init__(self, message: str, code: Exit = Exit.FAILED) -> None:
        super().__init__(message)
        self.code = code


def describe_error(error: Exception) -> tuple[Exit, str]:
    """Exit code and text of an error: one sentence, then what the vehicle or the checks listed, a line each."""
    if isinstance(error, Failed):
        return error.code, str(error)
    code = next((EXIT_CODES[kind.__name__] for kind in type(error).__mro__ if kind.__name__ in EXIT_CODES), None)
    if code is not None:
        text = str(error)
        details = getattr(error, "differences", ()) or getattr(error, "reasons", ())
        missing = [f"\n  {detail}" for detail in details if str(detail) not in text]
        todo = [f"\n  To do: {remedy}" for remedy in getattr(error, "remedies", ())]
        return code, text + "".join(missing + todo)
    if isinstance(error, UnicodeEncodeError) and any("\udc80" <= c <= "\udcff" for c in str(error.object)):
        # Bytes of the command line that are not UTF-8, as Python passes them on (PEP 383).
        return Exit.USAGE, f"{clean(error.object)[:80]} is not UTF-8: give names and paths in it"
    if isinstance(error, OSError):
        name = f"{error.filename}: " if error.filename is not None else ""
        if not name and error.errno == errno.ENOSPC:
            name = "the output: "  # what is written to files here has their names
        return Exit.FAILED, f"{name}{error.strerror or error}"
    return Exit.FAILED, f"internal error, please report it with the output of --debug: {type(error).__name__}: {error}"


def grouped(command: Callable[..., _T]) -> Callable[..., _T]:
    """Let a command take groups of options: a parameter whose type is a dataclass stands for an option per field.

    A field is declared as an option of a command is: ``Annotated[…, typer.Option(…)]`` with its default. The command
    gets an instance of the dataclass.
    """
    hints = get_type_hints(command, include_extras=True)
    groups = {name: kind for name, kind in hints.items() if isinstance(kind, type) and dataclasses.is_dataclass(kind)}
    shown: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        group = groups.get(parameter.name)
        if group is None:
            one = parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[parameter.name])
            shown.append(one)
            continue
        options = get_type_hints(group, include_extras=True)
        shown += [
            inspect.Parameter(
                field.name, inspect.Parameter.KEYWORD_ONLY, default=field.default, annotation=options[field.name]
            )
            for field in dataclasses.fields(group)
        ]

    @functools.wraps(command)
    def called(**given: Any) -> _T:
        made = {
            name: group(**{field.name: given.pop(field.name) for field in dataclasses.fields(group)})
            for name, group in groups.items()
        }
        return command(**given, **made)

    # Typer reads the signature that is set here, not that of the function inside.
    del called.__wrapped__
    called.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    return called


def _take_finite_numbers(command: Any) -> None:
    """Have a command and those below it refuse nan, which passes every bound, and inf."""
    for child in getattr(command, "commands", {}).values():
        _take_finite_numbers(child)
    do: Callable[..., Any] | None = command.callback
    if do is None:
        return

    shown = {
        parameter.name: parameter.opts[0] if parameter.opts[0].startswith("-") else parameter.metavar or parameter.name
        for parameter in command.params
    }

    @functools.wraps(do)
    def checked(**given: Any) -> Any:
        for name, value in given.items():
            for number in value if isinstance(value, tuple) else (value,):
                if isinstance(number, float) and not math.isfinite(number):
                    raise Failed(f"{shown[name]} is {number}, should be a finite number", Exit.USAGE)
        return do(**given)

    command.callback = checked


class RootGroup(TyperGroup):
    """The `vencejo` command: turns exceptions into a sentence and an exit code; takes ``--debug`` anywhere."""

    debug = False

    def __init__(self, *args: Any, **values: Any) -> None:
        super().__init__(*args, **values)
        _take_finite_numbers(self)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take ``--debug`` out wherever it stands before a ``--``."""
        end = args.index("--") if "--" in args else len(args)
        self.debug = "--debug" in args[:end] or bool(os.environ.get("VENCEJO_DEBUG"))
        return super().parse_args(ctx, [arg for arg in args[:end] if arg != "--debug"] + args[end:])

    def main(self, *args: Any, **values: Any) -> Any:
        """Run the program."""
        try:
            return super().main(*args, **values)
        except OSError as error:  # of help, which is written before there is a command
            code, text = describe_error(error)
            say(f"Error: {text}")
            _drop_output()
            sys.exit(code)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            try:
                return super().invoke(ctx)
            finally:
                # What is left is written now, when it can still be told that it was not.
                sys.stdout.flush()
        except (typer.Exit, typer.Abort, BrokenPipeError):
            raise
        except Exception as error:
            if hasattr(error, "exit_code"):  # a usage error, which shows itself
                raise
            if self.debug:
                traceback.print_exc()
            code, text = describe_error(error)
            say(f"Error: {text}")
            if isinstance(error, OSError):
                _drop_output()
            raise typer.Exit(code) from error


def _drop_output() -> None:
    """Let go of what stdout could not write: trying it once more, Python would end with exit code 120."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def end_by_signal() -> None:
    """Let SIGTERM end the command like Ctrl-C, closing everything."""

    def end(number: int, _frame: FrameType | None) -> None:
        raise SystemExit(128 + number)

    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, end)


def take_any_character() -> None:
    """Have characters that the output's encoding lacks, such as "→" in cp1252, written as escapes instead of raising."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def clean(text: str, *, keep_lines: bool = False) -> str:
    """Text from an aircraft or a file, without control characters for the terminal."""
    return "".join(c if c.isprintable() or (keep_lines and c == "\n") else "\N{REPLACEMENT CHARACTER}" for c in text)


def stdout() -> Console:
    """Console for results. Without a terminal its lines are never truncated."""
    return _console(sys.stdout)


def stderr() -> Console:
    """Console for status and questions."""
    return _console(sys.stderr)


def _console(file: Any) -> Console:
    from rich.console import Console

    console = Console(file=file, highlight=False, markup=False, emoji=False, soft_wrap=True)
    if not console.is_terminal:
        console.width = 200
    return console


UNREAD: Final = (OSError, ValueError)
"""Errors of writing to an output that is gone: a broken pipe, a closed terminal or file."""


def say(text: str) -> None:
    """Write one line of status to standard error. If that is gone, the command goes on."""
    with contextlib.suppress(*UNREAD):
        print(clean(text, keep_lines=True), file=sys.stderr, flush=True)


def warn_of_open_key(key: Path | None) -> None:
    """Say where others on this machine may read a private key."""
    # A missing file is reported when it is read.
    with contextlib.suppress(OSError):
        if key is not None and key.stat().st_mode & 0o077:
            say(f"Warning: others on this machine may read the TLS key {key}; run: chmod 600 {key}")


def put_json(value: Any) -> None:
    """Write one line of JSON to standard output, in ASCII where that is not UTF-8.

    Raises
    ------
    ValueError
        For NaN or infinity, which JSON does not have.
    """
    is_utf8 = (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"
    sys.stdout.write(json.dumps(value, allow_nan=False, ensure_ascii=not is_utf8, default=str) + "\n")
    sys.stdout.flush()


def table(*columns: str, right: tuple[str, ...] = (), title: str | None = None) -> Table:
    """A plain table; the columns in `right` are numbers."""
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", pad_edge=False, title_style="bold")
    for column in columns:
        made.add_column(column, justify="right" if column in right else "left", overflow="fold")
    return made


def confirm(question: str, *, yes: bool) -> bool:
    """Ask on the terminal. Without a terminal ``--yes`` is necessary."""
    if yes:
        return True
    if not sys.stdin.isatty():
        raise Failed(f"{question} There is no terminal to ask on: add --yes.", Exit.USAGE)
    try:
        return typer.confirm(question, default=False, err=True)
    except typer.Abort as abort:
        if isinstance(abort.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        return False


@contextlib.contextmanager
def progress_bar(what: str, *, quiet: bool = False) -> Iterator[Any]:
    """A progress bar on standard error, as a function of (done, total) that a transfer calls."""
    # Asked before Rich is loaded: a Ctrl-C that comes while Python makes its classes would end us by the signal, not
    # with 130.
    if quiet or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    console = stderr()
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


@contextlib.contextmanager
def status(text: str) -> Iterator[None]:
    """Show what the block waits for: a spinner on a terminal, a line elsewhere."""
    console = stderr()
    if not console.is_terminal:
        say(text)
        yield
        return
    with console.status(clean(text)):
        yield


@contextlib.contextmanager
def told_when_long(text: str | Callable[[], str | None]) -> Iterator[None]:
    """Print `text`, or what it returns then, once if the block takes longer than `LONG_S`."""

    def tell() -> None:
        if (told := text if isinstance(text, str) else text()) is not None:
            say(told)

    telling = threading.Timer(LONG_S, tell)
    telling.daemon = True
    telling.start()
    try:
        yield
    finally:
        telling.cancel()


def require_file(file: Path) -> None:
    """Refuse what is not there, and what is no file, such as a folder or a device."""
    if not file.is_file():
        raise Failed(f"{file}: " + ("it is not a file" if file.exists() else "there is no such file"))


def require_plan_name(file: Path) -> None:
    """Refuse a file name whose ending is not a plan format, before anything is done."""
    from vencejo.plan import PLAN_ENDINGS

    if file.suffix.lower() not in (*PLAN_ENDINGS, ".txt"):
        raise Failed(f"{file}: a plan is saved as {', '.join(PLAN_ENDINGS)}; name the file so", Exit.USAGE)


def say_notes(notes: Sequence[PlanNote]) -> None:
    """Print what reading or writing a file assumed or left out, to standard error."""
    for note in notes:
        say(f"note: {note}")


def finding_text(finding: Finding) -> str:
    """A finding of the checks in one line: severity, what is wrong, what to do."""
    text = finding.message.rstrip(".")
    if finding.item is not None and f"item {finding.item}" not in text:
        text = f"item {finding.item}: {text}"
    return f"{finding.severity}: {text}" + (f"; {finding.remedy}" if finding.remedy else "")


def size(count: int) -> str:
    """Bytes as a person reads them."""
    value = float(count)
    for unit in ("B", "kB", "MB"):
        if value < 1000.0:
            return f"{value:.0f} {unit}" if unit == "B" else f"{value:.1f} {unit}"
        value /= 1000.0
    return f"{value:.2f} GB"


def duration(seconds: float | None) -> str:
    """Minutes and seconds, such as ``4:05``; a dash when unknown."""
    if seconds is None:
        return "–"
    whole = round(max(0.0, seconds))
    hours, rest = divmod(whole, 3600)
    return f"{hours}:{rest // 60:02}:{rest % 60:02}" if hours else f"{rest // 60}:{rest % 60:02}"


def number(value: float | None, unit: str = "", digits: int = 0) -> str:
    """A value with its unit; a dash when unknown."""
    if value is None:
        return "–"
    rounded = round(value, digits) + 0.0  # without a minus before zero
    gap = "" if unit in ("", "°") else " "
    return f"{rounded:.{digits}f}{gap}{unit}"


def distance(metres: float | None) -> str:
    """Metres, or kilometres when far; a dash when unknown."""
    if metres is None:
        return "–"
    return f"{metres:.0f} m" if metres < 1000.0 else f"{metres / 1000.0:.2f} km"

"""Types and time limits that a program hands in, told where they are given and not when they are used."""

from __future__ import annotations

import time
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any, Final

from vencejo.errors import InvalidRequest

NUMBER: Final = (Real,)
WHOLE: Final = (Integral,)
FLAG: Final = (bool,)
NONE: Final = type(None)
"""Beside the others: ``None`` is allowed."""

_WORDS: Final[dict[type, str]] = {Real: "a number", Integral: "a whole number", bool: "True or False", NONE: "None"}


def check(owner: object, **kinds: tuple[type, ...]) -> None:
    """Look at fields of a dataclass, each with the types that it may have.

    Raises
    ------
    TypeError
        For a field of another type; it names the class, the field, its value and what belongs there.
    """
    for name, types in kinds.items():
        _check(f"{type(owner).__name__}.{name}", getattr(owner, name), types)


def check_argument(name: str, value: object, *types: type) -> None:
    """Look at an argument of a function; `TypeError` as `check` raises it."""
    _check(name, value, types)


def check_each(owner: object, name: str, *types: type) -> tuple[Any, ...]:
    """The values of a field as a tuple, each of one of these types; `TypeError` as `check` raises it."""
    where, values = f"{type(owner).__name__}.{name}", getattr(owner, name)
    if not isinstance(values, Iterable) or isinstance(values, (str, bytes)):
        raise TypeError(f"{where} is {_shown(values)}: give a tuple of {_words(types)}")
    given = tuple(values)
    for index, value in enumerate(given):
        _check(f"{where}[{index}]", value, types)
    return given


def number(name: str, value: float) -> float:
    """A number that was given; `TypeError` as `check` raises it for another type, also for a text that holds one."""
    _check(name, value, NUMBER)
    return float(value)


def check_timeout(timeout_s: float | None) -> None:
    """Look at a time limit, s; ``None`` is none.

    Raises
    ------
    InvalidRequest
        For NaN, which no moment is later than, and a negative one.
    """
    if timeout_s is not None and not timeout_s >= 0.0:
        raise InvalidRequest(f"timeout_s is {timeout_s}, should be 0 s or more")


def deadline_of(timeout_s: float | None) -> float | None:
    """When a time limit that begins now ends, on the monotonic clock; `InvalidRequest` as `check_timeout` raises it."""
    check_timeout(timeout_s)
    return None if timeout_s is None else time.monotonic() + timeout_s


def _check(where: str, value: object, types: tuple[type, ...]) -> None:
    # a bool is an int to Python; as a number of degrees or metres it is a mistake
    if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
        raise TypeError(f"{where} is {_shown(value)}: give {_words(types)}")


def _shown(value: object) -> str:
    text = repr(value)
    return "None" if value is None else f"{text[:60]}{'…' * (len(text) > 60)} ({type(value).__name__})"


def _words(types: tuple[type, ...]) -> str:
    return " or ".join(_WORDS.get(kind, f"a {kind.__name__}") for kind in types)

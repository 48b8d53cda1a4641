"""Objects with threads behind them belong to the process that made them; in one that is forked off they say so."""

from __future__ import annotations

import os
import weakref
from typing import Any, Final, NoReturn

from vencejo import _native
from vencejo.errors import ClosedError

__all__ = ["belongs_here"]

_owners: Final[weakref.WeakKeyDictionary[Any, tuple[str, ...]]] = weakref.WeakKeyDictionary()
"""Each with the attributes behind which its threads are."""


class _Elsewhere:
    """Stands in for a part whose threads are in the parent process."""

    def __init__(self, what: str) -> None:
        self._what = what

    def close(self) -> None:
        """Nothing of it is in this process."""

    def __getattr__(self, name: str) -> NoReturn:
        raise ClosedError(f"this {self._what} belongs to the process that was forked; make a new one in this one")


def belongs_here(owner: Any, *parts: str) -> None:
    """Let an object know its process: in one that is forked off, all but closing raises `ClosedError`.

    Parameters
    ----------
    owner : object
    *parts : str
        The attributes behind which its threads are; its native half by default.
    """
    _owners[owner] = parts or ("_native",)


def _leave_parents() -> None:
    _native.forked()
    for owner, parts in list(_owners.items()):
        elsewhere = _Elsewhere(type(owner).__name__.removeprefix("Async"))
        for part in parts:
            # Kept for ever: even its end would wait for those threads, or close what it shares with the parent.
            _native.abandon(getattr(owner, part))
            setattr(owner, part, elsewhere)
    _owners.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_parents)

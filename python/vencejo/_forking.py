"""Objects whose native half runs threads belong to the process that made them; in one that is forked off they say so."""

from __future__ import annotations

import os
import weakref
from typing import Any, Final, NoReturn

from vencejo import _native
from vencejo.errors import ClosedError

__all__ = ["belongs_here"]

_owners: Final[weakref.WeakSet[Any]] = weakref.WeakSet()


class _Elsewhere:
    """Stands in for a native half whose threads are in the parent process."""

    def __init__(self, what: str) -> None:
        self._what = what

    def close(self) -> None:
        """Nothing of it is in this process."""

    def __getattr__(self, name: str) -> NoReturn:
        raise ClosedError(f"this {self._what} belongs to the process that was forked; make a new one in this one")


def belongs_here(owner: Any) -> None:
    """Let an object know its process: in one that is forked off, all but closing raises `ClosedError`.

    Parameters
    ----------
    owner : object with ``_native``
    """
    _owners.add(owner)


def _leave_parents() -> None:
    for owner in list(_owners):
        _native.abandon(owner._native)
        owner._native = _Elsewhere(type(owner).__name__.removeprefix("Async").lower())
    _owners.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_parents)

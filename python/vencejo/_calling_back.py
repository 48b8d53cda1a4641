"""Calls back from a thread of its own: the one dispatcher of each subscription."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from types import CodeType
from typing import Any, TypeAlias

from vencejo import _native

__all__ = ["call_back"]

_Fault: TypeAlias = tuple[type[Exception], CodeType, int]


def call_back(subscription: _native.Subscription, call: Callable[[Any], None]) -> None:
    """Call a function with each entry until the subscription ends, in a daemon thread.

    An exception in it is told once for each type and place, and counted: a message may come 50 times a second.

    Raises
    ------
    TypeError
        For what cannot be called.
    """
    if not callable(call):
        raise TypeError(f"the callback is {call!r} ({type(call).__name__}): give a function")

    def run() -> None:
        told: set[_Fault] = set()
        while (item := subscription.next()) is not None:
            try:
                call(item)
            except Exception as error:  # noqa: BLE001 - reported as for any thread; the next entry follows
                subscription.on_failed()
                if (fault := _fault(error)) not in told:
                    told.add(fault)
                    threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread())))
            del item

    threading.Thread(target=run, name="vencejo-callback", daemon=True).start()


def _fault(error: Exception) -> _Fault:
    """Type of an exception, and where it was raised."""
    trace = error.__traceback__
    assert trace is not None, "it was raised"
    while trace.tb_next is not None:
        trace = trace.tb_next
    return type(error), trace.tb_frame.f_code, trace.tb_lineno

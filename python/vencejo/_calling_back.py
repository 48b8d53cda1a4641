"""Calls back from a thread of its own: the one dispatcher of each subscription."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import Any

from vencejo import _native

__all__ = ["call_back"]


def call_back(subscription: _native.Subscription, call: Callable[[Any], None]) -> None:
    """Call a function with each entry until the subscription ends, in a daemon thread.

    Raises
    ------
    TypeError
        For what cannot be called.
    """
    if not callable(call):
        raise TypeError(f"the callback is {call!r} ({type(call).__name__}): give a function")

    def run() -> None:
        while (item := subscription.next()) is not None:
            try:
                call(item)
            except Exception:  # noqa: BLE001 - reported as for any thread; the next entry follows
                threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread())))
            del item

    threading.Thread(target=run, name="vencejo-callback", daemon=True).start()

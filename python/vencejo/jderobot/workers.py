"""Thread pools for slow operations: a mission under way delays no other call, and no call delays the driver's end."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError, ThreadPoolExecutor
from typing import Any, Final, TypeVar

from vencejo.errors import Busy, Cancelled, VencejoError
from vencejo.jderobot.subject import LOG

__all__ = ["Workers"]

_T = TypeVar("_T")
_THREADS: Final = 8
_WAITING: Final = 64
"""Operations under way or waiting; more are refused."""
_ENDING: Final = "the driver is ending"


class Workers:
    """Runs operations outside the dispatch threads. Ice answers when the future is done.

    What commands the vehicle and what waits for pictures have a pool each: viewers of a slow camera delay no command.
    """

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(_THREADS, thread_name_prefix="vencejo-ice")
        self._lock = threading.Lock()
        self._promised: set[Future[Any]] = set()
        self._closed = False

    def later(self, work: Callable[[], _T]) -> Future[_T]:
        """Run something; its result or exception becomes the answer.

        Raises
        ------
        Busy
            When too much waits already, or everything ends.
        """
        promise: Future[_T] = Future()
        with self._lock:
            if self._closed:
                raise Busy(_ENDING)
            if len(self._promised) >= _WAITING:
                raise Busy(f"{_WAITING} operations wait already; wait for some of them")
            self._promised.add(promise)
            self._pool.submit(self._run, work, promise)
        return promise

    def go_on(self, otherwise: Callable[[], object] = lambda: None) -> None:
        """Called before each step of a multi-step operation: when the driver ends, its caller was told that it failed.

        Parameters
        ----------
        otherwise : function, optional
            Undoes the previous step if none may follow.

        Raises
        ------
        Cancelled
            When everything ends.
        """
        if self._closed:
            otherwise()
            raise Cancelled(_ENDING)

    def _run(self, work: Callable[[], _T], promise: Future[_T]) -> None:
        # It was answered already when the driver ended meanwhile.
        with contextlib.suppress(InvalidStateError):
            try:
                result = work()
            except BaseException as error:  # noqa: BLE001 - whoever waits for the promise handles it
                self._forget(promise)
                if not isinstance(error, VencejoError) and not hasattr(error, "ice_id"):
                    # Neither ours nor of a Slice file: the client sees an unknown exception, so it must be seen here.
                    LOG.error("an operation failed in a way that it should not", exc_info=error)
                promise.set_exception(error)
            else:
                self._forget(promise)
                promise.set_result(result)

    def _forget(self, promise: Future[Any]) -> None:
        with self._lock:
            self._promised.discard(promise)

    def close(self) -> None:
        """Take nothing more, and answer what is under way: it ends by itself (`go_on`), and Ice would wait for it."""
        with self._lock:
            self._closed = True
            promised, self._promised = self._promised, set()
        for promise in promised:
            with contextlib.suppress(InvalidStateError):
                promise.set_exception(Busy(_ENDING))
        self._pool.shutdown(wait=False, cancel_futures=True)

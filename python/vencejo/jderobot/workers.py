"""Threads for what takes long, so that a mission under way holds up no other call."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final, TypeVar

from vencejo.errors import Busy

__all__ = ["Workers"]

_T = TypeVar("_T")
_THREADS: Final = 8
_WAITING: Final = 64
"""Operations under way or waiting; more are refused."""


class Workers:
    """Runs operations beside the threads that dispatch requests. Ice answers when the future is done."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(_THREADS, thread_name_prefix="vencejo-ice")
        self._room = threading.BoundedSemaphore(_WAITING)

    def later(self, work: Callable[[], _T]) -> Future[_T]:
        """Run something; its result or exception becomes the answer.

        Raises
        ------
        Busy
            When too much waits already, or everything ends.
        """
        if not self._room.acquire(blocking=False):
            raise Busy(f"{_WAITING} operations wait already; wait for some of them")
        try:
            future = self._pool.submit(work)
        except RuntimeError as error:
            self._room.release()
            raise Busy("the driver is ending") from error
        future.add_done_callback(lambda _: self._room.release())
        return future

    def close(self) -> None:
        """Take nothing more; what runs ends by itself."""
        self._pool.shutdown(wait=False, cancel_futures=True)

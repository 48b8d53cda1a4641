"""Messages and events of a vehicle as they arrive, for ``for`` and ``async for``.

Made by `Vehicle.messages` and `Vehicle.events`, and those of `vencejo.aio.AsyncVehicle`.

Examples
--------
>>> for message in plane.messages("ATTITUDE", timeout_s=2):  # doctest: +SKIP
...     print(message.fields["roll"])
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from vencejo import _native
from vencejo._closing import Closing
from vencejo._given import check_timeout, deadline_of

__all__ = ["Arrivals", "AsyncArrivals"]

_T = TypeVar("_T")
_LOOK_S = 0.02
"""How often asyncio looks for something new, s: as often as for telemetry."""


class _Queue(Closing, Generic[_T]):
    def __init__(self, subscription: _native.Subscription, read: Callable[[Any], _T], timeout_s: float | None) -> None:
        check_timeout(timeout_s)
        self._subscription = subscription
        self._read = read
        self._timeout_s = timeout_s
        self._is_over = False

    @property
    def dropped(self) -> int:
        """Number of entries lost because they were not taken in time."""
        return self._subscription.dropped

    def close(self) -> None:
        """End it: nothing more is queued or returned. Can be called again."""
        self._is_over = True
        self._subscription.close()


class Arrivals(_Queue[_T]):
    """An iterator over what arrives from the moment it is made, in order.

    It waits for each entry, and ends when none has come for `timeout_s`, when the station is closed, and by `close`.
    At most `capacity` entries wait to be taken: beyond that the oldest is dropped and counted (`dropped`), and the link
    is never delayed.
    """

    def __iter__(self) -> Arrivals[_T]:
        return self

    def __next__(self) -> _T:
        found = None if self._is_over else self._subscription.get(self._timeout_s)
        if found is None:
            self.close()
            raise StopIteration
        return self._read(found)


class AsyncArrivals(_Queue[_T]):
    """An asynchronous iterator over what arrives from the moment it is made, in order; as `Arrivals`."""

    def __aiter__(self) -> AsyncArrivals[_T]:
        return self

    async def __anext__(self) -> _T:
        # Here, because a synchronous program has no use for it, and it takes long.
        import asyncio

        deadline = deadline_of(self._timeout_s)
        # Other tasks run, and a cancellation arrives, also between entries that wait. Before the look: none is lost.
        await asyncio.sleep(0)
        while not self._is_over:
            # Before the look: what was queued until then is returned.
            is_last = self._subscription.is_closed or (deadline is not None and time.monotonic() >= deadline)
            if (found := self._subscription.get(0.0)) is not None:
                return self._read(found)
            if is_last:
                self.close()
            else:
                await asyncio.sleep(_LOOK_S)
        raise StopAsyncIteration

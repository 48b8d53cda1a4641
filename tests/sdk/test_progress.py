"""Progress of a transfer: what came together with its end is told too."""

from typing import Any, cast

from vencejo import _native
from vencejo.aio import _finished
from vencejo.vehicle import Vehicle


class Ended:
    """An operation that ended before anybody could ask for its only report."""

    def wait_progress(self, seen: int) -> None:
        return None

    def progress(self) -> tuple[int, int]:
        return (12, 12)

    def on_done(self, callback: Any) -> None:
        callback()

    def wait(self, timeout_s: float | None) -> str:
        return "the reply"


def test_the_last_report_is_told() -> None:
    told: list[tuple[int, int]] = []
    vehicle = object.__new__(Vehicle)
    pending = cast(_native.Pending, Ended())
    assert vehicle._wait(pending, lambda done, total: told.append((done, total))) == "the reply"
    assert told == [(12, 12)]


async def test_the_last_report_is_told_to_asyncio() -> None:
    told: list[tuple[int, int]] = []
    pending = cast(_native.Pending, Ended())
    assert await _finished(pending, lambda done, total: told.append((done, total))) == "the reply"
    assert told == [(12, 12)]

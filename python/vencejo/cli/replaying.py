"""Recordings that `vencejo serve` is given as links."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vencejo.replay import Replay, ReplayLink
    from vencejo.station import Station


def parted(links: Iterable[str]) -> tuple[list[str], list[ReplayLink]]:
    """Links to vehicles, and the recordings that were given as links.

    Raises
    ------
    LinkError
        For a link string that cannot be read.
    """
    from vencejo.replay import replay_link

    live: list[str] = []
    recordings: list[ReplayLink] = []
    for link in links:
        recording = replay_link(link)
        if recording is None:
            live.append(link)
        else:
            recordings.append(recording)
    return live, recordings


@contextlib.contextmanager
def replayed(station: Station, recordings: Iterable[ReplayLink]) -> Iterator[list[Replay]]:
    """Recordings in a station, each as vehicles of its own."""
    from vencejo.replay import Replay

    with contextlib.ExitStack() as stack:
        yield [
            stack.enter_context(Replay(station, path, speed=speed, repeat=repeat)) for path, speed, repeat in recordings
        ]

"""MAVLink 2 signing as ArduPlane does it: one key for the vehicle, a time for each link, streams shared by all links.

What is signed and how: https://mavlink.io/en/guide/message_signing.html. The rules beyond it are ArduPilot's
(``GCS_Signing.cpp``): the first link is taken for USB and accepts what is not signed, and so does every link for the reports
of radios; a key is not changed while armed; the time is stored every 30 s, and goes on a minute later after a restart.
Not modelled: that the clock of the GPS moves the time on.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
from collections.abc import Callable

from vencejo.sim.autopilot.interface import Severity
from vencejo.sim.mavlink.codec import MavMessage
from vencejo.sim.mavlink.link import Link

__all__ = ["Signing"]

_SIGNATURE_BYTES = 13
_TAG_BYTES = 6
_TICKS_PER_S = 100_000
_NEWCOMER_TICKS = 60 * _TICKS_PER_S
_RESTART_TICKS = 60 * _TICKS_PER_S
_SAVE_S = 30.0
_MAX_TICKS = (1 << 48) - 1
_MAX_STREAMS = 16
_UNSIGNED_MESSAGES = ("RADIO_STATUS", "RADIO")


class Signing:
    """The key of one plane and what it has signed and accepted.

    Parameters
    ----------
    system : int
        System id of the plane.
    say : callable
        Tells a text to the stations.
    """

    def __init__(self, system: int, say: Callable[[Severity, str], None]) -> None:
        self._system = system
        self._say = say
        self._key: bytes | None = None
        self._stored_ticks = 0
        self._saved_s = 0.0
        self._links: dict[Link, int] = {}
        """The number of each link."""
        self._ticks: dict[int, int] = {}
        """The next time of each number; a link that is connected again goes on with it."""
        self._streams: dict[tuple[int, int, int], int] = {}
        self.accepted = 0
        """Frames whose signature was right."""
        self.rejected = 0
        """Frames that were ignored."""

    @property
    def key(self) -> bytes | None:
        """The key; ``None`` when nothing is signed."""
        return self._key

    def attach(self, link: Link) -> None:
        """A link is up."""
        if link not in self._links:
            number = next(n for n in itertools.count() if n not in self._links.values())
            self._links[link] = number
            self._ticks.setdefault(number, self._stored_ticks + _RESTART_TICKS)
        self._enlist()

    def detach(self, link: Link) -> None:
        """A link is gone."""
        self._links.pop(link, None)
        link.signers.pop(self._system, None)

    def set_up(self, message: MavMessage, *, armed: bool) -> None:
        """SETUP_SIGNING: take a key, or with zeros sign no more."""
        if armed:
            self._say(Severity.WARNING, "ERROR: Won't setup signing when armed")
            return
        key = bytes(message.secret_key)
        self._stored_ticks = message.initial_timestamp & _MAX_TICKS
        self._key = key if any(key) or message.initial_timestamp else None
        self._load()

    def restart(self) -> None:
        """The vehicle starts again: the key is kept, the streams are not."""
        self._streams.clear()
        self._load()

    def tick(self, now_s: float) -> None:
        """Store the time every 30 s."""
        if now_s - self._saved_s >= _SAVE_S:
            self._saved_s = now_s
            self._stored_ticks = max([self._stored_ticks, *self._ticks.values()])

    def accepts(self, link: Link, message: MavMessage) -> bool:
        """Whether a message is believed."""
        if self._key is None or self._is_right(link, message.get_msgbuf(), self._key):
            return True
        if link.is_usb or message.get_type() in _UNSIGNED_MESSAGES:
            return True
        self.rejected += 1
        return False

    def _load(self) -> None:
        self._ticks = dict.fromkeys(self._ticks, self._stored_ticks + _RESTART_TICKS)
        self._enlist()

    def _enlist(self) -> None:
        """See to it that what leaves is signed when there is a key."""
        for link, number in self._links.items():
            if self._key is None:
                link.signers.pop(self._system, None)
            else:
                link.signers[self._system] = functools.partial(self._sign, self._key, number)

    def _sign(self, key: bytes, number: int, frame: bytes) -> bytes:
        """The signature of a frame that leaves."""
        ticks = self._ticks[number]
        self._ticks[number] = ticks + 1
        head = bytes((number,)) + (ticks & _MAX_TICKS).to_bytes(6, "little")
        return head + hashlib.sha256(key + frame + head).digest()[:_TAG_BYTES]

    def _is_right(self, link: Link, frame: bytes, key: bytes) -> bool:
        if frame[0] != 0xFD or not frame[2] & 1:
            return False
        frame = bytes(frame)
        if hashlib.sha256(key + frame[:-_TAG_BYTES]).digest()[:_TAG_BYTES] != frame[-_TAG_BYTES:]:
            return False
        signature = frame[-_SIGNATURE_BYTES:]
        ticks = int.from_bytes(signature[1:7], "little")
        stream = (frame[5], frame[6], signature[0])
        number = self._links[link]
        last = self._streams.get(stream)
        if last is None:
            if len(self._streams) >= _MAX_STREAMS or ticks + _NEWCOMER_TICKS < self._ticks[number]:
                return False
        elif ticks <= last:
            return False
        self._streams[stream] = ticks
        self._ticks[number] = max(self._ticks[number], ticks)
        self.accepted += 1
        return True

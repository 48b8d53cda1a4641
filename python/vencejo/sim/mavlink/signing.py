"""MAVLink 2 signing as in ArduPlane: one key per vehicle, a timestamp per link, streams shared by all links.

Format: https://mavlink.io/en/guide/message_signing.html. The other rules are ArduPilot's (``GCS_Signing.cpp``): the
first link counts as USB and accepts unsigned messages, as every link does for radio reports; the key cannot be changed
while armed; the timestamp is stored every 30 s and continues one minute later after a restart. Not modelled: the GPS
clock advances it.
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
    """Signing state of one plane: its key, timestamps and streams.

    Parameters
    ----------
    system : int
        System id of the plane.
    say : callable
        Sends a text to the stations.
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
        """Next timestamp of each link number; a reconnected link continues with it."""
        self._streams: dict[tuple[int, int, int], int] = {}
        self.accepted = 0
        """Number of frames with a valid signature."""
        self.rejected = 0
        """Number of ignored frames."""

    @property
    def key(self) -> bytes | None:
        """The key; None when signing is off."""
        return self._key

    def attach(self, link: Link) -> None:
        """Add a link."""
        if link not in self._links:
            number = next(n for n in itertools.count() if n not in self._links.values())
            self._links[link] = number
            self._ticks.setdefault(number, self._stored_ticks + _RESTART_TICKS)
        self._enlist()

    def detach(self, link: Link) -> None:
        """Remove a link."""
        self._links.pop(link, None)
        link.signers.pop(self._system, None)

    def set_up(self, message: MavMessage, *, armed: bool) -> None:
        """SETUP_SIGNING: set the key; all zeros end signing."""
        if armed:
            self._say(Severity.WARNING, "ERROR: Won't setup signing when armed")
            return
        key = bytes(message.secret_key)
        self._stored_ticks = message.initial_timestamp & _MAX_TICKS
        self._key = key if any(key) or message.initial_timestamp else None
        self._load()

    def restart(self) -> None:
        """Restart after a reboot: the key is kept, the streams are not."""
        self._streams.clear()
        self._load()

    def tick(self, now_s: float) -> None:
        """Store the timestamp every 30 s."""
        if now_s - self._saved_s >= _SAVE_S:
            self._saved_s = now_s
            self._stored_ticks = max([self._stored_ticks, *self._ticks.values()])

    def accepts(self, link: Link, message: MavMessage) -> bool:
        """Whether a message is accepted."""
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
        """Enable signing of outgoing frames while there is a key."""
        for link, number in self._links.items():
            if self._key is None:
                link.signers.pop(self._system, None)
            else:
                link.signers[self._system] = functools.partial(self._sign, self._key, number)

    def _sign(self, key: bytes, number: int, frame: bytes) -> bytes:
        """The signature of an outgoing frame."""
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

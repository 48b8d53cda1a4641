"""One connection to a station: its decoder, its sequence numbers and its bounded queues. No sockets."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from vencejo.sim.mavlink.codec import Decoder, MavMessage, Payload, frame, payload_of, source_version

__all__ = ["Link", "Peer", "Source"]

MAX_REPLIES = 8192
"""Most queued frames that must not be lost (answers, texts). Beyond it the link has failed and is closed."""
MAX_STREAMED = 512
"""Most queued telemetry frames; beyond it the oldest are dropped."""


class Source(NamedTuple):
    """MAVLink system and component id of a sender on board."""

    system: int
    component: int


class Link:
    """The protocol state of one connection.

    Payloads are framed and numbered when they are sent, so answers may overtake telemetry without appearing as loss.

    Parameters
    ----------
    name : str
        For logging.
    is_usb : bool
        Whether it counts as the USB port, on which unsigned messages are accepted.
    """

    def __init__(self, name: str, *, is_usb: bool = True) -> None:
        self.name = name
        self.is_usb = is_usb
        self.signers: dict[int, Callable[[bytes], bytes]] = {}
        """Signing function of each system that has a key."""
        self.decoder = Decoder()
        self.version = 2
        self.failed = False
        """Too many answers are queued: the owner should close the connection."""
        self.dropped = 0
        """Number of telemetry frames dropped because the station reads too slowly."""
        self._seen_v2 = False
        self._replies: deque[tuple[Payload, Source]] = deque()
        self._streamed: deque[tuple[Payload, Source]] = deque(maxlen=MAX_STREAMED)
        self._sequence: dict[Source, int] = {}

    def receive(self, data: bytes) -> list[MavMessage]:
        """Decode received bytes; answers use the MAVLink version of the station."""
        messages = self.decoder.feed(data)
        for message in messages:
            if source_version(message) == 2:
                self._seen_v2 = True
                self.version = 2
            elif not self._seen_v2:
                self.version = 1
        return messages

    def send(self, message: MavMessage, source: Source) -> None:
        """Queue an answer or an announcement."""
        self.send_payload(payload_of(message), source)

    def send_payload(self, payload: Payload, source: Source) -> None:
        """Queue a packed answer."""
        if len(self._replies) >= MAX_REPLIES:
            self.failed = True
            return
        self._replies.append((payload, source))

    def stream(self, payload: Payload, source: Source) -> None:
        """Queue telemetry, dropping the oldest when the station is slow."""
        if len(self._streamed) == MAX_STREAMED:
            self.dropped += 1
        self._streamed.append((payload, source))

    def restart(self, source: Source) -> None:
        """Restart the sequence numbers of a sender at 0, from its next frame on."""
        self._sequence.pop(source, None)

    @property
    def waiting_replies(self) -> int:
        """Number of queued answers."""
        return len(self._replies)

    @property
    def pending(self) -> bool:
        """Whether anything is queued."""
        return bool(self._replies or self._streamed)

    def take(self, max_bytes: int) -> list[bytes]:
        """Take frames to send, answers first, up to about ``max_bytes``."""
        out: list[bytes] = []
        size = 0
        while size < max_bytes:
            if self._replies:
                payload, source = self._replies.popleft()
            elif self._streamed:
                payload, source = self._streamed.popleft()
            else:
                break
            sequence = self._sequence.get(source, 0)
            signer = self.signers.get(source.system) if self.version == 2 else None
            framed = frame(
                payload,
                sequence=sequence,
                system=source.system,
                component=source.component,
                version=self.version,
                signed=signer is not None,
            )
            if framed is None:
                continue
            if signer is not None:
                framed += signer(framed)
            self._sequence[source] = (sequence + 1) & 0xFF
            out.append(framed)
            size += len(framed)
        return out


class Peer(NamedTuple):
    """The address of an answer: a station on a link."""

    link: Link
    system: int
    component: int

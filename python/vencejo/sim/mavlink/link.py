"""One connection to a station: its decoder, its sequence numbers and its bounded queues. No sockets."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from vencejo.sim.mavlink.codec import Decoder, MavMessage, Payload, frame, payload_of, source_version

__all__ = ["Link", "Peer", "Source"]

MAX_REPLIES = 8192
"""Frames waiting that must not be lost (answers, texts). Beyond it the link has failed and is closed."""
MAX_STREAMED = 512
"""Telemetry frames waiting; beyond it the oldest are dropped."""


class Source(NamedTuple):
    """Who on board sends: MAVLink system and component id."""

    system: int
    component: int


class Link:
    """The protocol state of one connection.

    Frames are queued unframed and get their sequence number when they leave, so answers may overtake telemetry
    without looking like loss.

    Parameters
    ----------
    name : str
        For log lines.
    is_usb : bool
        Whether nobody else can reach it, so that what is not signed is believed.
    """

    def __init__(self, name: str, *, is_usb: bool = True) -> None:
        self.name = name
        self.is_usb = is_usb
        self.signers: dict[int, Callable[[bytes], bytes]] = {}
        """What signs the frames of a system that leave, when it has a key."""
        self.decoder = Decoder()
        self.version = 2
        self.failed = False
        """Too many answers wait: the owner should close the connection."""
        self.dropped = 0
        """Telemetry frames dropped because the station reads too slowly."""
        self._seen_v2 = False
        self._replies: deque[tuple[Payload, Source]] = deque()
        self._streamed: deque[tuple[Payload, Source]] = deque(maxlen=MAX_STREAMED)
        self._sequence: dict[Source, int] = {}

    def receive(self, data: bytes) -> list[MavMessage]:
        """Decode what arrived, and answer in the MAVLink version that the station speaks."""
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
        """Queue an answer that is already packed."""
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
        """Who sends starts anew, with what it sends from now on: its sequence numbers begin at 0."""
        self._sequence.pop(source, None)

    @property
    def waiting_replies(self) -> int:
        """Answers not yet taken."""
        return len(self._replies)

    @property
    def pending(self) -> bool:
        """Whether anything waits to leave."""
        return bool(self._replies or self._streamed)

    def take(self, max_bytes: int) -> list[bytes]:
        """Frames to send now, answers first, up to about ``max_bytes``."""
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
    """Whom to answer: a station on a link."""

    link: Link
    system: int
    component: int

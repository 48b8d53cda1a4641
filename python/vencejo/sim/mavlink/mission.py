"""The mission protocol for mission, fence and rally points, as implemented by ArduPlane's MissionItemProtocol.

It requests items with MISSION_REQUEST, in order, one at a time; accepts items ahead of a request if they are in
order; refuses others with INVALID_SEQUENCE without ending the upload; repeats a request after one second and times
out after eight. Protocol: https://mavlink.io/en/services/mission.html
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from vencejo.sim.autopilot.interface import Severity
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.link import Link, Peer
from vencejo.sim.plan_store import MissionResult, WireItem, has_position

__all__ = ["PlanKind", "PlanProtocol", "item_from_message", "item_to_message"]

_REQUEST_AGAIN_S = 1.0
_GIVE_UP_S = 8.0


class PlanItems(Protocol):
    """The part of a plan store that a transfer uses (:class:`vencejo.sim.plan_store.MissionStore` and others)."""

    max_items: int
    complaints: tuple[tuple[Severity, str], ...]
    """Texts sent when a complete upload is refused."""

    def __len__(self) -> int:
        """Number of items, stored or being uploaded."""

    def begin(self, count: int) -> None:
        """Start an upload of ``count`` items."""

    def put(self, item: WireItem, *, last_seq: int) -> MissionResult:
        """Store an item of an upload that ends with ``last_seq``."""

    def complete(self) -> MissionResult:
        """Complete the upload."""

    def abandon(self) -> None:
        """Abandon the upload."""

    def clear(self) -> bool:
        """Remove all items; False when that is not allowed now."""
        ...

    def read(self, seq: int) -> WireItem | None:
        """Read an item back, None when it does not exist."""


@dataclass(frozen=True, slots=True)
class PlanKind:
    """One of the three plans."""

    number: int
    """MAV_MISSION_TYPE."""
    name: str
    """As in "Mission upload timeout"."""
    received: tuple[Severity, str] | None
    """Text sent when an upload is complete."""
    says_when_cleared: bool = False
    """Whether it is sent after MISSION_CLEAR_ALL too."""


def item_from_message(message: MavMessage) -> WireItem | MissionResult:
    """Raw fields of a MISSION_ITEM or MISSION_ITEM_INT; positions of the former are converted to integers."""
    x, y = message.x, message.y
    if message.get_type() == "MISSION_ITEM":
        if not (math.isfinite(x) and math.isfinite(y)):
            return MissionResult.INVALID_PARAM5_X
        if has_position(message.command):
            if abs(x) > 90:
                return MissionResult.INVALID_PARAM5_X
            if abs(y) > 180:
                return MissionResult.INVALID_PARAM6_Y
            x, y = x * 1e7, y * 1e7
        x, y = int(min(max(x, -(2.0**31)), 2.0**31 - 1)), int(min(max(y, -(2.0**31)), 2.0**31 - 1))
    return WireItem(
        seq=message.seq,
        frame=message.frame,
        command=message.command,
        p1=message.param1,
        p2=message.param2,
        p3=message.param3,
        p4=message.param4,
        x=x,
        y=y,
        z=message.z,
        current=message.current,
        autocontinue=message.autocontinue,
        mission_type=message.mission_type,
    )


def item_to_message(item: WireItem, *, seq: int, system: int, component: int, as_float: bool) -> MavMessage:
    """MISSION_ITEM_INT of a stored item, or MISSION_ITEM in answer to MISSION_REQUEST."""
    cls = dialect.MAVLink_mission_item_message if as_float else dialect.MAVLink_mission_item_int_message
    scale = 1e-7 if as_float and has_position(item.command) else 1
    x, y = item.x * scale, item.y * scale
    return cls(
        system,
        component,
        seq,
        item.frame,
        item.command,
        item.current,
        item.autocontinue,
        item.p1,
        item.p2,
        item.p3,
        item.p4,
        x,
        y,
        item.z,
        item.mission_type,
    )


@dataclass(slots=True)
class _Upload:
    peer: Peer
    next_seq: int
    last_seq: int
    received_s: float
    requested_s: float


class PlanProtocol:
    """Transfers one kind of plan, for all links of one plane; one upload at a time.

    Parameters
    ----------
    kind : PlanKind
    store
        The stored items.
    reply : callable
        Sends a message to one peer.
    say : callable
        Sends a text to every link.
    now_s : callable
        Simulated time.
    capacity : callable, optional
        Number of items that fit at present (0 just after boot).
    """

    def __init__(
        self,
        kind: PlanKind,
        store: PlanItems,
        *,
        reply: Callable[[Peer, MavMessage], None],
        say: Callable[[Severity, str], None],
        now_s: Callable[[], float],
        capacity: Callable[[], int] | None = None,
    ) -> None:
        self.kind = kind
        self._store = store
        self._send = reply
        self._say = say
        self._now_s = now_s
        self._capacity = capacity or (lambda: store.max_items)
        self._upload: _Upload | None = None
        self._warned_request = False
        self._warned_item = False

    @property
    def receiving(self) -> bool:
        """Whether an upload is in progress."""
        return self._upload is not None

    def on_count(self, peer: Peer, message: MavMessage) -> None:
        """MISSION_COUNT: start or restart an upload."""
        if not self._allowed(peer) or not self._cancel(peer):
            return
        count = int(message.count)
        capacity = self._capacity()
        if count > capacity:
            self._ack(peer, MissionResult.NO_SPACE)
            self._say(Severity.WARNING, f"Only {capacity} items are supported")
            return
        self._store.begin(count)
        if count == 0:
            self._finish(peer)
            return
        self._start(peer, 0, count - 1)

    def on_write_partial(self, peer: Peer, message: MavMessage) -> None:
        """MISSION_WRITE_PARTIAL_LIST: replace a range of items."""
        if not self._allowed(peer):
            return
        if self._upload is not None:
            self._ack(peer, MissionResult.DENIED)
            return
        first, last = int(message.start_index), int(message.end_index)
        if not 0 <= first <= last <= len(self._store):
            self._say(Severity.WARNING, "Flight plan update rejected")
            self._ack(peer, MissionResult.ERROR)
            return
        begin_update = getattr(self._store, "begin_update", None)
        if begin_update is not None:
            begin_update()
        self._start(peer, first, last)

    def on_item(self, peer: Peer, message: MavMessage) -> None:
        """MISSION_ITEM or MISSION_ITEM_INT of an upload."""
        item = item_from_message(message)
        if isinstance(item, MissionResult):
            self._ack(peer, item)
            return
        if message.get_type() == "MISSION_ITEM" and not self._warned_item:
            self._warned_item = True
            self._say(Severity.WARNING, "got MISSION_ITEM; GCS should send MISSION_ITEM_INT")
        upload = self._upload
        if upload is None:
            self._ack(peer, MissionResult.ERROR)
            return
        if item.seq != upload.next_seq:
            self._ack(peer, MissionResult.INVALID_SEQUENCE)
            return
        if (peer.system, peer.component) != (upload.peer.system, upload.peer.component):
            self._ack(peer, MissionResult.DENIED)
            return
        result = self._store.put(item, last_seq=upload.last_seq)
        if result is not MissionResult.ACCEPTED:
            self._ack(peer, result)
            self._upload = None
            self._store.abandon()
            return
        upload.received_s = self._now_s()
        upload.next_seq += 1
        if upload.next_seq > upload.last_seq:
            self._finish(peer)
        else:
            self._request(upload)

    def on_request_list(self, peer: Peer) -> None:
        """MISSION_REQUEST_LIST: send the number of items."""
        if not self._allowed(peer):
            return
        if self._upload is not None:
            self._ack(peer, MissionResult.DENIED)
            return
        self._send_count(peer)

    def on_request(self, peer: Peer, seq: int, *, as_float: bool) -> None:
        """MISSION_REQUEST_INT, or MISSION_REQUEST, which ArduPlane answers with the deprecated MISSION_ITEM."""
        if not self._allowed(peer):
            return
        if self._upload is not None and not as_float:
            self._ack(peer, MissionResult.DENIED)
            return
        item = self._store.read(seq)
        if item is None:
            if not as_float:
                self._send_count(peer)
            self._ack(peer, MissionResult.INVALID_SEQUENCE)
            return
        if as_float and not self._warned_request:
            self._warned_request = True
            self._say(Severity.WARNING, "got MISSION_REQUEST; use MISSION_REQUEST_INT!")
        self._send(
            peer,
            item_to_message(item, seq=seq, system=peer.system, component=peer.component, as_float=as_float),
        )

    def on_clear(self, peer: Peer) -> None:
        """MISSION_CLEAR_ALL."""
        if not self._allowed(peer):
            return
        if not self._cancel(peer):
            return
        is_clear = self._store.clear()
        self._ack(peer, MissionResult.ACCEPTED if is_clear else MissionResult.ERROR)
        if is_clear and self.kind.says_when_cleared and self.kind.received is not None:
            self._say(*self.kind.received)

    def tick(self) -> None:
        """Repeat a request, or time out."""
        upload = self._upload
        if upload is None:
            return
        now_s = self._now_s()
        if now_s - upload.received_s > _GIVE_UP_S:
            self._upload = None
            self._store.abandon()
            self._say(Severity.WARNING, f"{self.kind.name} upload timeout")
            self._ack(upload.peer, MissionResult.OPERATION_CANCELLED)
        elif now_s - upload.requested_s > _REQUEST_AGAIN_S:
            self._request(upload)

    def forget(self, link: Link) -> None:
        """Handle the loss of a link; an upload on it times out, unless the vehicle reboots first."""
        if self._upload is not None and self._upload.peer.link is link:
            self._upload.peer = Peer(Link("gone"), self._upload.peer.system, self._upload.peer.component)

    def reset(self) -> None:
        """Reset after a reboot."""
        if self._upload is not None:
            self._upload = None
            self._store.abandon()
        self._warned_item = self._warned_request = False

    def _allowed(self, peer: Peer) -> bool:
        if self.kind.number == 0 or peer.link.version == 2:
            return True
        self._say(Severity.WARNING, "Need mavlink2 for item transfer")
        self._ack(peer, MissionResult.UNSUPPORTED)
        return False

    def _cancel(self, peer: Peer) -> bool:
        if self._upload is not None:
            if (peer.system, peer.component) != (self._upload.peer.system, self._upload.peer.component):
                self._ack(peer, MissionResult.DENIED)
                return False
            self._upload = None
            self._store.abandon()
        return True

    def _start(self, peer: Peer, first: int, last: int) -> None:
        now_s = self._now_s()
        self._upload = _Upload(peer, first, last, now_s, now_s)
        self._request(self._upload)

    def _request(self, upload: _Upload) -> None:
        upload.requested_s = self._now_s()
        peer = upload.peer
        self._send(
            peer,
            dialect.MAVLink_mission_request_message(peer.system, peer.component, upload.next_seq, self.kind.number),
        )

    def _send_count(self, peer: Peer) -> None:
        self._send(
            peer,
            dialect.MAVLink_mission_count_message(peer.system, peer.component, len(self._store), self.kind.number),
        )

    def _finish(self, peer: Peer) -> None:
        result = self._store.complete()
        self._upload = None
        self._ack(peer, result)
        if result is not MissionResult.ACCEPTED:
            for complaint in self._store.complaints:
                self._say(*complaint)
        elif self.kind.received is not None:
            self._say(*self.kind.received)

    def _ack(self, peer: Peer, result: MissionResult) -> None:
        self._send(
            peer,
            dialect.MAVLink_mission_ack_message(peer.system, peer.component, int(result), self.kind.number),
        )

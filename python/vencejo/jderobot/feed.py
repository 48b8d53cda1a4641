"""Pushes telemetry and events to subscribers. A slow subscriber loses the oldest ones and delays no other."""

from __future__ import annotations

import secrets
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from vencejo.errors import Busy, InvalidRequest, VencejoError
from vencejo.jderobot.access import remote_address
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.states import States
from vencejo.jderobot.subject import LOG
from vencejo.values import Event
from vencejo.vehicle import Vehicle

if TYPE_CHECKING:
    from vencejo import Subscription

__all__ = ["Feed"]

_MAX_SUBSCRIPTIONS: Final = 256
_MAX_EVENTS: Final = 256
"""Most events queued for one subscriber; the oldest are dropped."""
_MAX_UNSENT: Final = 16
"""Most calls to one subscriber that its connection has not accepted yet."""
_MAX_NUMBER: Final = 2**31 - 1
_LOOK_S: Final = 0.2
_AT_LEAST_S: Final = 5.0
"""Longest time between calls: without news the observer is called too, so that it sees values age and its connection stays open."""
_ASK_S: Final = 1.0
"""How often the subscriber's authorisation is checked again, at least."""


@dataclass
class _Subscriber:
    number: int
    vehicle: Vehicle
    observer: Any
    period_s: float
    refusal: Callable[[], str | None]
    """Why the subscription would be refused now; ``None`` if it would not."""
    due_s: float
    ask_s: float
    seen: int = -1
    told_s: float = 0.0
    events: deque[Event] = field(default_factory=lambda: deque(maxlen=_MAX_EVENTS))
    unsent: deque[Any] = field(default_factory=deque)
    watch: Subscription | None = None


class Feed:
    """Calls observers, from one thread.

    Parameters
    ----------
    slices : Slices
    states : States
    clock : function, optional
        Monotonic seconds.
    """

    def __init__(self, slices: Slices, states: States, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._ice = slices.ice
        self._precise = slices.precise
        self._states = states
        self._clock = clock
        self._changed = threading.Condition()
        self._subscribers: dict[int, _Subscriber] = {}
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="vencejo-ice-feed", daemon=True)
        self._thread.start()

    def subscribe(
        self, vehicle: Vehicle, observer: Any, rate_hz: float, connection: Any, refusal: Callable[[], str | None]
    ) -> int:
        """Call an observer over a connection of ours, only at the address of the request, so that no client aims us at others.

        Calls stop as soon as `refusal` gives a reason, and the subscription ends within a second.

        Raises
        ------
        InvalidRequest, Busy
        """
        if observer is None:
            raise InvalidRequest("the observer is null")
        remote = remote_address(connection)
        mine = []
        for endpoint in observer.ice_getEndpoints():
            info = endpoint.getInfo()
            while info is not None and not hasattr(info, "host"):
                info = info.underlying
            if info is not None and info.host == remote:
                mine.append(endpoint)
        if not mine:
            raise InvalidRequest(
                f"the observer has no endpoint at {remote}, where the request comes from; use subscribeHere instead"
            )
        return self._add(vehicle, observer.ice_endpoints(mine).ice_oneway(), rate_hz, refusal)

    def subscribe_here(
        self, vehicle: Vehicle, identity: str, rate_hz: float, connection: Any, refusal: Callable[[], str | None]
    ) -> int:
        """Call an observer over its own connection, for as long as `refusal` gives no reason.

        Raises
        ------
        InvalidRequest, Busy
        """
        try:
            name = self._ice.stringToIdentity(identity)
        except self._ice.IdentityParseException as error:
            raise InvalidRequest(f"{identity[:80]!r} is no identity; write name or category/name") from error
        if not name.name or connection is None:
            raise InvalidRequest("an observer has a name and a connection")
        proxy = self._precise.ObserverPrx.uncheckedCast(connection.createProxy(name)).ice_oneway()
        return self._add(vehicle, proxy, rate_hz, refusal)

    def _add(self, vehicle: Vehicle, observer: Any, rate_hz: float, refusal: Callable[[], str | None]) -> int:
        if not 0.1 <= rate_hz <= 50.0:
            raise InvalidRequest(f"rateHz is {rate_hz}, should be 0.1 to 50")
        with self._changed:
            if len(self._subscribers) >= _MAX_SUBSCRIPTIONS:
                raise Busy(f"there are {_MAX_SUBSCRIPTIONS} subscriptions already")
            number = self._new_number()
            now = self._clock()
            subscriber = _Subscriber(number, vehicle, observer, 1.0 / rate_hz, refusal, due_s=now, ask_s=now)
            subscriber.watch = vehicle.on_event(lambda event: self._on_event(subscriber, event))
            self._subscribers[number] = subscriber
            self._changed.notify_all()
        return number

    def _new_number(self) -> int:
        """A number that cannot be guessed: it is all that is needed to end the subscription."""
        while (number := secrets.randbelow(_MAX_NUMBER) + 1) in self._subscribers:
            pass
        return number

    def unsubscribe(self, number: int) -> None:
        """End a subscription."""
        with self._changed:
            subscriber = self._subscribers.pop(number, None)
        if subscriber is not None and subscriber.watch is not None:
            subscriber.watch.close()

    def close(self) -> None:
        """End all."""
        with self._changed:
            self._closed = True
            numbers = list(self._subscribers)
            self._changed.notify_all()
        for number in numbers:
            self.unsubscribe(number)
        self._thread.join(timeout=5.0)

    def _on_event(self, subscriber: _Subscriber, event: Event) -> None:
        with self._changed:
            subscriber.events.append(event)
            self._changed.notify_all()

    def _run(self) -> None:
        while True:
            with self._changed:
                if self._closed:
                    return
                now = self._clock()
                ready = [s for s in self._subscribers.values() if s.events or min(s.due_s, s.ask_s) <= now]
                if not ready:
                    dues = [min(s.due_s, s.ask_s) for s in self._subscribers.values()]
                    self._changed.wait(min((due - now for due in dues), default=None))
                    continue
            for subscriber in ready:
                ended = subscriber.refusal()
                subscriber.ask_s = now + _ASK_S
                if ended is None and not self._serve(subscriber, now):
                    ended = "its observer cannot be reached"
                if ended is not None:
                    LOG.info("subscription %d ended: %s", subscriber.number, ended)
                    self.unsubscribe(subscriber.number)

    def _serve(self, subscriber: _Subscriber, now_s: float) -> bool:
        """Send what is due; False when the observer cannot be reached any more."""
        while subscriber.unsent and subscriber.unsent[0].is_sent():
            subscriber.unsent.popleft()
        try:
            if any(call.done() and call.exception() is not None for call in subscriber.unsent):
                return False
            has_room = len(subscriber.unsent) < _MAX_UNSENT
            while has_room and subscriber.events:
                event = self._states.event(subscriber.vehicle, subscriber.events.popleft())
                subscriber.unsent.append(subscriber.observer.happenedAsync(event))
                has_room = len(subscriber.unsent) < _MAX_UNSENT
            if not has_room:
                # A connection that takes nothing: look again later.
                subscriber.due_s = now_s + _LOOK_S
                with self._changed:
                    subscriber.events.clear()
                return True
            if subscriber.due_s <= now_s:
                subscriber.due_s = max(subscriber.due_s + subscriber.period_s, now_s)
                # Latest wins: no other is sent while one is in flight.
                if not subscriber.unsent and self._is_worth_telling(subscriber, now_s):
                    telemetry = subscriber.vehicle.telemetry
                    subscriber.unsent.append(
                        subscriber.observer.movedAsync(
                            self._states.pose(subscriber.vehicle, telemetry),
                            self._states.navigation(subscriber.vehicle, telemetry),
                        )
                    )
        except (self._ice.Exception, VencejoError):
            return False
        return True

    @staticmethod
    def _is_worth_telling(subscriber: _Subscriber, now_s: float) -> bool:
        count = subscriber.vehicle.change_count
        if count == subscriber.seen and now_s - subscriber.told_s < _AT_LEAST_S:
            return False
        subscriber.seen, subscriber.told_s = count, now_s
        return True

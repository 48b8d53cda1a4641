"""One subscription for all vehicles of a station."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Iterator
from itertools import islice

import pytest
import vencejo
from pymavlink.dialects.v20 import ardupilotmega as dialect
from vencejo import aio

from tests.support import uncaught, wait_for

LIMIT_S = 120


class Fleet:
    """Planes on one socket that only send heartbeats, each numbered in its custom mode."""

    def __init__(self, station: vencejo.Station) -> None:
        host, _, port = str(station.links[0].local_address).rpartition(":")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((host, int(port)))
        self._planes: dict[int, dialect.MAVLink] = {}

    def beat(self, system: int, number: int) -> None:
        """Send one heartbeat of a plane."""
        plane = self._planes.setdefault(system, dialect.MAVLink(None, srcSystem=system, srcComponent=1))
        message = plane.heartbeat_encode(
            dialect.MAV_TYPE_FIXED_WING, dialect.MAV_AUTOPILOT_ARDUPILOTMEGA, 81, number, 4
        )
        self._socket.send(message.pack(plane))

    def close(self) -> None:
        """Send no more."""
        self._socket.close()


@pytest.fixture
def station() -> Iterator[vencejo.Station]:
    with vencejo.Station("udpin:127.0.0.1:0", record=False, request_streams=False) as station:
        wait_for(lambda: station.links[0].local_address is not None, "the link")
        yield station


@pytest.fixture
def fleet(station: vencejo.Station) -> Iterator[Fleet]:
    fleet = Fleet(station)
    yield fleet
    fleet.close()


def test_every_message_of_every_vehicle_in_order(station: vencejo.Station, fleet: Fleet) -> None:
    sent = [(system, number) for number in range(200) for system in (1, 2, 3)]
    heard: list[tuple[int, int]] = []
    threads = set()

    def on_message(message: vencejo.MavlinkMessage) -> None:
        threads.add(threading.current_thread())
        heard.append((message.system_id, message.fields["custom_mode"]))

    with station.on_message(on_message, names=["HEARTBEAT"]) as subscription:
        for system, number in sent:
            fleet.beat(system, number)
        wait_for(lambda: len(heard) == len(sent), "all of them")
        assert subscription.dropped == 0
    # Those of vehicles that were not heard before as well.
    assert heard == sent
    assert len(threads) == 1


def test_a_slow_callback_loses_the_oldest_and_an_error_nothing(
    station: vencejo.Station, fleet: Fleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = uncaught(monkeypatch)
    heard: list[int] = []
    called, go = threading.Event(), threading.Event()

    def on_message(message: vencejo.MavlinkMessage) -> None:
        heard.append(message.fields["custom_mode"])
        called.set()
        assert go.wait(LIMIT_S)
        raise ValueError("as this test wants it")

    with station.on_message(on_message, capacity=4) as subscription:
        fleet.beat(1, 0)
        assert called.wait(LIMIT_S)
        for number in range(1, 11):
            fleet.beat(1, number)
        wait_for(lambda: subscription.dropped == 6, "the overflow")
        go.set()
        wait_for(lambda: subscription.failed == 5, "the end of those that were left")
    assert heard == [0, 7, 8, 9, 10]
    assert len(told) == 1, "the same error is told once"


def test_closing_within_what_waits_calls_no_more(station: vencejo.Station, fleet: Fleet) -> None:
    heard: list[int] = []
    called, go = threading.Event(), threading.Event()

    def on_message(message: vencejo.MavlinkMessage) -> None:
        heard.append(message.fields["custom_mode"])
        called.set()
        assert go.wait(LIMIT_S)
        subscription.close()

    subscription = station.on_message(on_message)
    for number in range(5):
        fleet.beat(1, number)
    assert called.wait(LIMIT_S)
    wait_for(lambda: station.links[0].frames_received == 5, "all of them")
    go.set()
    wait_for(lambda: not [t for t in threading.enumerate() if t.name == "vencejo-callback"], "the thread's end")
    assert heard == [0]
    # What waited can still be taken.
    assert [message.fields["custom_mode"] for message in iter(lambda: subscription.get(0.0), None)] == [1, 2, 3, 4]


def test_messages_are_iterated_in_order_and_the_oldest_goes(station: vencejo.Station, fleet: Fleet) -> None:
    fleet.beat(1, 0)
    plane = station.wait_vehicle()
    with plane.messages("HEARTBEAT", capacity=4) as messages:
        for number in range(1, 11):
            fleet.beat(1, number)
        wait_for(lambda: messages.dropped == 6, "the overflow")
        fields = [message.fields["custom_mode"] for message in islice(messages, 4)]
    assert fields == [7, 8, 9, 10]
    assert list(messages) == []
    assert (list(plane.messages(timeout_s=0.0)), list(plane.events(timeout_s=0.0))) == ([], [])
    for wrong in (lambda: plane.messages("NO_SUCH_MESSAGE"), lambda: plane.events(timeout_s=-1.0)):
        with pytest.raises(vencejo.InvalidRequest):
            wrong()
    events = plane.events()
    fleet.beat(1, 11)
    assert (event := next(events)).kind == "mode", event
    ended = threading.Thread(target=lambda: list(events))
    ended.start()
    station.close()
    ended.join(LIMIT_S)
    assert not ended.is_alive()


async def test_asyncio_iterates_the_same(station: vencejo.Station, fleet: Fleet) -> None:
    fleet.beat(1, 0)
    plane = await aio.wait_vehicle(station)
    messages = plane.messages("HEARTBEAT", timeout_s=LIMIT_S)
    events = plane.events()
    for number in range(1, 6):
        fleet.beat(1, number)
    assert [(await anext(messages)).fields["custom_mode"] for _ in range(3)] == [1, 2, 3]
    # Other tasks run between messages that wait: this one is cancelled after its first, and loses none.
    wait_for(lambda: station.links[0].frames_received == 6, "all of them")
    taken: list[int] = []

    async def take() -> None:
        async for message in messages:
            taken.append(message.fields["custom_mode"])
            taking.cancel()

    taking = asyncio.create_task(take())
    with pytest.raises(asyncio.CancelledError):
        await taking
    assert (taken, (await anext(messages)).fields["custom_mode"]) == ([4], 5)
    assert (await anext(events)).kind == "mode"
    assert [message async for message in plane.messages(timeout_s=0.0)] == []

    async def rest() -> list[vencejo.Event]:
        return [event async for event in events]

    ended = asyncio.create_task(rest())
    await asyncio.sleep(0)
    await plane.close()
    assert {event.kind for event in await ended} == {"mode"}


def test_a_closed_station_has_none() -> None:
    station = vencejo.Station(record=False)
    station.close()
    assert station.on_message(lambda message: None).get(None) is None
    with vencejo.Station(record=False) as station:
        subscription = station.on_message(lambda message: None)
    assert subscription.get(None) is None

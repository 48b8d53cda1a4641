"""A wall clock that jumps under the whole program: set by a person or a GPS, a time zone, or a suspended machine.

`vencejo serve` runs under libfaketime, which changes the process's wall clock only. That covers a suspend too: on Linux
CLOCK_MONOTONIC "does not count time that the system is suspended" (clock_gettime(2)), so after a suspend the wall clock
is the only thing that has changed for a process. The plane, a separate process, keeps the true time.
"""

from __future__ import annotations

import calendar
import contextlib
import itertools
import os
import random
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.clock import Clock
from tests.server.client import Client, WebSocket, serving
from tests.support import Metronome, simulated_plane, wait_for

HOUR_S = 3600
JUMPS: dict[str, Callable[[int], int]] = {
    "an hour ahead": lambda now_s: HOUR_S,
    "an hour behind": lambda now_s: -HOUR_S,
    "1970": lambda now_s: 10 - now_s,
    "2040": lambda now_s: calendar.timegm((2040, 1, 1, 0, 0, 0)) - now_s,
    # One second before the clocks of Europe/Madrid, the time zone of this process, go back from 3 to 2.
    "daylight saving ends": lambda now_s: calendar.timegm((2026, 10, 25, 0, 59, 59)) - now_s,
    "the true time": lambda now_s: 0,
}
"""Offset of the clock from now on, in whole seconds since 1970."""
VALID_S = 15.0
"""Validity of a confirmation."""


class Tap(threading.Thread):
    """A UDP port that receives the station's broadcasts, and records the times of its heartbeats on a metronome."""

    def __init__(self, metronome: Metronome) -> None:
        super().__init__(name="tap", daemon=True)
        self.metronome = metronome
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self.port = int(self._socket.getsockname()[1])
        self.heartbeats: list[float] = []
        self.start()

    def run(self) -> None:
        while frame := self._socket.recv(2048):
            if frame[0] == 0xFD and int.from_bytes(frame[7:10], "little") == 0:
                self.heartbeats.append(self.metronome.now_s)

    def hear(self, count: int, since: int) -> None:
        """Wait for a number of further heartbeats."""
        wait_for(lambda: len(self.heartbeats) >= since + count, "our heartbeats")

    def close(self) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as last:
            last.sendto(b"", self._socket.getsockname())
        self.join(10)
        self._socket.close()


class Watcher(threading.Thread):
    """A browser that only reads: all messages of the WebSocket."""

    def __init__(self, client: Client) -> None:
        super().__init__(name="watcher", daemon=True)
        self._socket = WebSocket(client)
        self._socket.say(type="subscribe", vehicle=1, rate_hz=10)
        self.said: list[dict[str, Any]] = []
        self.is_over = False
        self.start()

    def run(self) -> None:
        with contextlib.suppress(OSError):
            while (message := self._socket.take()) is not None:
                self.said.append(message)
        self.is_over = True

    def hear(self, kind: str, count: int, since: int) -> None:
        """Wait for a number of messages of a type after the first `since`."""
        wait_for(lambda: sum(m["type"] == kind for m in self.said[since:]) >= count, f"{count} of {kind}")

    def check(self) -> None:
        """Check that nothing was lost, stale, restarted or closed."""
        assert not self.is_over, "the WebSocket ended"
        said = list(self.said)
        events = [m["kind"] for m in said if m["type"] == "event"]
        assert not {"lost", "regained", "rebooted", "contested", "streams_fell_back"} & set(events), events
        ages = [each["age_s"] for m in said if m["type"] == "vehicles" for each in m["vehicles"]]
        assert ages
        assert max(ages) < 3.5, f"stale: {max(ages)} s"
        assert all(m["has_control"] for m in said if m["type"] in {"hello", "control"})
        assert [m for m in said if m["type"] == "storage" and m["problems"]] == []

    def close(self) -> None:
        self._socket.close()


def mission(number: int) -> bytes:
    """Return a mission unique to the number, as a file."""
    home = "0\t1\t0\t16\t0\t0\t0\t0\t40.3332\t-3.7978\t600\t1"
    items = [
        f"{at}\t0\t3\t16\t0\t0\t0\t0\t{40.33 + at / 1e3}\t{-3.79 + number / 1e4}\t{100 + number}\t1"
        for at in range(1, 6)
    ]
    return "\n".join(["QGC WPL 110", home, *items, ""]).encode()


def times_of(tlog: bytes) -> list[int]:
    """Return the timestamps of a recording, in microseconds since 1970, parsed by its layout (MAVLink 2 frames)."""
    times, at = [], 0
    while at + 18 <= len(tlog):
        (stamp,) = struct.unpack_from(">Q", tlog, at)
        magic, length, flags = tlog[at + 8 : at + 11]
        assert magic == 0xFD, (at, tlog[at : at + 16])
        assert flags & 1 == 0, "signatures are taken off what is recorded"
        times.append(stamp)
        at += 8 + 12 + length
    return times


@contextlib.contextmanager
def signed_flight(tmp_path: Path, clock: Clock, metronome: Metronome) -> Iterator[tuple[Client, Tap, Path, str]]:
    """Serve a station under the clock, with a signing plane over UDP; yield an operator's client and more."""
    data, tap = tmp_path / "data", Tap(metronome)
    options = ("--record", "--token", f"--link=udpout:127.0.0.1:{tap.port}", "--telemetry-floor=0")
    with contextlib.closing(tap), serving(*options, data=data, env=clock.env) as served:
        token = served.token("operator")
        client = served.client(token=token, name="pilot")
        link = client.done("POST", "links", {"address": "udpin:127.0.0.1:0", "accept_unsigned": False})

        def address() -> str | None:
            links = {each["id"]: each for each in client.done("GET", "links")}
            return links[link["id"]]["local_address"]  # type: ignore[no-any-return]

        wait_for(lambda: address() is not None, "the link")
        # A plane's first link is its USB port, where it accepts unsigned frames.
        with simulated_plane(f"--link=udpout:{address()}"):
            wait_for(lambda: client.done("GET", "vehicles") != [], "the plane")
            change = {"act": "set_up", "confirm_system_id": 1, "any_link": True}
            assert client.done("POST", "vehicles/1/signing", change)["must_sign"] is True
            yield client, tap, data, token


def confirmation(client: Client) -> dict[str, str]:
    """Request an action that must be confirmed; return the confirmation header."""
    asked = client.ask("DELETE", "vehicles/1/plan/fence")
    assert asked.status == 428, asked.body
    return {"Vencejo-Confirmation": asked.json["cause"]["confirmation"]}


def jump_and_look(clock: Clock, client: Client, tap: Tap, watcher: Watcher, token: str, jump: str, number: int) -> None:
    """Make one jump, and check everything that depends on time."""
    given = confirmation(client)
    session = client.done("GET", "session")["session"]
    before = client.done("GET", "recorder")
    signing = client.done("GET", "vehicles/1/signing")
    now_s = time.time()
    offset_s = JUMPS[jump](int(now_s))
    clock.set(offset_s)
    beats, said = len(tap.heartbeats), len(watcher.said)

    plan = client.ask("POST", "plan/parse?name=m.waypoints", mission(number)).json
    base = (client.done("GET", "draft")["current"] or {"revision": 0})["revision"]
    draft = client.done("PUT", "draft", {"base": base, "author": "test", "plan": plan})
    assert draft["revision"] == base + 1
    assert abs(draft["saved_unix_s"] - now_s - offset_s) < 60, "the station's clock did jump"

    client.operation("DELETE", "vehicles/1/plan/fence", **given)  # with a confirmation from before the jump
    client.operation("PUT", "vehicles/1/plan/mission", plan)
    assert client.done("GET", "vehicles/1")["plan_states"]["mission"]["state"] == "verified"

    mine = client.done("GET", "session")
    assert (mine["session"], mine["has_control"]) == (session, True)
    other = Client(client.url)
    assert other.open_session(token=token)["role"] == "operator"
    other.done("DELETE", "session")

    tap.hear(1, beats)
    watcher.hear("telemetry", 3, said)
    watcher.hear("vehicles", 1, said)
    watcher.check()
    after = client.done("GET", "recorder")
    assert (after["file"], after["dropped"], after["problem"]) == (before["file"], 0, None)
    assert after["frames"] > before["frames"]
    signs = client.done("GET", "vehicles/1/signing")
    assert signs["verified"] > signing["verified"]
    refused = {name: count for name, count in signs.items() if name.startswith("refused_")}
    assert refused == {name: signing[name] for name in refused}, "none of the plane's frames was refused"


def through_the_jumps(tmp_path: Path, jumps: list[str], *, outlives: bool) -> None:
    """Fly through jumps of the clock; with `outlives`, check after each whether a confirmation expires in time."""
    clock = Clock(tmp_path)
    with Metronome() as metronome, signed_flight(tmp_path, clock, metronome) as (client, tap, data, token):
        tap.hear(1, 0)
        watcher = Watcher(client)
        began, began_unix_s, since_s = time.monotonic(), time.time(), metronome.now_s
        watcher.hear("vehicles", 1, 0)
        for number, jump in enumerate(jumps):
            jump_and_look(clock, client, tap, watcher, token, jump, number)
            if outlives:
                # Requested at the time to which the next jump returns.
                given = confirmation(client)
                until = time.monotonic() + VALID_S
                clock.set(JUMPS[jumps[number - 1]](int(time.time())))
                wait_for(lambda until=until: time.monotonic() > until, "it expires", VALID_S + 10)  # type: ignore[misc]
                assert client.ask("DELETE", "vehicles/1/plan/fence", **given).status == 412, "it lived too long"
                watcher.check()
        ended, until_s = time.monotonic(), metronome.now_s
        file = data / "telemetry" / client.done("GET", "recorder")["file"]
        watcher.close()
    beats = [at for at in tap.heartbeats if since_s <= at <= until_s]
    assert max(b - a for a, b in itertools.pairwise(beats)) < 2.0, "our heartbeat is awaited each second"
    assert until_s - since_s - 2 <= 1.01 * len(beats), "once a second, no less"
    assert 0.99 * len(beats) <= ended - began + 2, "and no more"

    times = times_of(file.read_bytes())
    flight = [each for each in times if each >= began_unix_s * 1e6]
    assert len(flight) > 100
    assert all(a >> 2 <= b >> 2 for a, b in itertools.pairwise(times)), "they rise; the lowest two bits are the link's"
    # On this clock, which continues while a busy machine delays the plane or the recorder.
    assert max(b - a for a, b in itertools.pairwise(flight)) < 1_500_000 + metronome.longest_s * 1e6, "a gap"
    assert abs((flight[-1] - flight[0]) / 1e6 - (ended - began)) < 3.0, "as long as it took"
    assert [path.name for path in file.parent.iterdir()] == [file.name], "one recording"


@pytest.mark.fault(
    61,
    figure="serve and a signing plane: ± 1 h, 1970, 2040, the end of daylight saving, back: nothing lost, late or twice",
)
@pytest.mark.e2e
def test_a_clock_that_jumps_ends_nothing(tmp_path: Path) -> None:
    through_the_jumps(tmp_path, list(JUMPS), outlives=False)


@pytest.mark.fault(
    61, figure="the same by the hour, and no confirmation that outlives its 15 s when the clock goes back"
)
@pytest.mark.soak
@pytest.mark.timeout(0)
def test_a_clock_that_jumps_again_and_again(tmp_path: Path) -> None:
    """VENCEJO_SOAK_S sets the duration; each jump takes some 17 s."""
    seconds = float(os.environ.get("VENCEJO_SOAK_S", "3600"))
    choose = random.Random(61)
    jumps = list(JUMPS) + choose.choices(list(JUMPS), k=max(0, round(seconds / 17) - len(JUMPS)))
    through_the_jumps(tmp_path, jumps, outlives=True)

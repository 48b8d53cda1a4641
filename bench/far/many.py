"""A thousand aircraft at one ground station and router: cost, duration of commands, and fan-out to twenty listeners."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from bench.far.rig import (
    AIRCRAFT,
    ORG,
    PATIENCE_S,
    Router,
    bare_router,
    crowd,
    free_tcp_port,
    ground_station,
    heard,
    listeners,
)
from bench.harness import NotMeasured, contestant, quantile, repeat, result_of, running, usage_over, wait_line
from tests.server.client import Client, WebSocket

Figures = dict[str, float]
Table = dict[str, "Figures | str"]

STATIONS = 20
COMMANDS = 300
#: Silence after which a vehicle counts as lost.
LOST_AFTER_S = 5.0
#: From killing a router to the end of the count.
RESTART_S = 12.0


class Listening(WebSocket):
    """A WebSocket that counts received bytes."""

    received_bytes = 0

    def _frame(self) -> tuple[int, bytes]:
        opcode, payload = super()._frame()
        self.received_bytes += len(payload)
        return opcode, payload


class Roster(threading.Thread):
    """Follows the fleet list as a browser does: its bytes, and the largest age of an aircraft's row."""

    def __init__(self, client: Client) -> None:
        super().__init__(daemon=True)
        self._socket = Listening(client)
        self._heard_s: dict[int, float] = {}
        self._is_over = threading.Event()
        self.is_counting = threading.Event()
        self.oldest_s = 0.0
        self.shown_lost: set[int] = set()

    @property
    def received_bytes(self) -> int:
        """Return the number of bytes received so far."""
        return self._socket.received_bytes

    def run(self) -> None:
        """Receive until stopped."""
        self._socket.say(type="subscribe_roster")
        while not self._is_over.is_set() and (message := self._socket.take()) is not None:
            if message["type"] == "roster":
                self._on_roster(message)

    def _on_roster(self, message: dict[str, Any]) -> None:
        for row in message["rows"]:
            if (heard_s := row.get("heard_s")) is not None:
                self._heard_s[row["id"]] = heard_s
        if self.is_counting.is_set():
            ages = {number: message["time_s"] - heard_s for number, heard_s in self._heard_s.items()}
            self.oldest_s = max(self.oldest_s, *ages.values())
            self.shown_lost |= {number for number, age_s in ages.items() if age_s > LOST_AFTER_S}

    def end(self) -> None:
        """Stop following."""
        self._is_over.set()
        self.join(5)
        self._socket.close()


@contextlib.contextmanager
def following(client: Client) -> Iterator[Roster]:
    """Run a client that follows the fleet list."""
    roster = Roster(client)
    roster.start()
    try:
        yield roster
    finally:
        roster.end()


def all_there(client: Client) -> list[int]:
    """Wait until the station has all aircraft; return their ids."""
    give_up_at = time.monotonic() + PATIENCE_S
    while time.monotonic() < give_up_at:
        found = [each["system_id"] for each in client.done("GET", "vehicles") if each["mode"]]
        if len(found) >= AIRCRAFT:
            return found
        time.sleep(0.5)
    raise NotMeasured(f"{len(found)} of {AIRCRAFT} aircraft came within {PATIENCE_S:.0f} s")


def commands(client: Client, aircraft: list[int]) -> list[float]:
    """Command aircraft in turn, twice each, the first time including the request for control; return durations, ms."""
    client.done("POST", "control/take")
    took_ms = []
    for number in range(COMMANDS // 2):
        at = aircraft[number * 7 % len(aircraft)]
        for act in ("loiter", "mission/resume"):
            began = time.monotonic()
            client.done("POST", f"vehicles/{at}/{act}")
            took_ms.append((time.monotonic() - began) * 1e3)
    return took_ms


def spread(router: Router, seconds: float) -> Figures:
    """Let twenty stations listen through the router."""
    with listeners(router.endpoint, STATIONS, seconds) as process:
        usage = usage_over(router.pid, seconds - 0.5)
        found = result_of(process, seconds + PATIENCE_S)
    ages = found["ages"]
    return {
        "spread_cpu_percent": usage.cpu * 100,
        "spread_rss_mb": usage.rss_mb,
        "states_per_s": found["states"] / seconds,
        "worst_lost": float(found["lost"]),
        "median_us": ages["median_us"],
        "p99_us": ages["p99_us"],
        "worst_ms": ages["worst_us"] / 1000,
    }


def ours(seconds: float) -> Figures:
    """Measure `vencejo serve --fleet`, which is router and station in one process."""
    with ground_station() as station, crowd(station.endpoint) as aircraft:
        client = station.operator()
        there = all_there(client)
        time.sleep(2.0)
        quiet, crowded = usage_over(station.pid, seconds), usage_over(aircraft.pid, 1.0)
        with following(client) as roster:
            before, began = roster.received_bytes, time.monotonic()
            listed = usage_over(station.pid, seconds)
            list_kb_s = (roster.received_bytes - before) / 1000 / (time.monotonic() - began)
            took_ms = commands(client, there)
        client.done("POST", "control/release")
        return {
            "cpu_percent": quiet.cpu * 100,
            "rss_mb": listed.rss_mb,
            "list_cpu_percent": listed.cpu * 100,
            "list_kb_s": list_kb_s,
            "command_median_ms": quantile(took_ms, 0.5),
            "command_p99_ms": quantile(took_ms, 0.99),
            "crowd_cpu_percent": crowded.cpu * 100,
            **spread(station, seconds),
        }


def bare(seconds: float) -> Figures:
    """Measure a Zenoh router with the same traffic, unprocessed; its "command" is a query answered by an aircraft."""
    with bare_router(ORG) as router, crowd(router.endpoint) as aircraft:
        time.sleep(3.0)
        quiet, crowded = usage_over(router.pid, seconds), usage_over(aircraft.pid, 1.0)
        asked = heard(router.endpoint, 1, seconds, ["ask"])["asked"]
        return {
            "cpu_percent": quiet.cpu * 100,
            "rss_mb": quiet.rss_mb,
            "command_median_ms": asked["median_us"] / 1000,
            "command_p99_ms": asked["p99_us"] / 1000,
            "crowd_cpu_percent": crowded.cpu * 100,
            **spread(router, seconds),
        }


def far(runs: int, seconds: float) -> Table:
    """Measure a station and router with a thousand aircraft of ten states a second."""
    return repeat(runs, {"vencejo": lambda: ours(seconds), "Zenoh's router alone": lambda: bare(seconds)})


def far_age(runs: int, seconds: float) -> Table:
    """Measure the age of states in Python callbacks, in a process that is also the router of a thousand aircraft."""

    def once(name: str) -> Figures:
        port = free_tcp_port()
        with running(contestant(name, "far", port=port, org=ORG, aircraft=AIRCRAFT, seconds=seconds)) as process:
            wait_line(process, "READY", 20)
            with crowd(f"tcp/127.0.0.1:{port}"):
                wait_line(process, "ALL", PATIENCE_S)
                usage = usage_over(process.pid, seconds - 1)
                found = result_of(process, seconds + 20)
        return {
            "median_us": quantile(found["ages_us"], 0.5),
            "p99_us": quantile(found["ages_us"], 0.99),
            "worst_ms": max(found["ages_us"]) / 1000,
            "cpu_percent": usage.cpu * 100,
            "rss_mb": usage.rss_mb,
            "messages_per_s": found["messages"] / seconds,
        }

    return repeat(runs, {"vencejo": lambda: once("vencejo_peer"), "Zenoh's own wheel": lambda: once("zenoh_peer")})


def far_restart(runs: int, _seconds: float) -> Table:
    """Kill a router with a thousand aircraft and a ground station, and restart it on the same port."""

    def once(router: Callable[..., contextlib.AbstractContextManager[Router]]) -> Figures:
        port = free_tcp_port()
        with contextlib.ExitStack() as stack:
            first = stack.enter_context(router(port=port))
            station = stack.enter_context(ground_station("--fleet-router", first.endpoint))
            stack.enter_context(crowd(first.endpoint))
            client = station.operator()
            all_there(client)
            roster = stack.enter_context(following(client))
            process = stack.enter_context(listeners(first.endpoint, 1, RESTART_S))
            # The whole list has arrived, and changes are being sent.
            time.sleep(2.0)
            roster.is_counting.set()
            first.process.kill()
            first.process.wait()
            began = time.monotonic()
            stack.enter_context(router(port=port))
            started_s = time.monotonic() - began
            found = result_of(process, RESTART_S + PATIENCE_S)
            if found["aircraft"] < AIRCRAFT:
                raise NotMeasured(f"{found['aircraft']} of {AIRCRAFT} aircraft were heard")
            return {
                "seconds": found["longest_silence_s"],
                "started_s": started_s,
                "shown_s": roster.oldest_s,
                "worst_shown_lost": float(len(roster.shown_lost)),
            }

    return repeat(runs, {"vencejo": lambda: once(ground_station), "Zenoh's router alone": lambda: once(bare_router)})

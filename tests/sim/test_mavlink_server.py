"""The loop with real sockets: many clients, bad clients, slow clients, several planes, shutdown."""

from __future__ import annotations

import json
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from types import SimpleNamespace
from typing import Any

import pytest
from vencejo.sim import SimOptions, SimulatedPlane, server
from vencejo.sim.config import parse_link
from vencejo.sim.mavlink.codec import Decoder, dialect
from vencejo.sim.server import SimServer

from tests.sim.autopilot_double import DoubleAutopilot

PATIENCE_S = 120.0


class Station:
    """A plain socket client."""

    def __init__(self, port: int, *, system: int = 255) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self._decoder = Decoder()
        self._packer = dialect.MAVLink(None, srcSystem=system, srcComponent=190)

    def send(self, message: Any, *, mavlink1: bool = False) -> None:
        self.socket.sendall(message.pack(self._packer, force_mavlink1=mavlink1))

    def messages(self) -> Iterator[Any]:
        while data := self.socket.recv(65536):
            yield from self._decoder.feed(data)

    def wait(self, kind: str, condition: Callable[[Any], bool] = lambda _m: True) -> Any:
        for message in self.messages():
            if message.get_type() == kind and condition(message):
                return message
        raise AssertionError(f"the connection ended before a {kind}")

    def close(self) -> None:
        self.socket.close()


@pytest.fixture
def sim() -> Iterator[SimulatedPlane]:
    options = SimOptions(links=("tcp:127.0.0.1:0",), speedup=20.0)
    with SimulatedPlane(options, autopilot=DoubleAutopilot) as running:
        yield running


def eventually(condition: Callable[[], bool]) -> None:
    """Poll a condition of another thread or process; there is no event to wait for."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.005)


def test_items_are_taken_one_a_main_loop(sim: SimulatedPlane) -> None:
    """Recorded: an upload without delay takes 20 ms an item, the period of ArduPlane's main loop."""

    def time_s() -> float:
        return sim.call(lambda world: world.planes[0].autopilot.time_s)

    count = 20
    with closing(Station(sim.port)) as station:
        station.wait("HOME_POSITION")
        sim.call(lambda world: world.planes[0].params.set("SIM_SPEEDUP", 1.0))
        began_s = time_s()
        station.send(dialect.MAVLink_mission_count_message(1, 1, count, 0))
        for seq in range(count):
            station.wait("MISSION_REQUEST", lambda m, seq=seq: m.seq == seq)  # type: ignore[misc]
            station.send(
                dialect.MAVLink_mission_item_int_message(
                    1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 403330000, -37970000, 50, 0
                )
            )
        assert station.wait("MISSION_ACK").type == 0
    assert time_s() - began_s >= 0.02 * count - 1e-6


def test_clients_at_once_each_hear_the_plane(sim: SimulatedPlane) -> None:
    with closing(Station(sim.port)) as one, closing(Station(sim.port, system=254)) as two:
        for station in (one, two):
            beat = station.wait("HEARTBEAT")
            assert (beat.type, beat.autopilot, beat.get_srcSystem(), beat.get_srcComponent()) == (1, 3, 1, 1)
            assert station.wait("ATTITUDE").roll == pytest.approx(0.01)
    eventually(lambda: sim.clients == 0)


def test_a_client_that_garbles_or_vanishes_disturbs_nobody(sim: SimulatedPlane) -> None:
    with closing(Station(sim.port)) as good:
        good.wait("HEARTBEAT")
        noise = random.Random(5)
        bad = Station(sim.port)
        bad.socket.sendall(noise.randbytes(200_000))
        bad.send(dialect.MAVLink_command_long_message(1, 1, 512, 0, 242, 0, 0, 0, 0, 0, 0))
        bad.wait("COMMAND_ACK", lambda m: m.command == 512)
        bad.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
        bad.close()  # with a reset, in the middle of telemetry
        first = good.wait("ATTITUDE").time_boot_ms
        assert good.wait("ATTITUDE", lambda m: m.time_boot_ms > first + 2000)
        assert sim.call(lambda world: world.planes[0].snapshot().mode) == 0


def test_a_client_that_never_reads_loses_telemetry_and_stalls_nobody(sim: SimulatedPlane) -> None:
    lazy = Station(sim.port)
    lazy.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 40, 1))
    with closing(lazy), closing(Station(sim.port)) as good:
        good.wait("HEARTBEAT")

        def dropped() -> bool:
            return sim.call(lambda world: any(link.dropped for link in world._carried))

        eventually(dropped)
        before = good.wait("ATTITUDE").time_boot_ms
        assert good.wait("ATTITUDE", lambda m: m.time_boot_ms > before + 2000)


def test_a_mavlink_1_client_is_answered_in_mavlink_1(sim: SimulatedPlane) -> None:
    with closing(Station(sim.port)) as station:
        station.send(dialect.MAVLink_param_request_read_message(1, 1, b"WP_RADIUS", -1), mavlink1=True)
        value = station.wait("PARAM_VALUE", lambda m: m.param_id == "WP_RADIUS")
        assert value.param_value == 50.0
        assert value.get_msgbuf()[0] == 0xFE
        later = station.wait("BATTERY_STATUS")
        assert later.get_msgbuf()[0] == 0xFE
        assert later.get_msgbuf()[1] == 36  # without its extensions


def test_sequence_numbers_leave_without_gaps(sim: SimulatedPlane) -> None:
    with closing(Station(sim.port)) as station:
        station.send(dialect.MAVLink_param_request_list_message(1, 1))
        sequence = None
        for seen, message in enumerate(station.messages()):
            if sequence is not None:
                assert message.get_seq() == (sequence + 1) % 256
            sequence = message.get_seq()
            if seen > 3000:
                break


def test_planes_share_a_link() -> None:
    options = SimOptions(links=("tcp:127.0.0.1:0",), planes=3, speedup=20.0)
    with SimulatedPlane(options, autopilot=DoubleAutopilot) as sim, closing(Station(sim.port)) as station:
        for system in (1, 2, 3):
            station.send(dialect.MAVLink_command_long_message(system, 1, 176, 0, 1, 10 + system, 0, 0, 0, 0, 0))
        found = {}
        for message in station.messages():
            if message.get_type() == "HEARTBEAT" and message.custom_mode:
                found[message.get_srcSystem()] = message.custom_mode
            if len(found) == 3:
                break
        assert found == {1: 11, 2: 12, 3: 13}


def test_planes_on_links_of_their_own() -> None:
    options = SimOptions(links=("tcp:127.0.0.1:0",), planes=2, ports="consecutive", speedup=20.0)
    with SimulatedPlane(options, autopilot=DoubleAutopilot) as sim:
        assert len(set(sim.links)) == 2
        for system, link in enumerate(sim.links, start=1):
            with closing(Station(parse_link(link).port)) as station:
                assert station.wait("HEARTBEAT").get_srcSystem() == system
    with pytest.raises(ValueError, match="plane 3 would be on port 65536, ports end at 65535"):
        SimOptions(links=("tcp:127.0.0.1:65534",), planes=3, ports="consecutive")


def test_datagrams_to_a_station_that_comes_late() -> None:
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as station:
        station.bind(("127.0.0.1", 0))
        port = station.getsockname()[1]
        station.settimeout(PATIENCE_S)
        options = SimOptions(links=(f"udpout:127.0.0.1:{port}",), speedup=20.0)
        with SimulatedPlane(options, autopilot=DoubleAutopilot):
            data, plane = station.recvfrom(65536)
            packer = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
            station.sendto(dialect.MAVLink_param_request_read_message(1, 1, b"WP_RADIUS", -1).pack(packer), plane)
            decoder = Decoder()
            found: list[Any] = []
            while not any(m.get_type() == "PARAM_VALUE" for m in found):
                one = decoder.feed(data)
                assert len(one) == 1  # a frame each
                found += one
                data = station.recv(65536)


def test_links_are_closed_and_the_port_is_free_again() -> None:
    with SimulatedPlane(autopilot=DoubleAutopilot) as sim, closing(Station(sim.port)) as station:
        port = sim.port
        station.wait("HEARTBEAT")
        sim.close()
        assert sum(1 for _ in station.messages()) >= 0  # ends
    with SimulatedPlane(SimOptions(links=(f"tcp:127.0.0.1:{port}",)), autopilot=DoubleAutopilot) as again:
        assert again.port == port
        with pytest.raises(OSError, match=f"tcp:127.0.0.1:{port}"):
            SimServer(again.options, autopilot=DoubleAutopilot)


def test_a_thousand_connections_leave_nothing_behind(sim: SimulatedPlane) -> None:
    for _ in range(1000):
        Station(sim.port).close()
    eventually(lambda: sim.call(lambda world: len(world._carried) + len(world.planes[0]._links)) == 0)
    assert sim.clients == 0


def test_a_failure_of_the_loop_is_told() -> None:
    class Broken(DoubleAutopilot):
        def step(self) -> None:
            raise ArithmeticError("the plane fell apart")

    sim = SimulatedPlane(SimOptions(links=()), autopilot=Broken)
    eventually(lambda: not sim._thread.is_alive())
    with pytest.raises(RuntimeError, match="stopped"):
        sim.call(lambda world: world)
    with pytest.raises(RuntimeError, match="the plane fell apart"):
        sim.close()


def test_the_loop_is_not_woken_for_each_tick_but_for_what_somebody_says(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s, stop, waits_s = 0.0, threading.Event(), []
    monkeypatch.setattr(server, "time", SimpleNamespace(monotonic=lambda: now_s))
    running = SimServer(SimOptions(links=("tcp:127.0.0.1:0",)), autopilot=DoubleAutopilot)
    select = running._selector.select

    def wait(timeout_s: float) -> list[Any]:
        nonlocal now_s
        waits_s.append(timeout_s)
        heard = select(0)
        now_s += 0.0 if heard else timeout_s
        if now_s >= 1.0:
            stop.set()
        elif len(waits_s) == 10:
            running.wake()
        return heard

    monkeypatch.setattr(running._selector, "select", wait)
    with closing(running):
        running.serve(stop)
        time_s = running.world.planes[0].snapshot().time_s
    assert time_s == pytest.approx(1.0, abs=0.03)
    # woken in its eleventh wait, it has the twelfth end with the next tick
    assert [each_s for each_s in waits_s if each_s < 0.0199] == [waits_s[11]]
    assert waits_s[11] <= 0.01
    assert 48 <= len(waits_s) <= 53


@pytest.mark.parametrize(
    ("text", "told"),
    [("serial:/dev/ttyUSB0", "tcp:HOST:PORT"), ("tcp:localhost", "tcp:HOST:PORT"), ("udpout:a:0", "the port")],
)
def test_wrong_links_are_told_with_the_right_form(text: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        parse_link(text)


def test_options_are_checked() -> None:
    with pytest.raises(ValueError, match="wind_m_s is 99"):
        SimOptions(wind_m_s=99)
    with pytest.raises(ValueError, match="speedup"):
        SimOptions(speedup=float("nan"))


def program(*options: str) -> subprocess.Popen[str]:
    """Start ``python -m vencejo.sim``, with a double for an autopilot."""
    code = (
        "import sys, vencejo.sim.mavlink.component as c; from tests.sim.autopilot_double import DoubleAutopilot;"
        "c._default_autopilot = DoubleAutopilot;"
        "from vencejo.sim import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, "--link", "tcp:127.0.0.1:0", *options]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_program_tells_its_link_and_stops_on_a_signal(number: signal.Signals) -> None:
    with program("--param", "WP_RADIUS=20") as process:
        assert process.stdout is not None
        told = json.loads(process.stdout.readline())
        assert told["system_ids"] == [1]
        with closing(Station(parse_link(told["listening"]).port)) as station:
            station.wait("HEARTBEAT")
        process.send_signal(number)
        assert process.wait(PATIENCE_S) == 0


def test_the_program_ends_with_the_one_that_started_it_when_told_to() -> None:
    with program("--end-with-stdin") as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert json.loads(process.stdout.readline())["system_ids"] == [1]
        process.stdin.close()
        assert process.wait(PATIENCE_S) == 0

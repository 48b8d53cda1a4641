"""Links that break and stations that come and go: everything recovers, and nothing leaks."""

from __future__ import annotations

import gc
import os
import resource
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import vencejo
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.faults.mock import MockPlane
from tests.plane import Plane
from tests.support import Metronome, wait_for


def native_threads() -> int:
    """Return our threads in this process: workers, callbacks, recorders."""
    names = []
    for task in Path("/proc/self/task").iterdir():
        try:
            names.append((task / "comm").read_text())
        except OSError:
            continue
    return sum(name.startswith("vencejo") for name in names)


def descriptors() -> int:
    """Return the open descriptors of this process."""
    return sum(1 for _ in Path("/proc/self/fd").iterdir())


def resident_bytes(process: int | str = "self") -> int:
    """Return the memory of this process, or of another."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * resource.getpagesize()


@pytest.mark.fault(
    26, figure="behind a driver that is stopped in flight the simulated plane's failsafe acts within 10 s"
)
def test_a_plane_whose_program_is_stopped_comes_home() -> None:
    program = (
        "import sys, time, vencejo\nplane = vencejo.connect(sys.argv[1], record=False)\n"
        "plane.set_mode('TAKEOFF')\nplane.arm()\nprint('flies', flush=True)\ntime.sleep(300)"
    )
    with (
        Plane(params={"FS_LONG_ACTN": 1}) as plane,
        vencejo.Station(plane.link, record=False, heartbeat=False) as watcher,
        subprocess.Popen([sys.executable, "-c", program, plane.link], stdout=subprocess.PIPE, text=True) as process,
    ):
        try:
            seen = watcher.wait_vehicle(1)
            assert process.stdout is not None
            assert process.stdout.readline() == "flies\n"
            plane.skip_to(lambda truth: truth.alt_rel_home_m > 30.0)
            seen.params.set("FS_GCS_ENABL", 1)
            assert seen.telemetry.mode == "TAKEOFF"
            assert plane.has_heard_a_station(), "the first heartbeat, which will be missed, is the first word on a link"
            stop(process)
            # By its own clock.
            plane.fly(10.0)
            assert plane.mode() == "RTL"
            wait_for(lambda: seen.telemetry.mode == "RTL", "its word of that")
        finally:
            process.kill()


@pytest.mark.fault(
    26, figure="once nobody is there any more behind a station on board the simulated plane's failsafe acts within 10 s"
)
def test_a_plane_whose_operators_are_gone_comes_home() -> None:
    params = {"FS_LONG_ACTN": 1, "FS_GCS_ENABL": 1, "MAV_GCS_SYSID": 252}
    with (
        Plane(params=params) as plane,
        vencejo.Station(plane.link, system_id=1, component_id=191, heartbeat=False, record=False) as station,
    ):
        flown = station.wait_vehicle(1)
        flown.set_mode("TAKEOFF")
        flown.arm()
        plane.skip_to(lambda truth: truth.alt_rel_home_m > 30.0)
        assert not plane.has_heard_a_station(), "to command is not to be there"
        # The station reads it by itself when idle; here it is known at once.
        assert flown.params.get("MAV_GCS_SYSID").value == 252
        station.set_heartbeat(True)
        wait_for(plane.has_heard_a_station, "an operator who has come")
        assert plane.mode() == "TAKEOFF"
        station.set_heartbeat(False)
        plane.fly(10.0)
        assert plane.mode() == "RTL"


def stop(process: subprocess.Popen[str] | subprocess.Popen[bytes]) -> None:
    """Stop a process; when this returns, none of its threads runs (proc(5))."""
    os.kill(process.pid, signal.SIGSTOP)
    tasks = Path(f"/proc/{process.pid}/task")
    wait_for(
        lambda: all((task / "stat").read_text().rpartition(")")[2].split()[0] == "T" for task in tasks.iterdir()),
        "the process stands",
    )


@pytest.mark.fault(13, figure="1,000 stations: no descriptor or thread more, < 8 MiB")
def test_a_thousand_stations_leave_nothing_behind(tmp_path: Path) -> None:
    with MockPlane() as mock:

        def cycle(number: int) -> None:
            record: bool | Path = tmp_path if number % 10 == 0 else False
            with vencejo.connect(mock.link, record=record) as plane:
                plane.on_event(lambda event: None)
                plane.on_message(lambda message: None, names=["HEARTBEAT"])
                assert plane.telemetry.heartbeat is not None
                if number % 3 == 0:
                    plane._native.param_read("WP_RADIUS")  # cancelled without being noticed
            if number % 100 == 0:
                wait_for(lambda: not mock._peers, "the plane's side")

        for number in range(200):
            cycle(number)
        wait_for(lambda: not mock._peers, "the plane's side")
        gc.collect()
        threads, files, memory = native_threads(), descriptors(), resident_bytes()
        # Other tests of this process may have left some of theirs.
        python_threads = threading.active_count()
        mock.received.clear()
        for number in range(1_000):
            cycle(number)
            mock.received.clear()
        wait_for(lambda: not mock._peers, "the plane's side")
        gc.collect()
        wait_for(lambda: native_threads() <= threads and threading.active_count() <= python_threads, "no more threads")
        assert descriptors() <= files
        assert resident_bytes() - memory < 8 << 20, "memory does not grow with the stations"


@pytest.mark.fault(13, figure="back within 2 s (3 s on a busy machine), 8 breaks")
def test_a_link_that_breaks_is_back_within_two_seconds() -> None:
    with Metronome() as metronome, MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:
        before = descriptors()
        longest = 0.0
        for number in range(8):
            connections = mock.connections
            began = metronome.now_s
            mock.do(lambda reset=number % 2 == 0: mock.cut(reset=reset))  # type: ignore[misc]
            wait_for(lambda connections=connections: mock.connections > connections, "connecting again")  # type: ignore[misc]
            longest = max(longest, metronome.now_s - began)
            assert plane.params["WP_RADIUS"] == 50.0
        assert longest < 2.0 + 1.0, "2 s, and what a busy machine adds"
        assert descriptors() <= before
        assert plane.telemetry.invalid_values == 0


@pytest.mark.fault(13, figure="followed to 4 ports")
def test_a_vehicle_that_changes_its_port_is_followed() -> None:
    """A vehicle behind UDP continues from another port.

    Its boot clock says that it is the same, and its silence where it was that what is sent to it goes to the new port.
    """

    class Out:
        data = b""

        def write(self, data: bytes) -> None:
            self.data += bytes(data)

    out = Out()
    writer = mavlink.MAVLink(out, srcSystem=1, srcComponent=1)
    began = time.monotonic()
    with vencejo.Station("udpin:127.0.0.1:0", record=False) as station:
        wait_for(lambda: station.links[0].state == "up", "listening")
        host, _, port = str(station.links[0].local_address).rpartition(":")
        before = descriptors()
        plane = None
        for number in range(4):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
                # Rate of its messages.
                sock.settimeout(0.1)
                sock.connect((host, int(port)))
                expected = f"P{number}".encode()

                def is_answered(sock: socket.socket = sock, number: int = number, expected: bytes = expected) -> bool:
                    nonlocal plane
                    out.data = b""
                    writer.heartbeat_send(1, 3, 1, 0, 4)
                    writer.system_time_send(0, int((time.monotonic() - began) * 1000) + 60_000)
                    sock.send(out.data)
                    plane = plane or station.wait_vehicle()
                    plane.send_message("PARAM_REQUEST_READ", param_id=f"P{number}", param_index=-1)
                    try:
                        return expected in sock.recv(300)
                    except TimeoutError:
                        return False

                wait_for(is_answered, "what is sent to it there")
        assert len(station.vehicles) == 1
        assert descriptors() <= before


@pytest.mark.fault(26, figure="at most 1 heartbeat in 2 s from a process that is stopped")
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no SIGSTOP on this system")
def test_a_program_that_is_stopped_sends_no_heartbeat() -> None:
    """The vehicle's ground-station failsafe must notice that the operator is gone."""
    program = "import sys, time, vencejo\nplane = vencejo.connect(sys.argv[1], record=False)\ntime.sleep(300)"
    with MockPlane() as mock, subprocess.Popen([sys.executable, "-c", program, mock.link]) as process:

        def beats() -> int:
            return sum(name == "HEARTBEAT" for name, _ in list(mock.received))

        try:
            wait_for(lambda: beats() >= 2, "heartbeats")
            stop(process)
            # The plane's own clock shows that two seconds pass.
            stopped, boot_ms = beats(), mock.boot_ms
            wait_for(lambda: mock.boot_ms >= boot_ms + 2_000, "two seconds")
            assert beats() <= stopped + 1, "one may have been on its way"
            os.kill(process.pid, signal.SIGCONT)
            seen = beats()
            wait_for(lambda: beats() > seen, "heartbeats again")
        finally:
            process.kill()

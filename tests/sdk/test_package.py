"""The package without a vehicle: errors, plans, parameter files, interruption, and what a station says of its links."""

from __future__ import annotations

import ast
import inspect
import os
import random
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import vencejo
from vencejo import _native, errors

from tests.support import CAPTURES, ROOT, wait_for


def test_every_error_of_the_core_has_its_exception() -> None:
    names = _native.error_classes()
    assert len(names) > 10
    for name in names:
        assert issubclass(getattr(errors, name), errors.VencejoError), name
        assert getattr(vencejo, name) is getattr(errors, name)


def test_the_stub_of_the_native_module_has_its_names_and_parameters() -> None:
    stub = ast.parse(Path(_native.__file__).with_name("_native.pyi").read_text(encoding="utf-8"))
    named = {
        node.target.id for node in stub.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }
    defined = {node.name: node for node in stub.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    assert {name for name in dir(_native) if not name.startswith("__")} <= named | defined.keys()
    compared = 0

    def compare(node: ast.FunctionDef, native: object, is_method: bool) -> None:
        nonlocal compared
        given = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
        assert given[is_method:] == [name for name in inspect.signature(native).parameters if name != "self"], node.name  # type: ignore[arg-type]
        compared += 1

    for name, node in defined.items():
        native = getattr(_native, name, None)
        if native is None:
            continue  # a build without fleets
        if isinstance(node, ast.FunctionDef):
            compare(node, native, False)
            continue
        methods = {member.name: member for member in node.body if isinstance(member, ast.FunctionDef)}
        known = methods.keys() | {
            ast.unparse(member.target) for member in node.body if isinstance(member, ast.AnnAssign)
        }
        assert {member for member in vars(native) if not member.startswith("__")} <= known, name
        for method in methods.values():
            decorators = {ast.unparse(decorator) for decorator in method.decorator_list}
            is_made = method.name in ("__init__", "__new__")
            if is_made or not (method.name.startswith("__") or "property" in decorators):
                owner = native if is_made else getattr(native, method.name)
                compare(method, owner, "staticmethod" not in decorators)
    assert compared > 150


def test_a_plan_survives_its_files(tmp_path: Path) -> None:
    plan = vencejo.Plan(
        items=(
            vencejo.MissionItem.takeoff(40.3332, -3.8, alt_rel_home_m=50.0),
            vencejo.MissionItem.loiter_turns(40.34, -3.79, alt_rel_home_m=80.0, turns=2, radius_m=-60.0),
            vencejo.MissionItem.jump(1, repeats=3),
            vencejo.MissionItem.return_to_launch(),
        ),
        home=vencejo.Home(40.3332, -3.7978, 600.0),
        fence=vencejo.Fence(
            (
                vencejo.Polygon(tuple(vencejo.GeoPoint(40.3 + a, -3.8 + b) for a, b in ((0, 0), (0.1, 0), (0.1, 0.1)))),
                vencejo.Circle(vencejo.GeoPoint(40.33, -3.79), 100.0, inclusion=False),
            )
        ),
        rally=(vencejo.RallyPoint(40.331, -3.797, 60.0),),
        settings=vencejo.PlanSettings(cruise_speed_m_s=18.0, hover_speed_m_s=5.0, vehicle_type=1, firmware_type=3),
    )
    plan.save(tmp_path / "mission.plan")
    assert vencejo.Plan.load(tmp_path / "mission.plan") == plan
    plan.save(tmp_path / "mission.waypoints")
    again = vencejo.Plan.load(tmp_path / "mission.waypoints")
    assert [item.name for item in again] == [item.name for item in plan]
    assert (again.home, again.items[1]) == (plan.home, plan.items[1])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "empty"),
        (b"<osm/>", "XML"),
        (b"<kml/>", "no point, line or area"),
        (b'{"fileType": "Plan", "version": 1', "line 1"),
        (b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t40,5\t-3\t600\t1\n", "line 2"),
        ("QGC WPL 110\n".encode("utf-16"), "UTF-8"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "bad.plan"
    path.write_bytes(content)
    with pytest.raises(vencejo.FileFormatError, match=said) as caught:
        vencejo.Plan.load(path)
    assert str(path) in str(caught.value)


def test_a_plan_with_an_error_is_refused_by_name() -> None:
    plan = vencejo.Plan(items=(vencejo.MissionItem.waypoint(91.0, -3.79, alt_rel_home_m=50.0),))
    with pytest.raises(vencejo.PlanRefused, match="item 1") as caught:
        plan.require_sound()
    assert caught.value.findings[0].severity == "error"
    assert caught.value.findings[0].remedy
    assert caught.value.findings[0].figures == {"field": "x", "value": 91.0, "wanted": "latitude"}


def test_parameter_files(tmp_path: Path) -> None:
    vencejo.save_params(tmp_path / "plane.param", {"WP_RADIUS": 50.0, "AIRSPEED_CRUISE": 22.5})
    assert vencejo.load_params(tmp_path / "plane.param") == {"AIRSPEED_CRUISE": 22.5, "WP_RADIUS": 50.0}
    recorded = vencejo.load_params(CAPTURES / "arduplane-params.parm")
    assert len(recorded) == 1_399


@pytest.mark.parametrize("link", ["", "upd:127.0.0.1:14550", "udpin:127.0.0.1:99999", "tcp:", "serial:", "tlog:"])
def test_a_bad_link_string_shows_the_right_form(link: str) -> None:
    with pytest.raises(vencejo.InvalidLink) as caught:
        vencejo.Station(link, record=False)
    assert ":" in str(caught.value)


@pytest.mark.parametrize("rate_hz", [0.0, 3.9, 51.0, float("nan"), float("inf")])
def test_a_rate_out_of_range_is_refused(rate_hz: float) -> None:
    with pytest.raises(vencejo.InvalidRequest, match="4 to 50"):
        vencejo.Station(rate_hz=rate_hz, record=False)


def test_no_vehicle_says_where_it_was_looked_for() -> None:
    with pytest.raises(vencejo.NoVehicleError, match=r"udpin:127\.0\.0\.1"):
        vencejo.connect("udpin:127.0.0.1:0", timeout_s=0.05, record=False)


def test_a_closed_station_says_so() -> None:
    station = vencejo.Station("udpin:127.0.0.1:0", record=False)
    station.close()
    station.close()
    with pytest.raises(vencejo.ClosedError):
        station.wait_vehicle(timeout_s=None)
    with pytest.raises(vencejo.ClosedError):
        station.open_link("udpin:127.0.0.1:0")


def test_a_hundred_thousand_frames_of_noise_change_no_state() -> None:
    noise = random.Random(7)
    with (
        vencejo.Station("udpin:127.0.0.1:0", record=False) as station,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock,
    ):
        wait_for(lambda: station.links[0].state == "up", "listening")
        host, _, port = str(station.links[0].local_address).rpartition(":")
        sock.connect((host, int(port)))
        garbage = 0
        for start in range(0, 100_000, 500):
            # Half pure noise, half frames of messages that exist with a wrong checksum.
            datagrams = [
                noise.randbytes(noise.randrange(1, 280))
                if number % 2
                else bytes([0xFD, 9, 0, 0, number % 256, noise.randrange(256), 1, 0, 0, 0]) + noise.randbytes(11)
                for number in range(500)
            ]
            before = station.links[0].garbage_bytes

            def is_counted(before: int = before) -> bool:
                return station.links[0].garbage_bytes > before

            for datagram in datagrams:
                sock.send(datagram)
            wait_for(is_counted, f"noise from {start} on")
            garbage = station.links[0].garbage_bytes
        assert garbage > 1_000_000
        assert station.vehicles == []
        # And the link still works: a genuine heartbeat of a plane makes a vehicle.
        heartbeat = bytes.fromhex("fd0900002a0101000000000000000103510403")
        sock.send(heartbeat + crc(heartbeat[1:], 50).to_bytes(2, "little"))
        assert station.wait_vehicle(timeout_s=120.0).system_id == 1


def crc(data: bytes, extra: int) -> int:
    """MAVLink's checksum (X.25), written down once more so that the package is not checked by itself."""
    value = 0xFFFF
    for byte in (*data, extra):
        folded = (byte ^ (value & 0xFF)) & 0xFF
        folded ^= (folded << 4) & 0xFF
        value = ((value >> 8) ^ (folded << 8) ^ (folded << 3) ^ (folded >> 4)) & 0xFFFF
    return value


@pytest.mark.parametrize("waiting", ["vencejo.connect('udpin:127.0.0.1:0', timeout_s=None, record=False)", "asyncio"])
def test_ctrl_c_ends_a_wait(waiting: str) -> None:
    if waiting == "asyncio":
        waiting = "asyncio.run(aio.connect('udpin:127.0.0.1:0', timeout_s=None, record=False))"
    program = f"import asyncio, vencejo\nfrom vencejo import aio\nprint('waiting', flush=True)\n{waiting}"
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "waiting\n"
            os.kill(process.pid, signal.SIGINT)
            _, said = process.communicate(timeout=120)
        finally:
            process.kill()
    assert "KeyboardInterrupt" in said
    assert process.returncode != 0


def test_every_kind_of_event_is_documented() -> None:
    source = (ROOT / "crates/py/src/subscription.rs").read_text(encoding="utf-8").partition("fn event_tuple")[2]
    kinds = set(re.findall(r'"([a-z_]+)"', re.sub(r'set_item\("\w+"', "", source)))
    documented = set(re.findall(r"``([a-z_]+)``(?=:|, ``)", vencejo.Event.__doc__ or ""))
    assert len(kinds) > 20
    assert documented == kinds - {"other"}


def test_little_is_imported_to_hear_a_vehicle() -> None:
    program = """
import sys, vencejo
vencejo.Station(record=False).close()
print(sorted({"dataclasses", "inspect", "pathlib", "vencejo.values"} & sys.modules.keys()))
assert vencejo.Event.__module__ == "vencejo.values"
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == "[]\n", done

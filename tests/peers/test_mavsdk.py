"""mavsdk 4 (the C++ library with its Python wrapper, in this process) works with the simulated plane."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from vencejo.sim.config import parse_link

from tests.peers.support import ITEMS, PATIENCE_S, running_plane

mavsdk = pytest.importorskip("mavsdk")

pytestmark = pytest.mark.peer


@pytest.fixture
def system() -> Iterator[Any]:
    with running_plane() as sim:
        configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
        library = mavsdk.Mavsdk(configuration)
        try:
            port = parse_link(sim.link).port
            result = library.add_any_connection(f"tcpout://127.0.0.1:{port}")
            assert result == mavsdk.ConnectionResult.SUCCESS
            found = library.first_autopilot(PATIENCE_S)
            assert found is not None
            yield found
        finally:
            library.destroy()


def first(subscribe: Callable[..., Any], unsubscribe: Callable[[Any], None], wanted: Callable[[Any], bool]) -> Any:
    """Return the first value of a subscription that fulfils a condition."""
    arrived = threading.Event()
    values: list[Any] = []

    def on_value(value: Any, _user_data: Any) -> None:
        if not arrived.is_set() and wanted(value):
            values.append(value)
            arrived.set()

    handle = subscribe(on_value)
    assert arrived.wait(PATIENCE_S)
    unsubscribe(handle)
    return values[0]


def test_telemetry(system: Any) -> None:
    from mavsdk.plugins.telemetry import Telemetry

    telemetry = Telemetry(system)
    position = first(
        telemetry.subscribe_position, telemetry.unsubscribe_position, lambda value: abs(value.latitude_deg) > 1
    )
    assert position.latitude_deg == pytest.approx(40.3332, abs=1e-3)
    assert position.longitude_deg == pytest.approx(-3.7978, abs=1e-3)
    assert position.absolute_altitude_m == pytest.approx(600.0, abs=5.0)
    attitude = first(telemetry.subscribe_attitude_euler, telemetry.unsubscribe_attitude_euler, lambda _value: True)
    assert abs(attitude.roll_deg) < 20
    battery = first(telemetry.subscribe_battery, telemetry.unsubscribe_battery, lambda _value: True)
    assert battery.voltage_v > 10


def test_mission_both_ways(system: Any) -> None:
    from mavsdk.plugins.mission_raw import MissionItem, MissionRaw
    from mavsdk.plugins.telemetry import Telemetry

    telemetry = Telemetry(system)
    first(telemetry.subscribe_home, telemetry.unsubscribe_home, lambda value: abs(value.latitude_deg) > 1)
    plugin = MissionRaw(system)
    items = []
    for seq, frame, command, current, auto, p1, p2, p3, p4, lat, lon, alt in ITEMS:
        x, y = round(lat * 1e7), round(lon * 1e7)
        whole = (int(seq), int(frame), int(command), int(current or seq == 0), int(auto))
        items.append(MissionItem(*whole, float(p1), float(p2), float(p3), float(p4), x, y, alt, 0))
    plugin.upload_mission(items)
    back = plugin.download_mission()
    assert len(back) == len(items)
    for sent, got in list(zip(items, back, strict=True))[1:]:
        assert (got.command, got.frame, got.x, got.y) == (sent.command, sent.frame, sent.x, sent.y)
        assert got.z == pytest.approx(sent.z, abs=0.01)


def test_parameters(system: Any) -> None:
    from mavsdk.plugins.param import Param

    plugin = Param(system)
    assert plugin.get_param_int("WP_RADIUS") == 50
    plugin.set_param_int("WP_RADIUS", 35)
    assert plugin.get_param_int("WP_RADIUS") == 35

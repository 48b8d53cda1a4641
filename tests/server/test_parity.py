"""Every capability of the Python package for a vehicle has a path in the HTTP API, or a reason why it needs none."""

from __future__ import annotations

import inspect
import json
import re
from typing import Any

import vencejo
from vencejo import aio, link, params, recording
from vencejo.replay import Replay

from tests.support import ROOT

OF_THE_VEHICLE = "/api/v1/vehicles/{id}"
PATHS = json.loads((ROOT / "schemas" / "openapi.json").read_text(encoding="utf-8"))["paths"]
#: Methods whose path has another name than `Vehicle.return_to_launch`, which is ``POST /return-to-launch``.
ROUTES: dict[str, tuple[str, ...]] = {
    "Vehicle.ask": (),  # the paths of all requests, by name
    "Vehicle.change_count": (),  # the WebSocket sends changes by itself
    "Vehicle.check_plan": ("POST /api/v1/plan/check",),
    "Vehicle.learned": ("GET /profile",),
    "Vehicle.rehearse": ("POST /api/v1/plan/rehearse",),
    "Vehicle.what_if": ("POST /api/v1/plan/what-if",),
    "Vehicle.clear": ("DELETE /plan/mission", "DELETE /plan/fence", "DELETE /plan/rally"),
    "Vehicle.climb_to": ("POST /climb",),
    "Vehicle.close": (),  # the server's owner closes the station
    "Vehicle.command": ("POST /command/long",),
    "Vehicle.command_int": ("POST /command/int",),
    "Vehicle.compare_plan": ("POST /plan/compare",),
    "Vehicle.control": ("GET /api/v1/vehicles",),
    "Vehicle.keep_control": ("POST /control/keep",),
    "Vehicle.release_control": ("POST /control/release",),
    "Vehicle.request_control": ("POST /control/request",),
    "Vehicle.download": ("POST /plan/mission/read", "POST /plan/fence/read", "POST /plan/rally/read"),
    "Vehicle.events": ("WS event",),
    "Vehicle.flight_preparation": ("GET ", "WS telemetry"),
    "Vehicle.fly_course": ("POST /course",),
    "Vehicle.follow_rival": ("POST /rival/follow",),
    "Vehicle.link": ("GET ",),
    "Vehicle.messages": ("WS subscribe_messages", "WS message"),
    "Vehicle.mission_progress": ("GET ",),
    "Vehicle.mode_names": ("GET ",),
    "Vehicle.note": ("POST /texts",),
    "Vehicle.on_event": ("WS event",),
    "Vehicle.on_message": ("WS subscribe_messages", "WS message"),
    "Vehicle.params": ("GET /params", "GET /params/{name}", "PUT /params/{name}"),
    "Vehicle.pause_mission": ("POST /mission/pause",),
    "Vehicle.plan_on_board": ("GET /plan/mission", "GET /plan/fence", "GET /plan/rally"),
    "Vehicle.plan_state": ("GET ", "WS plan_state"),
    "Vehicle.request_message": ("POST /request-message", "POST /messages/{name}/request"),
    "Vehicle.resume_mission": ("POST /mission/resume",),
    "Vehicle.send_and_fly": ("PUT /plan/mission", "POST /prepare-flight", "POST /arm", "POST /mission/start"),
    "Vehicle.send_message": ("POST /messages",),
    "Vehicle.set_airspeed": ("POST /speed",),
    "Vehicle.set_altitude": ("POST /altitude",),
    "Vehicle.set_current_item": ("POST /mission/current",),
    "Vehicle.set_groundspeed": ("POST /speed",),
    "Vehicle.set_home": ("POST /home",),
    "Vehicle.set_message_rate": ("POST /set-message-rate", "PUT /messages/{name}/rate"),
    "Vehicle.set_mode": ("POST /mode",),
    "Vehicle.set_velocity": ("POST /velocity",),
    "Vehicle.remove_signing": ("POST /signing",),
    "Vehicle.is_reached": ("GET /api/v1/vehicles",),
    "Vehicle.lacks_terrain": ("GET /api/v1/vehicles",),
    "Vehicle.remote_name": ("GET /api/v1/vehicles",),
    "Vehicle.rival": ("GET /api/v1/vehicles",),
    "Vehicle.rotate_signing": ("POST /signing",),
    "Vehicle.set_up_signing": ("POST /signing",),
    "Vehicle.signing": ("GET /signing",),
    "Vehicle.start_mission": ("POST /mission/start",),
    "Vehicle.station": (),  # the server serves one
    "Vehicle.stream": ("WS subscribe", "WS telemetry"),
    "Vehicle.system_id": ("GET ",),
    "Vehicle.telemetry": ("GET ",),
    "Vehicle.texts": ("GET /texts", "WS text"),
    "Vehicle.upload": ("PUT /plan/mission", "PUT /plan/fence", "PUT /plan/rally"),
    "Vehicle.wait_until": ("WS telemetry",),
    "Parameters.all": ("GET /params",),
    "Parameters.get": ("GET /params/{name}",),
    "Parameters.load": ("POST /api/v1/params/parse", "PUT /params/{name}"),
    "Parameters.save": ("GET /params", "POST /api/v1/params/format"),
    "Parameters.set": ("PUT /params/{name}",),
    "Station.add_operator": ("POST /api/v1/session",),
    "Station.close": (),  # the server's owner closes it
    "Station.close_link": ("DELETE /api/v1/links/{id}",),
    "Station.links": ("GET /api/v1/links", "WS links"),
    "Station.on_message": ("WS subscribe_messages", "WS message"),
    "Station.open_link": ("POST /api/v1/links",),
    "Station.operator": (
        "GET /api/v1/session",
        *(f"POST /api/v1/control/{act}" for act in ("take", "request", "release", "keep")),
    ),
    "Station.recorder": ("GET /api/v1/recorder",),
    "Station.recorder_changes": ("GET /api/v1/storage", "WS storage"),
    "Station.set_heartbeat": ("PUT /api/v1/heartbeat",),
    # Keys are never sent over the network.
    "Station.add_signing_key": (),
    "Station.export_signing_key": (),
    "Station.forget_signing_key": (),
    "Station.signing_keys": (),
    "Station.signing_of": ("GET /api/v1/vehicles/{id}/signing",),
    "Station.signing_vehicles": (),
    "Station.use_signing_key": (),
    "Station.vehicles": ("GET /api/v1/vehicles", "WS vehicles"),
    "Station.wait_vehicle": ("GET /api/v1/vehicles", "WS vehicles"),
    "Plan.check": ("POST /api/v1/plan/check",),
    "Plan.length_m": (),  # depends on the plan only, which the client has
    "Plan.edited_complex_items": ("POST /api/v1/plan/format",),
    "Plan.load": ("POST /api/v1/plan/parse",),
    "Plan.require_sound": ("POST /api/v1/plan/check",),
    "Plan.save": ("POST /api/v1/plan/format",),
    "link.serial_ports": ("GET /api/v1/serial-ports",),
    "params.load_params": ("POST /api/v1/params/parse",),
    "params.save_params": ("POST /api/v1/params/format",),
    "Replay.close": ("DELETE /api/v1/replays/{id}",),
    "Replay.name": ("GET /api/v1/replays",),
    "Replay.path": (),  # clients know its file by name
    "Replay.pause": ("PATCH /api/v1/replays/{id}",),
    "Replay.play": ("PATCH /api/v1/replays/{id}",),
    "Replay.seek": ("PATCH /api/v1/replays/{id}",),
    "Replay.set_speed": ("PATCH /api/v1/replays/{id}",),
    "Replay.status": ("GET /api/v1/replays", "GET /api/v1/vehicles"),
    "recording.summarize": (
        "GET /api/v1/recordings",
        "GET /api/v1/recordings/{name}",
        "GET /api/v1/recordings/{name}/summary",
    ),
    "recording.telemetry": ("GET /api/v1/recordings/{name}",),
}


def public(owner: Any) -> set[str]:
    """Return the names of a class's methods and properties, inherited ones included, or of a module's functions."""
    if inspect.ismodule(owner):
        return {
            f"{owner.__name__.rpartition('.')[2]}.{name}"
            for name in owner.__all__
            if inspect.isfunction(getattr(owner, name))
        }
    bases = [base for base in owner.__mro__ if base is not object]
    names = {name for base in bases for name in vars(base) if not name.startswith("_")}
    fields = getattr(owner, "__dataclass_fields__", {})
    return {f"{owner.__name__}.{name}" for name in names if name not in fields}


def own_path(operation: str) -> bool:
    """Return whether a vehicle has a path named like its method."""
    owner, _, method = operation.partition(".")
    return owner == "Vehicle" and "post" in PATHS.get(f"{OF_THE_VEHICLE}/{method.replace('_', '-')}", {})


def test_every_operation_has_its_route() -> None:
    owners = (
        vencejo.Vehicle,
        vencejo.Station,
        vencejo.Plan,
        vencejo.vehicle.Parameters,
        Replay,
        link,
        params,
        recording,
    )
    operations = {name for name in set().union(*map(public, owners)) if name in ROUTES or not own_path(name)}
    assert operations == set(ROUTES), f"say which path does {operations ^ set(ROUTES)}"


def test_every_route_is_in_the_description() -> None:
    description = json.loads((ROOT / "schemas" / "openapi.json").read_text(encoding="utf-8"))
    said = {
        f"WS {variant['properties']['type']['enum'][0]}"
        for schema in ("ClientMessage", "ServerMessage")
        for one in description["components"]["schemas"][schema]["oneOf"]
        for variant in (one.get("allOf", [one])[-1] if "allOf" in one else one,)
    }
    checked = 0
    for routes in ROUTES.values():
        for route in routes:
            checked += 1
            method, _, path = route.partition(" ")
            if method == "WS":
                assert route in said, f"{route}: {sorted(said)}"
                continue
            whole = path if path.startswith("/api/") else OF_THE_VEHICLE + path
            assert method.lower() in description["paths"].get(whole, {}), f"{method} {whole}"
    assert checked > 60


def test_every_request_of_the_list_has_a_method() -> None:
    listed = {
        path.removeprefix(f"{OF_THE_VEHICLE}/")
        for path, item in PATHS.items()
        if path.startswith(OF_THE_VEHICLE) and "commands" in item.get("post", {}).get("tags", ())
    }
    source = (ROOT / "python" / "vencejo" / "vehicle.py").read_text(encoding="utf-8")
    asked = set(re.findall(r'_ask\(\s*"([^"]+)"', source))
    assert asked == listed, "a name in vehicle.py is none, or a request has no method there"


def test_asyncio_has_the_same_operations() -> None:
    only_sync = public(vencejo.Vehicle) - {f"Vehicle.{name.partition('.')[2]}" for name in public(aio.AsyncVehicle)}
    assert only_sync == set()

"""Telemetry made by hand, and a vehicle that only notes what is asked of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from vencejo import Finding, FlightPreparation, MissionItem, MissionProgress, Plan, PlanState, StatusText, Telemetry
from vencejo.telemetry import GROUPS

LAT, LON = 40.3332, -3.7978


class Snapshot:
    """The native half of a telemetry snapshot."""

    invalid_values = 0

    def __init__(self, time_s: float, groups: Mapping[str, Mapping[str, Any]]) -> None:
        self.time_s = time_s
        self._groups = groups

    def group(self, name: str) -> Any:
        if name == "batteries":
            battery = self.group("battery")
            return () if battery is None else (battery,)
        if name == "imus":
            return (self.group("imu"), None, None)
        if name not in self._groups:
            return None
        names = [field.name for field in dataclasses.fields(GROUPS[name])]
        values: dict[str, Any] = {**dict.fromkeys(names), "age_s": 0.1, "has_invalid": False, **self._groups[name]}
        assert sorted(values) == sorted(names), f"{name}: {sorted(set(values) ^ set(names))}"
        return values


def telemetry(time_s: float = 100.0, **groups: Mapping[str, Any]) -> Telemetry:
    """A snapshot with these groups; fields that are not given are ``None``."""
    return Telemetry(Snapshot(time_s, groups))  # type: ignore[arg-type]


def flying(
    time_s: float = 100.0,
    *,
    mode: str = "AUTO",
    armed: bool = True,
    landed: str = "in air",
    age_s: float = 0.1,
    height_m: float = 80.0,
    speed_m_s: float = 20.0,
    state: str = "active",
    ready: bool | None = True,
    lat_deg: float = LAT,
    lon_deg: float = LON,
    **more: Mapping[str, Any],
) -> Telemetry:
    """A snapshot of a plane in the middle of its flight."""
    heartbeat = {"mode": mode, "mode_number": 10, "is_armed": armed, "system_status": "active"}
    groups: dict[str, Mapping[str, Any]] = {
        "heartbeat": {**heartbeat, "mav_type": 1, "autopilot": 3, "age_s": age_s},
        "position": {"lat_deg": lat_deg, "lon_deg": lon_deg, "alt_rel_home_m": height_m, "age_s": age_s},
        "hud": {"airspeed_m_s": 21.0, "groundspeed_m_s": speed_m_s, "climb_m_s": 0.2, "age_s": age_s},
        "extended": {"landed": landed, "age_s": age_s},
        "mission": {"seq": 1, "total": 4, "state": state, "age_s": age_s},
        "sys_status": {"is_ready_to_arm": ready, "unhealthy_sensors": (), "age_s": age_s if age_s > 1.0 else 0.0},
        **more,
    }
    return telemetry(time_s, **groups)


def parked(time_s: float = 100.0, **changes: Any) -> Telemetry:
    """A snapshot of a plane on the ground, disarmed."""
    ground = {"armed": False, "landed": "on ground", "height_m": 0.0, "speed_m_s": 0.0, "state": "not started"}
    return flying(time_s, **{"mode": "MANUAL", **ground, **changes})


def progress(item: int | None = 2, total: int | None = 4, **values: Any) -> MissionProgress:
    """Progress at an item."""
    rest = {"reached": (), "is_complete": False, "distance_m": 1500.0, "time_s": 75.0, "leg_distance_m": 300.0}
    return MissionProgress(**{"item": item, "total": total, **rest, **values})


def circuit(*, lands: bool = True) -> Plan:
    """Take-off, a waypoint, a change of speed, a waypoint, and a landing when it lands."""
    way = [
        MissionItem.takeoff(LAT, LON - 0.003, alt_rel_home_m=50.0),
        MissionItem.waypoint(LAT + 0.003, LON - 0.006, alt_rel_home_m=80.0),
        MissionItem.change_airspeed(18.0),
        MissionItem.waypoint(LAT + 0.003, LON + 0.006, alt_rel_home_m=60.0),
    ]
    return Plan(items=(*way, MissionItem.land(LAT, LON)) if lands else tuple(way))


class FakeStation:
    """A station without links."""

    recorder = None


class FakeVehicle:
    """Notes what is asked of it in `calls`; its telemetry is whatever `show` was given last."""

    system_id = 1

    def __init__(self, shown: Telemetry, *, findings: tuple[Finding, ...] = ()) -> None:
        self.calls: list[str] = []
        self.telemetry = shown
        self.texts: list[StatusText] = []
        self.mission_progress = progress(item=1)
        self.station = FakeStation()
        self.findings = findings
        self.frames: list[Telemetry] = []
        self.fails: dict[str, BaseException] = {}
        self.after: dict[str, Callable[[], None]] = {}
        self.flight_preparation: FlightPreparation | None = None

    def show(self, shown: Telemetry) -> None:
        self.telemetry = shown

    def _called(self, name: str, shown: str = "") -> None:
        self.calls.append(name + shown)
        if name in self.after:
            self.after[name]()
        if name in self.fails:
            raise self.fails[name]

    def stream(self, *, rate_hz: float, timeout_s: float | None = None) -> Iterator[Telemetry]:
        """The frames that were laid out, then the last one for ever: nothing new arrives."""
        while self.frames:
            self.telemetry = self.frames.pop(0)
            yield self.telemetry

    def wait_until(
        self, condition: Callable[[Telemetry], bool], *, timeout_s: float | None, what: str = ""
    ) -> Telemetry:
        assert condition(self.telemetry)
        return self.telemetry

    def check_plan(self, plan: Plan) -> tuple[Finding, ...]:
        return self.findings

    def upload(self, plan: Plan, *, kind: str = "mission", progress: Callable[[int, int], None]) -> PlanState:
        progress(1, 2)
        self._called("upload", f" {kind}")
        return PlanState(state="verified", count=len(plan), hash="00", detail="verified")

    def command(self, command: int, *params: float) -> int:
        self._called("command", f" {command}")
        return 0

    def set_current_item(self, item: int) -> None:
        self._called("set_current_item", f" {item}")

    def prepare_flight(self, *, despite_mixed_plan: bool) -> None:
        self._called("prepare_flight", " despite" if despite_mixed_plan else "")

    def arm(self, *, despite_mixed_plan: bool) -> None:
        self._called("arm", " despite" if despite_mixed_plan else "")

    def disarm(self) -> None:
        self._called("disarm")

    def start_mission(self, *, from_item: int | None = None, despite_mixed_plan: bool) -> None:
        self._called("start_mission", f" {from_item}" + (" despite" if despite_mixed_plan else ""))

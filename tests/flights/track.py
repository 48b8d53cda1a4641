"""Follows a flight through the driver and judges it: what was passed how closely, and where it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import TracebackType

import vencejo
from vencejo import _native

from tests.support import wait_for


def distance_m(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Length of the geodesic between two positions in degrees."""
    return _native.distance_m(*a, *b)


@dataclass
class Flight:
    """What was seen of a flight. Use it in a ``with`` statement around the flight."""

    plane: vencejo.Vehicle
    track: list[tuple[float, float, float]] = field(default_factory=list)
    """Latitude, longitude (degrees) and height above home (m) of each position message."""
    reached: list[int] = field(default_factory=list)
    modes: list[str] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    def __enter__(self) -> Flight:
        self._subscriptions = [
            self.plane.on_message(self._on_position, names=["GLOBAL_POSITION_INT"], capacity=100_000),
            self.plane.on_event(self._on_event),
        ]
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for subscription in self._subscriptions:
            subscription.close()

    def _on_position(self, message: vencejo.MavlinkMessage) -> None:
        fields = message.fields
        self.track.append((fields["lat"] / 1e7, fields["lon"] / 1e7, fields["relative_alt"] / 1e3))

    def _on_event(self, event: vencejo.Event) -> None:
        if event.kind == "item_reached":
            self.reached.append(event.detail["item"])
        elif event.kind == "mode":
            self.modes.append(event.detail["mode"])
        elif event.kind == "text":
            self.texts.append(event.detail["text"])

    def closest_m(self, lat_deg: float, lon_deg: float) -> float:
        """How near the track came to a position, horizontally."""
        assert self.track, "no position was received"
        return min(distance_m((lat, lon), (lat_deg, lon_deg)) for lat, lon, _ in self.track)

    def fly_on(self, positions: int = 20) -> None:
        """Let it fly for some more position messages: a place just reached is still being approached."""
        wanted = len(self.track) + positions
        wait_for(lambda: len(self.track) >= wanted, "more positions")

    def fly_to_the_end(self, timeout_s: float) -> vencejo.Telemetry:
        """Wait until the plane has landed and disarmed itself."""
        return self.plane.wait_until(
            lambda telemetry: telemetry.is_armed is False, timeout_s=timeout_s, what="landing and disarming"
        )


def assert_waypoints_passed(flight: Flight, plan: vencejo.Plan) -> None:
    """Each waypoint was passed within its own acceptance radius."""
    checked = 0
    for number, item in enumerate(plan.items, 1):
        if item.command == vencejo.Command.NAV_WAYPOINT and item.lat_deg is not None and item.lon_deg is not None:
            allowed_m = item.params[1]
            assert allowed_m, f"item {number} has no acceptance radius of its own"
            closest_m = flight.closest_m(item.lat_deg, item.lon_deg)
            assert closest_m <= allowed_m, f"item {number} was passed at {closest_m:.0f} m, allowed {allowed_m:.0f} m"
            checked += 1
    assert checked, "the plan has no waypoint to check"


def landing_error_m(telemetry: vencejo.Telemetry, plan: vencejo.Plan) -> float:
    """How far from its landing point the plane came to rest."""
    landing = [item for item in plan.items if item.command == vencejo.Command.NAV_LAND][-1]
    position = telemetry.position
    assert position is not None
    assert position.lat_deg is not None
    assert position.lon_deg is not None
    assert landing.lat_deg is not None
    assert landing.lon_deg is not None
    return distance_m((position.lat_deg, position.lon_deg), (landing.lat_deg, landing.lon_deg))

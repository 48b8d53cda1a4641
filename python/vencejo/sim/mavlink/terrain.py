"""TERRAIN_REQUEST, TERRAIN_DATA, TERRAIN_CHECK and TERRAIN_REPORT."""

from __future__ import annotations

from typing import Protocol

from vencejo.sim.autopilot.interface import AutopilotPort, Snapshot
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.link import Link, Peer, Source
from vencejo.sim.plan_store import PlanStore
from vencejo.sim.terrain import Terrain

__all__ = ["TerrainMessages"]


class Vehicle(Protocol):
    """The part of :class:`vencejo.sim.mavlink.component.PlaneComponent` that this protocol uses."""

    autopilot: AutopilotPort
    plans: PlanStore
    terrain: Terrain
    source: Source

    @property
    def home_set(self) -> bool:
        """Whether home is set."""

    def snapshot(self) -> Snapshot:
        """The present state."""
        ...

    def reply(self, peer: Peer, message: MavMessage) -> None:
        """Send to one peer's link."""


class TerrainMessages:
    """The terrain protocol of one plane."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle

    def look(self, now: Snapshot) -> None:
        """Decide which terrain is needed."""
        if now.gps_fix_type < 3:
            return
        home = (now.home_lat_deg, now.home_lon_deg) if self._vehicle.home_set else None
        self._vehicle.terrain.update(
            (now.lat_deg, now.lon_deg), home, self._vehicle.plans.mission, self._vehicle.plans.mission_revision
        )

    def report(self, lat_deg: float, lon_deg: float) -> MavMessage:
        """TERRAIN_REPORT: terrain at a position, and the height of the plane above the terrain below it."""
        now = self._vehicle.snapshot()
        here_m = self._vehicle.terrain.below_m(now.lat_deg, now.lon_deg)
        is_here = (lat_deg, lon_deg) == (now.lat_deg, now.lon_deg)
        ground_m = here_m if is_here else self._vehicle.terrain.height_m(lat_deg, lon_deg)
        pending, loaded = self._vehicle.terrain.statistics()
        return dialect.MAVLink_terrain_report_message(
            round(lat_deg * 1e7),
            round(lon_deg * 1e7),
            self._vehicle.terrain.spacing_at(lat_deg, lon_deg),
            ground_m or 0.0,
            now.alt_amsl_m - (here_m or 0.0),
            pending,
            loaded,
        )

    def ask(self, link: Link) -> None:
        """Ask a station for the next grid that is missing."""
        asked = self._vehicle.terrain.request(link, self._vehicle.autopilot.time_s)
        if asked is not None:
            link.send(dialect.MAVLink_terrain_request_message(*asked), self._vehicle.source)

    def on_data(self, _peer: Peer, message: MavMessage) -> None:
        """Store terrain heights."""
        self._vehicle.terrain.take(message.lat, message.lon, message.grid_spacing, message.gridbit, list(message.data))

    def on_check(self, peer: Peer, message: MavMessage) -> None:
        """Report the terrain at a position."""
        self._vehicle.reply(peer, self.report(message.lat * 1e-7, message.lon * 1e-7))

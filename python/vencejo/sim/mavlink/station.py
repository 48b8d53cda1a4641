"""The ground station that a plane is controlled by: its heartbeats, and the failsafe when they end."""

from __future__ import annotations

from vencejo.sim.autopilot.interface import AutopilotPort, LandedState, Mode, Snapshot
from vencejo.sim.mavlink.codec import MavMessage
from vencejo.sim.mavlink.link import Peer
from vencejo.sim.params import ParamStore

__all__ = ["StationWatch"]


class StationWatch:
    """FS_GCS_ENABL of one plane: 1 and 2 in all modes, 3 in AUTO; active from the first heartbeat on."""

    def __init__(self, params: ParamStore, autopilot: AutopilotPort) -> None:
        self._params = params
        self._autopilot = autopilot
        self.seen_s: float | None = None
        """Time at which the station was last heard, None before its first heartbeat."""
        self._is_lost = False

    def restart(self) -> None:
        """Forget the station, at a reboot."""
        self.seen_s = None
        self._is_lost = False

    def is_station(self, system: int) -> bool:
        """Whether a system is the ground station of this plane: MAV_GCS_SYSID to MAV_GCS_SYSID_HI."""
        first, last = self._params.integer("MAV_GCS_SYSID"), self._params.integer("MAV_GCS_SYSID_HI")
        return first <= system <= max(first, last)

    def heard(self) -> None:
        """The station was heard: by a heartbeat, or by sticks that it moves."""
        self.seen_s = self._autopilot.time_s

    def on_heartbeat(self, peer: Peer, _message: MavMessage) -> None:
        """HEARTBEAT."""
        if self.is_station(peer.system):
            self.heard()

    def check(self, now: Snapshot) -> None:
        """Report a lost station, or one that is back; ten times a second."""
        if self.seen_s is None:
            return
        enabled = self._params.integer("FS_GCS_ENABL")
        silent_s = now.time_s - self.seen_s
        if not self._is_lost:
            applies = enabled in (1, 2) or (enabled == 3 and now.mode is Mode.AUTO)
            if applies and now.landed_state is not LandedState.LANDING:
                self._is_lost = silent_s > self._params.get("FS_LONG_TIMEOUT")
                if self._is_lost:
                    self._autopilot.failsafe_gcs(True)
        elif silent_s < self._params.get("FS_LONG_TIMEOUT"):
            self._is_lost = False
            self._autopilot.failsafe_gcs(False)

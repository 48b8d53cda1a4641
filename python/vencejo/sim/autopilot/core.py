"""The autopilot of one simulated plane: its loop, and the requests of a ground station that it accepts."""

from __future__ import annotations

import math
from collections.abc import Mapping

from vencejo.sim.hand import CARRY_HEIGHT_M, Hand

from .auto.names import AT_ONCE, Cmd
from .geo import location_alt_m, wrap_pi
from .interface import (
    Armed,
    FenceBreach,
    MavResult,
    Mode,
    Outlook,
    RepositionTarget,
    Severity,
    Snapshot,
    StoredItem,
)
from .loop import STATION_REASON, FlightLoop
from .modes.guided import GuidedMode
from .snapshot import take

__all__ = ["Autopilot"]

_REFUSED_MODES: dict[int, tuple[Severity, str]] = {
    **dict.fromkeys(range(17, 24), (Severity.INFO, "Q_ENABLE 0")),
    **dict.fromkeys((Mode.INITIALISING, 24), (Severity.WARNING, "Flight mode change failed")),
}
"""Refusals of quadplane modes, of INITIALISING, and of THERMAL without SOAR_ENABLE."""


class Autopilot(FlightLoop):
    """One simulated plane.

    Parameters
    ----------
    config : SimConfig
        Start position, wind and seed.
    params : Parameters
        The parameter store.
    plan : PlanView
        The stored mission and rally points.
    prearm : callable, optional
        Returns the failing pre-arm checks; by default those of the mode alone.

    Examples
    --------
    >>> from vencejo.sim.autopilot.testing import FixedParameters, FixedPlan
    >>> plane = Autopilot(config=SimConfig(), params=FixedParameters(), plan=FixedPlan())
    >>> for _ in range(100):
    ...     plane.step()
    >>> round(plane.time_s, 2)
    1.0
    """

    # arming and modes

    def arm(self, *, force: bool = False) -> MavResult:
        """Arm; refused by failing pre-arm checks, and with ``force`` by the mandatory ones alone."""
        if self.armed:
            return MavResult.ACCEPTED
        mandatory = ["Waiting for RC"] if self.failsafes.waits_for_radio else []
        failures = mandatory if force else list(self.prearm()) or mandatory
        if failures:
            for failure in failures:
                self.say(Severity.CRITICAL, f"Arm: {failure}")
            return MavResult.FAILED
        self.armed = True
        self.throttle_suppressed = self.mode.auto_throttle and not self.is_flying
        self._ground_heading_rad = self.est.yaw_rad
        self.climbout.reset()
        if int(self.tune["AUTOLAND_OPTIONS"]) & 1:
            self._set_direction(self.est.yaw_rad)
        self._events.append(Armed())
        self.say(Severity.INFO, "Throttle armed")
        if not self.home_locked:
            self._put_home_here()
        return MavResult.ACCEPTED

    def disarm(self, *, force: bool = False) -> MavResult:
        """Disarm; in flight only by force."""
        if not self.armed:
            return MavResult.ACCEPTED
        if self.is_flying and not force:
            return MavResult.FAILED
        self._disarm()
        return MavResult.ACCEPTED

    def set_mode(self, number: int) -> MavResult:
        """Change the mode at the request of a ground station."""
        number &= 0xFF  # ArduPlane keeps the low byte: 256 is MANUAL
        if number not in self._modes:
            self.say(*_REFUSED_MODES.get(number, (Severity.WARNING, f"No such mode {number}")))
            return MavResult.FAILED
        if self.flight_mode is Mode.INITIALISING:
            # As ArduPlane, which enters its initial mode at the end of the start whatever was requested before.
            return MavResult.ACCEPTED
        return MavResult.ACCEPTED if self.change_mode(Mode(number), STATION_REASON) else MavResult.FAILED

    # the mission and the flight

    def set_mission_current(self, seq: int, *, reset: bool = False) -> MavResult:
        """Make an item the current one; ``reset`` clears the jump counters and restarts a completed mission."""
        if reset:
            self.mission.reset()
        if not self.mission.set_current(seq):
            return MavResult.FAILED
        if reset:
            self.mission.start_or_resume(restart=False)
        return MavResult.ACCEPTED

    def mission_start(self) -> MavResult:
        """Enter AUTO; ACCEPTED even when the mode change is refused, as by ArduPlane."""
        self.set_mode(Mode.AUTO)
        return MavResult.ACCEPTED

    def reposition(self, target: RepositionTarget) -> MavResult:
        """Fly to a point in GUIDED."""
        if not target.change_mode and self.flight_mode is not Mode.GUIDED:
            return MavResult.DENIED
        values = (target.lat_deg, target.lon_deg, target.alt_m, target.radius_m)
        if any(value is not None and not math.isfinite(value) for value in values):
            return MavResult.DENIED
        lat, lon = target.lat_deg, target.lon_deg
        if lat is not None and lon is not None and not (-90.0 <= lat <= 90.0 and -180.0 <= lon <= 180.0):
            return MavResult.DENIED
        if target.frame not in (0, 3, 10):
            return MavResult.DENIED
        # As ArduPlane: when the mode change is refused, the present mode takes the new point.
        self.set_mode(Mode.GUIDED)
        guided = self._guided
        spot = self.here()
        if lat is not None and lon is not None and (lat != 0.0 or lon != 0.0):
            spot.n_m, spot.e_m = self.frame.to_plane(lat, lon)
        if target.alt_m is not None:
            spot.alt_m = target.alt_m if target.frame == 0 else target.alt_m + self.home.alt_m
            spot.follows_ground = target.frame == 10
        if target.radius_m is not None and target.radius_m != 0.0:
            guided.radius_m = abs(target.radius_m)
            guided.clockwise = target.radius_m > 0
            spot.anticlockwise = target.radius_m < 0
        guided.go_to(spot)
        return MavResult.ACCEPTED

    def set_home(self, lat_deg: float | None, lon_deg: float | None, alt_amsl_m: float | None) -> MavResult:
        """Set home, here when all are None, and lock it until the next boot; RTL turns to it at once."""
        result = super().set_home(lat_deg, lon_deg, alt_amsl_m)
        if result is MavResult.ACCEPTED:
            self.home_locked = True
            if self.flight_mode is Mode.RTL:
                self.mode.enter()
        return result

    def change_speed(self, kind: int, speed_m_s: float, throttle_pct: float) -> MavResult:
        """Set target airspeed (``kind`` 0), minimum ground speed (1) or cruise throttle."""
        return self.energy.change_speed(kind, speed_m_s, throttle_pct)

    def change_altitude(self, alt_m: float, frame: int) -> MavResult:
        """Change the altitude of the point being flown to, whatever the mode: of the landing point too, on a landing.

        As ArduPlane's handle_change_alt_request, which looks at neither mode nor flight stage.
        """
        if not math.isfinite(alt_m) or frame not in (0, 3, 10):
            return MavResult.DENIED
        amsl_m = location_alt_m(alt_m if frame == 0 else alt_m + self.home.alt_m)
        self.nav.change_altitude(amsl_m, follows_ground=frame == 10)
        return MavResult.ACCEPTED

    def change_guided_altitude(self, alt_m: float, frame: int, rate_m_s: float) -> MavResult:
        """Hold an altitude in GUIDED, reached at a climb rate or as fast as possible (0)."""
        if self.flight_mode is not Mode.GUIDED:
            return MavResult.FAILED
        if not math.isfinite(alt_m) or frame not in (0, 3, 10):
            return MavResult.DENIED
        self._guided.hold_altitude(
            location_alt_m(alt_m if frame == 0 else alt_m + self.home.alt_m),
            follows_ground=frame == 10,
            rate_m_s=abs(rate_m_s) if math.isfinite(rate_m_s) else 0.0,
        )
        return MavResult.ACCEPTED

    def change_guided_speed(self, airspeed_m_s: float, accel_m_s2: float) -> MavResult:
        """Hold an airspeed in GUIDED, reached at an acceleration or at once (0)."""
        if self.flight_mode is not Mode.GUIDED:
            return MavResult.FAILED
        self._guided.hold_airspeed(airspeed_m_s, accel_m_s2)
        return MavResult.ACCEPTED

    def raise_target(self, metres: float) -> None:
        """Change the altitude of the point being flown to, in GUIDED."""
        if self.flight_mode is Mode.GUIDED and math.isfinite(metres):
            alt_m = location_alt_m(self.nav.next.alt_m + metres)
            self.nav.next = self.nav.next.copy()
            self.nav.next.alt_m = alt_m
            self.say(Severity.INFO, f"Change alt to {alt_m - self.home.alt_m:.1f}")

    def force_attitude(self, roll_rad: float | None, pitch_rad: float | None, throttle: float | None) -> None:
        """Fly an attitude and throttle for GUIDED_TIMEOUT, in GUIDED."""
        if self.flight_mode is Mode.GUIDED:
            self._guided.force(roll_rad, pitch_rad, throttle)

    def change_heading(self, kind: int, heading_deg: float, accel_m_s2: float) -> MavResult:
        """Fly a course (``kind`` 0) or heading (1) instead of to the point in GUIDED; 2 returns to the point."""
        guided = self.mode
        if not isinstance(guided, GuidedMode) or kind not in (0, 1, 2):
            return MavResult.FAILED
        if kind == 2:
            guided.heading = None
            return MavResult.ACCEPTED
        if not math.isfinite(heading_deg) or not 0.0 <= heading_deg <= 360.0:
            return MavResult.DENIED
        limit = math.atan(accel_m_s2 / 9.80665) if math.isfinite(accel_m_s2) and accel_m_s2 > 0 else math.radians(30.0)
        guided.heading = (kind, wrap_pi(math.radians(heading_deg)), limit)
        return MavResult.ACCEPTED

    def do_mission_command(self, item: StoredItem) -> MavResult:
        """Execute a DO_* command that was sent on its own."""
        command = item.command
        if command == Cmd.DO_LAND_START:
            found = self.mission.jump_to_landing(self.distance_to_item)
            return MavResult.ACCEPTED if found and self._enter_auto(STATION_REASON) else MavResult.FAILED
        if command == Cmd.DO_RETURN_PATH_START:
            found = self.mission.jump_to_return_path(self.distance_to_item)
            return MavResult.ACCEPTED if found and self._enter_auto(STATION_REASON) else MavResult.FAILED
        if command == Cmd.DO_JUMP_TAG:
            tags = [i.seq for i in self._plan.mission[1:] if i.command == Cmd.JUMP_TAG and int(i.p1) == int(item.p1)]
            return self.set_mission_current(tags[0]) if tags else MavResult.FAILED
        if command == Cmd.DO_CHANGE_SPEED:
            return self.change_speed(int(item.p1), item.p2, item.p3)
        if command == Cmd.NAV_RETURN_TO_LAUNCH:
            return self.set_mode(Mode.RTL)
        if command == Cmd.NAV_LOITER_UNLIM:
            return self.set_mode(Mode.LOITER)
        if command in AT_ONCE or command in (
            Cmd.DO_SET_HOME,
            Cmd.DO_FENCE_ENABLE,
            Cmd.DO_INVERTED_FLIGHT,
            Cmd.DO_AUTOTUNE_ENABLE,
            Cmd.DO_SET_ROI,
            Cmd.DO_SET_ROI_LOCATION,
            Cmd.DO_SET_ROI_NONE,
            Cmd.DO_MOUNT_CONTROL,
            Cmd.DO_ENGINE_CONTROL,
        ):
            return MavResult.ACCEPTED if self.commands.start(item) else MavResult.FAILED
        return MavResult.UNSUPPORTED

    def abort_landing(self, climb_to_m: float) -> MavResult:
        """Abort the landing that is being flown; ``climb_to_m`` 0 leaves the altitude to the mission."""
        return MavResult.ACCEPTED if self.landing.request_go_around(climb_to_m) else MavResult.FAILED

    def terminate(self, *, wanted: bool) -> MavResult:
        """Terminate the flight or abort its termination, of which none is configured."""
        return self.failsafes.terminate(wanted=wanted)

    # the world outside

    def rc_input(self, channels: Mapping[int, int | None]) -> None:
        """Override radio channels by number, in µs; None returns a channel to the transmitter."""
        self.rc.override(channels)

    def move_by_hand(
        self,
        roll_rad: float,
        pitch_rad: float,
        yaw_rad: float,
        *,
        seconds: float = 0.0,
        offset_ned_m: tuple[float, float, float] = (0.0, 0.0, -CARRY_HEIGHT_M),
    ) -> None:
        """Turn and carry the plane by hand, disarmed and on the ground.

        Parameters
        ----------
        roll_rad, pitch_rad, yaw_rad : float
            Target attitude.
        seconds : float
            Duration; 0 is immediate.
        offset_ned_m : tuple of float
            North, east and down of the point where it was picked up.

        Raises
        ------
        RuntimeError
            The plane is armed, or not on the ground.
        """
        if self.armed:
            raise RuntimeError("the plane is armed: disarm it before it is taken in the hand")
        if self._hand is None:
            if not self.body.on_wheels or self.est.groundspeed_m_s > 1.0:
                raise RuntimeError("the plane is not at rest on the ground: let it land before it is taken in the hand")
            self._hand = Hand(self.body)
        self._hand.move(roll_rad, pitch_rad, yaw_rad, seconds=seconds, offset_ned_m=offset_ned_m)

    def put_down(self) -> None:
        """Put the plane down where it is held, with its heading."""
        if self._hand is not None:
            self._hand = None
            self.body.place(self.body.lat_deg, self.body.lon_deg, self.body.yaw_rad)

    def failsafe_gcs(self, active: bool) -> None:
        """Report that the ground station's heartbeat is lost, or back."""
        self.failsafes.station(is_lost=active)

    def fence_breached(self, kind: FenceBreach | None, return_point: tuple[float, float] | None = None) -> None:
        """Report a fence breach, or that all fences are clear again (None)."""
        self._fence.breached(kind, return_point)

    def fence_disabled(self) -> None:
        """Report that no fence is enabled."""
        self._fence.disabled()

    def reboot(self) -> None:
        """Restart in place, disarmed, with the charge that is left in the battery; time starts from zero."""
        self.battery.restart()
        self.energy.load_saved()
        # Rounded to a centimetre, the resolution of positions on the wire.
        self._boot(round(self.body.lat_deg, 7), round(self.body.lon_deg, 7))

    # camera

    def outlook(self) -> Outlook:
        """The true pose of the plane, for a camera on board."""
        body = self.body
        north, east = self.start.to_plane(body.lat_deg, body.lon_deg)
        revision = self._plan.mission_revision
        if revision != self._landings_revision:
            self._landings_revision = revision
            self._landings = tuple(
                self.start.to_plane(item.lat_deg, item.lon_deg)
                for item in self._plan.mission[1:]
                if item.command == Cmd.NAV_LAND
            )
        return Outlook(
            north_m=north,
            east_m=east,
            up_m=body.alt_amsl_m - self.config.home_alt_amsl_m,
            roll_rad=body.roll_rad,
            pitch_rad=body.pitch_rad,
            yaw_rad=body.yaw_rad,
            home_m=self.start.to_plane(*self._home_lat_lon),
            landings_m=self._landings,
        )

    # telemetry

    def snapshot(self) -> Snapshot:
        """The present state."""
        return take(self)

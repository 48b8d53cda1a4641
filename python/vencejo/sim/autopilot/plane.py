"""State shared by everything that flies the plane: airframe, estimate, home, radio, texts and camera.

Guidance and commands are in the modules that are given a :class:`Plane`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, overload

from vencejo._native import PlanePilot
from vencejo.sim.battery import Battery
from vencejo.sim.dynamics import Dynamics
from vencejo.sim.sensors import Sensors
from vencejo.sim.wind import Wind

from . import boot
from .geo import LocalFrame, Spot, distance_m, wrap_pi
from .interface import (
    DT_S,
    CameraTriggered,
    Event,
    GroundView,
    HomeChanged,
    MavResult,
    MissionItemReached,
    Mode,
    Parameters,
    PlanView,
    Severity,
    SimConfig,
    StatusText,
    StoredItem,
)
from .radio import Radio
from .tuning import Tuning

__all__ = ["Estimate", "Plane"]

_EVENT_LIMIT = 1024


@dataclass(slots=True)
class Estimate:
    """The estimated state: the true one with modelled errors; the estimator itself is not simulated."""

    n_m: float = 0.0
    e_m: float = 0.0
    alt_m: float = 0.0
    velocity_n_m_s: float = 0.0
    velocity_e_m_s: float = 0.0
    velocity_d_m_s: float = 0.0
    groundspeed_m_s: float = 0.0
    roll_rad: float = 0.0
    pitch_rad: float = 0.0
    yaw_rad: float = 0.0
    p_rad_s: float = 0.0
    q_rad_s: float = 0.0
    r_rad_s: float = 0.0
    airspeed_m_s: float = 0.0
    eas_to_tas: float = 1.0
    forward_accel_m_s2: float = 0.0


class Plane:
    """One plane, with its estimate and its control laws."""

    def __init__(self, config: SimConfig, params: Parameters, plan: PlanView) -> None:
        self.config = config
        self.on_fence_enable: Callable[[int], None] | None = None
        """Called with 0 or 1 by DO_FENCE_ENABLE (2 disables the floor only)."""
        self.utc_s: Callable[[], float | None] = lambda: None
        """Returns the time in seconds since 1970, None while it is unknown; for NAV_DELAY."""
        self.ground: GroundView | None = None
        """Its terrain data."""
        self.tune = Tuning(params)
        self._plan = plan
        self._events: deque[Event] = deque(maxlen=_EVENT_LIMIT)
        self.start = LocalFrame(config.home_lat_deg, config.home_lon_deg)
        """The tangent plane at the start position."""
        self.body = Dynamics(
            lat_deg=config.home_lat_deg,
            lon_deg=config.home_lon_deg,
            ground_amsl_m=config.home_alt_amsl_m,
            heading_deg=config.heading_deg,
            dt_s=DT_S,
        )
        self.wind = Wind(config.wind_m_s, config.wind_from_deg, config.gust_m_s, config.seed)
        self.sensors = Sensors(seed=config.seed, lat_deg=config.home_lat_deg, lon_deg=config.home_lon_deg)
        self.battery = Battery(capacity_mah=self.tune["BATT_CAPACITY"])
        self._boot(config.home_lat_deg, config.home_lon_deg)

    def _boot(self, lat_deg: float, lon_deg: float) -> None:
        """Initialise the state at a boot."""
        self.time_s = 0.0
        self.frame = LocalFrame(lat_deg, lon_deg)
        self._errors = self.sensors.errors(0.0)
        self.est = Estimate()
        self._estimate()
        self.home = Spot(0.0, 0.0, self.config.home_alt_amsl_m)
        self._home_lat_lon = (lat_deg, lon_deg)
        self.home_locked = False
        """Home was set by a command and no longer follows the plane (AP_AHRS::lock_home)."""
        self.rc = Radio()
        self.pilot = PlanePilot()
        self.pilot.set_params(self.tune.for_pilot())
        self._surfaces = self.pilot.output

        self.armed = False
        self.throttle_suppressed = True
        self.is_flying = False
        self.flying_since_s: float | None = None
        self._wind_estimate = (0.0, 0.0)
        self.trigger_distance_m = 0.0
        self._tunes = False
        self._last_picture: tuple[float, float] | None = None
        self._pictures = 0
        self.resume_forced = False
        self.flight_mode = Mode.MANUAL
        """The present mode."""
        self.previous_mode = Mode.MANUAL
        """The mode before the present one."""
        self.mode_reason = ""
        """Reason of the present mode."""
        self.takeoff_course_rad: float | None = None
        """AUTOLAND's direction, taken after take-off and forgotten when the plane is disarmed."""
        self.previous_mode_reason = ""
        """Reason of the mode before the present one."""

    def _estimate(self) -> None:
        body, est, errors = self.body, self.est, self._errors
        north, east = self.frame.to_plane(body.lat_deg, body.lon_deg)
        est.n_m = north + errors.north_m
        est.e_m = east + errors.east_m
        est.alt_m = body.alt_amsl_m - 0.112 + errors.up_m
        vn, ve = body.velocity_n_m_s, body.velocity_e_m_s
        est.velocity_n_m_s = vn
        est.velocity_e_m_s = ve
        est.velocity_d_m_s = body.velocity_d_m_s
        est.groundspeed_m_s = math.sqrt(vn * vn + ve * ve)
        est.roll_rad = body.roll_rad + errors.roll_rad
        est.pitch_rad = body.pitch_rad + errors.pitch_rad
        est.yaw_rad = wrap_pi(body.yaw_rad + errors.yaw_rad)
        est.p_rad_s = body.p_rad_s
        est.q_rad_s = body.q_rad_s
        est.r_rad_s = body.r_rad_s
        est.airspeed_m_s = max(0.0, body.airspeed_m_s + errors.airspeed_m_s)
        est.eas_to_tas = body.eas_to_tas
        est.forward_accel_m_s2 = body.accel_x_m_s2

    def stick_pitch_rad(self, stick: float) -> float:
        """Pitch demanded by a stick, within PTCH_LIM_MAX_DEG and PTCH_LIM_MIN_DEG."""
        limit = self.tune["PTCH_LIM_MAX_DEG"] if stick >= 0 else -self.tune["PTCH_LIM_MIN_DEG"]
        return math.radians(stick * limit)

    def throttle_ramp(self, target: float) -> float:
        """Throttle towards a target, at most 0.1 s at 100 %/s above the present one."""
        return min(target, self._surfaces.throttle + 0.1)

    def bank_limit_deg(self) -> float:
        """ROLL_LIMIT_DEG, reduced when the airspeed is too low for the load factor of such a turn."""
        limit = self.tune["ROLL_LIMIT_DEG"]
        if self.tune["STALL_PREVENTION"] == 0 or not self.is_flying:
            return limit
        ratio = self.est.airspeed_m_s / max(1.0, self.tune["AIRSPEED_MIN"])
        load = ratio * ratio
        if load <= 1.0:
            return min(limit, 25.0)
        return min(limit, max(25.0, math.degrees(math.acos(1.0 / load))))

    def head_wind_m_s(self) -> float:
        """Estimated head wind."""
        north, east = self._wind_estimate
        return -(north * math.cos(self.est.yaw_rad) + east * math.sin(self.est.yaw_rad))

    def wind_along_m_s(self, bearing: float) -> float:
        """Estimated wind component along a bearing; negative is a head wind."""
        north, east = self._wind_estimate
        return north * math.cos(bearing) + east * math.sin(bearing)

    @property
    def throttle(self) -> float:
        """Present throttle, 0 to 1."""
        return self._surfaces.throttle

    def l1_length_m(self) -> float:
        """Present L1 length of the lateral control law."""
        return self.pilot.output.l1_length_m

    # positions

    def here(self) -> Spot:
        """The estimated position."""
        est = self.est
        return Spot(est.n_m, est.e_m, est.alt_m)

    @property
    def alt_rel_home_m(self) -> float:
        """Height above home."""
        return self.est.alt_m - self.home.alt_m

    @property
    def in_auto(self) -> bool:
        """True in AUTO."""
        return self.flight_mode is Mode.AUTO

    def ground_rel_home_m(self, spot: Spot | None = None) -> float | None:
        """Terrain height above home, below the plane or at a position; None while it is unknown there or at home."""
        if self.ground is None or self.ground.height_m(*self._home_lat_lon) is None:
            return None
        if spot is None:
            height_m = self.ground.below_m(*self.where())
        else:
            height_m = self.ground.height_m(*self.frame.to_earth(spot.n_m, spot.e_m))
        return None if height_m is None else height_m - self.home.alt_m

    def follows_terrain(self, bit: int) -> bool:
        """Whether TERRAIN_FOLLOW covers a mode, by its bit: that or all modes (Plane::terrain_enabled_in_mode)."""
        return bool(int(self.tune["TERRAIN_FOLLOW"]) & (1 | 1 << bit))

    def alt_of(self, item: StoredItem) -> float:
        """Altitude of an item above mean sea level; above terrain it counts from home (:attr:`Spot.follows_ground`)."""
        return item.alt_m if item.frame == 0 else item.alt_m + self.home.alt_m

    @overload
    def spot_of(self, item: StoredItem, *, or_none: Literal[False] = False) -> Spot: ...
    @overload
    def spot_of(self, item: StoredItem, *, or_none: Literal[True]) -> Spot | None: ...
    def spot_of(self, item: StoredItem, *, or_none: bool = False) -> Spot | None:
        """Position of an item; without one the plane's (or None), without an altitude the plane's altitude."""
        if item.lat_deg == 0.0 and item.lon_deg == 0.0:
            if or_none:
                return None
            here = self.here()
            if item.alt_m == 0.0:
                return here
            return Spot(here.n_m, here.e_m, self.alt_of(item), follows_ground=item.frame == 10)
        north, east = self.frame.to_plane(item.lat_deg, item.lon_deg)
        return Spot(north, east, self.alt_of(item), follows_ground=item.frame == 10)

    def distance_to_item(self, item: StoredItem) -> float | None:
        """Distance to an item's position, or None without one."""
        spot = self.spot_of(item, or_none=True)
        if spot is None:
            return None
        here = self.here()
        return math.hypot(distance_m(here, spot), spot.alt_m - here.alt_m)

    def return_spot(self) -> Spot:
        """Target of RTL: the nearest rally point within RALLY_LIMIT_KM, or home at RTL_ALTITUDE."""
        here = self.here()
        altitude = self.tune["RTL_ALTITUDE"]
        home = Spot(self.home.n_m, self.home.e_m, here.alt_m if altitude < 0 else self.home.alt_m + altitude)
        best: Spot | None = None
        for point in self._plan.rally:
            north, east = self.frame.to_plane(point.lat_deg, point.lon_deg)
            spot = Spot(north, east, point.alt_m + (self.home.alt_m if point.relative else 0.0))
            if best is None or distance_m(here, spot) < distance_m(here, best):
                best = spot
        if best is None:
            return home
        limit = self.tune["RALLY_LIMIT_KM"] * 1000.0
        if limit > 0 and distance_m(here, best) > limit and distance_m(here, home) < distance_m(here, best):
            return home
        if self.tune["RALLY_INCL_HOME"] != 0 and distance_m(here, home) < distance_m(here, best):
            return home
        return best

    def where(self) -> tuple[float, float]:
        """Estimated latitude and longitude."""
        return self.frame.to_earth(self.est.n_m, self.est.e_m)

    # events

    def say(self, severity: Severity, text: str) -> None:
        """Send a status text."""
        self._events.append(StatusText(int(severity), text))

    def item_reached(self, seq: int) -> None:
        """Send MISSION_ITEM_REACHED."""
        self._events.append(MissionItemReached(seq))

    def events(self) -> list[Event]:
        """Events since the last call, oldest first; beyond 1,024 the oldest are dropped."""
        if not self._events:
            return []
        drained = list(self._events)
        self._events.clear()
        return drained

    def autotune(self, *, on: bool) -> None:
        """Announce the start or end of a tuning (Plane::autotune_start); it changes nothing here."""
        if on:
            axes = int(self.tune["AUTOTUNE_AXES"])
            tuned = "".join(word for bit, word in enumerate(("roll ", "pitch ", "yaw")) if axes & 1 << bit)
            self._tunes = bool(tuned)
            self.say(Severity.INFO, "Started autotune" if tuned else "No axis selected for tuning!")
            if tuned:
                self.say(Severity.INFO, f"Autotuning {tuned}")
        elif self._tunes:
            self._tunes = False
            self.say(Severity.INFO, "Stopped autotune")

    # home

    def set_home(self, lat_deg: float | None, lon_deg: float | None, alt_amsl_m: float | None) -> MavResult:
        """Set home, to the present position when all are None, which fails before the first fix."""
        if lat_deg is None or lon_deg is None:
            if self.time_s < boot.FIX_S:
                return MavResult.FAILED
            self._put_home_here()
            return MavResult.ACCEPTED
        alt = self.home.alt_m if alt_amsl_m is None else alt_amsl_m
        if not all(map(math.isfinite, (lat_deg, lon_deg, alt))) or abs(lat_deg) > 90 or abs(lon_deg) > 180:
            return MavResult.DENIED
        self._put_home(lat_deg, lon_deg, alt)
        return MavResult.ACCEPTED

    def _put_home_here(self) -> None:
        """Set home here, rounded to the centimetre of the wire: a plane that never moved stays exactly at home."""
        body, ground_m = self.body, self.config.home_alt_amsl_m
        alt_m = ground_m if body.on_wheels else round(ground_m + body.height_m, 2)
        self._put_home(round(body.lat_deg, 7), round(body.lon_deg, 7), alt_m)

    def _put_home(self, lat_deg: float, lon_deg: float, alt_m: float) -> None:
        north, east = self.frame.to_plane(lat_deg, lon_deg)
        self.home = Spot(north, east, alt_m)
        self._home_lat_lon = (lat_deg, lon_deg)
        self._events.append(HomeChanged(lat_deg, lon_deg, alt_m))

    # camera

    def take_picture(self) -> None:
        """Trigger the camera."""
        self._pictures += 1
        self._last_picture = (self.est.n_m, self.est.e_m)
        est = self.est
        lat, lon = self.frame.to_earth(est.n_m, est.e_m)
        self._events.append(
            CameraTriggered(
                index=self._pictures,
                lat_deg=lat,
                lon_deg=lon,
                alt_amsl_m=est.alt_m,
                alt_rel_home_m=self.alt_rel_home_m,
                roll_deg=math.degrees(est.roll_rad),
                pitch_deg=math.degrees(est.pitch_rad),
                yaw_deg=math.degrees(est.yaw_rad) % 360.0,
            )
        )

    def _take_pictures(self) -> None:
        if self.trigger_distance_m <= 0.0 or not self.is_flying:
            return
        last = self._last_picture
        if last is None or math.hypot(self.est.n_m - last[0], self.est.e_m - last[1]) >= self.trigger_distance_m:
            self.take_picture()

"""A vehicle's telemetry and events as the objects of ``vencejo.ice``: what is asked for and what is pushed are made here alike."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

from vencejo.jderobot.runtime import Slices
from vencejo.telemetry import Group, Telemetry
from vencejo.values import Event
from vencejo.vehicle import Vehicle

__all__ = ["States"]


class States:
    """Makes the objects that describe a vehicle."""

    def __init__(self, slices: Slices, *, clock: Callable[[], float] = time.time) -> None:
        self._precise = slices.precise
        self._unset = slices.ice.Unset
        self._clock = clock

    def _known(self, group: Group | None, **names: str) -> dict[str, Any]:
        """Members by the names of a group's fields; what is not known is not set."""
        if group is None:
            return {}
        values = {member: getattr(group, name) for member, name in names.items()}
        return {member: self._plain(value) for member, value in values.items() if value is not None}

    @staticmethod
    def _plain(value: Any) -> Any:
        return list(value) if isinstance(value, tuple) else value

    def moment(self, telemetry: Telemetry) -> Any:
        """Now, by our clock and by the vehicle's."""
        moment = self._precise.Moment(self._clock())
        clock = telemetry.system_time
        if clock is not None:
            moment.bootS = clock.boot_ms / 1e3 + clock.age_s
            if clock.utc_us is not None:
                moment.vehicleUtcS = clock.utc_us / 1e6 + clock.age_s
        return moment

    def pose(self, vehicle: Vehicle, telemetry: Telemetry) -> Any:
        """Where it is and how it lies."""
        return self._precise.Pose(
            systemId=vehicle.system_id,
            at=self.moment(telemetry),
            **self._known(
                telemetry.position,
                positionAgeS="age_s",
                latDeg="lat_deg",
                lonDeg="lon_deg",
                altAmslM="alt_amsl_m",
                altRelHomeM="alt_rel_home_m",
                velocityNorthMS="velocity_north_m_s",
                velocityEastMS="velocity_east_m_s",
                velocityDownMS="velocity_down_m_s",
            ),
            **self._known(
                telemetry.attitude,
                attitudeAgeS="age_s",
                rollRad="roll_rad",
                pitchRad="pitch_rad",
                yawRad="yaw_rad",
                rollRateRadS="roll_rate_rad_s",
                pitchRateRadS="pitch_rate_rad_s",
                yawRateRadS="yaw_rate_rad_s",
            ),
        )

    def navigation(self, vehicle: Vehicle, telemetry: Telemetry) -> Any:
        """Everything else."""
        link = vehicle.link
        loss = None if link is None else link.loss_pct
        round_trip = None if link is None else link.round_trip_ms
        reached = vehicle.is_reached
        return self._precise.Navigation(
            systemId=vehicle.system_id,
            at=self.moment(telemetry),
            linkLossPct=self._unset if loss is None else loss,
            linkRoundTripMs=self._unset if round_trip is None else round_trip,
            isReached=self._unset if reached is None else reached,
            **self._known(
                telemetry.heartbeat, heartbeatAgeS="age_s", mode="mode", isArmed="is_armed", mavType="mav_type"
            ),
            **self._known(telemetry.sys_status, isReadyToArm="is_ready_to_arm"),
            **self._known(telemetry.extended, landed="landed"),
            **self._known(
                telemetry.hud,
                hudAgeS="age_s",
                airspeedMS="airspeed_m_s",
                groundspeedMS="groundspeed_m_s",
                headingDeg="heading_deg",
                throttlePct="throttle_pct",
                climbMS="climb_m_s",
            ),
            **self._known(telemetry.gps, gpsAgeS="age_s", gpsFix="fix", satellites="satellites", hdop="hdop"),
            **self._known(
                telemetry.sys_status,
                batteryAgeS="age_s",
                batteryRemainingPct="battery_remaining_pct",
                batteryVoltageV="voltage_v",
                batteryCurrentA="current_a",
            ),
            **self._known(telemetry.wind, windAgeS="age_s", windFromDeg="from_deg", windSpeedMS="speed_m_s"),
            **self._known(
                telemetry.imu,
                imuAgeS="age_s",
                accelerationG="acc_g",
                gyroRadS="gyro_rad_s",
                magneticFieldGauss="mag_gauss",
            ),
            **self._known(
                telemetry.pressure, pressureAgeS="age_s", pressurePa="absolute_pa", temperatureC="temperature_c"
            ),
            **self._known(telemetry.home, homeLatDeg="lat_deg", homeLonDeg="lon_deg", homeAltAmslM="alt_amsl_m"),
        )

    def event(self, vehicle: Vehicle, event: Event) -> Any:
        """Something that happened, just now."""
        detail = json.dumps(dict(event.detail), default=str)
        return self._precise.Event(vehicle.system_id, self._clock(), event.kind, detail)

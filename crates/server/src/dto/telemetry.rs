//! Telemetry as JSON: groups and fields are named as in the Python package's `vencejo.telemetry`.

use serde::Serialize;
use utoipa::ToSchema;
use vencejo_proto::MonoTime;
use vencejo_vehicle::telemetry::{self as core, Sampled, Telemetry};

/// Defines a group, and its making from the core's value.
macro_rules! group {
    ($(#[$doc:meta])* $name:ident from $core:ty, |$value:ident| { $($(#[$field_doc:meta])* $field:ident: $kind:ty = $from:expr,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
        pub struct $name {
            /// How old the values are, seconds.
            pub age_s: f64,
            /// Whether the message held a value that cannot be; such fields are null.
            pub has_invalid: bool,
            $($(#[$field_doc])* #[schema(required = true)] pub $field: $kind,)*
        }

        impl $name {
            fn new(sampled: &Sampled<$core>, now: MonoTime) -> Self {
                let $value = &sampled.value;
                Self { age_s: sampled.age(now).as_secs_f64(), has_invalid: sampled.invalid, $($field: $from,)* }
            }
        }
    };
}

group! {
    /// HEARTBEAT of the autopilot.
    Heartbeat from core::HeartbeatState, |h| {
        /// The flight mode by name.
        mode: String = h.mode.to_string(),
        /// Its number on the wire.
        mode_number: u32 = h.mode.custom_mode,
        /// Whether the motors can run.
        is_armed: bool = h.is_armed,
        /// `MAV_STATE` in words.
        system_status: String = h.system_status.to_string(),
        /// `MAV_TYPE`: 1 fixed wing.
        mav_type: u8 = h.mav_type,
        /// `MAV_AUTOPILOT`: 3 ArduPilot.
        autopilot: u8 = h.autopilot,
    }
}
group! {
    /// ATTITUDE: body (forward, right, down) in the local north, east, down frame.
    Attitude from core::Attitude, |a| {
        /// Right wing down positive.
        roll_rad: Option<f64> = a.roll_rad,
        /// Nose up positive.
        pitch_rad: Option<f64> = a.pitch_rad,
        /// Clockwise from true north.
        yaw_rad: Option<f64> = a.yaw_rad,
        /// Body rate about the forward axis.
        roll_rate_rad_s: Option<f64> = a.roll_rate_rad_s,
        /// Body rate about the right axis.
        pitch_rate_rad_s: Option<f64> = a.pitch_rate_rad_s,
        /// Body rate about the down axis.
        yaw_rate_rad_s: Option<f64> = a.yaw_rate_rad_s,
    }
}
group! {
    /// GLOBAL_POSITION_INT: where the autopilot believes to be.
    Position from core::Position, |p| {
        /// WGS-84 latitude.
        lat_deg: Option<f64> = p.lat_deg,
        /// WGS-84 longitude.
        lon_deg: Option<f64> = p.lon_deg,
        /// Height above mean sea level.
        alt_amsl_m: Option<f64> = p.alt_amsl_m,
        /// Height above home.
        alt_rel_home_m: Option<f64> = p.alt_rel_home_m,
        /// Ground speed northward.
        velocity_north_m_s: Option<f64> = p.velocity_north_m_s,
        /// Ground speed eastward.
        velocity_east_m_s: Option<f64> = p.velocity_east_m_s,
        /// Speed downward.
        velocity_down_m_s: Option<f64> = p.velocity_down_m_s,
        /// Where the nose points, 0 to 360.
        heading_deg: Option<f64> = p.heading_deg,
    }
}
group! {
    /// VFR_HUD: what a pilot looks at.
    Hud from core::Hud, |h| {
        /// Speed through the air.
        airspeed_m_s: Option<f64> = h.airspeed_m_s,
        /// Speed over ground.
        groundspeed_m_s: Option<f64> = h.groundspeed_m_s,
        /// Where the nose points, 0 to 360.
        heading_deg: Option<f64> = h.heading_deg,
        /// 0 to 100.
        throttle_pct: Option<f64> = h.throttle_pct,
        /// Height above mean sea level.
        alt_amsl_m: Option<f64> = h.alt_amsl_m,
        /// Up positive.
        climb_m_s: Option<f64> = h.climb_m_s,
    }
}
group! {
    /// GPS_RAW_INT: what the receiver says, unfiltered.
    Gps from core::Gps, |g| {
        /// `GPS_FIX_TYPE`; 3 and more is a position in three dimensions.
        fix: u8 = g.fix.0,
        /// The fix in words.
        fix_name: String = g.fix.name().to_owned(),
        /// Satellites in view.
        satellites: Option<u8> = g.satellites,
        /// Horizontal dilution of precision.
        hdop: Option<f64> = g.hdop,
        /// Vertical dilution of precision.
        vdop: Option<f64> = g.vdop,
        /// WGS-84 latitude.
        lat_deg: Option<f64> = g.lat_deg,
        /// WGS-84 longitude.
        lon_deg: Option<f64> = g.lon_deg,
        /// Height above mean sea level.
        alt_amsl_m: Option<f64> = g.alt_amsl_m,
        /// Speed over ground.
        groundspeed_m_s: Option<f64> = g.groundspeed_m_s,
        /// Course over ground, 0 to 360.
        course_deg: Option<f64> = g.course_deg,
        /// Horizontal uncertainty.
        horizontal_accuracy_m: Option<f64> = g.horizontal_accuracy_m,
        /// Vertical uncertainty.
        vertical_accuracy_m: Option<f64> = g.vertical_accuracy_m,
    }
}
group! {
    /// SYS_STATUS: sensors and power at a glance.
    SysStatus from core::SysStatus, |s| {
        /// Whether the pre-arm checks pass.
        is_ready_to_arm: Option<bool> = s.is_ready_to_arm(),
        /// Sensors that are in use and do not work.
        unhealthy_sensors: Vec<String> = s.unhealthy().map(str::to_owned).collect(),
        /// Processor load.
        load_pct: Option<f64> = s.load_pct,
        /// Battery voltage.
        voltage_v: Option<f64> = s.voltage_v,
        /// Battery current, discharge positive.
        current_a: Option<f64> = s.current_a,
        /// Charge left.
        battery_remaining_pct: Option<f64> = s.battery_remaining_pct,
        /// Messages lost on their way to the vehicle.
        drop_rate_pct: Option<f64> = s.drop_rate_pct,
    }
}
group! {
    /// BATTERY_STATUS of one battery.
    Battery from core::Battery, |b| {
        /// Battery id, from 0.
        id: u8 = b.id,
        /// Voltage of the pack.
        voltage_v: Option<f64> = b.voltage_v,
        /// Current, discharge positive.
        current_a: Option<f64> = b.current_a,
        /// Charge used.
        consumed_mah: Option<f64> = b.consumed_mah,
        /// Energy used.
        consumed_j: Option<f64> = b.consumed_j,
        /// Charge left.
        remaining_pct: Option<f64> = b.remaining_pct,
        /// Temperature.
        temperature_c: Option<f64> = b.temperature_c,
        /// Time left at this rate.
        time_remaining_s: Option<f64> = b.time_remaining_s,
    }
}
group! {
    /// SCALED_IMU: one inertial sensor, body forward, right, down.
    Imu from core::Imu, |i| {
        /// Specific force, in g.
        acc_g: Option<[f64; 3]> = i.acc_g,
        /// Angular rate.
        gyro_rad_s: Option<[f64; 3]> = i.gyro_rad_s,
        /// Magnetic field.
        mag_gauss: Option<[f64; 3]> = i.mag_gauss,
        /// Temperature of the sensor.
        temperature_c: Option<f64> = i.temperature_c,
    }
}
group! {
    /// SCALED_PRESSURE.
    Pressure from core::Pressure, |p| {
        /// Static pressure.
        absolute_pa: Option<f64> = p.absolute_pa,
        /// Differential pressure of the airspeed sensor.
        differential_pa: Option<f64> = p.differential_pa,
        /// Temperature at the barometer.
        temperature_c: Option<f64> = p.temperature_c,
    }
}
group! {
    /// WIND.
    Wind from core::Wind, |w| {
        /// Where the wind comes from.
        from_deg: Option<f64> = w.from_deg,
        /// Horizontal speed.
        speed_m_s: Option<f64> = w.speed_m_s,
        /// Vertical speed, down positive.
        speed_down_m_s: Option<f64> = w.speed_down_m_s,
    }
}
group! {
    /// HOME_POSITION.
    HomePosition from core::Home, |h| {
        /// WGS-84 latitude.
        lat_deg: f64 = h.lat_deg,
        /// WGS-84 longitude.
        lon_deg: f64 = h.lon_deg,
        /// Height above mean sea level.
        alt_amsl_m: f64 = h.alt_amsl_m,
    }
}
group! {
    /// MISSION_CURRENT, with the numbers of the wire; `progress` counts items from 1.
    MissionCurrent from core::MissionCurrent, |m| {
        /// Number of the item in execution on the wire.
        seq: u16 = m.seq,
        /// Items on board.
        total: Option<u16> = m.total,
        /// What the mission does.
        state: Option<String> = m.state.map(|state| state.to_string()),
    }
}
group! {
    /// NAV_CONTROLLER_OUTPUT.
    NavController from core::NavController, |n| {
        /// Wanted roll.
        nav_roll_deg: Option<f64> = n.nav_roll_deg,
        /// Wanted pitch.
        nav_pitch_deg: Option<f64> = n.nav_pitch_deg,
        /// Bearing that is steered.
        nav_bearing_deg: Option<f64> = n.nav_bearing_deg,
        /// Bearing to the target.
        target_bearing_deg: Option<f64> = n.target_bearing_deg,
        /// Distance to the target.
        wp_distance_m: Option<f64> = n.wp_distance_m,
        /// Height error, target above positive.
        alt_error_m: Option<f64> = n.alt_error_m,
        /// Airspeed error.
        airspeed_error_m_s: Option<f64> = n.airspeed_error_m_s,
        /// Distance off the track, right of it positive.
        cross_track_error_m: Option<f64> = n.cross_track_error_m,
    }
}
group! {
    /// EXTENDED_SYS_STATE.
    ExtendedState from core::ExtendedState, |e| {
        /// `undefined`, `on ground`, `in air`, `taking off` or `landing`.
        landed: String = e.landed.to_string(),
        /// `MAV_VTOL_STATE`; null for a plane without VTOL.
        vtol: Option<u8> = e.vtol,
    }
}
group! {
    /// EKF_STATUS_REPORT; a variance of 1 is the limit.
    Ekf from core::Ekf, |e| {
        /// `EKF_STATUS_FLAGS` bits.
        flags: u16 = e.flags,
        /// Of velocity.
        velocity_variance: Option<f64> = e.velocity_variance,
        /// Of horizontal position.
        pos_horiz_variance: Option<f64> = e.pos_horiz_variance,
        /// Of height.
        pos_vert_variance: Option<f64> = e.pos_vert_variance,
        /// Of the compass.
        compass_variance: Option<f64> = e.compass_variance,
        /// Of terrain height.
        terrain_alt_variance: Option<f64> = e.terrain_alt_variance,
    }
}
group! {
    /// VIBRATION.
    Vibration from core::Vibration, |v| {
        /// Levels along body x, y, z.
        vibration_m_s2: [Option<f64>; 3] = v.vibration_m_s2,
        /// How often each accelerometer was clipped since boot.
        clipping: [u32; 3] = v.clipping,
    }
}
group! {
    /// AUTOPILOT_VERSION.
    AutopilotVersion from core::AutopilotVersion, |v| {
        /// Version of the flight software.
        flight_sw: String = v.flight_sw.to_string(),
        /// First characters of its git hash.
        git_hash: String = v.git_hash.to_string(),
        /// `MAV_PROTOCOL_CAPABILITY` bits.
        capabilities: u64 = v.capabilities,
        /// Unique id of the hardware, in decimal: it has more digits than a JSON number keeps.
        uid: Option<String> = v.uid.map(|uid| uid.to_string()),
    }
}
group! {
    /// RADIO_STATUS of the telemetry radio.
    Radio from core::Radio, |r| {
        /// Received signal on our side, raw.
        rssi: Option<u8> = r.rssi,
        /// Received signal on the vehicle's side, raw.
        remote_rssi: Option<u8> = r.remote_rssi,
        /// Noise on our side, raw.
        noise: Option<u8> = r.noise,
        /// Noise on the vehicle's side, raw.
        remote_noise: Option<u8> = r.remote_noise,
        /// Free transmit buffer.
        tx_buffer_pct: Option<u8> = r.tx_buffer_pct,
        /// Packets lost to radio errors.
        rx_errors: u16 = r.rx_errors,
        /// Packets that error correction saved.
        fixed: u16 = r.fixed,
    }
}
group! {
    /// AIRSPEED of one sensor.
    AirspeedSensor from core::AirspeedSensor, |a| {
        /// Sensor id.
        id: u8 = a.id,
        /// Calibrated airspeed.
        airspeed_m_s: Option<f64> = a.airspeed_m_s,
        /// Differential pressure.
        differential_pa: Option<f64> = a.differential_pa,
        /// Temperature.
        temperature_c: Option<f64> = a.temperature_c,
        /// Whether the sensor says that it is unhealthy.
        is_unhealthy: bool = a.is_unhealthy,
        /// Whether the autopilot uses it.
        is_used: bool = a.is_used,
    }
}
group! {
    /// SERVO_OUTPUT_RAW.
    ServoOutputs from core::ServoOutputs, |s| {
        /// Pulse lengths of outputs 1 to 16; null for one that is off.
        pulse_us: Vec<Option<u16>> = s.pulse_us.to_vec(),
    }
}
group! {
    /// RC_CHANNELS.
    RcChannels from core::RcChannels, |r| {
        /// Channels that exist.
        count: u8 = r.count,
        /// Pulse lengths of channels 1 to 18; null for one that is not there.
        pulse_us: Vec<Option<u16>> = r.pulse_us.to_vec(),
        /// Received signal, raw.
        rssi: Option<u8> = r.rssi,
    }
}
group! {
    /// SYSTEM_TIME.
    SystemTime from core::SystemTime, |s| {
        /// UTC of the vehicle, microseconds since 1970.
        utc_us: Option<u64> = s.utc_us,
        /// Time since the vehicle booted.
        boot_ms: u32 = s.boot_ms,
    }
}
group! {
    /// TERRAIN_REPORT: what the vehicle knows of the ground.
    TerrainReport from core::Terrain, |r| {
        /// Ground above mean sea level under the vehicle; null as long as it does not know it.
        ground_amsl_m: Option<f64> = r.ground_amsl_m,
        /// Altitude of the vehicle above that ground.
        alt_terrain_m: Option<f64> = r.alt_terrain_m,
        /// Blocks of 4 × 4 altitudes that it waits for.
        pending: u16 = r.pending,
        /// Blocks that it holds in memory.
        loaded: u16 = r.loaded,
    }
}
group! {
    /// FENCE_STATUS.
    FenceStatus from core::FenceStatus, |f| {
        /// Whether the vehicle is outside now.
        is_breached: bool = f.is_breached,
        /// Breaches so far.
        breach_count: u16 = f.breach_count,
        /// Kind of the last one (`FENCE_BREACH`).
        breach_type: u8 = f.breach_type,
    }
}

/// `None` is left out of the JSON ("as before"), `Some(None)` is null ("forgotten").
type Slot<T> = Option<Option<T>>;

macro_rules! groups {
    ($($(#[$doc:meta])* $field:ident: $kind:ident,)*) => {
        /// The newest values by group. A group that was never heard is absent. In a WebSocket message a group that did not
        /// change is absent, and one that the vehicle's restart made void is null.
        #[derive(Debug, Clone, PartialEq, Serialize, ToSchema, Default)]
        pub struct TelemetryGroups {
            $($(#[$doc])*
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(value_type = Option<$kind>, required = false)]
            pub $field: Slot<$kind>,)*
            /// The first inertial sensor; the same as the first of `imus`.
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(value_type = Option<Imu>, required = false)]
            pub imu: Slot<Imu>,
            /// Inertial sensors 1 to 3.
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(required = false, nullable = false)]
            pub imus: Option<Vec<Option<Imu>>>,
            /// The batteries heard so far.
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(required = false, nullable = false)]
            pub batteries: Option<Vec<Battery>>,
        }

        /// When each group was sent last; what a client that reads slowly has still to hear follows from it.
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct Sent {
            $($field: Option<MonoTime>,)*
            imus: [Option<MonoTime>; core::MAX_IMUS],
            batteries: [Option<MonoTime>; core::MAX_BATTERIES],
        }

        impl TelemetryGroups {
            /// What `telemetry` has that was not sent yet; `sent` is brought up to it.
            pub fn changes(telemetry: &Telemetry, now: MonoTime, sent: &mut Sent) -> Self {
                let mut groups = Self::default();
                $({
                    let at = telemetry.$field.as_ref().map(|sampled| sampled.at);
                    if at != sent.$field {
                        sent.$field = at;
                        groups.$field = Some(telemetry.$field.as_ref().map(|sampled| $kind::new(sampled, now)));
                    }
                })*
                let moments = telemetry.imus.map(|imu| imu.map(|sampled| sampled.at));
                if moments != sent.imus {
                    let imu = |imu: &Option<Sampled<core::Imu>>| imu.as_ref().map(|sampled| Imu::new(sampled, now));
                    if moments[0] != sent.imus[0] {
                        groups.imu = Some(imu(&telemetry.imus[0]));
                    }
                    groups.imus = Some(telemetry.imus.iter().map(imu).collect());
                    sent.imus = moments;
                }
                let moments = telemetry.batteries.map(|battery| battery.map(|sampled| sampled.at));
                if moments != sent.batteries {
                    let batteries = telemetry.batteries.iter().flatten();
                    groups.batteries = Some(batteries.map(|sampled| Battery::new(sampled, now)).collect());
                    sent.batteries = moments;
                }
                groups
            }

            /// Everything that `telemetry` has.
            pub fn all(telemetry: &Telemetry, now: MonoTime) -> Self {
                Self::changes(telemetry, now, &mut Sent::default())
            }

            /// Whether there is nothing to tell.
            pub fn is_empty(&self) -> bool {
                $(self.$field.is_none() &&)* self.imus.is_none() && self.batteries.is_none()
            }
        }
    };
}

groups! {
    /// HEARTBEAT.
    heartbeat: Heartbeat,
    /// ATTITUDE.
    attitude: Attitude,
    /// GLOBAL_POSITION_INT.
    position: Position,
    /// VFR_HUD.
    hud: Hud,
    /// GPS_RAW_INT.
    gps: Gps,
    /// SYS_STATUS.
    sys_status: SysStatus,
    /// SCALED_PRESSURE.
    pressure: Pressure,
    /// WIND.
    wind: Wind,
    /// HOME_POSITION.
    home: HomePosition,
    /// MISSION_CURRENT.
    mission: MissionCurrent,
    /// NAV_CONTROLLER_OUTPUT.
    nav: NavController,
    /// EXTENDED_SYS_STATE.
    extended: ExtendedState,
    /// EKF_STATUS_REPORT.
    ekf: Ekf,
    /// VIBRATION.
    vibration: Vibration,
    /// AUTOPILOT_VERSION.
    version: AutopilotVersion,
    /// RADIO_STATUS.
    radio: Radio,
    /// AIRSPEED.
    airspeed: AirspeedSensor,
    /// SERVO_OUTPUT_RAW.
    servos: ServoOutputs,
    /// RC_CHANNELS.
    rc: RcChannels,
    /// SYSTEM_TIME.
    system_time: SystemTime,
    /// FENCE_STATUS.
    fence: FenceStatus,
    /// TERRAIN_REPORT.
    terrain: TerrainReport,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled<T>(value: T, ms: u64) -> Option<Sampled<T>> {
        Some(Sampled { value, at: MonoTime::from_millis(ms), invalid: false })
    }

    #[test]
    fn only_what_changed_is_told_and_what_is_void_is_null() {
        let now = MonoTime::from_millis(200);
        let mut sent = Sent::default();
        let mut telemetry = Telemetry {
            attitude: sampled(core::Attitude { roll_rad: Some(0.1), ..core::Attitude::default() }, 100),
            wind: sampled(core::Wind::default(), 100),
            ..Telemetry::default()
        };
        telemetry.imus[0] = sampled(core::Imu::default(), 100);
        let json = |groups: &TelemetryGroups| serde_json::to_value(groups).expect("JSON");

        let first = TelemetryGroups::changes(&telemetry, now, &mut sent);
        let first = json(&first);
        let keys: Vec<_> = first.as_object().expect("an object").keys().cloned().collect();
        assert_eq!(keys, ["attitude", "imu", "imus", "wind"]);
        assert_eq!(first["attitude"]["roll_rad"], 0.1);
        assert_eq!(first["attitude"]["age_s"], 0.1);
        assert!(first["attitude"]["pitch_rad"].is_null(), "an absent value is null, and its key is there");

        assert!(TelemetryGroups::changes(&telemetry, now, &mut sent).is_empty());

        telemetry.wind = None;
        telemetry.attitude = sampled(core::Attitude::default(), 150);
        let second = json(&TelemetryGroups::changes(&telemetry, now, &mut sent));
        assert!(second["wind"].is_null() && second.get("wind").is_some());
        assert_eq!(second.as_object().expect("an object").len(), 2);
    }
}

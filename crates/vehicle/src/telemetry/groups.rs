//! The groups of values that a vehicle reports, one per message: a field is declared here once, with its unit and
//! range, and read in `apply.rs`. Behind the feature `describe` each describes itself: its JSON, and the schema from
//! which the types of the web app and of the Python package are generated. What is kept for the state machines alone
//! says `serde(skip)`.

#[cfg(feature = "describe")]
use super::kinds::exact;
use super::{FlightMode, GitHash, GpsFix, LandedState, MissionState, Sensors, SoftwareVersion, SystemStatus};

/// Derives what all groups have in common. What is `None` is null in JSON, and in the schema's descriptions: its key is
/// always there.
macro_rules! groups {
    ($($(#[$meta:meta])* pub struct $name:ident {
        $($(#[$field_meta:meta])* pub $field:ident: $kind:ty,)*
    })*) => {$(
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
        pub struct $name {
            $($(#[$field_meta])* #[cfg_attr(feature = "describe", schema(required = true))] pub $field: $kind,)*
        }
    )*};
}

groups! {
    /// HEARTBEAT of the autopilot: type, mode and state of the vehicle.
    #[derive(Eq)]
    pub struct HeartbeatState {
        /// Flight mode by name, such as `"AUTO"`; `"mode 42"` when the number is not known.
        #[cfg_attr(feature = "describe", schema(value_type = String))]
        pub mode: FlightMode,
        /// The mode's number on the wire, in the autopilot's own numbering.
        pub mode_number: u32,
        /// Whether the motors can run.
        pub is_armed: bool,
        /// `MAV_STATE` in words, such as `"standby"` or `"active"`.
        #[cfg_attr(feature = "describe", schema(value_type = String))]
        pub system_status: SystemStatus,
        /// `MAV_TYPE`: 1 fixed wing, 2 quadrotor, 19 to 25 VTOL.
        pub mav_type: u8,
        /// `MAV_AUTOPILOT`: 3 ArduPilot, 12 PX4.
        pub autopilot: u8,
        /// `MAV_MODE_FLAG` bits as sent.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub base_mode: u8,
    }

    /// ATTITUDE: body (forward, right, down) in the local frame (north, east, down), Tait-Bryan ZYX.
    #[derive(Default)]
    pub struct Attitude {
        /// Right wing down positive, -pi to pi.
        pub roll_rad: Option<f64>,
        /// Nose up positive, -pi/2 to pi/2.
        pub pitch_rad: Option<f64>,
        /// Clockwise from true north, -pi to pi.
        pub yaw_rad: Option<f64>,
        /// Body rate about the forward axis.
        pub roll_rate_rad_s: Option<f64>,
        /// Body rate about the right axis.
        pub pitch_rate_rad_s: Option<f64>,
        /// Body rate about the down axis.
        pub yaw_rate_rad_s: Option<f64>,
    }

    /// GLOBAL_POSITION_INT: the autopilot's filtered position estimate.
    #[derive(Default)]
    pub struct Position {
        /// WGS-84 latitude; `None` without a position.
        pub lat_deg: Option<f64>,
        /// WGS-84 longitude; `None` without a position.
        pub lon_deg: Option<f64>,
        /// Altitude above mean sea level.
        pub alt_amsl_m: Option<f64>,
        /// Altitude above home.
        pub alt_rel_home_m: Option<f64>,
        /// Ground speed northward.
        pub velocity_north_m_s: Option<f64>,
        /// Ground speed eastward.
        pub velocity_east_m_s: Option<f64>,
        /// Speed downward.
        pub velocity_down_m_s: Option<f64>,
        /// Heading, 0 to 360 from true north.
        pub heading_deg: Option<f64>,
    }

    /// VFR_HUD: speeds, heading and altitude for a head-up display.
    #[derive(Default)]
    pub struct Hud {
        /// Airspeed (indicated or equivalent, depending on the autopilot).
        pub airspeed_m_s: Option<f64>,
        /// Speed over ground.
        pub groundspeed_m_s: Option<f64>,
        /// Heading, 0 to 360.
        pub heading_deg: Option<f64>,
        /// Throttle, 0 to 100 %.
        pub throttle_pct: Option<f64>,
        /// Altitude above mean sea level.
        pub alt_amsl_m: Option<f64>,
        /// Climb rate, up positive.
        pub climb_m_s: Option<f64>,
    }

    /// GPS_RAW_INT: the GPS receiver's data, unfiltered.
    pub struct Gps {
        /// `GPS_FIX_TYPE`; 3 and more is a position in three dimensions.
        #[cfg_attr(feature = "describe", schema(value_type = u8))]
        pub fix: GpsFix,
        /// The fix in words.
        pub fix_name: &'static str,
        /// Satellites in view.
        pub satellites: Option<u8>,
        /// Horizontal dilution of precision.
        pub hdop: Option<f64>,
        /// Vertical dilution of precision.
        pub vdop: Option<f64>,
        /// WGS-84 latitude.
        pub lat_deg: Option<f64>,
        /// WGS-84 longitude.
        pub lon_deg: Option<f64>,
        /// Altitude above mean sea level.
        pub alt_amsl_m: Option<f64>,
        /// Altitude above the WGS-84 ellipsoid, if the receiver reports it.
        pub alt_ellipsoid_m: Option<f64>,
        /// Speed over ground.
        pub groundspeed_m_s: Option<f64>,
        /// Course over ground, 0 to 360.
        pub course_deg: Option<f64>,
        /// Horizontal uncertainty, one sigma as the receiver estimates it.
        pub horizontal_accuracy_m: Option<f64>,
        /// Vertical uncertainty, one sigma as the receiver estimates it.
        pub vertical_accuracy_m: Option<f64>,
    }

    /// SYS_STATUS: sensors and power at a glance.
    pub struct SysStatus {
        /// Whether the vehicle's pre-arm checks pass; `None` when not reported.
        pub is_ready_to_arm: Option<bool>,
        /// Sensors in use that are unhealthy.
        #[cfg_attr(feature = "describe", schema(value_type = Vec<String>))]
        pub unhealthy_sensors: Sensors,
        /// Processor load, 0 to 100 %.
        pub load_pct: Option<f64>,
        /// Battery voltage.
        pub voltage_v: Option<f64>,
        /// Battery current, discharge positive.
        pub current_a: Option<f64>,
        /// Charge left, 0 to 100 %.
        pub battery_remaining_pct: Option<f64>,
        /// Messages lost on their way to the vehicle, 0 to 100 %.
        pub drop_rate_pct: Option<f64>,
    }

    /// BATTERY_STATUS of one battery.
    pub struct Battery {
        /// Battery id, from 0.
        pub id: u8,
        /// Voltage of the pack: the sum of the reported voltages.
        pub voltage_v: Option<f64>,
        /// Voltages of single cells. Empty (all `None`) when only the pack is measured.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub cells_v: [Option<f32>; 14],
        /// Current, discharge positive.
        pub current_a: Option<f64>,
        /// Charge used.
        pub consumed_mah: Option<f64>,
        /// Energy used.
        pub consumed_j: Option<f64>,
        /// Charge left, 0 to 100 %.
        pub remaining_pct: Option<f64>,
        /// Temperature.
        pub temperature_c: Option<f64>,
        /// Time left at this rate.
        pub time_remaining_s: Option<f64>,
    }

    /// RAW_IMU: raw sensor values. ArduPilot's are scaled, see [`Imu`].
    #[derive(Eq)]
    pub struct RawImu {
        /// Accelerometer, body FRD, raw.
        pub acc_raw: [i16; 3],
        /// Gyro, body FRD, raw.
        pub gyro_raw: [i16; 3],
        /// Magnetometer, body FRD, raw.
        pub mag_raw: [i16; 3],
    }

    /// SCALED_IMU to SCALED_IMU3, or an ArduPilot's RAW_IMU: one inertial sensor, body forward, right, down.
    #[derive(Default)]
    pub struct Imu {
        /// Specific force in g (9.80665 m/s²).
        pub acc_g: Option<[f64; 3]>,
        /// Angular rate.
        pub gyro_rad_s: Option<[f64; 3]>,
        /// Magnetic field; `None` when all three are 0, which no place on Earth has.
        pub mag_gauss: Option<[f64; 3]>,
        /// Temperature of the sensor.
        pub temperature_c: Option<f64>,
    }

    /// SCALED_PRESSURE: barometer and airspeed sensor.
    #[derive(Default)]
    pub struct Pressure {
        /// Static pressure.
        pub absolute_pa: Option<f64>,
        /// Differential pressure of the airspeed sensor.
        pub differential_pa: Option<f64>,
        /// Temperature at the barometer.
        pub temperature_c: Option<f64>,
    }

    /// WIND (ArduPilot) or WIND_COV: the autopilot's estimate.
    #[derive(Default)]
    pub struct Wind {
        /// Direction that the wind comes from, 0 to 360.
        pub from_deg: Option<f64>,
        /// Horizontal speed.
        pub speed_m_s: Option<f64>,
        /// Vertical speed, down positive.
        pub speed_down_m_s: Option<f64>,
    }

    /// MISSION_CURRENT, with the numbers of the wire: on ArduPilot item 0 is home.
    #[derive(Eq)]
    pub struct MissionCurrent {
        /// Number of the item in execution on the wire.
        pub seq: u16,
        /// Items on board, home not counted, 0 where there is no mission; `None` when not reported.
        pub total: Option<u16>,
        /// `"no mission"`, `"not started"`, `"active"`, `"paused"` or `"complete"`; `None` when the vehicle does not
        /// say.
        #[cfg_attr(feature = "describe", schema(value_type = Option<String>))]
        pub state: Option<MissionState>,
        /// Whether the vehicle is in a mode that follows the mission; `None` when not reported.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub in_mission_mode: Option<bool>,
        /// Id of the mission on board; `None` without a mission, and from vehicles that give no ids (other than PX4).
        #[cfg_attr(feature = "describe", serde(skip))]
        pub mission_id: Option<u32>,
        /// Id of the geofence on board.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub fence_id: Option<u32>,
        /// Id of the rally points on board.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub rally_points_id: Option<u32>,
    }

    /// NAV_CONTROLLER_OUTPUT: targets and errors of the navigation controller.
    #[derive(Default)]
    pub struct NavController {
        /// Desired roll.
        pub nav_roll_deg: Option<f64>,
        /// Desired pitch.
        pub nav_pitch_deg: Option<f64>,
        /// Desired heading, -180 to 180.
        pub nav_bearing_deg: Option<f64>,
        /// Bearing to the target, -180 to 180.
        pub target_bearing_deg: Option<f64>,
        /// Distance to the target.
        pub wp_distance_m: Option<f64>,
        /// Altitude error, target above positive.
        pub alt_error_m: Option<f64>,
        /// Airspeed error, target faster positive.
        pub airspeed_error_m_s: Option<f64>,
        /// Distance off the track, right of it positive.
        pub cross_track_error_m: Option<f64>,
    }

    /// EXTENDED_SYS_STATE: on the ground or in the air.
    #[derive(Eq)]
    pub struct ExtendedState {
        /// `"undefined"`, `"on ground"`, `"in air"`, `"taking off"` or `"landing"`.
        #[cfg_attr(feature = "describe", schema(value_type = String))]
        pub landed: LandedState,
        /// `MAV_VTOL_STATE` (3 multicopter, 4 fixed wing, 1 and 2 transitions); `None` for a plane without VTOL.
        pub vtol: Option<u8>,
    }

    /// EKF_STATUS_REPORT: agreement of the estimator with its sensors; a test ratio of 1 is the limit.
    #[derive(Default)]
    pub struct Ekf {
        /// `EKF_STATUS_FLAGS` bits.
        pub flags: u16,
        /// Test ratio of velocity.
        pub velocity_variance: Option<f64>,
        /// Test ratio of horizontal position.
        pub pos_horiz_variance: Option<f64>,
        /// Test ratio of altitude.
        pub pos_vert_variance: Option<f64>,
        /// Test ratio of the compass.
        pub compass_variance: Option<f64>,
        /// Test ratio of terrain altitude.
        pub terrain_alt_variance: Option<f64>,
    }

    /// VIBRATION of the airframe, measured by the accelerometers.
    #[derive(Default)]
    pub struct Vibration {
        /// Levels along body x, y, z.
        pub vibration_m_s2: [Option<f64>; 3],
        /// Clipping events of each accelerometer since boot.
        pub clipping: [u32; 3],
    }

    /// AUTOPILOT_VERSION.
    #[derive(Eq)]
    pub struct AutopilotVersion {
        /// Version of the flight software, such as `"4.6.3"`.
        #[cfg_attr(feature = "describe", schema(value_type = String))]
        pub flight_sw: SoftwareVersion,
        /// First eight characters of the git hash of the flight software.
        #[cfg_attr(feature = "describe", schema(value_type = String))]
        pub git_hash: GitHash,
        /// `MAV_PROTOCOL_CAPABILITY` bits.
        pub capabilities: u64,
        /// Board version.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub board_version: u32,
        /// USB vendor id of the board.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub vendor_id: u16,
        /// USB product id of the board.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub product_id: u16,
        /// Unique id of the hardware, 64 bits; in JSON a string of decimal digits, which a JSON number could not hold
        /// exactly.
        #[cfg_attr(feature = "describe", serde(serialize_with = "exact"), schema(value_type = Option<String>))]
        pub uid: Option<u64>,
        /// The longer id that replaces it (ArduPilot reports only this one); `None` when not reported.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub uid2: Option<[u8; 18]>,
    }

    /// RADIO_STATUS or RADIO of the telemetry radio.
    #[derive(Eq, Default)]
    pub struct Radio {
        /// Received signal on our side, raw 0 to 254.
        pub rssi: Option<u8>,
        /// Received signal on the vehicle's side, raw 0 to 254.
        pub remote_rssi: Option<u8>,
        /// Noise on our side, raw.
        pub noise: Option<u8>,
        /// Noise on the vehicle's side, raw.
        pub remote_noise: Option<u8>,
        /// Free transmit buffer, 0 to 100 %.
        pub tx_buffer_pct: Option<u8>,
        /// Packets lost to radio errors.
        pub rx_errors: u16,
        /// Packets restored by error correction.
        pub fixed: u16,
    }

    /// AIRSPEED of the sensor heard last.
    pub struct AirspeedSensor {
        /// Sensor id.
        pub id: u8,
        /// Calibrated airspeed.
        pub airspeed_m_s: Option<f64>,
        /// Differential pressure.
        pub differential_pa: Option<f64>,
        /// Temperature.
        pub temperature_c: Option<f64>,
        /// Whether the sensor reports that it is unhealthy.
        pub is_unhealthy: bool,
        /// Whether the autopilot uses it.
        pub is_used: bool,
    }

    /// SERVO_OUTPUT_RAW of outputs 1 to 16: the signals to the actuators.
    #[derive(Eq)]
    pub struct ServoOutputs {
        /// Pulse lengths of outputs 1 to 16; `None` for an output that is off.
        pub pulse_us: [Option<u16>; 16],
    }

    /// RC_CHANNELS: the pilot's radio.
    #[derive(Eq)]
    pub struct RcChannels {
        /// Number of channels.
        pub count: u8,
        /// Pulse lengths of channels 1 to 18; `None` for a missing channel.
        pub pulse_us: [Option<u16>; 18],
        /// Received signal, raw 0 to 254.
        pub rssi: Option<u8>,
    }

    /// EFI_STATUS: an engine with fuel injection. Values that are not measured may be reported as 0.
    #[derive(Default)]
    pub struct Engine {
        /// Health as sent: 1 healthy and 0 not on ArduPilot; 0 stopped, 1 starting, 2 running and 3 at fault on PX4.
        pub health: u8,
        /// Number of the engine control unit.
        pub ecu_index: Option<f64>,
        /// Revolutions per minute.
        pub rpm: Option<f64>,
        /// Fuel used.
        pub fuel_consumed_cm3: Option<f64>,
        /// Fuel flow, cubic centimetres per minute.
        pub fuel_flow_cm3_min: Option<f64>,
        /// Load, 0 to 200 %.
        pub load_pct: Option<f64>,
        /// Throttle position, 0 to 100 %.
        pub throttle_position_pct: Option<f64>,
        /// Commanded throttle, 0 to 100 %.
        pub throttle_output_pct: Option<f64>,
        /// Charging time of the ignition coil.
        pub spark_dwell_ms: Option<f64>,
        /// Ignition timing, crank angle.
        pub ignition_timing_deg: Option<f64>,
        /// Injection time.
        pub injection_ms: Option<f64>,
        /// Atmospheric pressure.
        pub barometric_pa: Option<f64>,
        /// Pressure in the intake manifold.
        pub intake_manifold_pa: Option<f64>,
        /// Temperature in the intake manifold.
        pub intake_manifold_temperature_c: Option<f64>,
        /// Temperature of the cylinder head.
        pub cylinder_head_temperature_c: Option<f64>,
        /// Temperature of the exhaust gas.
        pub exhaust_gas_temperature_c: Option<f64>,
        /// Correction factor of the fuel for pressure and temperature.
        pub pressure_temperature_compensation: Option<f64>,
        /// Ignition voltage.
        pub ignition_v: Option<f64>,
        /// Fuel pressure.
        pub fuel_pressure_pa: Option<f64>,
    }

    /// SYSTEM_TIME: the vehicle's clocks.
    #[derive(Eq)]
    pub struct SystemTime {
        /// UTC of the vehicle when the message was sent, microseconds since 1970; `None` before it knows the date.
        pub utc_us: Option<u64>,
        /// Time since the vehicle booted.
        pub boot_ms: u32,
    }

    /// FENCE_STATUS.
    #[derive(Eq)]
    pub struct FenceStatus {
        /// Whether the vehicle is outside now.
        pub is_breached: bool,
        /// Breaches so far.
        pub breach_count: u16,
        /// Kind of the last breach (`FENCE_BREACH`: 1 too low, 2 too high, 3 over the boundary).
        pub breach_type: u8,
        /// Time since boot of the last breach; `None` without one.
        #[cfg_attr(feature = "describe", serde(skip))]
        pub breach_boot_ms: Option<u32>,
    }

    /// TERRAIN_REPORT: the vehicle's terrain data.
    pub struct Terrain {
        /// Ground above mean sea level under the vehicle (or where TERRAIN_CHECK asked); `None` as long as it does not
        /// know it.
        pub ground_amsl_m: Option<f64>,
        /// Altitude of the vehicle above that terrain.
        pub alt_terrain_m: Option<f64>,
        /// Blocks of 4 × 4 altitudes that it waits for.
        pub pending: u16,
        /// Blocks that it holds in memory.
        pub loaded: u16,
    }
}

impl AutopilotVersion {
    /// `MAV_PROTOCOL_CAPABILITY_MISSION_INT`.
    pub const MISSION_INT: u64 = 4;
    /// `MAV_PROTOCOL_CAPABILITY_COMMAND_INT`.
    pub const COMMAND_INT: u64 = 8;
    /// `MAV_PROTOCOL_CAPABILITY_FTP`.
    pub const FTP: u64 = 32;

    /// Whether files, and with them whole plans and parameter sets, can be transferred.
    pub fn has_ftp(&self) -> bool {
        self.capabilities & Self::FTP != 0
    }
}

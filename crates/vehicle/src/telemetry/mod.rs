//! What a vehicle says about itself: the newest value of every group, each with its age.
//!
//! [`Telemetry`] is plain data without heap memory, so a snapshot is a copy. A message overwrites its group as a
//! whole; a field that the vehicle marks as unknown is `None`, and a field that cannot be (NaN, a latitude of 91°)
//! is `None` too, counted in [`Telemetry::invalid_values`] and flagged in [`Sampled::invalid`]. It is never used.
//!
//! Axes: body is forward, right, down (FRD); local is north, east, down (NED). Angles are radians where the name
//! ends in `_rad`, degrees where it ends in `_deg`; headings and courses are degrees clockwise from true north.

mod apply;
mod boot;
#[cfg(test)]
mod tests;
mod texts;
mod valid;

use std::fmt;
use std::time::Duration;

use vencejo_proto::MonoTime;

use vencejo_flight::guidance::NorthEast;
use vencejo_flight::rehearsal::Recorded;

use crate::modes::FlightMode;
pub use vencejo_flight::plan::Home;

pub(crate) use apply::boot_ms_of;
pub use boot::{BootClock, BootEvent};
pub use texts::{CHUNK_TIMEOUT, MAX_TEXTS, Severity, StatusLog, Text};

/// A value older than this is stale: shown, but marked.
pub const STALE_AFTER: Duration = Duration::from_millis(3_500);
/// A value older than this is lost: it says nothing about the vehicle any more.
pub const LOST_AFTER: Duration = Duration::from_secs(5);
/// Batteries that are kept, by id 0 to 7; others are counted and dropped.
pub const MAX_BATTERIES: usize = 8;
/// IMUs that are kept.
pub const MAX_IMUS: usize = 3;

/// How much a value may be trusted by its age.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Freshness {
    /// At most [`STALE_AFTER`] old.
    Fresh,
    /// At most [`LOST_AFTER`] old.
    Stale,
    /// Older.
    Lost,
}

impl Freshness {
    /// The freshness of something that was heard `age` ago.
    #[must_use]
    pub fn of_age(age: Duration) -> Self {
        if age <= STALE_AFTER {
            Self::Fresh
        } else if age <= LOST_AFTER {
            Self::Stale
        } else {
            Self::Lost
        }
    }
}

/// A group of values and when it was received.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled<T> {
    /// The values.
    pub value: T,
    /// When the message arrived, on our monotonic clock.
    pub at: MonoTime,
    /// Whether the message held at least one value that cannot be; such fields are `None`.
    pub invalid: bool,
}

impl<T> Sampled<T> {
    /// How old the values are.
    pub fn age(&self, now: MonoTime) -> Duration {
        now.since(self.at)
    }

    /// Fresh, stale or lost.
    pub fn freshness(&self, now: MonoTime) -> Freshness {
        Freshness::of_age(self.age(now))
    }
}

/// HEARTBEAT of the autopilot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeartbeatState {
    /// The flight mode, by name where it is known.
    pub mode: FlightMode,
    /// Whether the motors can run.
    pub is_armed: bool,
    /// What the system is doing.
    pub system_status: SystemStatus,
    /// `MAV_TYPE`: 1 fixed wing, 2 quadrotor, 19 to 25 VTOL…
    pub mav_type: u8,
    /// `MAV_AUTOPILOT`: 3 ArduPilot, 12 PX4…
    pub autopilot: u8,
    /// `MAV_MODE_FLAG` bits as sent.
    pub base_mode: u8,
}

/// `MAV_STATE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SystemStatus {
    /// 0: not said.
    Uninit,
    /// 1: booting.
    Boot,
    /// 2: calibrating.
    Calibrating,
    /// 3: on the ground, ready.
    Standby,
    /// 4: flying (or motors running).
    Active,
    /// 5: in a failsafe that it can handle.
    Critical,
    /// 6: lost control.
    Emergency,
    /// 7: powering off.
    Poweroff,
    /// 8: terminating its flight.
    FlightTermination,
    /// A number that this version does not know.
    Other(u8),
}

impl From<u8> for SystemStatus {
    fn from(value: u8) -> Self {
        match value {
            0 => Self::Uninit,
            1 => Self::Boot,
            2 => Self::Calibrating,
            3 => Self::Standby,
            4 => Self::Active,
            5 => Self::Critical,
            6 => Self::Emergency,
            7 => Self::Poweroff,
            8 => Self::FlightTermination,
            other => Self::Other(other),
        }
    }
}

impl fmt::Display for SystemStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Uninit => "uninitialised",
            Self::Boot => "booting",
            Self::Calibrating => "calibrating",
            Self::Standby => "standby",
            Self::Active => "active",
            Self::Critical => "critical",
            Self::Emergency => "emergency",
            Self::Poweroff => "powering off",
            Self::FlightTermination => "terminating",
            Self::Other(number) => return write!(f, "status {number}"),
        })
    }
}

/// ATTITUDE: body orientation in the local NED frame, Tait-Bryan ZYX (yaw, pitch, roll).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attitude {
    /// Roll, right wing down positive, −π to π.
    pub roll_rad: Option<f64>,
    /// Pitch, nose up positive, −π/2 to π/2.
    pub pitch_rad: Option<f64>,
    /// Yaw, clockwise from true north, −π to π.
    pub yaw_rad: Option<f64>,
    /// Body rate about the forward axis.
    pub roll_rate_rad_s: Option<f64>,
    /// Body rate about the right axis.
    pub pitch_rate_rad_s: Option<f64>,
    /// Body rate about the down axis.
    pub yaw_rate_rad_s: Option<f64>,
}

/// GLOBAL_POSITION_INT: where the autopilot believes to be (filtered).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Position {
    /// WGS-84 latitude; `None` as long as the vehicle has no position.
    pub lat_deg: Option<f64>,
    /// WGS-84 longitude; `None` as long as the vehicle has no position.
    pub lon_deg: Option<f64>,
    /// Height above mean sea level.
    pub alt_amsl_m: Option<f64>,
    /// Height above home.
    pub alt_rel_home_m: Option<f64>,
    /// Ground speed northward.
    pub velocity_north_m_s: Option<f64>,
    /// Ground speed eastward.
    pub velocity_east_m_s: Option<f64>,
    /// Speed downward.
    pub velocity_down_m_s: Option<f64>,
    /// Where the nose points, 0 to 360.
    pub heading_deg: Option<f64>,
}

/// VFR_HUD: what a pilot looks at.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hud {
    /// Speed through the air (indicated or equivalent, as the autopilot has it).
    pub airspeed_m_s: Option<f64>,
    /// Speed over ground.
    pub groundspeed_m_s: Option<f64>,
    /// Where the nose points, 0 to 360.
    pub heading_deg: Option<f64>,
    /// Throttle, 0 to 100 %.
    pub throttle_pct: Option<f64>,
    /// Height above mean sea level.
    pub alt_amsl_m: Option<f64>,
    /// Climb rate, up positive.
    pub climb_m_s: Option<f64>,
}

/// `GPS_FIX_TYPE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GpsFix(pub u8);

impl GpsFix {
    /// Whether there is a position in three dimensions.
    #[must_use]
    pub fn is_3d(self) -> bool {
        self.0 >= 3
    }

    /// The kind of fix in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            0 => "no GPS",
            1 => "no fix",
            2 => "2D",
            3 => "3D",
            4 => "DGPS",
            5 => "RTK float",
            6 => "RTK fixed",
            7 => "static",
            8 => "PPP",
            _ => "unknown fix",
        }
    }
}

impl fmt::Display for GpsFix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// GPS_RAW_INT: what the receiver says, unfiltered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gps {
    /// Kind of fix.
    pub fix: GpsFix,
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
    /// Height above mean sea level.
    pub alt_amsl_m: Option<f64>,
    /// Speed over ground.
    pub groundspeed_m_s: Option<f64>,
    /// Course over ground, 0 to 360.
    pub course_deg: Option<f64>,
    /// Horizontal uncertainty, one sigma as the receiver estimates it.
    pub horizontal_accuracy_m: Option<f64>,
    /// Vertical uncertainty.
    pub vertical_accuracy_m: Option<f64>,
}

/// SYS_STATUS: sensors and power at a glance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SysStatus {
    /// Sensors that exist (`MAV_SYS_STATUS_SENSOR` bits).
    pub sensors_present: u32,
    /// Sensors in use.
    pub sensors_enabled: u32,
    /// Sensors that work.
    pub sensors_health: u32,
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

impl SysStatus {
    /// `MAV_SYS_STATUS_SENSOR_BATTERY`.
    pub const BATTERY: u32 = 1 << 25;
    /// `MAV_SYS_STATUS_PREARM_CHECK`.
    pub const PREARM_CHECK: u32 = 1 << 28;

    /// Whether the pre-arm checks pass; `None` when the vehicle does not say.
    #[must_use]
    pub fn is_ready_to_arm(&self) -> Option<bool> {
        (self.sensors_present & self.sensors_enabled & Self::PREARM_CHECK != 0)
            .then_some(self.sensors_health & Self::PREARM_CHECK != 0)
    }

    /// Names of the sensors that are in use and do not work.
    pub fn unhealthy(&self) -> impl Iterator<Item = &'static str> {
        let bad = self.sensors_present & self.sensors_enabled & !self.sensors_health;
        SENSOR_NAMES.iter().enumerate().filter(move |(bit, _)| bad & (1 << bit) != 0).map(|(_, name)| *name)
    }
}

/// Names of the bits of `MAV_SYS_STATUS_SENSOR`, lowest first.
const SENSOR_NAMES: [&str; 32] = [
    "gyro",
    "accelerometer",
    "compass",
    "barometer",
    "airspeed",
    "GPS",
    "optical flow",
    "vision position",
    "laser position",
    "ground truth",
    "rate control",
    "attitude stabilisation",
    "yaw position",
    "altitude control",
    "position control",
    "motor outputs",
    "RC receiver",
    "second gyro",
    "second accelerometer",
    "second compass",
    "geofence",
    "AHRS",
    "terrain",
    "reversed motor",
    "logging",
    "battery",
    "proximity",
    "satellite link",
    "pre-arm check",
    "obstacle avoidance",
    "propulsion",
    "extended sensors",
];

/// BATTERY_STATUS of one battery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Battery {
    /// Battery id, from 0.
    pub id: u8,
    /// Voltage of the pack: the sum of what is reported.
    pub voltage_v: Option<f64>,
    /// Voltages of single cells. Empty (all `None`) when only the pack is measured.
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

/// RAW_IMU: numbers as the sensors give them. On ArduPilot they are scaled, see [`Imu`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawImu {
    /// Accelerometer, body FRD, raw.
    pub acc_raw: [i16; 3],
    /// Gyro, body FRD, raw.
    pub gyro_raw: [i16; 3],
    /// Magnetometer, body FRD, raw.
    pub mag_raw: [i16; 3],
}

/// SCALED_IMU, SCALED_IMU2, SCALED_IMU3, and RAW_IMU of an ArduPilot (which sends it in the same units).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Imu {
    /// Specific force, body FRD, in g (9.80665 m/s²).
    pub acc_g: Option<[f64; 3]>,
    /// Angular rate, body FRD.
    pub gyro_rad_s: Option<[f64; 3]>,
    /// Magnetic field, body FRD; `None` when all three are 0, which no place on Earth has.
    pub mag_gauss: Option<[f64; 3]>,
    /// Temperature of the sensor.
    pub temperature_c: Option<f64>,
}

/// SCALED_PRESSURE.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pressure {
    /// Static pressure.
    pub absolute_pa: Option<f64>,
    /// Differential pressure of the airspeed sensor.
    pub differential_pa: Option<f64>,
    /// Temperature at the barometer.
    pub temperature_c: Option<f64>,
}

/// WIND (ArduPilot) or WIND_COV.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wind {
    /// Where the wind comes **from**, 0 to 360.
    pub from_deg: Option<f64>,
    /// Horizontal speed.
    pub speed_m_s: Option<f64>,
    /// Vertical speed as the message has it (NED: down positive).
    pub speed_down_m_s: Option<f64>,
}

/// `MISSION_STATE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MissionState {
    /// 1: there is none.
    NoMission,
    /// 2: loaded, not started.
    NotStarted,
    /// 3: being flown, or would be in the mission mode.
    Active,
    /// 4: paused.
    Paused,
    /// 5: flown to its end.
    Complete,
    /// A number that this version does not know.
    Other(u8),
}

impl fmt::Display for MissionState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoMission => "no mission",
            Self::NotStarted => "not started",
            Self::Active => "active",
            Self::Paused => "paused",
            Self::Complete => "complete",
            Self::Other(number) => return write!(f, "state {number}"),
        })
    }
}

/// MISSION_CURRENT.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissionCurrent {
    /// Item in execution.
    pub seq: u16,
    /// Items on board, home not counted; `None` when the vehicle does not say.
    pub total: Option<u16>,
    /// What the mission does; `None` when the vehicle does not say.
    pub state: Option<MissionState>,
    /// Whether the vehicle is in a mode that follows the mission; `None` when it does not say.
    pub in_mission_mode: Option<bool>,
    /// Identity of the mission on board, where the vehicle has one (PX4).
    pub mission_id: Option<u32>,
    /// Identity of the geofence on board.
    pub fence_id: Option<u32>,
    /// Identity of the rally points on board.
    pub rally_points_id: Option<u32>,
}

/// NAV_CONTROLLER_OUTPUT.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NavController {
    /// Wanted roll.
    pub nav_roll_deg: Option<f64>,
    /// Wanted pitch.
    pub nav_pitch_deg: Option<f64>,
    /// Bearing that is steered, −180 to 180.
    pub nav_bearing_deg: Option<f64>,
    /// Bearing to the target, −180 to 180.
    pub target_bearing_deg: Option<f64>,
    /// Distance to the target.
    pub wp_distance_m: Option<f64>,
    /// Height error, target above positive.
    pub alt_error_m: Option<f64>,
    /// Airspeed error, target above positive.
    pub airspeed_error_m_s: Option<f64>,
    /// Distance off the track, right of it positive.
    pub cross_track_error_m: Option<f64>,
}

/// `MAV_LANDED_STATE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LandedState {
    /// 0: not known.
    Undefined,
    /// 1: on the ground.
    OnGround,
    /// 2: flying.
    InAir,
    /// 3: taking off.
    TakingOff,
    /// 4: landing.
    Landing,
}

impl fmt::Display for LandedState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Undefined => "undefined",
            Self::OnGround => "on ground",
            Self::InAir => "in air",
            Self::TakingOff => "taking off",
            Self::Landing => "landing",
        })
    }
}

/// EXTENDED_SYS_STATE.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExtendedState {
    /// On the ground, flying, or between.
    pub landed: LandedState,
    /// `MAV_VTOL_STATE` (3 multicopter, 4 fixed wing, 1 and 2 transitions); `None` for a plane without VTOL.
    pub vtol: Option<u8>,
}

/// EKF_STATUS_REPORT.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ekf {
    /// `EKF_STATUS_FLAGS` bits.
    pub flags: u16,
    /// Innovation test ratio of velocity; 1 is the limit.
    pub velocity_variance: Option<f64>,
    /// Of horizontal position.
    pub pos_horiz_variance: Option<f64>,
    /// Of height.
    pub pos_vert_variance: Option<f64>,
    /// Of the compass.
    pub compass_variance: Option<f64>,
    /// Of terrain height.
    pub terrain_alt_variance: Option<f64>,
}

/// VIBRATION.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vibration {
    /// Levels along body x, y, z.
    pub vibration_m_s2: [Option<f64>; 3],
    /// How often each accelerometer was clipped since boot.
    pub clipping: [u32; 3],
}

/// AUTOPILOT_VERSION.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AutopilotVersion {
    /// Version of the flight software.
    pub flight_sw: SoftwareVersion,
    /// First eight characters of the git hash of the flight software.
    pub git_hash: GitHash,
    /// `MAV_PROTOCOL_CAPABILITY` bits.
    pub capabilities: u64,
    /// Board version.
    pub board_version: u32,
    /// USB vendor id of the board.
    pub vendor_id: u16,
    /// USB product id of the board.
    pub product_id: u16,
    /// Unique id of the hardware; `None` when not reported.
    pub uid: Option<u64>,
    /// The longer one that takes its place (ArduPilot reports this one alone); `None` when not reported.
    pub uid2: Option<[u8; 18]>,
}

impl AutopilotVersion {
    /// `MAV_PROTOCOL_CAPABILITY_MISSION_INT`.
    pub const MISSION_INT: u64 = 4;
    /// `MAV_PROTOCOL_CAPABILITY_COMMAND_INT`.
    pub const COMMAND_INT: u64 = 8;
    /// `MAV_PROTOCOL_CAPABILITY_FTP`.
    pub const FTP: u64 = 32;

    /// Whether files, and with them whole plans and parameter sets, can be transferred.
    #[must_use]
    pub fn has_ftp(&self) -> bool {
        self.capabilities & Self::FTP != 0
    }
}

/// A version as AUTOPILOT_VERSION packs it: major, minor, patch and kind of release.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SoftwareVersion {
    /// Major.
    pub major: u8,
    /// Minor.
    pub minor: u8,
    /// Patch.
    pub patch: u8,
    /// `FIRMWARE_VERSION_TYPE`: 0 dev, 64 alpha, 128 beta, 192 rc, 255 official.
    pub release: u8,
}

impl From<u32> for SoftwareVersion {
    fn from(packed: u32) -> Self {
        let [major, minor, patch, release] = packed.to_be_bytes();
        Self { major, minor, patch, release }
    }
}

impl fmt::Display for SoftwareVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)?;
        match self.release {
            255 => Ok(()),
            192..=254 => f.write_str("-rc"),
            128..=191 => f.write_str("-beta"),
            64..=127 => f.write_str("-alpha"),
            _ => f.write_str("-dev"),
        }
    }
}

/// A git hash as sent: eight characters (ArduPilot) or eight bytes (others).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GitHash(pub [u8; 8]);

impl fmt::Display for GitHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.iter().all(u8::is_ascii_hexdigit) {
            return self.0.iter().try_for_each(|byte| write!(f, "{}", char::from(*byte)));
        }
        // PX4 sends the bytes of a number, lowest first.
        self.0.iter().rev().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// RADIO_STATUS of the telemetry radio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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
    /// Packets that error correction saved.
    pub fixed: u16,
}

/// AIRSPEED of one sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirspeedSensor {
    /// Sensor id.
    pub id: u8,
    /// Calibrated airspeed.
    pub airspeed_m_s: Option<f64>,
    /// Differential pressure.
    pub differential_pa: Option<f64>,
    /// Temperature.
    pub temperature_c: Option<f64>,
    /// Whether the sensor says that it is unhealthy.
    pub is_unhealthy: bool,
    /// Whether the autopilot uses it.
    pub is_used: bool,
}

/// SERVO_OUTPUT_RAW.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ServoOutputs {
    /// Bank: 0 is outputs 1 to 16.
    pub port: u8,
    /// Pulse lengths; `None` for an output that is off.
    pub pulse_us: [Option<u16>; 16],
}

/// RC_CHANNELS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RcChannels {
    /// Channels that exist.
    pub count: u8,
    /// Pulse lengths; `None` for a channel that is not there.
    pub pulse_us: [Option<u16>; 18],
    /// Received signal, raw 0 to 254.
    pub rssi: Option<u8>,
}

/// SYSTEM_TIME.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SystemTime {
    /// UTC of the vehicle when the message was sent, µs since 1970; `None` before it knows the date.
    pub utc_us: Option<u64>,
    /// Time since the vehicle booted.
    pub boot_ms: u32,
}

impl Sampled<SystemTime> {
    /// What to add to our monotonic clock to have the vehicle's UTC, in µs (transport delay not taken off).
    pub fn utc_offset_us(&self) -> Option<i64> {
        let utc_us = i64::try_from(self.value.utc_us?).ok()?;
        utc_us.checked_sub(i64::try_from(self.at.as_micros()).ok()?)
    }
}

/// FENCE_STATUS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FenceStatus {
    /// Whether the vehicle is outside now.
    pub is_breached: bool,
    /// Breaches so far.
    pub breach_count: u16,
    /// Kind of the last one (`FENCE_BREACH`: 1 minimum altitude, 2 maximum altitude, 3 boundary).
    pub breach_type: u8,
    /// When it happened, time since boot; `None` when there was none.
    pub breach_boot_ms: Option<u32>,
}

/// TERRAIN_REPORT: what the vehicle knows of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terrain {
    /// Ground above mean sea level under the vehicle (or where TERRAIN_CHECK asked); `None` as long as it does not know it.
    pub ground_amsl_m: Option<f64>,
    /// Height of the vehicle above that ground.
    pub alt_terrain_m: Option<f64>,
    /// Blocks of 4 × 4 heights that it waits for.
    pub pending: u16,
    /// Blocks that it holds in memory.
    pub loaded: u16,
}

/// A group of [`Telemetry`], named after what it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the fields of `Telemetry`")]
#[non_exhaustive]
pub enum Group {
    Heartbeat,
    Attitude,
    Position,
    Hud,
    Gps,
    SysStatus,
    Battery,
    RawImu,
    Imu,
    Pressure,
    Wind,
    Home,
    Mission,
    ItemReached,
    Nav,
    Extended,
    Ekf,
    Vibration,
    Version,
    Radio,
    Airspeed,
    Servos,
    Rc,
    SystemTime,
    Fence,
    Terrain,
}

macro_rules! telemetry {
    ($($(#[$doc:meta])* $field:ident: $value:ty,)*) => {
        /// The newest value of every group. See the [module](self).
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct Telemetry {
            $($(#[$doc])* pub $field: Option<Sampled<$value>>,)*
            /// BATTERY_STATUS by battery id.
            pub batteries: [Option<Sampled<Battery>>; MAX_BATTERIES],
            /// IMU 1 to 3.
            pub imus: [Option<Sampled<Imu>>; MAX_IMUS],
            /// Values so far that could not be and were not used.
            pub invalid_values: u64,
            /// Messages so far that have a group here.
            pub messages: u64,
            /// When the newest position was, by the vehicle's own clock: ms since its boot.
            pub position_boot_ms: u32,
        }

        impl Telemetry {
            /// Forgets every group that was received before `moment`.
            pub(crate) fn forget_before(&mut self, moment: MonoTime) {
                $(if self.$field.as_ref().is_some_and(|sampled| sampled.at < moment) {
                    self.$field = None;
                })*
                for slot in &mut self.batteries {
                    slot.take_if(|sampled| sampled.at < moment);
                }
                for slot in &mut self.imus {
                    slot.take_if(|sampled| sampled.at < moment);
                }
            }
        }
    };
}

telemetry! {
    /// HEARTBEAT.
    heartbeat: HeartbeatState,
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
    /// RAW_IMU.
    raw_imu: RawImu,
    /// SCALED_PRESSURE.
    pressure: Pressure,
    /// WIND or WIND_COV.
    wind: Wind,
    /// HOME_POSITION.
    home: Home,
    /// MISSION_CURRENT.
    mission: MissionCurrent,
    /// MISSION_ITEM_REACHED: the item that was reached last.
    item_reached: u16,
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
    /// RADIO_STATUS or RADIO.
    radio: Radio,
    /// AIRSPEED of the sensor heard last.
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
    terrain: Terrain,
}

impl Telemetry {
    /// Nothing heard yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The moment that a position has just told, for learning the plane from its flight; `None` while attitude or airspeed are not known
    /// now.
    #[must_use]
    pub fn recorded(&self, now: MonoTime) -> Option<Recorded> {
        const SAME: Duration = Duration::from_secs(1);
        fn fresh<T: Copy>(sampled: Option<&Sampled<T>>, now: MonoTime) -> Option<T> {
            sampled.filter(|sampled| now.since(sampled.at) <= SAME).map(|sampled| sampled.value)
        }
        let position = fresh(self.position.as_ref(), now)?;
        let attitude = fresh(self.attitude.as_ref(), now)?;
        let hud = fresh(self.hud.as_ref(), now)?;
        let battery = fresh(self.sys_status.as_ref(), now);
        Some(Recorded {
            // Of the vehicle's clock: a link holds messages back and brings them in bursts.
            time_s: f64::from(self.position_boot_ms) / 1e3,
            velocity: NorthEast::new(position.velocity_north_m_s?, position.velocity_east_m_s?),
            climb_m_s: -position.velocity_down_m_s?,
            height_amsl_m: position.alt_amsl_m?,
            height_m: position.alt_rel_home_m?,
            airspeed_m_s: hud.airspeed_m_s?,
            bank_rad: attitude.roll_rad?,
            pitch_rad: attitude.pitch_rad?,
            throttle: hud.throttle_pct? / 100.0,
            power_w: battery.and_then(|battery| Some(battery.voltage_v? * battery.current_a?)),
            voltage_v: battery.and_then(|battery| battery.voltage_v),
        })
    }

    /// Whether the newest heartbeat says armed; `None` before the first.
    #[must_use]
    pub fn is_armed(&self) -> Option<bool> {
        self.heartbeat.map(|heartbeat| heartbeat.value.is_armed)
    }

    /// The mode of the newest heartbeat; `None` before the first.
    #[must_use]
    pub fn mode(&self) -> Option<FlightMode> {
        self.heartbeat.map(|heartbeat| heartbeat.value.mode)
    }

    /// Whether the vehicle says that it is on the ground; `None` when it does not say.
    #[must_use]
    pub fn is_on_ground(&self) -> Option<bool> {
        match self.extended?.value.landed {
            LandedState::Undefined => None,
            landed => Some(landed == LandedState::OnGround),
        }
    }
}

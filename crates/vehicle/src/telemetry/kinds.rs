//! Types of the groups' fields: numbers of the wire with their names.

use std::fmt;

#[cfg(feature = "describe")]
use super::FlightMode;

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

/// `GPS_FIX_TYPE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "describe", derive(serde::Serialize))]
pub struct GpsFix(pub u8);

impl GpsFix {
    /// The numbers that MAVLink gives a meaning.
    pub const KNOWN: std::ops::RangeInclusive<u8> = 0..=8;

    /// Whether there is a position in three dimensions.
    pub fn is_3d(self) -> bool {
        self.0 >= 3
    }

    /// The kind of fix in words.
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

/// Sensors of a vehicle, as `MAV_SYS_STATUS_SENSOR` bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Sensors(pub u32);

impl Sensors {
    /// `MAV_SYS_STATUS_SENSOR_BATTERY`.
    pub const BATTERY: u32 = 1 << 25;
    /// `MAV_SYS_STATUS_PREARM_CHECK`.
    pub const PREARM_CHECK: u32 = 1 << 28;

    /// Their names, lowest bit first.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        SENSOR_NAMES.iter().enumerate().filter(move |(bit, _)| self.0 & (1 << bit) != 0).map(|(_, name)| *name)
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

/// `MISSION_STATE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MissionState {
    /// 1: there is no mission.
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

/// In a report these are said in words.
#[cfg(feature = "describe")]
macro_rules! in_words {
    ($($kind:ty),*) => {$(
        impl serde::Serialize for $kind {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }
    )*};
}

#[cfg(feature = "describe")]
in_words!(FlightMode, SystemStatus, MissionState, LandedState, SoftwareVersion, GitHash);

#[cfg(feature = "describe")]
impl serde::Serialize for Sensors {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.names())
    }
}

/// A number of 64 bits. Where people read (JSON) it is text: a number keeps 53 bits there.
#[cfg(feature = "describe")]
#[allow(clippy::ref_option, reason = "serde asks for it")]
pub(super) fn exact<S: serde::Serializer>(number: &Option<u64>, serializer: S) -> Result<S::Ok, S::Error> {
    match number {
        Some(number) if serializer.is_human_readable() => serializer.collect_str(number),
        number => serde::Serialize::serialize(number, serializer),
    }
}

//! The newest values that a vehicle reports, in groups, each with its age.
//!
//! [`Telemetry`] is plain data without heap memory, so a snapshot is a copy. A message overwrites its group as a whole;
//! a field that the vehicle marks as unknown is `None`, and an impossible value (NaN, a latitude of 91°) is `None` too,
//! counted in [`Telemetry::invalid_values`] and flagged in [`Sampled::invalid`]. It is never used.
//!
//! Axes: body is forward, right, down (FRD); local is north, east, down (NED). Angles are radians where the name
//! ends in `_rad`, degrees where it ends in `_deg`; headings and courses are degrees clockwise from true north.

mod apply;
mod boot;
mod groups;
mod kinds;
#[cfg(feature = "describe")]
mod report;
#[cfg(test)]
mod tests;
mod texts;
mod valid;

use std::time::Duration;

use vencejo_proto::MonoTime;

use vencejo_flight::guidance::NorthEast;
use vencejo_flight::rehearsal::Recorded;

use crate::autopilot::AutopilotType;
use crate::modes::FlightMode;
pub use vencejo_flight::plan::Home;

pub(crate) use apply::boot_ms_of;
pub use boot::{BootClock, BootEvent};
pub use groups::*;
pub use kinds::{GitHash, GpsFix, LandedState, MissionState, Sensors, SoftwareVersion, SystemStatus};
#[cfg(feature = "describe")]
pub use report::{Aged, Sent, TelemetryGroups};
pub use texts::{CHUNK_TIMEOUT, MAX_TEXTS, Severity, StatusLog, Text};

/// A value older than this is stale: shown, but marked.
pub const STALE_AFTER: Duration = Duration::from_millis(3_500);
/// A value older than this is lost: it no longer describes the vehicle.
pub const LOST_AFTER: Duration = Duration::from_secs(5);
/// A battery with less left wants to be looked at, percent. What the vehicle itself does then is in its parameters
/// (`BATT_LOW_*`).
pub const BATTERY_LOW_PCT: f64 = 30.0;
/// A battery with less left is an alarm, percent.
pub const BATTERY_CRITICAL_PCT: f64 = 15.0;
/// Loss of a link above which it needs attention, percent of the messages.
pub const LOSS_NOTABLE_PCT: f64 = 5.0;
/// Loss of a link above which an order may fail, percent.
pub const LOSS_HIGH_PCT: f64 = 20.0;
/// Batteries that are kept, by id 0 to 7; others are counted and dropped.
pub const MAX_BATTERIES: usize = 8;
/// IMUs that are kept.
pub const MAX_IMUS: usize = 3;

/// Trust in a value by its age.
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

impl Sampled<SystemTime> {
    /// What to add to our monotonic clock to have the vehicle's UTC, in µs (transport delay not taken off).
    pub fn utc_offset_us(&self) -> Option<i64> {
        let utc_us = i64::try_from(self.value.utc_us?).ok()?;
        utc_us.checked_sub(i64::try_from(self.at.as_micros()).ok()?)
    }
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
    Engine,
}

/// The groups by name, what each is read from, and the name of its schema where that is not the type's. Each list of
/// them is made from this.
macro_rules! for_each_group {
    ($make:ident) => {
        $make! {
            reported {
                /// HEARTBEAT.
                heartbeat: HeartbeatState as "Heartbeat",
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
                /// WIND or WIND_COV.
                wind: Wind,
                /// HOME_POSITION: where altitudes above home are counted from.
                home: Home as "HomePosition",
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
                /// RADIO_STATUS or RADIO.
                radio: Radio,
                /// AIRSPEED of the sensor heard last.
                airspeed: AirspeedSensor,
                /// SERVO_OUTPUT_RAW of outputs 1 to 16.
                servos: ServoOutputs,
                /// RC_CHANNELS.
                rc: RcChannels,
                /// SYSTEM_TIME.
                system_time: SystemTime,
                /// FENCE_STATUS.
                fence: FenceStatus,
                /// TERRAIN_REPORT.
                terrain: Terrain as "TerrainReport",
                /// EFI_STATUS.
                engine: Engine,
            }
            kept {
                /// RAW_IMU.
                raw_imu: RawImu,
                /// MISSION_ITEM_REACHED: the item that was reached last.
                item_reached: u16,
            }
        }
    };
}
#[cfg(feature = "describe")]
use for_each_group;

macro_rules! telemetry {
    (reported { $($(#[$doc:meta])* $field:ident: $value:ident $(as $title:literal)?,)* }
     kept { $($(#[$kept_doc:meta])* $kept:ident: $kept_value:ty,)* }) => {
        /// The newest value of every group. See the [module](self).
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct Telemetry {
            $($(#[$doc])* pub $field: Option<Sampled<$value>>,)*
            $($(#[$kept_doc])* pub $kept: Option<Sampled<$kept_value>>,)*
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
            /// What the vehicle is by its last HEARTBEAT. A restart forgets the heartbeat and keeps this.
            pub last_type: Option<AutopilotType>,
        }

        impl Telemetry {
            /// Forgets every group that was received before `moment`.
            pub(crate) fn forget_before(&mut self, moment: MonoTime) {
                $(self.$field.take_if(|sampled| sampled.at < moment);)*
                $(self.$kept.take_if(|sampled| sampled.at < moment);)*
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

for_each_group!(telemetry);

impl Telemetry {
    /// Nothing heard yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The moment that a position has just told, for learning the plane from its flight; `None` while attitude or
    /// airspeed are not known now.
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
    pub fn is_armed(&self) -> Option<bool> {
        self.heartbeat.map(|heartbeat| heartbeat.value.is_armed)
    }

    /// What the vehicle is, by its last heartbeat, also by one from before a restart; `None` before the first.
    pub fn autopilot_type(&self) -> Option<AutopilotType> {
        let heard = self.heartbeat.map(|heartbeat| heartbeat.value);
        heard.map(|heard| AutopilotType { autopilot: heard.autopilot, mav_type: heard.mav_type }).or(self.last_type)
    }

    /// Whether it is an ArduPilot, whose missions begin with home as item 0; `false` before its first heartbeat.
    pub fn is_ardupilot(&self) -> bool {
        self.autopilot_type().is_some_and(AutopilotType::is_ardupilot)
    }

    /// The mode of the newest heartbeat; `None` before the first.
    pub fn mode(&self) -> Option<FlightMode> {
        self.heartbeat.map(|heartbeat| heartbeat.value.mode)
    }

    /// Whether the vehicle says that it is on the ground; `None` when it does not say.
    pub fn is_on_ground(&self) -> Option<bool> {
        match self.extended?.value.landed {
            LandedState::Undefined => None,
            landed => Some(landed == LandedState::OnGround),
        }
    }
}

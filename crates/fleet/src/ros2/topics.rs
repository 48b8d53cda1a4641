//! What a plane says in ROS 2, topic by topic, and how often. What is not known now is not said.

use std::time::Duration;

use vencejo_flight::plan::{MavFrame, MissionItem};
use vencejo_proto::MonoTime;
use vencejo_vehicle::telemetry::{Gps, LOST_AFTER, LandedState, SystemStatus};

use twox_hash::XxHash3_128;

use super::diagnosis;
use super::frames;
use super::message::{
    BatteryState, DiagnosticArray, ExtendedState, Float64, GeoPoint, GeoPose, GeoPoseStamped, HomePosition, Imu,
    Message, NavSatFix, NavSatStatus, Odometry, Path, Pose, PoseStamped, PoseWithCovariance, Quaternion, RCIn, State,
    TFMessage, Time, TimeReference, Transform, TransformStamped, Twist, TwistStamped, TwistWithCovariance,
    TwistWithCovarianceStamped, Vector3, VfrHud, WaypointList,
};
use super::mission;
use super::moment::{Moment, time};
use super::name::Names;

/// How often a moving plane is told of at most.
const FAST: Duration = Duration::from_millis(50);
/// How often the rest is.
const SLOW: Duration = Duration::from_secs(1);
/// How often a mission is told again, for whoever came since.
const RARE: Duration = Duration::from_secs(5);
/// Standard gravity, m/s² (ISO 80000-3).
const G_M_S2: f64 = 9.806_65;
/// Before a covariance whose values are not there at all (REP-145).
const NOT_THERE: [f64; 9] = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// A covariance that is not known (REP-145, `PoseWithCovariance`).
const UNKNOWN: [f64; 9] = [0.0; 9];
/// The same of a pose or twist.
const UNKNOWN_6: [f64; 36] = [0.0; 36];

/// A topic of a plane.
pub struct Topic {
    /// Its name below the plane's; whole with a slash in front.
    pub name: &'static str,
    /// Such as `sensor_msgs/msg/Imu`.
    pub kind: &'static str,
    /// `RIHS01_…`.
    pub hash: &'static str,
    every: Duration,
    /// How often the same is said again; what goes by its moment is not.
    again: Option<Duration>,
    say: Say,
}

type Say = Box<dyn Fn(&Moment<'_>) -> Option<(MonoTime, Vec<u8>)> + Send + Sync>;

fn topic<M: Message + 'static>(
    name: &'static str,
    every: Duration,
    say: fn(&Moment<'_>) -> Option<(MonoTime, M)>,
) -> Topic {
    let say = move |moment: &Moment<'_>| say(moment).map(|(at, message)| (at, message.to_bytes()));
    Topic { name, kind: M::TYPE, hash: M::HASH, every, again: None, say: Box::new(say) }
}

impl Topic {
    /// Said when it changes, and again after so long.
    fn again(self, after: Duration) -> Self {
        Self { again: Some(after), ..self }
    }
}

/// The topics of a plane.
pub fn topics(names: Names) -> Vec<Topic> {
    match names {
        Names::Mavros => vec![
            topic("state", SLOW, state),
            topic("extended_state", SLOW, extended_state),
            topic("home_position/home", SLOW, home_position),
            topic("rc/in", FAST, rc_in),
            topic("vfr_hud", FAST, vfr_hud),
            topic("global_position/global", FAST, global),
            topic("global_position/raw/fix", FAST, raw_fix),
            topic("global_position/rel_alt", FAST, relative_altitude),
            topic("global_position/compass_hdg", FAST, heading),
            topic("local_position/pose", FAST, local_pose),
            topic("local_position/odom", FAST, odometry),
            topic("local_position/velocity_local", FAST, velocity_local),
            topic("imu/data", FAST, imu),
            topic("battery", SLOW, battery),
            topic("wind_estimation", SLOW, wind),
            topic("time_reference", SLOW, time_reference),
            topic("mission/path", RARE, path),
            topic("mission/waypoints", SLOW, waypoints).again(RARE),
            topic("/tf", FAST, transform),
            topic("/diagnostics", SLOW, diagnostics),
        ],
        Names::ArduPilot => vec![
            topic("time", SLOW, vehicle_time),
            topic("navsat", FAST, raw_fix),
            topic("battery", SLOW, battery),
            topic("imu/experimental/data", FAST, imu),
            topic("pose/filtered", FAST, local_pose),
            topic("twist/filtered", FAST, twist),
            topic("geopose/filtered", FAST, geopose),
            topic("/diagnostics", SLOW, diagnostics),
        ],
    }
}

/// What of a plane was said, so that nothing is said twice, and nothing too often.
pub struct StateSource {
    topics: Vec<Topic>,
    said: Vec<Option<Said>>,
    /// The newest moment that was looked at.
    now: MonoTime,
}

/// What was said last.
#[derive(Debug, Clone, Copy)]
struct Said {
    /// Its moment.
    of: MonoTime,
    /// When it was said.
    at: MonoTime,
    /// When it was last looked whether there is more.
    looked: MonoTime,
    /// Of its bytes.
    digest: u128,
}

impl StateSource {
    /// Says these topics.
    pub fn new(topics: Vec<Topic>) -> Self {
        Self { said: vec![None; topics.len()], topics, now: MonoTime::ZERO }
    }

    /// The topics.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// What is to be said now: numbers of topics, with their messages.
    pub fn due(&mut self, moment: &Moment<'_>) -> Vec<(usize, Vec<u8>)> {
        let mut due = Vec::new();
        if moment.now < self.now {
            // A replay went back: what was said is still to come.
            self.said.fill(None);
        }
        self.now = moment.now;
        for (index, (topic, said)) in self.topics.iter().zip(&mut self.said).enumerate() {
            let now = moment.now;
            if said.is_some_and(|said| now.since(said.looked) < topic.every) {
                continue;
            }
            let Some((of, bytes)) = (topic.say)(moment) else { continue };
            let digest = topic.again.map_or(0, |_| XxHash3_128::oneshot(&bytes));
            let is_due = said.is_none_or(|said| match topic.again {
                None => of > said.of,
                Some(again) => digest != said.digest || now.since(said.at) >= again,
            });
            match said {
                Some(said) if !is_due => {
                    if topic.again.is_some() {
                        said.looked = now;
                    }
                }
                _ => {
                    *said = Some(Said { of, at: now, looked: now, digest });
                    due.push((index, bytes));
                }
            }
        }
        due
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the message has 32 bits")]
fn single(value: Option<f64>) -> f32 {
    value.map_or(f32::NAN, |value| value as f32)
}

fn status_number(status: SystemStatus) -> u8 {
    (0..=u8::MAX).find(|number| SystemStatus::from(*number) == status).unwrap_or_default()
}

fn state(moment: &Moment<'_>) -> Option<(MonoTime, State)> {
    let heartbeat = moment.telemetry.heartbeat?;
    let base = heartbeat.value.base_mode;
    if heartbeat.age(moment.now) > LOST_AFTER {
        // As MAVROS: of a plane that is not heard nothing else is known.
        let header = moment.header(moment.now, "base_link");
        let (mode, system_status) = (String::new(), 0);
        let lost =
            State { header, connected: false, armed: false, guided: false, manual_input: false, mode, system_status };
        return Some((moment.now, lost));
    }
    let said = State {
        header: moment.header(heartbeat.at, "base_link"),
        connected: true,
        armed: heartbeat.value.is_armed,
        // MAV_MODE_FLAG_GUIDED_ENABLED, MAV_MODE_FLAG_MANUAL_INPUT_ENABLED.
        guided: base & 8 != 0,
        manual_input: base & 64 != 0,
        mode: heartbeat.value.mode.to_string(),
        system_status: status_number(heartbeat.value.system_status),
    };
    Some((heartbeat.at, said))
}

fn extended_state(moment: &Moment<'_>) -> Option<(MonoTime, ExtendedState)> {
    let extended = moment.fresh(moment.telemetry.extended)?;
    let landed_state = match extended.value.landed {
        LandedState::Undefined => 0,
        LandedState::OnGround => 1,
        LandedState::InAir => 2,
        LandedState::TakingOff => 3,
        LandedState::Landing => 4,
    };
    let vtol_state = extended.value.vtol.unwrap_or(0);
    Some((extended.at, ExtendedState { header: moment.header(extended.at, "base_link"), vtol_state, landed_state }))
}

/// Once a second, as nothing is kept for whoever comes later. Home is the origin of `map`; which way the plane stood
/// there is not told.
fn home_position(moment: &Moment<'_>) -> Option<(MonoTime, HomePosition)> {
    moment.fresh(moment.telemetry.heartbeat)?;
    let home = moment.home?;
    let none = || Vector3 { x: 0.0, y: 0.0, z: 0.0 };
    let said = HomePosition {
        header: moment.header(moment.now, "map"),
        geo: GeoPoint {
            latitude: home.lat_deg,
            longitude: home.lon_deg,
            altitude: ellipsoid_m(moment, Some(home.alt_amsl_m)),
        },
        position: none(),
        orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
        approach: none(),
    };
    Some((moment.now, said))
}

/// The pilot's radio; a channel that is missing is `UINT16_MAX`, as on the wire.
fn rc_in(moment: &Moment<'_>) -> Option<(MonoTime, RCIn)> {
    let radio = moment.fresh(moment.telemetry.rc)?;
    let channels = radio.value.pulse_us.iter().take(radio.value.count.into());
    let said = RCIn {
        header: moment.header(radio.at, "base_link"),
        rssi: radio.value.rssi.unwrap_or(u8::MAX),
        channels: channels.map(|pulse| pulse.unwrap_or(u16::MAX)).collect(),
    };
    Some((radio.at, said))
}

fn vfr_hud(moment: &Moment<'_>) -> Option<(MonoTime, VfrHud)> {
    let hud = moment.fresh(moment.telemetry.hud)?;
    let value = hud.value;
    #[expect(clippy::cast_possible_truncation, reason = "0 to 360")]
    let heading = value.heading_deg?.round() as i16;
    let said = VfrHud {
        header: moment.header(hud.at, "base_link"),
        airspeed: single(value.airspeed_m_s),
        groundspeed: single(value.groundspeed_m_s),
        heading,
        throttle: single(value.throttle_pct.map(|percent| percent / 100.0)),
        altitude: single(value.alt_amsl_m),
        climb: single(value.climb_m_s),
    };
    Some((hud.at, said))
}

/// What a receiver says of its fix. Which satellites it used is not told.
fn fix_status(gps: Option<&Gps>) -> NavSatStatus {
    let status = match gps.map(|gps| gps.fix.0) {
        None => -2,
        Some(0 | 1) => -1,
        Some(4 | 8) => 1,
        Some(5 | 6) => 2,
        Some(_) => 0,
    };
    NavSatStatus { status, service: 0 }
}

/// Diagonal of the receiver's own figures, east, north, up; the kind is 0 (unknown) where it has none.
fn fix_covariance(gps: Option<&Gps>, known: u8) -> ([f64; 9], u8) {
    let figures = gps.and_then(|gps| Some((gps.horizontal_accuracy_m?.powi(2), gps.vertical_accuracy_m?.powi(2))));
    figures.map_or((UNKNOWN, 0), |(across, up)| ([across, 0.0, 0.0, 0.0, across, 0.0, 0.0, 0.0, up], known))
}

/// Height above the ellipsoid of where the autopilot believes to be: its own above the sea, and what the receiver has
/// between the two.
fn ellipsoid_m(moment: &Moment<'_>, alt_amsl_m: Option<f64>) -> f64 {
    let gps = moment.fresh(moment.telemetry.gps).map(|gps| gps.value);
    let geoid_m = gps.and_then(|gps| Some(gps.alt_ellipsoid_m? - gps.alt_amsl_m?));
    alt_amsl_m.zip(geoid_m).map_or(f64::NAN, |(amsl, geoid)| amsl + geoid)
}

fn global(moment: &Moment<'_>) -> Option<(MonoTime, NavSatFix)> {
    let position = moment.fresh(moment.telemetry.position)?;
    let gps = moment.fresh(moment.telemetry.gps).map(|gps| gps.value);
    let (position_covariance, position_covariance_type) = fix_covariance(gps.as_ref(), 1);
    let said = NavSatFix {
        header: moment.header(position.at, "base_link"),
        status: fix_status(gps.as_ref()),
        latitude: position.value.lat_deg?,
        longitude: position.value.lon_deg?,
        altitude: ellipsoid_m(moment, position.value.alt_amsl_m),
        position_covariance,
        position_covariance_type,
    };
    Some((position.at, said))
}

fn raw_fix(moment: &Moment<'_>) -> Option<(MonoTime, NavSatFix)> {
    let gps = moment.fresh(moment.telemetry.gps)?;
    let value = gps.value;
    let (position_covariance, position_covariance_type) = fix_covariance(Some(&value), 2);
    let said = NavSatFix {
        header: moment.header(gps.at, "base_link"),
        status: fix_status(Some(&value)),
        latitude: value.lat_deg.unwrap_or(f64::NAN),
        longitude: value.lon_deg.unwrap_or(f64::NAN),
        altitude: value.alt_ellipsoid_m.unwrap_or(f64::NAN),
        position_covariance,
        position_covariance_type,
    };
    Some((gps.at, said))
}

fn relative_altitude(moment: &Moment<'_>) -> Option<(MonoTime, Float64)> {
    let position = moment.fresh(moment.telemetry.position)?;
    Some((position.at, Float64 { data: position.value.alt_rel_home_m? }))
}

fn heading(moment: &Moment<'_>) -> Option<(MonoTime, Float64)> {
    let position = moment.fresh(moment.telemetry.position)?;
    Some((position.at, Float64 { data: position.value.heading_deg? }))
}

fn local_pose(moment: &Moment<'_>) -> Option<(MonoTime, PoseStamped)> {
    let (at, pose) = moment.pose()?;
    Some((at, PoseStamped { header: moment.header(at, "map"), pose }))
}

fn odometry(moment: &Moment<'_>) -> Option<(MonoTime, Odometry)> {
    let (at, pose) = moment.pose()?;
    let velocity = frames::velocity(&moment.telemetry.position?.value)?;
    let angular = frames::rates(&moment.beside(at, moment.telemetry.attitude)?)?;
    // In the child's frame, as the definition says.
    let twist = Twist { linear: frames::unrotated(&pose.orientation, &velocity), angular };
    let said = Odometry {
        header: moment.header(at, "map"),
        child_frame_id: moment.frame("base_link"),
        pose: PoseWithCovariance { pose, covariance: UNKNOWN_6 },
        twist: TwistWithCovariance { twist, covariance: UNKNOWN_6 },
    };
    Some((at, said))
}

fn velocity_local(moment: &Moment<'_>) -> Option<(MonoTime, TwistStamped)> {
    let position = moment.fresh(moment.telemetry.position)?;
    let attitude = moment.beside(position.at, moment.telemetry.attitude)?;
    let angular = frames::rotated(&frames::orientation(&attitude)?, &frames::rates(&attitude)?);
    let twist = Twist { linear: frames::velocity(&position.value)?, angular };
    Some((position.at, TwistStamped { header: moment.header(position.at, "map"), twist }))
}

/// As ArduPilot's own: velocity east, north, up; rates of the body.
fn twist(moment: &Moment<'_>) -> Option<(MonoTime, TwistStamped)> {
    let position = moment.fresh(moment.telemetry.position)?;
    let angular = frames::rates(&moment.beside(position.at, moment.telemetry.attitude)?)?;
    let twist = Twist { linear: frames::velocity(&position.value)?, angular };
    Some((position.at, TwistStamped { header: moment.header(position.at, "map"), twist }))
}

fn geopose(moment: &Moment<'_>) -> Option<(MonoTime, GeoPoseStamped)> {
    let position = moment.fresh(moment.telemetry.position)?;
    let attitude = moment.beside(position.at, moment.telemetry.attitude)?;
    let place = GeoPoint {
        latitude: position.value.lat_deg?,
        longitude: position.value.lon_deg?,
        altitude: ellipsoid_m(moment, position.value.alt_amsl_m),
    };
    let pose = GeoPose { position: place, orientation: frames::orientation(&attitude)? };
    Some((position.at, GeoPoseStamped { header: moment.header(position.at, "base_link"), pose }))
}

fn imu(moment: &Moment<'_>) -> Option<(MonoTime, Imu)> {
    let attitude = moment.fresh(moment.telemetry.attitude)?;
    let force = moment.beside(attitude.at, moment.telemetry.imus[0]).and_then(|imu| imu.acc_g);
    let none = Vector3 { x: 0.0, y: 0.0, z: 0.0 };
    let said = Imu {
        header: moment.header(attitude.at, "base_link"),
        orientation: frames::orientation(&attitude.value)?,
        orientation_covariance: UNKNOWN,
        angular_velocity: frames::rates(&attitude.value)?,
        angular_velocity_covariance: UNKNOWN,
        linear_acceleration_covariance: if force.is_some() { UNKNOWN } else { NOT_THERE },
        linear_acceleration: force.map_or(none, |force| frames::flu(force.map(|part| part * G_M_S2))),
    };
    Some((attitude.at, said))
}

fn battery(moment: &Moment<'_>) -> Option<(MonoTime, BatteryState)> {
    let battery = moment.fresh(moment.telemetry.batteries[0]);
    let status = moment.fresh(moment.telemetry.sys_status);
    let at = battery.map(|battery| battery.at).or(status.map(|status| status.at))?;
    let (battery, status) = (battery.map(|battery| battery.value), status.map(|status| status.value));
    let voltage = battery.and_then(|battery| battery.voltage_v).or(status.and_then(|status| status.voltage_v))?;
    let current = battery.and_then(|battery| battery.current_a).or(status.and_then(|status| status.current_a));
    let left =
        battery.and_then(|battery| battery.remaining_pct).or(status.and_then(|status| status.battery_remaining_pct));
    let cells = battery.map(|battery| battery.cells_v).into_iter().flatten().flatten().collect();
    let said = BatteryState {
        header: moment.header(at, "base_link"),
        voltage: single(Some(voltage)),
        temperature: single(battery.and_then(|battery| battery.temperature_c)),
        current: single(current.map(|current| -current)),
        charge: f32::NAN,
        capacity: f32::NAN,
        design_capacity: f32::NAN,
        percentage: single(left.map(|percent| percent / 100.0)),
        // Discharging; a vehicle that says no current does not say it.
        power_supply_status: if current.is_some_and(|current| current > 0.0) { 2 } else { 0 },
        power_supply_health: 0,
        power_supply_technology: 0,
        present: true,
        cell_voltage: cells,
        cell_temperature: Vec::new(),
        location: "id0".into(),
        serial_number: String::new(),
    };
    Some((at, said))
}

/// Where the air goes to.
fn wind(moment: &Moment<'_>) -> Option<(MonoTime, TwistWithCovarianceStamped)> {
    let wind = moment.fresh(moment.telemetry.wind)?;
    let (from_rad, speed) = (wind.value.from_deg?.to_radians(), wind.value.speed_m_s?);
    let (north, east) = (-speed * from_rad.cos(), -speed * from_rad.sin());
    let linear = frames::enu([north, east, wind.value.speed_down_m_s?]);
    let twist = Twist { linear, angular: Vector3 { x: 0.0, y: 0.0, z: 0.0 } };
    let header = moment.header(wind.at, "map");
    Some((wind.at, TwistWithCovarianceStamped { header, twist: TwistWithCovariance { twist, covariance: UNKNOWN_6 } }))
}

fn vehicle_time(moment: &Moment<'_>) -> Option<(MonoTime, Time)> {
    let clock = moment.fresh(moment.telemetry.system_time)?;
    let utc_ns = i64::try_from(clock.value.utc_us?).ok()?.checked_mul(1_000)?;
    Some((clock.at, time(utc_ns)))
}

fn time_reference(moment: &Moment<'_>) -> Option<(MonoTime, TimeReference)> {
    let (at, time_ref) = vehicle_time(moment)?;
    Some((at, TimeReference { header: moment.header(at, "base_link"), time_ref, source: "FCU".into() }))
}

fn transform(moment: &Moment<'_>) -> Option<(MonoTime, TFMessage)> {
    let (at, pose) = moment.pose()?;
    let transform = TransformStamped {
        header: moment.header(at, "map"),
        child_frame_id: moment.frame("base_link"),
        transform: Transform { translation: pose.position, rotation: pose.orientation },
    };
    Some((at, TFMessage { transforms: vec![transform] }))
}

/// The places of the mission in order, from home; a height that is counted from the ground below is not known here:
/// NaN.
fn path(moment: &Moment<'_>) -> Option<(MonoTime, Path)> {
    moment.fresh(moment.telemetry.heartbeat)?;
    let (home, header) = (moment.home?, moment.header(moment.now, "map"));
    let place = |item: &MissionItem| {
        let (point, alt) = (item.point()?, item.alt_m()?);
        let up_m = match item.frame {
            MavFrame::Global => alt - home.alt_amsl_m,
            MavFrame::GlobalRelativeAlt => alt,
            _ => f64::NAN,
        };
        let position = frames::from_home(&home, point.lat_deg(), point.lon_deg(), up_m)?;
        let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
        Some(PoseStamped { header: header.clone(), pose: Pose { position, orientation } })
    };
    let poses = moment.mission?.items.iter().filter(|item| item.has_position()).filter_map(place).collect();
    Some((moment.now, Path { header, poses }))
}

/// The mission on board as on the wire.
fn waypoints(moment: &Moment<'_>) -> Option<(MonoTime, WaypointList)> {
    moment.fresh(moment.telemetry.heartbeat)?;
    let current = moment.fresh(moment.telemetry.mission).map(|current| current.value.seq);
    Some((moment.now, mission::list(moment.mission?, moment.telemetry.is_ardupilot(), current)))
}

fn diagnostics(moment: &Moment<'_>) -> Option<(MonoTime, DiagnosticArray)> {
    let status = diagnosis::of(moment);
    let mut header = moment.header(moment.now, "");
    header.frame_id.clear();
    (!status.is_empty()).then_some((moment.now, DiagnosticArray { header, status }))
}

#[cfg(test)]
#[path = "topics_tests.rs"]
mod tests;

//! Reads messages into [`Telemetry`]. Field meanings, units and "unknown" numbers: mavlink.io, common.xml and
//! ardupilotmega.xml.
//!
//! Nothing here allocates: it runs for every message of every vehicle.

use std::f64::consts::{PI, TAU};

use vencejo_proto::dialect::{
    BATTERY_STATUS_DATA, EFI_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA, MISSION_CURRENT_DATA,
    MavLandedState, MavMessage, MavVtolState, MissionState as WireMissionState, SYS_STATUS_DATA,
};
use vencejo_proto::{Heartbeat, Message, MonoTime};

use super::groups::*;
use super::valid::{Check, HEIGHT_M, PERCENT, SPEED_M_S, TEMPERATURE_C, VELOCITY_M_S};
use super::{
    Freshness, GitHash, GpsFix, Group, Home, LandedState, MAX_BATTERIES, MissionState, Sampled, Sensors, Telemetry,
};
use crate::autopilot::AutopilotType;
use crate::modes::{FlightMode, ModeFamily};

/// [`imu`] of SCALED_IMU, SCALED_IMU2 or SCALED_IMU3: three types with the same fields.
macro_rules! scaled_imu {
    ($m:ident, $check:ident) => {
        imu(
            [$m.xacc, $m.yacc, $m.zacc],
            [$m.xgyro, $m.ygyro, $m.zgyro],
            [$m.xmag, $m.ymag, $m.zmag],
            $m.temperature,
            $check,
        )
    };
}

/// Whether a position, degE7, is one of an ArduPilot that has no origin yet: it counts from 0/0 then, metres off by
/// what its estimate drifts (recorded, and `AP_AHRS::get_location`). Nobody flies in the open Atlantic within a
/// kilometre of that.
const fn is_without_origin(lat: i32, lon: i32) -> bool {
    const NEAR: u32 = 100_000;
    lat.unsigned_abs() < NEAR && lon.unsigned_abs() < NEAR
}

impl Telemetry {
    /// Reads a message of the vehicle into its group. `None`: the message belongs to no group.
    pub fn apply(&mut self, message: &Message, now: MonoTime) -> Option<Group> {
        let mut check = Check::default();
        let group = match message {
            Message::Heartbeat(heartbeat) => {
                self.heartbeat = Some(sampled(heartbeat_state(heartbeat), now, &check));
                self.last_type = self.autopilot_type();
                Group::Heartbeat
            }
            Message::Dialect(message) => self.apply_dialect(message, now, &mut check)?,
            _ => return None,
        };
        self.messages += 1;
        self.invalid_values += u64::from(check.invalid);
        Some(group)
    }

    /// Whether both heights of a position count from where an ArduPilot was switched on: it knows no home yet, and
    /// tells the one for the other, cut to whole centimetres (recorded: also with a right place, for 0.8 s before
    /// home). On a coast the receiver says the same.
    fn counts_from_start(&self, m: &GLOBAL_POSITION_INT_DATA, now: MonoTime) -> bool {
        const CENTIMETRE_MM: u32 = 10;
        const APART_M: f64 = 20.0;
        let gps = self.gps.filter(|gps| gps.freshness(now) == Freshness::Fresh);
        let fix_m = gps.and_then(|gps| gps.value.alt_amsl_m);
        m.alt.abs_diff(m.relative_alt) < CENTIMETRE_MM
            && fix_m.is_some_and(|fix_m| (fix_m - f64::from(m.alt) / 1e3).abs() > APART_M)
    }

    fn apply_dialect(&mut self, message: &MavMessage, now: MonoTime, check: &mut Check) -> Option<Group> {
        Some(match message {
            MavMessage::ATTITUDE(m) => {
                let value = Attitude {
                    roll_rad: check.float(m.roll, -ANGLE_RAD..=ANGLE_RAD),
                    pitch_rad: check.float(m.pitch, -ANGLE_RAD..=ANGLE_RAD),
                    yaw_rad: check.float(m.yaw, -TAU - 0.01..=TAU + 0.01).map(wrap_pi),
                    roll_rate_rad_s: check.float(m.rollspeed, -RATE_RAD_S..=RATE_RAD_S),
                    pitch_rate_rad_s: check.float(m.pitchspeed, -RATE_RAD_S..=RATE_RAD_S),
                    yaw_rate_rad_s: check.float(m.yawspeed, -RATE_RAD_S..=RATE_RAD_S),
                };
                self.attitude = Some(sampled(value, now, check));
                Group::Attitude
            }
            MavMessage::GLOBAL_POSITION_INT(m) => {
                let has_origin = !is_without_origin(m.lat, m.lon);
                let (lat_deg, lon_deg) = if has_origin { check.lat_lon(m.lat, m.lon).unzip() } else { (None, None) };
                let is_above_sea = has_origin && !self.counts_from_start(m, now);
                let mut speed = |raw: i16| check.scaled(raw, i16::MAX, 1e2, VELOCITY_M_S);
                let value = Position {
                    lat_deg,
                    lon_deg,
                    velocity_north_m_s: speed(m.vx),
                    velocity_east_m_s: speed(m.vy),
                    velocity_down_m_s: speed(m.vz),
                    alt_amsl_m: check.height_mm(m.alt).filter(|_| is_above_sea),
                    alt_rel_home_m: check.height_mm(m.relative_alt),
                    // All 0: it was just switched on, and has no attitude yet.
                    heading_deg: check.direction_cdeg(m.hdg).filter(|_| (m.lat, m.lon, m.hdg) != (0, 0, 0)),
                };
                self.position = Some(sampled(value, now, check));
                self.position_boot_ms = m.time_boot_ms;
                Group::Position
            }
            MavMessage::VFR_HUD(m) => {
                // The same estimate, with fewer marks of missing values.
                let beside = self.position.filter(|position| position.freshness(now) == Freshness::Fresh);
                let is_above_sea = beside.is_none_or(|position| position.value.alt_amsl_m.is_some());
                let has_heading = m.heading != 0 || beside.is_none_or(|position| position.value.heading_deg.is_some());
                let value = Hud {
                    airspeed_m_s: check.float(m.airspeed, SPEED_M_S),
                    groundspeed_m_s: check.float(m.groundspeed, SPEED_M_S),
                    heading_deg: check
                        .scaled(m.heading, -1, 1.0, 0.0..=360.0)
                        .map(|degrees| if degrees == 360.0 { 0.0 } else { degrees })
                        .filter(|_| has_heading),
                    throttle_pct: check.scaled(m.throttle, u16::MAX, 1.0, PERCENT),
                    alt_amsl_m: check.float(m.alt, HEIGHT_M).filter(|_| is_above_sea),
                    climb_m_s: check.float(m.climb, VELOCITY_M_S),
                };
                self.hud = Some(sampled(value, now, check));
                Group::Hud
            }
            MavMessage::GPS_RAW_INT(m) => {
                let value = gps(m, check);
                self.gps = Some(sampled(value, now, check));
                Group::Gps
            }
            MavMessage::SYS_STATUS(m) => {
                let is_px4 = self.autopilot_type().is_some_and(AutopilotType::is_px4);
                let value = sys_status(m, is_px4, check);
                self.sys_status = Some(sampled(value, now, check));
                Group::SysStatus
            }
            MavMessage::BATTERY_STATUS(m) => {
                let is_px4 = self.autopilot_type().is_some_and(AutopilotType::is_px4);
                let Some(slot) = self.batteries.get_mut(usize::from(m.id)) else {
                    debug_assert!(usize::from(m.id) >= MAX_BATTERIES);
                    check.invalid += 1;
                    return Some(Group::Battery);
                };
                let value = battery(m, is_px4, check);
                *slot = Some(sampled(value, now, check));
                Group::Battery
            }
            MavMessage::RAW_IMU(m) => {
                let value = RawImu {
                    acc_raw: [m.xacc, m.yacc, m.zacc],
                    gyro_raw: [m.xgyro, m.ygyro, m.zgyro],
                    mag_raw: [m.xmag, m.ymag, m.zmag],
                };
                // ArduPilot sends RAW_IMU in the units of SCALED_IMU (GCS_MAVLINK::send_raw_imu).
                if self.is_ardupilot() {
                    let scaled = imu(value.acc_raw, value.gyro_raw, value.mag_raw, m.temperature, check);
                    self.imus[0] = Some(sampled(scaled, now, check));
                }
                self.raw_imu = Some(sampled(value, now, check));
                Group::RawImu
            }
            MavMessage::SCALED_IMU(m) => {
                self.imus[0] = Some(sampled(scaled_imu!(m, check), now, check));
                Group::Imu
            }
            MavMessage::SCALED_IMU2(m) => {
                self.imus[1] = Some(sampled(scaled_imu!(m, check), now, check));
                Group::Imu
            }
            MavMessage::SCALED_IMU3(m) => {
                self.imus[2] = Some(sampled(scaled_imu!(m, check), now, check));
                Group::Imu
            }
            MavMessage::SCALED_PRESSURE(m) => {
                let value = Pressure {
                    absolute_pa: check.float(m.press_abs, 1.0..=2_000.0).map(hpa),
                    differential_pa: check.float(m.press_diff, -1_000.0..=1_000.0).map(hpa),
                    temperature_c: check.scaled(m.temperature, i16::MAX, 1e2, TEMPERATURE_C),
                };
                self.pressure = Some(sampled(value, now, check));
                Group::Pressure
            }
            MavMessage::WIND(m) => {
                let value = Wind {
                    from_deg: check.float(m.direction, -360.0..=360.0).map(|degrees| degrees.rem_euclid(360.0)),
                    speed_m_s: check.float(m.speed, 0.0..=150.0),
                    speed_down_m_s: check.float(m.speed_z, -150.0..=150.0),
                };
                self.wind = Some(sampled(value, now, check));
                Group::Wind
            }
            MavMessage::WIND_COV(m) => {
                // The vector says where the air goes, NED; wind is named after where it comes from.
                let north = check.float(m.wind_x, -150.0..=150.0);
                let east = check.float(m.wind_y, -150.0..=150.0);
                let horizontal = north.zip(east);
                let value = Wind {
                    from_deg: horizontal.map(|(north, east)| (-east).atan2(-north).to_degrees().rem_euclid(360.0)),
                    speed_m_s: horizontal.map(|(north, east)| north.hypot(east)),
                    speed_down_m_s: check.float(m.wind_z, -150.0..=150.0),
                };
                self.wind = Some(sampled(value, now, check));
                Group::Wind
            }
            MavMessage::HOME_POSITION(m) => {
                let place = check.lat_lon(m.latitude, m.longitude).zip(check.height_mm(m.altitude));
                if let Some(((lat_deg, lon_deg), alt_amsl_m)) = place {
                    self.home = Some(sampled(Home { lat_deg, lon_deg, alt_amsl_m }, now, check));
                }
                Group::Home
            }
            MavMessage::MISSION_CURRENT(m) => {
                self.mission = Some(sampled(mission_current(m), now, check));
                Group::Mission
            }
            MavMessage::MISSION_ITEM_REACHED(m) => {
                self.item_reached = Some(sampled(m.seq, now, check));
                Group::ItemReached
            }
            MavMessage::NAV_CONTROLLER_OUTPUT(m) => {
                // ArduPlane sends centimetres per second (GCS_MAVLINK_Plane::send_nav_controller_output).
                let unit = if self.is_ardupilot() { 0.01 } else { 1.0 };
                let value = NavController {
                    nav_roll_deg: check.float(m.nav_roll, -360.0..=360.0),
                    nav_pitch_deg: check.float(m.nav_pitch, -360.0..=360.0),
                    nav_bearing_deg: check.scaled(m.nav_bearing, i16::MAX, 1.0, -360.0..=360.0),
                    target_bearing_deg: check.scaled(m.target_bearing, i16::MAX, 1.0, -360.0..=360.0),
                    wp_distance_m: check.scaled(m.wp_dist, u16::MAX, 1.0, 0.0..=65_535.0),
                    alt_error_m: check.float(m.alt_error, -100_000.0..=100_000.0),
                    airspeed_error_m_s: check.float(m.aspd_error, -100_000.0..=100_000.0).map(|error| error * unit),
                    cross_track_error_m: check.float(m.xtrack_error, -1e7..=1e7),
                };
                self.nav = Some(sampled(value, now, check));
                Group::Nav
            }
            MavMessage::EXTENDED_SYS_STATE(m) => {
                let value = ExtendedState {
                    landed: match m.landed_state {
                        MavLandedState::MAV_LANDED_STATE_UNDEFINED => LandedState::Undefined,
                        MavLandedState::MAV_LANDED_STATE_ON_GROUND => LandedState::OnGround,
                        MavLandedState::MAV_LANDED_STATE_IN_AIR => LandedState::InAir,
                        MavLandedState::MAV_LANDED_STATE_TAKEOFF => LandedState::TakingOff,
                        MavLandedState::MAV_LANDED_STATE_LANDING => LandedState::Landing,
                    },
                    vtol: (m.vtol_state != MavVtolState::MAV_VTOL_STATE_UNDEFINED).then_some(m.vtol_state as u8),
                };
                self.extended = Some(sampled(value, now, check));
                Group::Extended
            }
            MavMessage::EKF_STATUS_REPORT(m) => {
                let mut variance = |raw: f32| check.float(raw, 0.0..=1e6);
                let value = Ekf {
                    flags: m.flags.bits(),
                    velocity_variance: variance(m.velocity_variance),
                    pos_horiz_variance: variance(m.pos_horiz_variance),
                    pos_vert_variance: variance(m.pos_vert_variance),
                    compass_variance: variance(m.compass_variance),
                    terrain_alt_variance: variance(m.terrain_alt_variance),
                };
                self.ekf = Some(sampled(value, now, check));
                Group::Ekf
            }
            MavMessage::VIBRATION(m) => {
                let levels = [m.vibration_x, m.vibration_y, m.vibration_z];
                let value = Vibration {
                    vibration_m_s2: levels.map(|level| check.float(level, 0.0..=10_000.0)),
                    clipping: [m.clipping_0, m.clipping_1, m.clipping_2],
                };
                self.vibration = Some(sampled(value, now, check));
                Group::Vibration
            }
            MavMessage::AUTOPILOT_VERSION(m) => {
                let value = AutopilotVersion {
                    flight_sw: m.flight_sw_version.into(),
                    git_hash: GitHash(m.flight_custom_version),
                    capabilities: m.capabilities.bits(),
                    board_version: m.board_version,
                    vendor_id: m.vendor_id,
                    product_id: m.product_id,
                    uid: (m.uid != 0).then_some(m.uid),
                    uid2: (m.uid2 != [0; 18]).then_some(m.uid2),
                };
                self.version = Some(sampled(value, now, check));
                Group::Version
            }
            MavMessage::RADIO_STATUS(m) => {
                let value = radio([m.rssi, m.remrssi, m.noise, m.remnoise, m.txbuf], m.rxerrors, m.fixed, check);
                self.radio = Some(sampled(value, now, check));
                Group::Radio
            }
            MavMessage::RADIO(m) => {
                let value = radio([m.rssi, m.remrssi, m.noise, m.remnoise, m.txbuf], m.rxerrors, m.fixed, check);
                self.radio = Some(sampled(value, now, check));
                Group::Radio
            }
            MavMessage::AIRSPEED(m) => {
                let flags = m.flags.bits();
                // Specified in hPa; ArduPilot sends Pa (GCS_MAVLINK::send_airspeed).
                let unit = if self.is_ardupilot() { 1.0 } else { 100.0 };
                let value = AirspeedSensor {
                    id: m.id,
                    airspeed_m_s: check.float(m.airspeed, SPEED_M_S),
                    differential_pa: check.float(m.raw_press, -100_000.0..=100_000.0).map(|raw| raw * unit),
                    temperature_c: check.scaled(m.temperature, i16::MAX, 1e2, TEMPERATURE_C),
                    is_unhealthy: flags & 1 != 0,
                    is_used: flags & 2 != 0,
                };
                self.airspeed = Some(sampled(value, now, check));
                Group::Airspeed
            }
            // Another bank has other outputs: 17 to 32 of an ArduPilot, AUX of a PX4.
            MavMessage::SERVO_OUTPUT_RAW(m) if m.port == 0 => {
                let raw = [
                    m.servo1_raw,
                    m.servo2_raw,
                    m.servo3_raw,
                    m.servo4_raw,
                    m.servo5_raw,
                    m.servo6_raw,
                    m.servo7_raw,
                    m.servo8_raw,
                    m.servo9_raw,
                    m.servo10_raw,
                    m.servo11_raw,
                    m.servo12_raw,
                    m.servo13_raw,
                    m.servo14_raw,
                    m.servo15_raw,
                    m.servo16_raw,
                ];
                let value = ServoOutputs { pulse_us: raw.map(pulse_us) };
                self.servos = Some(sampled(value, now, check));
                Group::Servos
            }
            MavMessage::RC_CHANNELS(m) => {
                let raw = [
                    m.chan1_raw,
                    m.chan2_raw,
                    m.chan3_raw,
                    m.chan4_raw,
                    m.chan5_raw,
                    m.chan6_raw,
                    m.chan7_raw,
                    m.chan8_raw,
                    m.chan9_raw,
                    m.chan10_raw,
                    m.chan11_raw,
                    m.chan12_raw,
                    m.chan13_raw,
                    m.chan14_raw,
                    m.chan15_raw,
                    m.chan16_raw,
                    m.chan17_raw,
                    m.chan18_raw,
                ];
                let value =
                    RcChannels { count: m.chancount.min(18), pulse_us: raw.map(pulse_us), rssi: known_u8(m.rssi) };
                self.rc = Some(sampled(value, now, check));
                Group::Rc
            }
            MavMessage::SYSTEM_TIME(m) => {
                let value = SystemTime { utc_us: utc_us(m.time_unix_usec, check), boot_ms: m.time_boot_ms };
                self.system_time = Some(sampled(value, now, check));
                Group::SystemTime
            }
            MavMessage::TERRAIN_REPORT(m) => {
                // Without data the spacing is 0, and the heights are 0 or those of somewhere else
                // (AP_Terrain::send_terrain_report); without a position it reports 0 m at 0/0.
                let is_known = m.spacing != 0 && check.lat_lon(m.lat, m.lon).is_some();
                let mut height = |raw: f32| is_known.then(|| check.float(raw, HEIGHT_M)).flatten();
                let value = Terrain {
                    ground_amsl_m: height(m.terrain_height),
                    alt_terrain_m: height(m.current_height),
                    pending: m.pending,
                    loaded: m.loaded,
                };
                self.terrain = Some(sampled(value, now, check));
                Group::Terrain
            }
            MavMessage::EFI_STATUS(m) => {
                self.engine = Some(sampled(engine(m, check), now, check));
                Group::Engine
            }
            MavMessage::FENCE_STATUS(m) => {
                let value = FenceStatus {
                    is_breached: m.breach_status != 0,
                    breach_count: m.breach_count,
                    breach_type: m.breach_type as u8,
                    breach_boot_ms: (m.breach_time != 0).then_some(m.breach_time),
                };
                self.fence = Some(sampled(value, now, check));
                Group::Fence
            }
            _ => return None,
        })
    }
}

/// Angles are sent within ±π; the rest is rounding.
const ANGLE_RAD: f64 = PI + 0.01;
/// No gyro measures more.
const RATE_RAD_S: f64 = 100.0;

fn sampled<T>(value: T, at: MonoTime, check: &Check) -> Sampled<T> {
    Sampled { value, at, invalid: check.invalid > 0 }
}

fn wrap_pi(angle_rad: f64) -> f64 {
    if angle_rad.abs() <= PI { angle_rad } else { angle_rad - TAU * (angle_rad / TAU).round() }
}

fn hpa(pressure_hpa: f64) -> f64 {
    pressure_hpa * 100.0
}

fn known_u8(raw: u8) -> Option<u8> {
    (raw != u8::MAX).then_some(raw)
}

fn pulse_us(raw: u16) -> Option<u16> {
    (raw != 0 && raw != u16::MAX).then_some(raw)
}

/// UTC between 2000 and 2200; a receiver that does not know the date sends 0.
fn utc_us(raw: u64, check: &mut Check) -> Option<u64> {
    const YEAR_2000_US: u64 = 946_684_800_000_000;
    const YEAR_2200_US: u64 = 7_258_118_400_000_000;
    match raw {
        0 => None,
        YEAR_2000_US..=YEAR_2200_US => Some(raw),
        _ => {
            check.invalid += 1;
            None
        }
    }
}

/// Reads a HEARTBEAT.
pub(crate) fn heartbeat_state(heartbeat: &Heartbeat) -> HeartbeatState {
    let family = ModeFamily::of(heartbeat.autopilot, heartbeat.mav_type);
    HeartbeatState {
        mode: FlightMode { family, custom_mode: heartbeat.custom_mode },
        mode_number: heartbeat.custom_mode,
        is_armed: heartbeat.is_armed(),
        system_status: heartbeat.system_status.into(),
        mav_type: heartbeat.mav_type,
        autopilot: heartbeat.autopilot,
        base_mode: heartbeat.base_mode,
    }
}

fn gps(m: &GPS_RAW_INT_DATA, check: &mut Check) -> Gps {
    let fix = GpsFix(m.fix_type as u8);
    // Without a fix the coordinates are outdated or unset.
    let (lat_deg, lon_deg) = check.lat_lon(m.lat, m.lon).filter(|_| fix.0 >= 2).unzip();
    let alt_amsl_m = check.height_mm(m.alt).filter(|_| fix.is_3d());
    // An extension field: vehicles without it send 0.
    let alt_ellipsoid_m = check.height_mm(m.alt_ellipsoid).filter(|_| fix.is_3d() && m.alt_ellipsoid != 0);
    // Accuracies are extension fields: vehicles without them send 0.
    let mut accuracy_m = |raw: u32| check.scaled(raw, 0, 1e3, 0.0..=4_000_000.0).filter(|_| raw != u32::MAX);
    Gps {
        fix,
        fix_name: fix.name(),
        satellites: known_u8(m.satellites_visible),
        horizontal_accuracy_m: accuracy_m(m.h_acc),
        vertical_accuracy_m: accuracy_m(m.v_acc),
        hdop: check.scaled(m.eph, u16::MAX, 1e2, 0.0..=655.0),
        vdop: check.scaled(m.epv, u16::MAX, 1e2, 0.0..=655.0),
        lat_deg,
        lon_deg,
        alt_amsl_m,
        alt_ellipsoid_m,
        groundspeed_m_s: check.scaled(m.vel, u16::MAX, 1e2, SPEED_M_S),
        course_deg: check.direction_cdeg(m.cog),
    }
}

fn sys_status(m: &SYS_STATUS_DATA, is_px4: bool, check: &mut Check) -> SysStatus {
    let present = m.onboard_control_sensors_present.bits();
    let used = present & m.onboard_control_sensors_enabled.bits();
    let healthy = m.onboard_control_sensors_health.bits();
    // A vehicle without a battery monitor sends 0 V.
    let is_measured = m.voltage_battery != 0 || present & Sensors::BATTERY != 0;
    SysStatus {
        // A PX4 tells it in `health` alone: whether it arms in its present mode.
        is_ready_to_arm: (is_px4 || used & Sensors::PREARM_CHECK != 0).then_some(healthy & Sensors::PREARM_CHECK != 0),
        unhealthy_sensors: Sensors(used & !healthy),
        load_pct: check.scaled(m.load, u16::MAX, 10.0, PERCENT),
        voltage_v: check.scaled(m.voltage_battery, u16::MAX, 1e3, 0.0..=65.5).filter(|_| is_measured),
        current_a: current_a(m.current_battery, is_px4, check),
        battery_remaining_pct: check.scaled(m.battery_remaining, -1, 1.0, PERCENT),
        drop_rate_pct: check.scaled(m.drop_rate_comm, u16::MAX, 1e2, PERCENT),
    }
}

/// A PX4 that does not measure it has −1 A, which is sent as such.
fn current_a(raw: i16, is_px4: bool, check: &mut Check) -> Option<f64> {
    check.scaled(raw, -1, 1e2, VELOCITY_M_S).filter(|_| !(is_px4 && raw == -100))
}

fn battery(m: &BATTERY_STATUS_DATA, is_px4: bool, check: &mut Check) -> Battery {
    let mut cells_v = [None; 14];
    let mut total_mv = 0u32;
    let mut reported = 0;
    // In the first ten UINT16_MAX marks a cell that is not there, in the extension 0 does.
    let raw = m.voltages.into_iter().chain(m.voltages_ext.map(|raw| if raw == 0 { u16::MAX } else { raw }));
    for (cell, raw) in cells_v.iter_mut().zip(raw) {
        if raw != u16::MAX {
            *cell = Some(f32::from(raw) / 1000.0);
            total_mv += u32::from(raw);
            reported += 1;
        }
    }
    // A single entry, or one above what a cell can have, is the voltage of the pack.
    if reported <= 1 || cells_v.iter().flatten().any(|cell_v| *cell_v > 5.5) {
        cells_v = [None; 14];
    }
    let consumed_hj = check.scaled(m.energy_consumed, -1, 1.0, 0.0..=1e9);
    Battery {
        id: m.id,
        voltage_v: (total_mv > 0).then(|| f64::from(total_mv) / 1000.0),
        cells_v,
        current_a: current_a(m.current_battery, is_px4, check),
        consumed_mah: check.scaled(m.current_consumed, -1, 1.0, 0.0..=1e9),
        consumed_j: consumed_hj.map(|hundred_j| hundred_j * 100.0),
        remaining_pct: check.scaled(m.battery_remaining, -1, 1.0, PERCENT),
        temperature_c: check.scaled(m.temperature, i16::MAX, 1e2, TEMPERATURE_C),
        time_remaining_s: check.scaled(m.time_remaining, 0, 1.0, 0.0..=1e7),
    }
}

/// Pressures are sent in kPa.
fn engine(m: &EFI_STATUS_DATA, check: &mut Check) -> Engine {
    // PX4 sends NaN for values that it does not measure.
    let mut value = |raw: f32, range| if raw.is_nan() { None } else { check.float(raw, range) };
    let mut pressure_pa = |raw: f32| value(raw, 0.0..=100_000.0).map(|kpa| kpa * 1e3);
    let (barometric_pa, intake_manifold_pa) =
        (pressure_pa(m.barometric_pressure), pressure_pa(m.intake_manifold_pressure));
    // Extension fields: 0 is not known, and 0.0001 stands for 0.
    let fuel_pressure_pa = pressure_pa(m.fuel_pressure).filter(|pa| *pa != 0.0);
    let ignition_v = value(m.ignition_voltage, 0.0..=100_000.0).filter(|v| *v != 0.0);
    let or_zero = |value: f64, least: f64| if value < least { 0.0 } else { value };
    // A sensor that an ArduPilot does not have is at 0 K (AP_EFI::send_mavlink_status).
    let mut temperature_c = |raw: f32| if raw < -273.0 { None } else { value(raw, -100.0..=2_000.0) };
    Engine {
        health: m.health,
        intake_manifold_temperature_c: temperature_c(m.intake_manifold_temperature),
        cylinder_head_temperature_c: temperature_c(m.cylinder_head_temperature),
        exhaust_gas_temperature_c: temperature_c(m.exhaust_gas_temperature),
        ecu_index: value(m.ecu_index, 0.0..=255.0),
        rpm: value(m.rpm, 0.0..=200_000.0),
        fuel_consumed_cm3: value(m.fuel_consumed, 0.0..=1e9),
        fuel_flow_cm3_min: value(m.fuel_flow, 0.0..=1e6),
        load_pct: value(m.engine_load, 0.0..=200.0),
        throttle_position_pct: value(m.throttle_position, PERCENT),
        throttle_output_pct: value(m.throttle_out, PERCENT),
        spark_dwell_ms: value(m.spark_dwell_time, 0.0..=1e4),
        ignition_timing_deg: value(m.ignition_timing, -360.0..=360.0),
        injection_ms: value(m.injection_time, 0.0..=1e4),
        pressure_temperature_compensation: value(m.pt_compensation, 0.0..=100.0),
        barometric_pa,
        intake_manifold_pa,
        ignition_v: ignition_v.map(|v| or_zero(v, 0.001)),
        fuel_pressure_pa: fuel_pressure_pa.map(|pa| or_zero(pa, 1.0)),
    }
}

/// Units of SCALED_IMU: mG, mrad/s, mgauss, centidegrees (0: no temperature).
fn imu(acc: [i16; 3], gyro: [i16; 3], mag: [i16; 3], temperature: i16, check: &mut Check) -> Imu {
    Imu {
        acc_g: check.vector(acc, 1e3),
        gyro_rad_s: check.vector(gyro, 1e3),
        mag_gauss: if mag == [0; 3] { None } else { check.vector(mag, 1e3) },
        temperature_c: check.scaled(temperature, 0, 1e2, TEMPERATURE_C),
    }
}

fn mission_current(m: &MISSION_CURRENT_DATA) -> MissionCurrent {
    let state = match m.mission_state {
        WireMissionState::MISSION_STATE_UNKNOWN => None,
        WireMissionState::MISSION_STATE_NO_MISSION => Some(MissionState::NoMission),
        WireMissionState::MISSION_STATE_NOT_STARTED => Some(MissionState::NotStarted),
        WireMissionState::MISSION_STATE_ACTIVE => Some(MissionState::Active),
        WireMissionState::MISSION_STATE_PAUSED => Some(MissionState::Paused),
        WireMissionState::MISSION_STATE_COMPLETE => Some(MissionState::Complete),
    };
    let id = |raw: u32| (raw != 0).then_some(raw);
    let total = match m.total {
        u16::MAX => Some(0),
        // An extension field: without a state beside it, 0 is a vehicle that does not send it.
        0 if state.is_none() => None,
        total => Some(total),
    };
    MissionCurrent {
        seq: m.seq,
        total,
        state,
        in_mission_mode: match m.mission_mode {
            // ArduPilot sends 1 and 0 and always says a state; elsewhere 1 is in, 2 out, 0 not said.
            1 => Some(true),
            2 => Some(false),
            0 if state.is_some() => Some(false),
            _ => None,
        },
        mission_id: id(m.mission_id),
        fence_id: id(m.fence_id),
        rally_points_id: id(m.rally_points_id),
    }
}

/// `levels`: signal and noise on both sides, then the free transmit buffer.
fn radio(levels: [u8; 5], rx_errors: u16, fixed: u16, check: &mut Check) -> Radio {
    let [rssi, remote_rssi, noise, remote_noise, tx_buffer] = levels;
    Radio {
        rssi: known_u8(rssi),
        remote_rssi: known_u8(remote_rssi),
        noise: known_u8(noise),
        remote_noise: known_u8(remote_noise),
        tx_buffer_pct: check.scaled(tx_buffer, u8::MAX, 1.0, PERCENT).map(|_| tx_buffer),
        rx_errors,
        fixed,
    }
}

/// The vehicle's time since boot in a message that carries it.
pub(crate) fn boot_ms_of(message: &Message) -> Option<u32> {
    let Message::Dialect(message) = message else { return None };
    Some(match message {
        MavMessage::ATTITUDE(m) => m.time_boot_ms,
        MavMessage::GLOBAL_POSITION_INT(m) => m.time_boot_ms,
        MavMessage::SYSTEM_TIME(m) => m.time_boot_ms,
        MavMessage::SCALED_PRESSURE(m) => m.time_boot_ms,
        MavMessage::SCALED_IMU2(m) => m.time_boot_ms,
        MavMessage::RC_CHANNELS(m) => m.time_boot_ms,
        MavMessage::LOCAL_POSITION_NED(m) => m.time_boot_ms,
        MavMessage::POSITION_TARGET_GLOBAL_INT(m) => m.time_boot_ms,
        _ => return None,
    })
}

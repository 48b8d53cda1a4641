//! Plans, planes, wind, terrain and initial states from bytes: mostly realistic ones, so that deep code is reached.
#![allow(dead_code)]

use std::sync::LazyLock;

use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{
    Command, Fence, FenceShape, FenceZone, Home, MavFrame, Mission, MissionItem, Plan, Rally, RallyPoint,
};
use vencejo_flight::progress::Circled;
use vencejo_flight::rehearsal::{Air, Aircraft, Airframe, BatterySettings, Doing, Origin, Start};

use super::wild::Wild;

/// All parameters of a vehicle that are read, old names included, with a large value of each.
const PARAMETERS: &[(&str, f64)] = &[
    ("AIRSPEED_CRUISE", 40.0),
    ("AIRSPEED_MAX", 50.0),
    ("AIRSPEED_MIN", 30.0),
    ("ALT_HOLD_RTL", 30_000.0),
    ("ALT_SLOPE_MAXHGT", 30.0),
    ("ALT_SLOPE_MIN", 60.0),
    ("ARSPD_FBW_MAX", 50.0),
    ("ARSPD_FBW_MIN", 30.0),
    ("ARSPD_TYPE", 2.0),
    ("ARSPD_USE", 2.0),
    ("BATT_CAPACITY", 9e3),
    ("BATT_CRT_MAH", 3e3),
    ("BATT_CRT_VOLT", 12.0),
    ("BATT_FS_CRT_ACT", 8.0),
    ("BATT_FS_LOW_ACT", 8.0),
    ("BATT_LOW_MAH", 3e3),
    ("BATT_LOW_TIMER", 60.0),
    ("BATT_LOW_VOLT", 12.0),
    ("BATT_MONITOR", 10.0),
    ("FLIGHT_OPTIONS", 4096.0),
    ("FS_GCS_ENABL", 3.0),
    ("FS_LONG_ACTN", 6.0),
    ("FS_LONG_TIMEOUT", 300.0),
    ("FS_SHORT_ACTN", 5.0),
    ("FS_SHORT_TIMEOUT", 100.0),
    ("GLIDE_SLOPE_MIN", 60.0),
    ("GLIDE_SLOPE_THR", 30.0),
    ("KFF_RDDRMIX", 2.0),
    ("LAND_FLARE_AIM", 100.0),
    ("LAND_FLARE_ALT", 20.0),
    ("LAND_FLARE_SEC", 10.0),
    ("LAND_PF_ALT", 30.0),
    ("LAND_PF_ARSPD", 20.0),
    ("LAND_PF_SEC", 20.0),
    ("LAND_PITCH_CD", 2_000.0),
    ("LAND_PITCH_DEG", 20.0),
    ("LAND_WIND_COMP", 100.0),
    ("LEVEL_ROLL_LIMIT", 45.0),
    ("LIM_PITCH_MAX", 9_000.0),
    ("LIM_PITCH_MIN", 9_000.0),
    ("LIM_ROLL_CD", 9_000.0),
    ("MIN_GNDSPD_CM", 2_000.0),
    ("MIN_GROUNDSPEED", 20.0),
    ("MIS_OPTIONS", 8.0),
    ("NAVL1_DAMPING", 1.0),
    ("NAVL1_LIM_BANK", 89.0),
    ("NAVL1_PERIOD", 60.0),
    ("NAVL1_XTRACK_I", 0.1),
    ("PTCH2SRV_RLL", 1.5),
    ("PTCH2SRV_RMAX_UP", 100.0),
    ("PTCH2SRV_TCONST", 1.0),
    ("PTCH_LIM_MAX_DEG", 90.0),
    ("PTCH_LIM_MIN_DEG", 90.0),
    ("PTCH_TRIM_DEG", 45.0),
    ("Q_ENABLE", 1.0),
    ("RALLY_INCL_HOME", 1.0),
    ("RALLY_LIMIT_KM", 10.0),
    ("RLL2SRV_RMAX", 180.0),
    ("RLL2SRV_TCONST", 1.0),
    ("ROLL_LIMIT_DEG", 90.0),
    ("RTL_ALTITUDE", 300.0),
    // It enables a landing, so it is four times as likely as the others.
    ("RTL_AUTOLAND", 4.0),
    ("RTL_AUTOLAND", 4.0),
    ("RTL_AUTOLAND", 4.0),
    ("RTL_AUTOLAND", 4.0),
    ("RTL_CLIMB_MIN", 30.0),
    ("RTL_RADIUS", 300.0),
    ("SCALING_SPEED", 50.0),
    ("SIM_RATE_HZ", 2400.0),
    ("SIM_WIND_T", 3.0),
    ("SIM_WIND_T_ALT", 100.0),
    ("STALL_PREVENTION", 1.0),
    ("TECS_APPR_SMAX", 10.0),
    ("TECS_CLMB_MAX", 20.0),
    ("TECS_FLARE_HGT", 15.0),
    ("TECS_HDEM_TCONST", 5.0),
    ("TECS_INTEG_GAIN", 0.5),
    ("TECS_LAND_ARSPD", 30.0),
    ("TECS_LAND_DAMP", 1.0),
    ("TECS_LAND_IGAIN", 0.5),
    ("TECS_LAND_PDAMP", 1.0),
    ("TECS_LAND_PMAX", 45.0),
    ("TECS_LAND_SINK", 2.0),
    ("TECS_LAND_SPDWGT", 2.0),
    ("TECS_LAND_TCONST", 5.0),
    ("TECS_LAND_TDAMP", 1.0),
    ("TECS_PITCH_MAX", 45.0),
    ("TECS_PITCH_MIN", 45.0),
    ("TECS_PTCH_DAMP", 1.0),
    ("TECS_RLL2THR", 30.0),
    ("TECS_SINK_MAX", 20.0),
    ("TECS_SINK_MIN", 10.0),
    ("TECS_SPDWEIGHT", 2.0),
    ("TECS_THR_DAMP", 1.0),
    ("TECS_TIME_CONST", 10.0),
    ("TECS_TKOFF_IGAIN", 0.5),
    ("TECS_VERT_ACC", 10.0),
    ("TERRAIN_ENABLE", 1.0),
    ("TERRAIN_FOLLOW", 32.0),
    ("TERRAIN_LOOKAHD", 10_000.0),
    ("TERRAIN_SPACING", 100.0),
    ("THR_FAILSAFE", 2.0),
    ("THR_MAX", 100.0),
    ("THR_MIN", 100.0),
    ("THR_SLEWRATE", 120.0),
    ("TKOFF_LVL_ALT", 50.0),
    ("TKOFF_PLIM_SEC", 10.0),
    ("TKOFF_ROTATE_SPD", 30.0),
    ("TKOFF_THR_DELAY", 127.0),
    ("TKOFF_THR_MAX", 100.0),
    ("TKOFF_THR_MINACC", 30.0),
    ("TRIM_ARSPD_CM", 4_000.0),
    ("TRIM_PITCH_CD", 4_500.0),
    ("TRIM_THROTTLE", 100.0),
    ("WP_LOITER_RAD", 300.0),
    ("WP_MAX_RADIUS", 300.0),
    ("WP_RADIUS", 300.0),
    ("YAW2SRV_DAMP", 1.0),
];

/// Commands that a plane flies to, and those that lead it there; the others of the table are drawn too.
const USUAL: [Command; 24] = [
    Command::NAV_WAYPOINT,
    Command::NAV_WAYPOINT,
    Command::NAV_WAYPOINT,
    Command::NAV_LOITER_UNLIM,
    Command::NAV_LOITER_TURNS,
    Command::NAV_LOITER_TIME,
    Command::NAV_RETURN_TO_LAUNCH,
    Command::NAV_LAND,
    Command::NAV_LAND,
    Command::NAV_TAKEOFF,
    Command::NAV_CONTINUE_AND_CHANGE_ALT,
    Command::NAV_LOITER_TO_ALT,
    Command::NAV_SPLINE_WAYPOINT,
    Command::NAV_ARC_WAYPOINT,
    Command::CONDITION_DELAY,
    Command::CONDITION_DISTANCE,
    Command::DO_JUMP,
    Command::DO_JUMP,
    Command::DO_JUMP_TAG,
    Command::JUMP_TAG,
    Command::DO_CHANGE_SPEED,
    Command::DO_RETURN_PATH_START,
    Command::DO_LAND_START,
    Command::DO_SET_CAM_TRIGG_DIST,
];

/// All commands that a mission may contain.
static KNOWN: LazyLock<Vec<Command>> =
    LazyLock::new(|| (0..=u16::MAX).map(Command).filter(|command| command.info().is_some()).collect());

/// Reference positions, and others for the start of a plan: at the antimeridian, at a pole, at 0/0.
const HOME: Home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };
const ELSEWHERE: [(f64, f64); 6] =
    [(-33.0, 179.999_9), (89.999_9, 10.0), (-90.0, 0.0), (0.0, 0.000_1), (0.0, 0.0), (60.0, -179.999_9)];

/// The parameters that are set.
pub struct Settings(Vec<(&'static str, f64)>);

impl Settings {
    pub fn out_of(wild: &mut Wild<'_>) -> Self {
        let count = wild.byte() % 12;
        Self(
            (0..count)
                .map(|_| {
                    let (name, most) = wild.one_of(PARAMETERS);
                    (name, wild.setting(most))
                })
                .collect(),
        )
    }

    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().rev().find(|(set, _)| *set == name).map(|(_, value)| *value)
    }

    /// The plane of these settings, sometimes with another airframe and battery, as the interfaces accept them.
    pub fn plane(&self, wild: &mut Wild<'_>) -> Aircraft {
        let plane = Aircraft::from_ardupilot(|name| self.get(name));
        if wild.byte() & 3 != 3 {
            return plane;
        }
        let mut part = |(low, high): (f64, f64)| low + (high - low) * f64::from(wild.byte()) / 255.0;
        let airframe = Airframe {
            origin: Origin::Flight,
            cruise_m_s: part((3.0, 100.0)),
            drag_m_s2: part((0.05, 20.0)),
            induced: part((0.0, 1.0)),
            thrust_full_m_s2: part((0.05, 60.0)),
            throttle_cruise: part((0.01, 0.99)),
            attack_rad: part((0.005, 0.5)),
            level_pitch_rad: part((-0.5, 0.5)),
            pitot: part((0.5, 2.0)),
            skid: part((0.0, 5.0)),
            power_cruise_w: Some(part((0.1, 1e3))),
            power_exponent: part((0.5, 5.0)),
            voltage_v: Some(part((1.0, 30.0))),
            ..plane.airframe
        };
        let still = part((airframe.thrust_full_m_s2, 60.0));
        let airframe = Airframe {
            thrust_static_m_s2: (still > 30.0).then_some(still),
            ground_drag_m_s2: (still > 50.0).then_some(1.0),
            ..airframe
        };
        let battery = BatterySettings {
            capacity_mah: Some(part((1.0, 9_000.0))),
            charge_pct: Some(part((0.0, 100.0))),
            ..BatterySettings::default()
        };
        plane.with(airframe.fault().is_none().then_some(airframe), Some(&battery))
    }

    /// A wind that the interfaces accept.
    pub fn air(&self, wild: &mut Wild<'_>) -> Air {
        let wind = Wind { from_deg: wild.number(360.0), speed_m_s: wild.number(30.0).abs() };
        let is_wind = (-360.0..=360.0).contains(&wind.from_deg) && (0.0..=60.0).contains(&wind.speed_m_s);
        let air = if is_wind { Air::of(wind, |name| self.get(name)) } else { Air::default() };
        let gusts = wild.byte();
        Air { gust_m_s: f64::from(gusts.saturating_sub(192)) / 16.0, seed: u64::from(gusts), ..air }
    }
}

/// A terrain for each number: none; hills; level; cliffs; holes in hills; a step up at home's meridian; unknown
/// everywhere.
pub fn ground(kind: u8) -> Option<impl Fn(GeoPoint) -> Option<f64> + Sync> {
    let hills = |at: GeoPoint| 600.0 + 80.0 * (at.lat_deg() * 3e3).sin() * (at.lon_deg() * 2e3).cos();
    (kind != 0).then_some(move |at: GeoPoint| match kind {
        1 => Some(hills(at)),
        2 => Some(600.0),
        3 => Some(if (at.lat_deg() * 500.0).floor() as i64 % 2 == 0 { 600.0 } else { 8_848.0 }),
        4 => Some(hills(at)).filter(|_| (at.lon_deg() * 700.0).floor() as i64 % 3 != 0),
        5 => Some(if at.lon_deg() < -3.0 { -430.0 } else { 660.0 }),
        6 => None,
        _ => Some(600.0 + 2e4 * (at.lat_deg() - 40.0).abs()),
    })
}

/// A position some hundred metres from home, home itself, the previous position, or any.
fn place(wild: &mut Wild<'_>, home: Home, before: Option<GeoPoint>) -> Option<GeoPoint> {
    match wild.byte() % 16 {
        0 => home.point().ok(),
        1 => before,
        2 => GeoPoint::new(wild.number(90.0), wild.number(180.0)).ok(),
        _ => {
            let (lat, lon) = (wild.number(0.02), wild.number(0.02));
            GeoPoint::new((home.lat_deg + lat).clamp(-90.0, 90.0), home.lon_deg + lon).ok()
        }
    }
}

/// A plan of up to 40 items, with zones and rally points.
pub fn plan(wild: &mut Wild<'_>) -> Plan {
    let what = wild.byte();
    let home = match what & 15 {
        0 => {
            let (lat_deg, lon_deg) = wild.one_of(&ELSEWHERE);
            Home { lat_deg, lon_deg, alt_amsl_m: wild.number(9_000.0) }
        }
        _ => HOME,
    };
    let mut fence = Fence::default();
    for _ in 0..what >> 4 & 3 {
        let shape = wild.byte();
        let zone = if shape & 1 == 1 {
            let corners = (0..shape >> 2 & 7).filter_map(|_| place(wild, home, None));
            FenceShape::Polygon { vertices: corners.collect() }
        } else {
            let Some(center) = place(wild, home, None) else { continue };
            FenceShape::Circle { center, radius_m: wild.number(2_000.0) }
        };
        fence.zones.push(FenceZone { inclusion: shape & 2 == 2, shape: zone });
    }
    let mut rally = Rally::default();
    for _ in 0..what >> 6 {
        let frame = wild.one_of(&[MavFrame::GlobalRelativeAlt, MavFrame::Global, MavFrame::GlobalTerrainAlt]);
        let (point, alt_m) = (place(wild, home, None), wild.number(300.0));
        rally.points.extend(point.map(|point| RallyPoint { point, alt_m, frame }));
    }
    if wild.byte() & 15 == 1 {
        fence.return_point = place(wild, home, None).map(|point| (point, wild.number(200.0)));
    }
    let mut items: Vec<MissionItem> = Vec::new();
    let mut before = None;
    while !wild.0.is_empty() && items.len() < 40 {
        let command = wild.byte();
        if command >= 250
            && let Some(last) = items.last().cloned()
        {
            items.push(last);
            continue;
        }
        let item = item(wild, command, home, before, items.len());
        before = item.point().or(before);
        items.push(item);
    }
    let home = (what & 15 != 15).then_some(home);
    Plan { mission: Mission { home, items }, fence, rally }
}

fn item(wild: &mut Wild<'_>, command: u8, home: Home, before: Option<GeoPoint>, index: usize) -> MissionItem {
    let command = match command {
        0..=191 => USUAL[usize::from(command) % USUAL.len()],
        192..=247 => KNOWN[(usize::from(command - 192) * 2 + usize::from(wild.flag())) % KNOWN.len()],
        _ => Command(u16::from_be_bytes([wild.byte(), wild.byte()])),
    };
    // Bits select deviations; without any, it is an item as programs make it.
    let there = wild.byte();
    let frame = match there & 7 {
        0..=3 => MavFrame::GlobalRelativeAlt,
        4 => MavFrame::Global,
        5 | 6 => MavFrame::GlobalTerrainAlt,
        _ => wild.one_of(&[MavFrame::Mission, MavFrame::Other(7)]),
    };
    let mut params = [Some(0.0); 7];
    match command {
        // To an existing item, mostly backwards; a few times, forever, or never.
        Command::DO_JUMP => {
            params[0] = Some(f64::from(wild.byte() % (index as u8 + 3)));
            params[1] = Some(wild.one_of(&[1.0, -1.0, 2.0, 0.0, 30.0, 32_767.0]));
        }
        Command::DO_JUMP_TAG | Command::JUMP_TAG => {
            params[0] = Some(f64::from(wild.byte() % 3));
            params[1] = Some(wild.one_of(&[1.0, -1.0, 2.0, 300.0]));
        }
        _ => {}
    }
    if there & 8 == 8 {
        let which = wild.byte();
        for (bit, param) in params.iter_mut().enumerate().take(4) {
            if which >> bit & 1 == 1 {
                *param = if which >> 4 & 7 == 7 { wild.maybe(64.0) } else { Some(wild.setting(64.0)) };
            }
        }
    }
    match there >> 4 & 3 {
        // 0/0 means "here".
        0 if command.has_position() == Some(true) && !matches!(command, Command::NAV_TAKEOFF) => {
            if let Some(at) = place(wild, home, before) {
                (params[4], params[5]) = (Some(at.lat_deg()), Some(at.lon_deg()));
            }
        }
        1 => {
            let at = place(wild, home, before);
            (params[4], params[5]) = (at.map(GeoPoint::lat_deg), at.map(GeoPoint::lon_deg));
        }
        2 => (params[4], params[5]) = (wild.maybe(90.0), wild.maybe(180.0)),
        _ => {}
    }
    params[6] = match there >> 6 {
        0 => Some(if command == Command::NAV_LAND { 0.0 } else { 80.0 }),
        1 => Some(wild.number(400.0)),
        2 => Some(wild.setting(50.0)),
        _ => wild.maybe(4_000.0),
    };
    MissionItem { command, frame, params, autocontinue: true }
}

/// Half an hour for most, which reaches as much code as six hours do, in a tenth of the time.
pub fn longest_s(what: u8) -> f64 {
    if what >= 240 { f64::INFINITY } else { 1_800.0 }
}

/// Start of a rehearsal.
pub fn start(wild: &mut Wild<'_>) -> Start {
    let what = wild.byte();
    let heading_deg = wild.maybe(360.0).filter(|heading_deg| heading_deg.is_finite());
    let point = place(wild, HOME, None);
    let (Some(point), true) = (point, what & 1 == 1) else { return Start::Ground { heading_deg } };
    // Telemetry values are finite.
    let mut telemetry = |most: f64| Some(wild.number(most)).filter(|value| value.is_finite()).unwrap_or(0.0);
    let (height_m, around_m, airspeed_m_s) = (telemetry(400.0), telemetry(400.0), telemetry(30.0));
    let around = place(wild, HOME, None).unwrap_or(point);
    let doing = match what >> 1 & 7 {
        0 => Doing::Mission,
        1 => Doing::Returning,
        2 => Doing::Guided { to: around, height_m: around_m },
        3 => Doing::Loitering { around, height_m: around_m },
        4 => Doing::Circling,
        5 => Doing::TookOff { around, height_m: around_m },
        6 => Doing::Piloted,
        _ => Doing::Soaring,
    };
    let heading_deg = heading_deg.unwrap_or(0.0);
    let circled = circled(wild);
    Start::Air { point, height_m, heading_deg, airspeed_m_s, index: usize::from(what >> 4), circled, doing }
}

/// Circle progress: none, `turns >= 0` in `time_s`, or unknown.
pub fn circled(wild: &mut Wild<'_>) -> Circled {
    match wild.byte() % 4 {
        0 => Circled::Unknown,
        1 => {
            let mut number = |most: f64| wild.number(most).abs();
            let (turns, time_s) = (number(10.0), number(3600.0));
            if turns.is_finite() && time_s.is_finite() { Circled::Flown { turns, time_s } } else { Circled::Unknown }
        }
        _ => Circled::Nothing,
    }
}

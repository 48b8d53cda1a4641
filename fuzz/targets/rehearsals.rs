//! Any plan, flown by any plane in any wind: every rehearsal ends, and says of each moment only what is a number.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::checks::rehearse_and_check;
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{Command, Home, MavFrame, Mission, MissionItem, Plan};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions, Rehearsal, Trigger, glide_range, rehearse, what_ifs};

mod wild;
use wild::Wild;

const HOME: Home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };

/// What a rehearsal reads of the vehicle, and how much of it is much.
const PARAMETERS: [(&str, f64); 87] = [
    ("AIRSPEED_CRUISE", 40.0),
    ("AIRSPEED_MAX", 50.0),
    ("AIRSPEED_MIN", 30.0),
    ("ALT_SLOPE_MAXHGT", 30.0),
    ("ALT_SLOPE_MIN", 60.0),
    ("ARSPD_TYPE", 2.0),
    ("ARSPD_USE", 2.0),
    ("BATT_CAPACITY", 9e3),
    ("BATT_CRT_MAH", 3e3),
    ("BATT_FS_CRT_ACT", 8.0),
    ("BATT_FS_LOW_ACT", 8.0),
    ("BATT_LOW_MAH", 3e3),
    ("BATT_MONITOR", 10.0),
    ("FLIGHT_OPTIONS", 4096.0),
    ("FS_GCS_ENABL", 3.0),
    ("FS_LONG_ACTN", 6.0),
    ("FS_LONG_TIMEOUT", 300.0),
    ("FS_SHORT_ACTN", 5.0),
    ("FS_SHORT_TIMEOUT", 100.0),
    ("KFF_RDDRMIX", 2.0),
    ("LAND_FLARE_AIM", 100.0),
    ("LAND_FLARE_ALT", 20.0),
    ("LAND_FLARE_SEC", 10.0),
    ("LAND_PF_ALT", 30.0),
    ("LAND_PF_ARSPD", 20.0),
    ("LAND_PF_SEC", 20.0),
    ("LAND_PITCH_DEG", 20.0),
    ("LAND_WIND_COMP", 100.0),
    ("LEVEL_ROLL_LIMIT", 45.0),
    ("MIN_GROUNDSPEED", 20.0),
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
    ("RALLY_INCL_HOME", 1.0),
    ("RALLY_LIMIT_KM", 10.0),
    ("RLL2SRV_RMAX", 180.0),
    ("RLL2SRV_TCONST", 1.0),
    ("ROLL_LIMIT_DEG", 90.0),
    ("RTL_ALTITUDE", 300.0),
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
    ("TECS_LAND_PMAX", 45.0),
    ("TECS_LAND_SINK", 2.0),
    ("TECS_LAND_SPDWGT", 2.0),
    ("TECS_LAND_TCONST", 5.0),
    ("TECS_PITCH_MAX", 45.0),
    ("TECS_PITCH_MIN", 45.0),
    ("TECS_PTCH_DAMP", 1.0),
    ("TECS_RLL2THR", 30.0),
    ("TECS_SINK_MAX", 20.0),
    ("TECS_SINK_MIN", 10.0),
    ("TECS_SPDWEIGHT", 2.0),
    ("TECS_THR_DAMP", 1.0),
    ("TECS_TIME_CONST", 10.0),
    ("TECS_VERT_ACC", 10.0),
    ("TERRAIN_FOLLOW", 32.0),
    ("TERRAIN_LOOKAHD", 10_000.0),
    ("TERRAIN_SPACING", 100.0),
    ("THR_MAX", 100.0),
    ("THR_MIN", 100.0),
    ("THR_SLEWRATE", 120.0),
    ("TKOFF_ROTATE_SPD", 30.0),
    ("TKOFF_THR_DELAY", 127.0),
    ("TKOFF_THR_MINACC", 30.0),
    ("TRIM_THROTTLE", 100.0),
    ("WP_LOITER_RAD", 300.0),
    ("WP_RADIUS", 300.0),
];

const COMMANDS: [u16; 24] =
    [16, 16, 16, 17, 18, 19, 20, 21, 22, 30, 31, 82, 92, 93, 112, 114, 177, 178, 188, 189, 203, 206, 600, 601];

fuzz_target!(|data: &[u8]| {
    let mut wild = Wild(data);
    let what = wild.byte();
    let wind = Wind { from_deg: wild.number(360.0), speed_m_s: wild.number(30.0) };
    let set: Vec<(&str, f64)> = (0..wild.byte() % 8)
        .map(|_| {
            let (name, most) = wild.one_of(&PARAMETERS);
            (name, wild.number(most))
        })
        .collect();
    let get = |name: &str| set.iter().rev().find(|(set, _)| *set == name).map(|(_, value)| *value);
    let plan = plan(&mut wild);
    let plane = Aircraft::from_ardupilot(get);
    // What a front door lets in.
    let air = if (0.0..=60.0).contains(&wind.speed_m_s) && wind.from_deg.is_finite() {
        Air::of(wind, get)
    } else {
        Air::default()
    };
    let hills = |point: GeoPoint| Some(600.0 + 80.0 * (point.lat_deg() * 3e3).sin() * (point.lon_deg() * 2e3).cos());
    let conditions =
        Conditions { ground: if what & 1 == 1 { Some(&hills) } else { None }, ..Conditions::new(&plane, air) };
    match what >> 1 & 7 {
        0 => {
            if let Some((flown, findings)) = rehearse_and_check(&plan, &conditions, 30.0) {
                check(&flown);
                findings.iter().for_each(|finding| drop(finding.to_string()));
            }
        }
        1 => {
            let found = what_ifs(&plan, &conditions, &Trigger::ALL, &[f64::from(wild.byte())]).unwrap_or_default();
            found.iter().filter_map(|found| found.flown.as_ref()).for_each(check);
            if let Some(first) = found.first() {
                drop(glide_range(&plan, &conditions, &first.at));
            }
        }
        _ => drop(rehearse(&plan, &conditions).as_ref().map(check)),
    }
});

fn plan(wild: &mut Wild<'_>) -> Plan {
    let mut items = Vec::new();
    while !wild.0.is_empty() && items.len() < 40 {
        let command = wild.byte();
        let command =
            if command == 255 { u16::from(wild.byte()) } else { COMMANDS[usize::from(command) % COMMANDS.len()] };
        let frame = wild.one_of(&[
            MavFrame::GlobalRelativeAlt,
            MavFrame::Global,
            MavFrame::GlobalTerrainAlt,
            MavFrame::Mission,
            MavFrame::Other(7),
        ]);
        let mut params = [Some(0.0); 7];
        // Bits say which parameters follow.
        let there = wild.byte();
        for (index, param) in params.iter_mut().enumerate().take(4) {
            if there >> index & 1 == 1 {
                *param = wild.maybe(64.0);
            }
        }
        if there & 16 == 16 {
            // Some hundred metres from home, or anywhere.
            let (lat, lon) = (wild.number(0.02), wild.number(0.02));
            let of = |off: f64, home: f64| Some(if off.abs() <= 0.02 { home + off } else { off });
            (params[4], params[5]) = (of(lat, HOME.lat_deg), of(lon, HOME.lon_deg));
        }
        params[6] = if there & 32 == 32 { wild.maybe(400.0) } else { Some(80.0) };
        items.push(MissionItem { command: Command(command), frame, params, autocontinue: true });
    }
    Plan::from_mission(Mission { home: Some(HOME), items })
}

fn check(flown: &Rehearsal) {
    for sample in &flown.track {
        let numbers = [
            sample.time_s,
            sample.height_m,
            sample.height_asked_m,
            sample.airspeed_m_s,
            sample.groundspeed_m_s,
            sample.course_deg,
            sample.heading_deg,
            sample.climb_m_s,
            sample.bank_deg,
            sample.pitch_deg,
            sample.throttle,
        ];
        assert!(numbers.iter().all(|number| number.is_finite()), "{sample:?}");
    }
    assert!(flown.duration_s.is_finite() && flown.distance_m.is_finite(), "{flown:?}");
    assert!(flown.duration_s <= 6.0 * 3_600.0 + 1.0);
}

//! Any plan, flown by any plane in any wind over any terrain from any initial state: every rehearsal ends, contains
//! only finite values, is deterministic, and is accepted by all of its consumers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::alongside::{along, lowest};
use vencejo_flight::guidance::NorthEast;
use vencejo_flight::profile::profile;
use vencejo_flight::progress::ProgressOptions;
use vencejo_flight::rehearsal::{
    Air, Conditions, Doubts, Expected, Learner, Recorded, Rehearsal, expected_at, fly_once, gather, nearest_to_ground,
    rehearse,
};
use vencejo_flight::separation::{Limits, conflicts, track_of};
use vencejo_flight::survey::photographs;
use vencejo_flight::way::way;

mod plans;
mod sound;
mod wild;
use plans::Settings;
use sound::check;
use wild::Wild;

/// Most track samples used for learning and comparison: enough to reach all code.
const MOST_SAMPLES: usize = 20_000;

fuzz_target!(|data: &[u8]| {
    let mut wild = Wild(data);
    let what = wild.byte();
    let settings = Settings::out_of(&mut wild);
    let plane = settings.plane(&mut wild);
    let air = settings.air(&mut wild);
    let start = plans::start(&mut wild);
    let plan = plans::plan(&mut wild);
    let ground = plans::ground(what & 7);
    let ground = ground.as_ref().map(|ground| ground as &vencejo_flight::rehearsal::Ground<'_>);
    let conditions = Conditions { start, ground, longest_s: plans::longest_s(what), ..Conditions::new(&plane, air) };
    let Ok(flown) = rehearse(&plan, &conditions) else { return };
    check(&flown);
    match what >> 3 & 7 {
        0 => assert_eq!(rehearse(&plan, &conditions).as_ref(), Ok(&flown), "flown again it is the same"),
        1 => {
            let flights = (1..4).filter_map(|seed| fly_once(&plan, &conditions, &Doubts::default(), &flown, seed));
            let mut flights: Vec<_> = flights.collect();
            let spread = gather(flown.clone(), &flights);
            let corridor = spread.corridor.iter().flat_map(|breadth| [breadth.across_m, breadth.height_m]);
            let ranges = corridor.chain([spread.duration_s]).chain(spread.energy_wh).chain(spread.battery_left);
            for range in ranges.chain(spread.touch_down_m) {
                assert!(range.low <= range.median && range.median <= range.high, "{range:?}");
            }
            flights.reverse();
            assert_eq!(gather(flown, &flights), spread, "the order of the flights does not matter");
        }
        2 => learned(&flown, &plane),
        _ => consume(&plan, &conditions, &flown),
    }
});

/// Consumers of a rehearsed flight.
fn consume(plan: &vencejo_flight::plan::Plan, conditions: &Conditions<'_>, flown: &Rehearsal) {
    let way = way(&plan.mission, conditions.plane.airspeed_cruise_m_s, &ProgressOptions::default());
    let known = |at| conditions.ground.and_then(|ground| ground(at));
    let profile = profile(&plan.mission, &way, &known, 30.0);
    let moments = flown.thinned(2.0);
    let along_m = along(&moments, &flown.passages, &profile);
    assert!(along_m.len() == moments.len() && along_m.iter().all(|along_m| along_m.is_finite()), "{along_m:?}");
    if let Some(lowest) = lowest(&plan.mission, &moments, &along_m, 30.0) {
        assert!(lowest.clearance_m.is_finite(), "{lowest:?}");
    }
    assert_eq!(nearest_to_ground(&flown.track).is_some(), flown.track.iter().any(|sample| sample.ground_m.is_some()));
    let expect = |sample: &&vencejo_flight::rehearsal::Sample| Expected {
        time_s: sample.time_s,
        point: sample.point,
        height_m: sample.height_m,
        index: sample.index,
    };
    let expected: Vec<Expected> = moments.iter().map(expect).collect();
    for moment in expected.iter().step_by(expected.len().div_ceil(20).max(1)) {
        if let Some(found) = expected_at(&expected, moment.point, moment.index, Some(moment.time_s)) {
            assert!(found.time_s.is_finite() && found.height_m.is_finite(), "{found:?}");
        }
    }
    for photo in photographs(flown, 1.0, 20.0) {
        assert!(photo.time_s.is_finite() && photo.height_m.is_finite() && photo.heading_deg.is_finite(), "{photo:?}");
    }
    let samples = &flown.track[..flown.track.len().min(2_000)];
    let tracks = [0.0, 7.5].map(|starts_s| track_of(samples, starts_s, 600.0));
    for conflict in conflicts(&tracks, &Limits::default(), &|| true) {
        let numbers = [conflict.begins_s, conflict.ends_s, conflict.horizontal_m, conflict.vertical_m];
        assert!(numbers.iter().all(|number| number.is_finite()), "{conflict:?}");
        assert!(conflict.begins_s <= conflict.ends_s, "{conflict:?}");
    }
}

/// A model learned from a flight can be flown.
fn learned(flown: &Rehearsal, plane: &vencejo_flight::rehearsal::Aircraft) {
    let mut learner = Learner::of_recording();
    for sample in flown.track.iter().take(MOST_SAMPLES) {
        learner.note(Recorded {
            time_s: sample.time_s,
            velocity: NorthEast::from_bearing(sample.course_deg.to_radians()) * sample.groundspeed_m_s,
            climb_m_s: sample.climb_m_s,
            height_amsl_m: 600.0 + sample.height_m,
            height_m: sample.height_m,
            airspeed_m_s: sample.airspeed_m_s,
            bank_rad: sample.bank_deg.to_radians(),
            pitch_rad: sample.pitch_deg.to_radians(),
            throttle: sample.throttle,
            power_w: Some(300.0 * sample.throttle),
            voltage_v: Some(11.1),
        });
    }
    let Some(learned) = learner.learned(plane) else { return };
    assert_eq!(learned.airframe.fault(), None, "what was learned is let in again");
    let wind = learned.wind;
    assert!((0.0..=60.0).contains(&wind.speed_m_s) && (0.0..360.0).contains(&wind.from_deg), "{wind:?}");
    let again = vencejo_flight::rehearsal::Aircraft { airframe: learned.airframe, ..*plane };
    let home = vencejo_flight::plan::Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };
    let items = vec![vencejo_flight::plan::MissionItem::waypoint(40.01, -3.0, 80.0)];
    let plan = vencejo_flight::plan::Plan::from_mission(vencejo_flight::plan::Mission { home: Some(home), items });
    check(&rehearse(&plan, &Conditions::new(&again, Air::from(wind))).expect("home is known"));
}

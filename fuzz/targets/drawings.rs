//! Any plan without flying it: checked, laid out, measured, ended with a landing, converted to another altitude frame,
//! uploaded and written.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_flight::approaches::{LandingPart, move_landing};
use vencejo_flight::checks::{CheckContext, check_plan};
use vencejo_flight::ending::{mission_end, towards_end};
use vencejo_flight::formats::{PlanFormat, PlanSettings, read_plan, write_plan};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::ground::squares_around;
use vencejo_flight::landing::{LandingOptions, Wind, design_landing};
use vencejo_flight::plan::{
    Keeping, Levels, MavFrame, Mission, Plan, PlanKind, ardupilot_stored, counted_from, items_from_wire,
    plans_equal_as_stored,
};
use vencejo_flight::profile::profile;
use vencejo_flight::progress::{Circled, ProgressOptions, remaining, trip};
use vencejo_flight::rehearsal::Ground;
use vencejo_flight::way::way;
use vencejo_proto::Address;

mod plans;
mod quick;
mod wild;
use quick::quick;
use wild::Wild;

fuzz_target!(|data: &[u8]| {
    let mut wild = Wild(data);
    let what = wild.byte();
    let options = ProgressOptions {
        loiter_radius_m: wild.number(300.0),
        climb_rate_m_s: wild.number(10.0),
        flies_arcs: what & 8 == 8,
        own_speed_m_s: (what & 32 == 32).then_some(15.0),
        airspeed_min_m_s: (what & 64 == 64).then_some(10.0),
        airspeed_max_m_s: (what & 128 == 128).then_some(25.0),
    };
    let speed_m_s = wild.number(40.0);
    let context = CheckContext {
        on_ground: [None, Some(true), Some(false)][usize::from(wild.byte() % 3)],
        can_hover: what & 16 == 16,
        flies_arcs: options.flies_arcs,
        airspeed_m_s: speed_m_s,
        airspeed_min_m_s: options.airspeed_min_m_s,
        airspeed_max_m_s: options.airspeed_max_m_s,
        is_fence_union: what & 4 == 4,
        bank_deg: wild.number(90.0),
        ..CheckContext::default()
    };
    let wind = Wind { from_deg: wild.number(360.0), speed_m_s: wild.number(20.0) };
    let plan = plans::plan(&mut wild);
    let ground = plans::ground(what & 7);
    let circled = plans::circled(&mut wild);
    let known = |at: GeoPoint| ground.as_ref().and_then(|ground| ground(at));
    let found = quick(|| check_plan(&plan, &context));
    found.iter().for_each(|finding| assert!(!finding.to_string().is_empty()));
    assert_eq!(check_plan(&plan, &context), found, "checked again it is the same");
    quick(|| drawn(&plan.mission, circled, speed_m_s, &options, &known));
    quick(|| ended(&plan.mission, speed_m_s, &options, wind));
    quick(|| drop(squares_around(&plan, None)));
    counted(&plan);
    sent(&plan);
    written(&plan);
});

fn drawn(mission: &Mission, circled: Circled, speed_m_s: f64, options: &ProgressOptions, known: &Ground<'_>) {
    let way = way(mission, speed_m_s, options);
    for stop in &way.stops {
        assert!((1..=mission.items.len()).contains(&stop.item));
        if let Some(leg) = &stop.leg {
            assert!(leg.length_m.is_finite() && leg.course_deg.is_finite(), "{leg:?}");
            assert!(leg.lat_deg.len() >= 2 && leg.lat_deg.len() == leg.lon_deg.len(), "{leg:?}");
            assert!(leg.points().count() == leg.lat_deg.len(), "{leg:?}");
            assert!(leg.descent.is_none_or(|descent| descent.drop_m.is_finite()), "{leg:?}");
        }
        if let Some(loiter) = &stop.loiter {
            assert!(loiter.radius_m.is_finite() && (0.0..=1.0).contains(&loiter.changed_before), "{loiter:?}");
            assert!([loiter.length_m, loiter.time_s].iter().flatten().all(|number| number.is_finite()), "{loiter:?}");
        }
    }
    assert!(way.jumps.iter().all(|jump| (1..=mission.items.len()).contains(&jump.to_item)));
    let profile = profile(mission, &way, known, 30.0);
    assert!(profile.length_m.is_finite());
    for point in &profile.points {
        assert!(point.distance_m.is_finite() && point.alt_rel_home_m.is_finite(), "{point:?}");
    }
    assert!(profile.points.is_sorted_by_key(|point| point.distance_m), "it goes on");
    let trip = trip(mission, Some(speed_m_s), options);
    assert!([trip.distance_m, trip.time_s].iter().flatten().all(|number| number.is_finite()), "{trip:?}");
    let here = GeoPoint::new(40.001, -3.001).expect("it is on Earth");
    for index in [0, mission.items.len() / 2, mission.items.len(), usize::MAX] {
        let left = remaining(mission, index, here, circled, Some(speed_m_s), options);
        let numbers = [left.distance_m, left.time_s, left.leg_m];
        assert!(numbers.iter().flatten().all(|number| number.is_finite()), "{left:?}");
    }
}

/// The landing that ends it, and one that is added and moved.
fn ended(mission: &Mission, speed_m_s: f64, options: &ProgressOptions, wind: Wind) {
    let end = mission_end(mission);
    assert!((1..=mission.items.len() + 1).contains(&end.item), "{end:?}");
    assert!(end.designed_item.is_none_or(|item| (1..=mission.items.len()).contains(&item)), "{end:?}");
    let way = way(mission, speed_m_s, options);
    let landing = towards_end(mission, &way, LandingOptions { wind: Some(wind), ..LandingOptions::default() });
    let points = || mission.items.iter().filter_map(|item| item.point());
    let Some(point) = points().next() else { return };
    let mut moved =
        mission.items[end.designed_item.unwrap_or(end.item).min(mission.items.len()).saturating_sub(1)..].to_vec();
    if let Ok(designed) = design_landing(point, &landing) {
        assert!(designed.items.iter().all(|item| item.unsendable().is_none()), "{designed:?}");
        moved = designed.items;
    }
    for (part, to) in [LandingPart::Point, LandingPart::FinalLeg, LandingPart::Circle].into_iter().zip(points().skip(1))
    {
        match move_landing(&moved, part, to, &landing) {
            Ok(landing) => {
                let numbers = [landing.final_m, landing.slope, landing.course_deg, landing.radius_m];
                assert!(numbers.iter().all(|number| number.is_finite()), "{landing:?}");
                assert!(landing.items.iter().all(|item| item.unsendable().is_none()), "{landing:?}");
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

fn counted(plan: &Plan) {
    let home = plan.mission.home.filter(|home| home.point().is_ok());
    let levels = Levels { home_amsl_m: home.map(|home| home.alt_amsl_m), ground_amsl_m: Some(580.0) };
    for item in &plan.mission.items {
        for frame in [MavFrame::Global, MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt] {
            let (there, lacks) = counted_from(item, frame, levels);
            let (back, lacks_back) = counted_from(&there, item.frame, levels);
            let is_near = |(a, b): (f64, f64)| (a - b).abs() <= 0.02 + 1e-9 * a.abs();
            let heights = item.alt_m().zip(back.alt_m()).filter(|(alt_m, _)| alt_m.abs() < 1e9);
            assert!(heights.is_none_or(is_near), "{item:?} {there:?} {back:?}");
            let is_ours = item.frame.is_supported() && item.frame != frame;
            assert!(!is_ours || lacks.is_some() == lacks_back.is_some(), "{item:?} {lacks:?} {lacks_back:?}");
        }
    }
}

/// A plan that may be uploaded is the same when read back from a vehicle with an ArduPlane's storage.
fn sent(plan: &Plan) {
    for kind in PlanKind::ALL {
        let Ok(wire) = plan.to_wire(kind, Address::new(1, 1), true) else { continue };
        let list = items_from_wire(&wire, kind).expect("what is sent is read");
        let kept: Vec<_> = list.iter().map(ardupilot_stored).collect();
        assert_eq!(plans_equal_as_stored(&list, &kept, kind, Keeping::ARDUPILOT), Ok(()));
    }
}

/// A written plan that is read again is written as the same file.
fn written(plan: &Plan) {
    // An empty plan makes a file without content to read.
    if *plan == Plan::default() {
        return;
    }
    for format in PlanFormat::WRITTEN {
        let Ok(file) = write_plan(plan, &PlanSettings::default(), format) else { continue };
        let again = quick(|| read_plan(&file.bytes, None)).unwrap_or_else(|error| panic!("{format:?}: {error}"));
        let Ok(twice) = write_plan(&again.plan, &again.settings, format) else { continue };
        let same = read_plan(&twice.bytes, None).unwrap_or_else(|error| panic!("{format:?} again: {error}"));
        assert_eq!(same.plan, again.plan, "{format:?}");
    }
}

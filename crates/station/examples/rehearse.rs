//! Measures rehearsals: a mission of half an hour once on one core, with its findings, what if at every minute of it, and 1,000 flights on all
//! cores.
//!
//! ```text
//! cargo run --release -p vencejo-station --example rehearse
//! ```
//! Prints one line of JSON; the flights of one core are the best of ten, which another program's work disturbs least.
#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::hint::black_box;
use std::time::Instant;

use vencejo_flight::checks::{CLEARANCE_M, rehearse_and_check};
use vencejo_flight::geodesy::{GeoPoint, direct};
use vencejo_flight::landing::{LandingOptions, Wind, design_landing};
use vencejo_flight::plan::{Home, Mission, MissionItem, Plan};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions, Doubts, Trigger, rehearse, what_ifs};
use vencejo_station::{Runs, rehearse_many};

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };
const FLIGHTS: usize = 1_000;

fn main() {
    let plan = half_an_hour();
    let plane = Aircraft::default();
    let conditions = Conditions::new(&plane, Air::from(Wind { from_deg: 240.0, speed_m_s: 6.0 }));
    let flown = rehearse(&plan, &conditions).expect("invariant: the plan has a home");
    let moments: Vec<f64> = (1..30).map(|minute| f64::from(minute) * 60.0).collect();
    let once_ms = best_ms(|| {
        let _ = black_box(rehearse(&plan, &conditions));
    });
    let checked_ms = best_ms(|| {
        let _ = black_box(rehearse_and_check(&plan, &conditions, CLEARANCE_M));
    });
    let one_what_if_ms = best_ms(|| {
        let _ = black_box(what_ifs(&plan, &conditions, &[Trigger::ReturnAsked], &[900.0]));
    });
    let what_ifs_ms = best_ms(|| {
        let _ = black_box(what_ifs(&plan, &conditions, Trigger::ALL, &moments));
    });
    let begin = Instant::now();
    let runs = Runs { count: FLIGHTS, seed: 0, spared: 0 };
    let spread = rehearse_many(&plan, &conditions, &Doubts::default(), flown.clone(), &runs);
    let many_s = begin.elapsed().as_secs_f64();
    assert_eq!(spread.map(|spread| spread.runs), Ok(FLIGHTS), "all of them are flown");
    println!(
        "{{\"flown_s\":{:.0},\"once_ms\":{once_ms:.2},\"checked_ms\":{checked_ms:.2},\"one_what_if_ms\":{one_what_if_ms:.2},\
         \"what_ifs_ms\":{what_ifs_ms:.1},\"many_s\":{many_s:.2}}}",
        flown.duration_s
    );
}

/// Waypoints around a field, climbing and sinking, a circle, and a landing.
fn half_an_hour() -> Plan {
    let field = GeoPoint::new(HOME.lat_deg, HOME.lon_deg).expect("invariant: home is on Earth");
    let mut items = vec![MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0)];
    for leg in 0..30_u32 {
        let at = direct(field, f64::from(leg) * 67.0, 600.0 + f64::from(leg % 5) * 250.0);
        items.push(MissionItem::waypoint(at.lat_deg(), at.lon_deg(), 80.0 + f64::from(leg % 4) * 15.0));
    }
    let options =
        LandingOptions { coming_from: items.last().and_then(MissionItem::point), ..LandingOptions::default() };
    items.extend(design_landing(field, &options).expect("invariant: the options are in range").items);
    Plan::from_mission(Mission { home: Some(HOME), items })
}

fn best_ms(mut work: impl FnMut()) -> f64 {
    let times = (0..10).map(|_| {
        let begin = Instant::now();
        work();
        begin.elapsed().as_secs_f64() * 1e3
    });
    times.fold(f64::INFINITY, f64::min)
}

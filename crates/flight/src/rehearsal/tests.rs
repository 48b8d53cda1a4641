//! Rehearsals of whole plans, and of plans and planes that make no sense.

use proptest::prelude::*;
use vencejo_proto::MissionSeq;

use super::fly::LONGEST_S;
use super::*;
use crate::geodesy::GeoPoint;
use crate::geodesy::{direct, distance_m, inverse, leg_offset};
use crate::guidance::NorthEast;
use crate::landing::{LandingOptions, Wind, design_landing};
use crate::plan::{Command, MavFrame, Mission, MissionItem, Rally, RallyPoint};
use crate::plan::{Home, Plan};
use crate::progress::Circled;

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };

/// A place by bearing and distance from home.
fn at(bearing_deg: f64, distance_m: f64) -> GeoPoint {
    direct(HOME.point().unwrap(), bearing_deg, distance_m)
}

fn waypoint(bearing_deg: f64, distance_m: f64, height_m: f64) -> MissionItem {
    let point = at(bearing_deg, distance_m);
    MissionItem::waypoint(point.lat_deg(), point.lon_deg(), height_m)
}

fn takeoff(height_m: f64) -> MissionItem {
    MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, height_m, 12.0)
}

fn plan(items: Vec<MissionItem>) -> Plan {
    Plan::from_mission(Mission { home: Some(HOME), items })
}

fn wind(from_deg: f64, speed_m_s: f64) -> Air {
    Air { exponent: 0.0, ..Air::from(Wind { from_deg, speed_m_s }) }
}

fn fly(items: Vec<MissionItem>, air: Air) -> Rehearsal {
    let plane = Aircraft::default();
    rehearse(&plan(items), &Conditions::new(&plane, air)).unwrap()
}

fn reached(flown: &Rehearsal) -> Vec<usize> {
    flown.passages.iter().filter(|passage| passage.reached_s.is_some()).map(|passage| passage.item).collect()
}

#[test]
fn a_plan_is_flown_from_the_ground_to_its_landing() {
    let options = LandingOptions { coming_from: Some(at(90.0, 1_500.0)), ..LandingOptions::default() };
    let landing = design_landing(HOME.point().unwrap(), &options).unwrap();
    let mut items = vec![takeoff(50.0), waypoint(45.0, 900.0, 80.0), waypoint(90.0, 1_500.0, 100.0)];
    items.extend(landing.items);
    for air in [Air::default(), wind(20.0, 6.0), wind(250.0, 6.0)] {
        let flown = fly(items.clone(), air);
        assert_eq!(flown.ending, Ending::Landed, "{air:?}");
        assert_eq!(reached(&flown), [0, 1, 2, 4, 5]);
        let touch_down = flown.touch_down.unwrap();
        assert!(distance_m(touch_down.point, HOME.point().unwrap()) < 120.0, "{air:?}: {touch_down:?}");
        assert!(flown.track.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
        assert_eq!(flown, fly(items.clone(), air), "the same flight each time");
    }
}

#[test]
fn the_wind_bends_turns_and_not_legs() {
    let items =
        vec![takeoff(50.0), waypoint(0.0, 1_500.0, 60.0), waypoint(0.0, 3_500.0, 60.0), waypoint(90.0, 3_500.0, 60.0)];
    let flown = fly(items, wind(270.0, 8.0));
    // Half-way along the second leg the nose points into the wind and the plane is on its line.
    let begins_s = flown.passages[2].begins_s;
    let middle = flown.track.iter().find(|sample| sample.time_s > begins_s + 40.0).unwrap();
    let offset = leg_offset(at(0.0, 1_500.0), at(0.0, 3_500.0), middle.point);
    assert!(offset.cross_m.abs() < 3.0, "{offset:?}");
    assert!((330.0..350.0).contains(&middle.heading_deg), "{middle:?}");
    assert!(middle.course_deg < 2.0 || middle.course_deg > 358.0);
    // 22 m/s EAS are 22.7 m/s true at 660 m.
    assert!((middle.groundspeed_m_s - (22.7_f64.powi(2) - 8.0_f64.powi(2)).sqrt()).abs() < 0.3, "{middle:?}");
}

#[test]
fn a_corner_is_cut_where_the_radius_says_so() {
    let items = vec![takeoff(50.0), waypoint(0.0, 1_500.0, 60.0), waypoint(45.0, 2_121.0, 60.0)];
    let flown = fly(items, Air::default());
    let corner = flown.passages[1].nearest_m.unwrap();
    assert!((5.0..40.0).contains(&corner), "{corner}");
    let turns_at = flown.track.iter().find(|sample| Some(sample.time_s) >= flown.passages[1].reached_s).unwrap();
    let before_m = distance_m(turns_at.point, at(0.0, 1_500.0));
    assert!((45.0..55.0).contains(&before_m), "{before_m}");
}

/// The slope of the leg that leads to a circle passes through the plane's own height; that is not the circle's.
#[test]
fn a_circle_down_is_left_at_its_own_height_however_near_it_begins() {
    for distance_m in (100..=400).step_by(20) {
        let centre = direct(at(0.0, 1_500.0), 30.0, f64::from(distance_m));
        let (lat, lon) = (centre.lat_deg(), centre.lon_deg());
        let onward = direct(centre, 200.0, 900.0);
        let flown = fly(
            vec![
                takeoff(60.0),
                waypoint(0.0, 1_500.0, 110.0),
                MissionItem::loiter_to_alt(lat, lon, 40.0, 80.0),
                MissionItem::waypoint(onward.lat_deg(), onward.lon_deg(), 40.0),
            ],
            Air::default(),
        );
        let leaves = flown.track.iter().rfind(|sample| sample.index == Some(2)).unwrap();
        assert!((leaves.height_m - 40.0).abs() < 6.0, "{distance_m} m: {leaves:?}");
    }
}

#[test]
fn circles_are_counted_timed_and_left_towards_what_follows() {
    let point = at(0.0, 1_500.0);
    let (lat, lon) = (point.lat_deg(), point.lon_deg());
    let through = |circle: MissionItem| {
        let flown = fly(vec![takeoff(60.0), circle, waypoint(90.0, 3_000.0, 60.0)], Air::default());
        let passage = flown.passages[1];
        let swept: f64 = flown
            .track
            .windows(2)
            .filter(|pair| pair[0].index == Some(1) && distance_m(pair[0].point, point) < 130.0)
            .map(|pair| crate::geodesy::wrap_180_deg(pair[1].course_deg - pair[0].course_deg))
            .sum();
        (passage.reached_s.unwrap() - passage.begins_s, swept)
    };
    let (_, right) = through(MissionItem::loiter_turns(lat, lon, 60.0, 2.0, 100.0));
    let (_, left) = through(MissionItem::loiter_turns(lat, lon, 60.0, 2.0, -100.0));
    assert!((600.0..1_100.0).contains(&right), "{right}");
    assert!((-1_100.0..-600.0).contains(&left), "{left}");
    let (short_s, _) = through(MissionItem::loiter_time(lat, lon, 60.0, 20.0, true));
    let (long_s, _) = through(MissionItem::loiter_time(lat, lon, 60.0, 80.0, true));
    assert!(long_s - short_s > 40.0, "{short_s} {long_s}");
    let up = fly(
        vec![takeoff(60.0), MissionItem::loiter_to_alt(lat, lon, 160.0, 100.0), waypoint(90.0, 3_000.0, 160.0)],
        Air::default(),
    );
    let leaves = up.track.iter().rfind(|sample| sample.index == Some(1)).unwrap();
    assert!((leaves.height_m - 160.0).abs() < 6.0, "{leaves:?}");
}

#[test]
fn a_circle_after_another_counts_from_its_own_beginning() {
    let (first, second) = (at(0.0, 1_500.0), at(30.0, 2_000.0));
    let turns = MissionItem::loiter_turns(first.lat_deg(), first.lon_deg(), 60.0, 1.0, 100.0);
    let time = MissionItem::loiter_time(second.lat_deg(), second.lon_deg(), 60.0, 45.0, true);
    let flown = fly(vec![takeoff(60.0), turns, time, waypoint(90.0, 3_000.0, 60.0)], Air::default());
    let on_it = |sample: &&Sample| sample.index == Some(2) && distance_m(sample.point, second) < 180.0;
    let seconds = flown.track.iter().filter(on_it).count() as f64 / 5.0;
    assert!(seconds >= 45.0, "{seconds}");
}

/// An ArduPlane as its own simulator comes with.
fn simulators() -> Aircraft {
    let set = [
        ("SIM_RATE_HZ", 1_200.0),
        ("ROLL_LIMIT_DEG", 65.0),
        ("PTCH_LIM_MAX_DEG", 25.0),
        ("PTCH_LIM_MIN_DEG", -20.0),
        ("RLL2SRV_TCONST", 0.25),
        ("RLL2SRV_RMAX", 90.0),
        ("PTCH2SRV_TCONST", 0.25),
        ("WP_RADIUS", 50.0),
        ("WP_LOITER_RAD", 80.0),
        ("LAND_FLARE_SEC", 3.0),
        ("LAND_PITCH_DEG", 1.0),
    ];
    Aircraft::from_ardupilot(|name| set.iter().find(|(known, _)| *known == name).map(|(_, value)| *value))
}

/// An ArduPlane in its own simulator was on its way to the second circle and on it for 85 s: it counts from the moment
/// at which it leaves the first, from the bearing of that one's centre on, and is done a lap sooner.
#[test]
fn a_circle_right_after_one_the_other_way_round_is_a_lap_shorter() {
    let circle = |point: GeoPoint, radius_m| {
        let mut item = MissionItem::loiter_turns(point.lat_deg(), point.lon_deg(), 62.0, 3.0, radius_m);
        item.params[3] = Some(0.0);
        item
    };
    let items = vec![
        takeoff(50.0),
        waypoint(320.6, 1_296.5, 62.0),
        circle(at(304.91, 855.9), -140.0),
        circle(at(290.66, 1_246.6), 80.0),
        waypoint(298.7, 987.0, 62.0),
    ];
    let flown = rehearse(&plan(items), &Conditions::new(&simulators(), Air::default())).unwrap();
    let passage = flown.passages[3];
    let seconds = passage.reached_s.unwrap() - passage.begins_s;
    assert!((82.0..89.0).contains(&seconds), "{seconds}");
}

/// It touched the ground 46 m before the point of its landing in calm air, at 0.55 m/s: its nose lags while the speed
/// falls in the flare.
#[test]
fn a_flare_ends_where_the_trim_lets_it() {
    let plane = simulators();
    let centre = direct(at(180.0, 516.0), 90.0, 80.0);
    let items = vec![
        takeoff(50.0),
        waypoint(180.0, 1_200.0, 60.0),
        MissionItem::loiter_to_alt(centre.lat_deg(), centre.lon_deg(), 40.0, 80.0),
        MissionItem::land(at(0.0, 0.0).lat_deg(), at(0.0, 0.0).lon_deg(), 0.0),
    ];
    let flown = rehearse(&plan(items), &Conditions::new(&plane, Air::default())).unwrap();
    let down = flown.touch_down.unwrap();
    let before_m = distance_m(down.point, at(0.0, 0.0));
    assert!((36.0..56.0).contains(&before_m), "{before_m}");
}

#[test]
fn jumps_are_flown_as_often_as_they_say() {
    let lap = |repeats| {
        let items = vec![
            takeoff(50.0),
            waypoint(0.0, 1_000.0, 60.0),
            waypoint(90.0, 1_000.0, 60.0),
            MissionItem::jump(MissionSeq(2), repeats),
        ];
        let flown = fly(items, Air::default());
        (reached(&flown), flown.ending)
    };
    assert_eq!(lap(0), (vec![0, 1, 2], Ending::Returned));
    assert_eq!(lap(2), (vec![0, 1, 2, 1, 2, 1, 2], Ending::Returned));
    assert_eq!(lap(-1).1, Ending::Endless);
}

#[test]
fn each_end_is_told() {
    let circle = at(0.0, 1_000.0);
    let unlimited = MissionItem::loiter_unlimited(circle.lat_deg(), circle.lon_deg(), 60.0, 0.0);
    assert_eq!(fly(vec![takeoff(50.0), unlimited], Air::default()).ending, Ending::Unlimited);
    assert_eq!(fly(vec![takeoff(50.0), MissionItem::return_to_launch()], Air::default()).ending, Ending::Returned);
    // From so far away that the return takes longer than a plane is waited for that the wind holds.
    let far = vec![takeoff(50.0), waypoint(0.0, 20_000.0, 60.0), MissionItem::return_to_launch()];
    assert_eq!(fly(far, Air::default()).ending, Ending::Returned);
    assert_eq!(fly(vec![takeoff(50.0), waypoint(0.0, 3_000.0, 60.0)], wind(0.0, 30.0)).ending, Ending::Held);
    let script = MissionItem::action(Command::NAV_SCRIPT_TIME, [1.0, 10.0, 0.0, 0.0]);
    assert_eq!(fly(vec![takeoff(50.0), script], Air::default()).ending, Ending::NotRehearsed);
    let plane = Aircraft { takeoff_throttle: 0.0, ..Aircraft::default() };
    let stays = rehearse(&plan(vec![takeoff(50.0)]), &Conditions::new(&plane, Air::default())).unwrap();
    assert_eq!(stays.ending, Ending::Grounded);
    let (usual, flat) = (Aircraft::default(), |_: GeoPoint| Some(HOME.alt_amsl_m));
    let over = Conditions { ground: Some(&flat), ..Conditions::new(&usual, Air::default()) };
    let deep = rehearse(&plan(vec![takeoff(50.0), waypoint(0.0, 2_000.0, -40.0)]), &over).unwrap();
    assert_eq!(deep.ending, Ending::Ground);
    // Items that ArduPlane skips do not end the flight.
    let passed = [Command::NAV_GUIDED_ENABLE, Command::NAV_SET_YAW_SPEED, Command::NAV_DELAY]
        .map(|command| MissionItem::action(command, [1.0, 5.0, 0.0, 0.0]));
    let items = [&[takeoff(50.0)], &passed[..], &[MissionItem::return_to_launch()]].concat();
    assert_eq!(fly(items, Air::default()).ending, Ending::Returned);
    let nowhere = Plan::from_mission(Mission { home: None, items: vec![takeoff(50.0)] });
    assert_eq!(rehearse(&nowhere, &Conditions::new(&plane, Air::default())), Err(NotRehearsed::NoHome));
}

#[test]
fn a_plan_with_an_item_without_a_place_is_not_rehearsed() {
    let plane = Aircraft::default();
    for missing in [[4, 4], [5, 5], [4, 5]] {
        let mut items = vec![takeoff(50.0), waypoint(90.0, 2_500.0, 60.0)];
        missing.into_iter().for_each(|param| items[1].params[param] = None);
        let why = rehearse(&plan(items), &Conditions::new(&plane, Air::default())).unwrap_err();
        assert_eq!(why.to_string(), "item 2 (NAV_WAYPOINT) has no latitude or longitude; place it on the map");
    }
    // A take-off may be where the plane stands.
    let mut items = vec![takeoff(50.0), waypoint(90.0, 2_500.0, 60.0)];
    items[0].params[4..6].fill(None);
    assert!(rehearse(&plan(items), &Conditions::new(&plane, Air::default())).is_ok());
}

#[test]
fn a_flight_that_nobody_waits_for_any_more_ends() {
    let (plane, asked) = (Aircraft::default(), std::sync::atomic::AtomicU32::new(0));
    let is_wanted = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 100;
    let conditions = Conditions { is_wanted: &is_wanted, ..Conditions::new(&plane, Air::default()) };
    assert_eq!(rehearse(&plan(with_landing()), &conditions), Err(NotRehearsed::NotWanted));
    assert_eq!(asked.into_inner(), 101);
}

#[test]
fn a_return_goes_where_the_vehicle_would_go() {
    let plane = Aircraft::default();
    let mut with_rally = plan(vec![takeoff(50.0), waypoint(90.0, 2_500.0, 60.0)]);
    let rally = RallyPoint { point: at(90.0, 2_000.0), alt_m: 80.0, frame: MavFrame::GlobalRelativeAlt };
    with_rally.rally = Rally { points: vec![rally] };
    let flown = rehearse(&with_rally, &Conditions::new(&plane, Air::default())).unwrap();
    let last = flown.track.last().unwrap();
    assert!(distance_m(last.point, rally.point) < 100.0);
    assert!((last.height_m - 80.0).abs() < 3.0);
    // From nearer to home too, unless home takes part; as ArduPlane comes it does not.
    with_rally.mission.items[1] = waypoint(90.0, 600.0, 60.0);
    for (includes_home, goal) in [(None, rally.point), (Some(0.0), rally.point), (Some(1.0), at(0.0, 0.0))] {
        let plane = Aircraft::from_ardupilot(|name| includes_home.filter(|_| name == "RALLY_INCL_HOME"));
        let flown = rehearse(&with_rally, &Conditions::new(&plane, Air::default())).unwrap();
        assert!(distance_m(flown.track.last().unwrap().point, goal) < 100.0, "{includes_home:?}");
    }

    let landing =
        design_landing(at(270.0, 500.0), &LandingOptions { course_deg: Some(270.0), ..LandingOptions::default() });
    let mut items = vec![takeoff(50.0), waypoint(90.0, 1_500.0, 60.0), MissionItem::return_to_launch()];
    items.extend(landing.unwrap().items);
    for (autoland, ending) in [
        (Autoland::Never, Ending::Returned),
        (Autoland::AfterReturn, Ending::Landed),
        (Autoland::AtOnce, Ending::Landed),
    ] {
        let plane = Aircraft { autoland, ..Aircraft::default() };
        let flown = rehearse(&plan(items.clone()), &Conditions::new(&plane, Air::default())).unwrap();
        assert_eq!(flown.ending, ending, "{autoland:?}");
    }
}

#[test]
fn a_landing_sequence_that_only_returns_is_left_at_once() {
    let start = MissionItem::at(Command::DO_LAND_START, [0.0; 4], HOME.lat_deg, HOME.lon_deg, 0.0);
    let path = MissionItem { command: Command::DO_RETURN_PATH_START, ..start.clone() };
    let without = fly(vec![takeoff(50.0), waypoint(90.0, 1_500.0, 60.0)], Air::default());
    for autoland in [Autoland::AfterReturn, Autoland::AtOnce, Autoland::ReturnPath] {
        let plane = Aircraft { autoland, ..Aircraft::default() };
        for sequence in [vec![start.clone()], vec![start.clone(), MissionItem::return_to_launch()], vec![path.clone()]]
        {
            let mut items = vec![takeoff(50.0), waypoint(90.0, 1_500.0, 60.0)];
            items.extend(sequence);
            let flown = rehearse(&plan(items), &Conditions::new(&plane, Air::default())).unwrap();
            assert_eq!(flown.ending, Ending::Returned, "{autoland:?}");
            assert!(
                (flown.duration_s - without.duration_s).abs() < 60.0,
                "{} {}",
                flown.duration_s,
                without.duration_s
            );
        }
    }
}

#[test]
fn speeds_change_where_the_plan_says() {
    let items = vec![
        takeoff(50.0),
        waypoint(0.0, 1_500.0, 60.0),
        MissionItem::change_airspeed(16.0),
        waypoint(0.0, 3_500.0, 60.0),
        MissionItem::action(Command::CONDITION_DISTANCE, [800.0, 0.0, 0.0, 0.0]),
        MissionItem::change_airspeed(26.0),
        waypoint(0.0, 6_000.0, 60.0),
    ];
    let flown = fly(items, Air::default());
    let speed = |distance_from_home_m: f64| {
        let near = |sample: &&Sample| distance_m(sample.point, HOME.point().unwrap()) > distance_from_home_m;
        flown.track.iter().find(near).unwrap().airspeed_m_s
    };
    for (distance_m, expected) in [(1_300.0, 22.0), (3_000.0, 16.0), (4_500.0, 16.0), (5_900.0, 26.0)] {
        assert!((speed(distance_m) - expected).abs() < 1.0, "{distance_m}: {}", speed(distance_m));
    }
}

#[test]
fn gusts_are_those_of_their_seed() {
    let items = vec![takeoff(50.0), waypoint(0.0, 2_000.0, 60.0)];
    let gusty = |seed| fly(items.clone(), Air { gust_m_s: 2.0, seed, ..wind(90.0, 5.0) });
    assert_eq!(gusty(1), gusty(1));
    assert_ne!(gusty(1), gusty(2));
}

#[test]
fn a_thinned_track_draws_the_same_line() {
    let flown = fly(vec![takeoff(50.0), waypoint(0.0, 2_000.0, 60.0), waypoint(60.0, 2_500.0, 120.0)], wind(90.0, 6.0));
    let thinned = flown.thinned(0.7);
    assert!(thinned.len() * 3 < flown.track.len(), "{} of {}", thinned.len(), flown.track.len());
    assert_eq!(thinned.last().unwrap().time_s, flown.duration_s);
    for sample in &flown.track {
        let next = thinned.iter().position(|kept| kept.time_s >= sample.time_s).unwrap();
        let (a, b) = (thinned[next.saturating_sub(1)], thinned[next]);
        if a.time_s < b.time_s {
            let offset = leg_offset(a.point, b.point, sample.point);
            assert!(offset.cross_m.abs() < 2.0, "{offset:?} at {}", sample.time_s);
        }
    }
    // However long it is, a given number of them is enough, from its beginning to its end.
    assert_eq!(flown.thinned_to(0.7, thinned.len()).len(), thinned.len());
    for most in [thinned.len() / 2, 10, 2] {
        let kept = flown.thinned_to(0.7, most);
        assert!((2..=most).contains(&kept.len()), "{} of {most}", kept.len());
        assert_eq!((kept[0].time_s, kept.last().unwrap().time_s), (thinned[0].time_s, flown.duration_s));
    }
}

#[test]
fn a_ridge_stays_in_what_is_drawn_of_a_long_flight() {
    let home = HOME.point().unwrap();
    let ridge_at_m = 3_000.0..3_120.0;
    let ground = |point| Some(if ridge_at_m.contains(&distance_m(home, point)) { 710.0 } else { 600.0 });
    let mut circles = waypoint(0.0, 1_000.0, 150.0);
    (circles.command, circles.params[0]) = (Command::NAV_LOITER_TURNS, Some(40.0));
    let plan = plan(vec![takeoff(50.0), circles, waypoint(0.0, 5_000.0, 150.0)]);
    let usual = Aircraft::default();
    let conditions = Conditions { ground: Some(&ground), ..Conditions::new(&usual, Air::default()) };
    let flown = rehearse(&plan, &conditions).unwrap();
    let highest = |kept: Vec<&Sample>| kept.iter().filter_map(|sample| sample.ground_m).fold(f64::MIN, f64::max);
    let fine = flown.thinned(0.7);
    let (many, highest_m) = (fine.len(), highest(fine));
    assert_eq!(highest(flown.thinned_to(0.7, many / 20)), highest_m);
}

#[test]
fn many_flights_give_a_corridor_and_the_odds() {
    let landing =
        design_landing(HOME.point().unwrap(), &LandingOptions { course_deg: Some(270.0), ..LandingOptions::default() });
    let mut items = vec![takeoff(50.0), waypoint(45.0, 900.0, 80.0), waypoint(90.0, 1_500.0, 100.0)];
    items.extend(landing.unwrap().items);
    let plan = plan(items);
    let plane = Aircraft::default();
    let conditions = Conditions::new(&plane, wind(280.0, 5.0));
    let sure = Doubts { wind_speed_m_s: 0.0, wind_from_deg: 0.0, gust_m_s: 0.0, thrust: 0.0, drag: 0.0, power: 0.0 };
    let expected = rehearse(&plan, &conditions).unwrap();
    let spread = |doubts: &Doubts, seeds: std::ops::Range<u64>| {
        let runs: Vec<Run> = seeds.map(|seed| fly_once(&plan, &conditions, doubts, &expected, seed).unwrap()).collect();
        gather(expected.clone(), &runs)
    };
    let alike = spread(&sure, 0..4);
    assert_eq!((alike.runs, alike.endings.as_slice()), (4, &[(Ending::Landed, 4)][..]));
    assert!(alike.corridor.iter().all(|breadth| breadth.across_m.high.abs() < 1e-6), "nothing differs");
    let doubtful = spread(&Doubts::default(), 0..40);
    assert_eq!(doubtful.runs, 40);
    assert_eq!(doubtful.endings[0].0, Ending::Landed);
    assert!(
        doubtful.duration_s.low < doubtful.duration_s.median && doubtful.duration_s.median < doubtful.duration_s.high
    );
    let widest =
        doubtful.corridor.iter().map(|breadth| breadth.across_m.high - breadth.across_m.low).fold(0.0, f64::max);
    assert!((2.0..200.0).contains(&widest), "{widest}");
    assert_eq!(doubtful, spread(&Doubts::default(), 0..40), "the same seeds, the same flights");
}

/// A flight with climbs, turns and other speeds in a wind of 6 m/s from 240°.
fn recorded_with(truth: Airframe) -> Vec<Recorded> {
    let plane = Aircraft { airframe: truth, ..Aircraft::default() };
    let items = vec![
        takeoff(50.0),
        waypoint(0.0, 1_000.0, 60.0),
        waypoint(90.0, 1_200.0, 160.0),
        MissionItem::change_airspeed(16.0),
        waypoint(180.0, 1_000.0, 60.0),
        MissionItem::change_airspeed(26.0),
        waypoint(270.0, 1_200.0, 120.0),
        waypoint(0.0, 1_200.0, 60.0),
    ];
    let air = wind(240.0, 6.0);
    let flown = rehearse(&plan(items), &Conditions::new(&plane, air)).unwrap();
    let recorded = flown.track.iter().map(|sample| Recorded {
        time_s: sample.time_s,
        velocity: NorthEast::from_bearing(sample.course_deg.to_radians()) * sample.groundspeed_m_s,
        climb_m_s: sample.climb_m_s,
        height_amsl_m: HOME.alt_amsl_m + sample.height_m,
        height_m: sample.height_m,
        airspeed_m_s: sample.airspeed_m_s,
        bank_rad: sample.bank_deg.to_radians(),
        pitch_rad: sample.pitch_deg.to_radians(),
        throttle: sample.throttle,
        power_w: Some(180.0 * truth.power(sample.throttle)),
        voltage_v: Some(11.4),
    });
    recorded.collect()
}

#[test]
fn a_plane_is_learned_from_its_flight() {
    let truth = Airframe {
        skid: 0.2,
        level_pitch_rad: 0.05,
        drag_m_s2: 1.8,
        thrust_full_m_s2: 6.0,
        throttle_cruise: 0.3,
        pitot: 1.04,
        power_cruise_w: Some(180.0),
        ..Aircraft::default().airframe
    };
    let recorded = recorded_with(truth);
    let learned = learn(&recorded, &Aircraft::default()).unwrap();
    let close = |a: f64, b: f64, within: f64| assert!((a - b).abs() <= within, "{a} for {b}: {learned:?}");
    close(learned.wind.speed_m_s, 6.0, 0.1);
    close(learned.wind.from_deg, 240.0, 2.0);
    close(learned.airframe.pitot, 1.04, 0.005);
    close(learned.airframe.skid, 0.2, 0.04);
    close(learned.airframe.level_pitch_rad, 0.05, 0.01);
    close(learned.airframe.attack_rad, truth.attack_rad, 0.02);
    close(learned.airframe.drag_m_s2, 1.8, 0.25);
    close(learned.airframe.thrust_full_m_s2, 6.0, 0.9);
    close(learned.airframe.power_cruise_w.unwrap(), 180.0, 20.0);
    close(learned.airframe.voltage_v.unwrap(), 11.4, 1e-9);
    assert_eq!(learned.airframe.origin, Origin::Flight);

    let straight = |moment: &&Recorded| (20.0..40.0).contains(&moment.time_s);
    let one_way: Vec<Recorded> = recorded.iter().filter(straight).copied().collect();
    assert_eq!(learn(&one_way, &Aircraft::default()), None, "one direction does not tell wind from pitot");
    assert_eq!(learn(&[], &Aircraft::default()), None);
}

#[test]
fn how_thrust_falls_with_airspeed_is_learned() {
    let truth = Airframe {
        drag_m_s2: 1.5,
        thrust_full_m_s2: 8.0,
        thrust_static_m_s2: Some(13.75),
        throttle_cruise: 0.6,
        ..Aircraft::default().airframe
    };
    assert!((truth.thrust(0.6, truth.cruise_m_s) - 1.5).abs() < 1e-9, "level flight at cruise");
    assert!((truth.thrust(1.0, 0.0) - 13.75).abs() < 1e-9);
    assert_eq!(truth.thrust(0.1, truth.cruise_m_s).to_bits(), 0.0_f64.to_bits(), "a windmill is no brake");
    let learned = learn(&recorded_with(truth), &Aircraft::default()).unwrap().airframe;
    let close = |a: f64, b: f64, within: f64| assert!((a - b).abs() <= within, "{a} for {b}: {learned:?}");
    close(learned.drag_m_s2, 1.5, 0.3);
    close(learned.thrust_full_m_s2, 8.0, 0.8);
    close(learned.thrust_static_m_s2.unwrap(), 13.75, 2.0);
}

/// A flight that is level all the way, but for its landing: there it comes down without thrust, in a wind that ceases,
/// and brakes on its wheels.
#[test]
fn drag_is_learned_down_to_the_ground_and_not_on_it() {
    let truth = Airframe { drag_m_s2: 3.5, ..Aircraft::default().airframe };
    let wind = NorthEast::new(-6.0, 0.0);
    let moment = |time_s: f64, bearing: f64, airspeed_m_s: f64, height_m: f64, climb_m_s: f64| {
        let here = wind * (height_m / 20.0).clamp(0.0, 1.0);
        Recorded {
            time_s,
            velocity: NorthEast::from_bearing(bearing) * airspeed_m_s + here,
            climb_m_s,
            height_amsl_m: 0.0,
            height_m,
            airspeed_m_s,
            bank_rad: 0.0,
            pitch_rad: climb_m_s / airspeed_m_s,
            throttle: if height_m < 20.0 { 0.0 } else { 0.6 },
            power_w: None,
            voltage_v: None,
        }
    };
    let level =
        (0..1_500).map(|step| 0.2 * f64::from(step)).map(|time_s| moment(time_s, 0.02 * time_s, 22.0, 100.0, 0.0));
    let mut flight: Vec<Recorded> = level.collect();
    // Northward, into the wind, at 5 moments a second. That the wind ceases costs airspeed and no speed over the
    // ground.
    let (mut speed, mut height_m, sink_m_s) = (18.0, 8.0, 1.2);
    for step in 0..60 {
        let is_down = height_m <= 0.0;
        let airspeed_m_s = (speed + wind.north * (1.0 - (height_m / 20.0_f64).clamp(0.0, 1.0))).max(0.0);
        flight.push(moment(
            300.0 + 0.2 * f64::from(step),
            0.0,
            airspeed_m_s,
            height_m,
            if is_down { 0.0 } else { -sink_m_s },
        ));
        let accel = if is_down {
            -1.5 - truth.drag(airspeed_m_s, 0.0)
        } else {
            9.806_65 * sink_m_s / airspeed_m_s - truth.drag(airspeed_m_s, 1.0)
        };
        speed += 0.2 * accel;
        height_m = (height_m - 0.2 * sink_m_s).max(0.0);
    }
    let learned = learn(&flight, &Aircraft::default()).unwrap().airframe;
    assert!((learned.drag_m_s2 / 3.5 - 1.0).abs() < 0.05, "{learned:?}");
    assert!((learned.ground_drag_m_s2.unwrap() - 1.5).abs() < 0.15, "{learned:?}");
}

/// A propeller that gives less the faster the plane is, and more than twice as much at full throttle as at half, mostly
/// in level flight at three speeds with a throttle that is never still.
#[test]
fn full_thrust_is_learned_from_climbs_not_from_level_flight() {
    let excess = |throttle: f64, airspeed_m_s: f64| {
        // Level at 16, 22 and 25 m/s with 47, 61 and 70 % throttle; 6 m/s² more at full throttle and 22 m/s.
        let level = 0.47 + (airspeed_m_s - 16.0) * 0.0245;
        15.4 * (throttle - level)
    };
    let mut flight = Vec::new();
    for second in 0..600_u32 {
        for part in 0..5_u32 {
            let time_s = f64::from(second) + 0.2 * f64::from(part);
            let bearing = 0.02 * time_s;
            let airspeed_m_s = [16.0, 22.0, 22.0, 25.0][second as usize / 150];
            let climbs = second % 50 < 5;
            let wobble = 0.03 * (time_s * 1.7).sin();
            let throttle = if climbs { 1.0 } else { 0.47 + (airspeed_m_s - 16.0) * 0.0245 + wobble };
            // What the throttle does by the way is over before the plane follows.
            let pull = if climbs { excess(throttle, airspeed_m_s) } else { 0.0 };
            let climb_m_s = pull / 9.806_65 * airspeed_m_s;
            let along = (airspeed_m_s * airspeed_m_s - climb_m_s * climb_m_s).max(1.0).sqrt();
            flight.push(Recorded {
                time_s,
                velocity: NorthEast::from_bearing(bearing) * along,
                climb_m_s,
                height_amsl_m: 0.0,
                height_m: 100.0,
                airspeed_m_s,
                bank_rad: 0.0,
                pitch_rad: climb_m_s / airspeed_m_s,
                throttle,
                power_w: Some(160.0 * (throttle / 0.617).powf(2.2)),
                voltage_v: Some(15.0),
            });
        }
    }
    let plane = Aircraft::default();
    let learned = learn(&flight, &plane).unwrap().airframe;
    let more = learned.thrust_full_m_s2 - learned.drag_m_s2;
    assert!((5.0..7.0).contains(&more), "{learned:?}");
    assert!((learned.throttle_cruise - 0.617).abs() < 0.02, "{learned:?}");
    assert!((learned.power_exponent - 2.2).abs() < 0.1, "{learned:?}");
    let full_w = learned.power_cruise_w.unwrap() * learned.power(1.0);
    assert!((full_w / (160.0 * 0.617_f64.powf(-2.2)) - 1.0).abs() < 0.1, "{full_w}");
    // The flight under way is learned from by its last ten minutes, and by no more.
    let mut learner = Learner::default();
    for moment in flight.iter().chain(&flight) {
        learner.note(*moment);
    }
    assert_eq!(learner.learned(&plane).map(|learned| learned.moments), Some(3_000));
    let late = Recorded { time_s: flight.last().unwrap().time_s - 0.3, ..flight[0] };
    learner.note(late);
    assert_eq!(learner.learned(&plane).map(|learned| learned.moments), Some(3_000), "only out of order");
    let early = Recorded { time_s: 0.0, ..flight[0] };
    learner.note(early);
    assert_eq!(learner.learned(&plane), None, "a clock that goes back is another flight");
}

#[test]
fn parameters_of_older_versions_are_read() {
    let old = |name: &str| match name {
        "TRIM_ARSPD_CM" => Some(1_500.0),
        "LIM_ROLL_CD" => Some(5_500.0),
        "ALT_HOLD_RTL" => Some(8_000.0),
        "ARSPD_FBW_MIN" => Some(9.0),
        _ => None,
    };
    let plane = Aircraft::from_ardupilot(old);
    assert_eq!((plane.airspeed_cruise_m_s, plane.bank_max_deg, plane.return_height_m), (15.0, 55.0, 80.0));
    assert_eq!((plane.tecs.airspeed_min_m_s, plane.airframe.origin), (9.0, Origin::Parameters));
    let simulated = Aircraft::from_ardupilot(|name| (name == "SIM_RATE_HZ").then_some(1_200.0));
    assert_eq!(simulated.airframe.origin, Origin::Simulator);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_the_plan_and_the_plane_the_flight_ends_and_is_finite(
        items in proptest::collection::vec(
            (0..24_usize, proptest::array::uniform4(-300.0..300.0f64), 0.0..360.0f64, 0.0..20_000.0f64, -500.0..3_000.0f64), 0..12),
        values in proptest::collection::vec(prop_oneof![-1e6..1e6f64, -10.0..100.0f64, (0..6).prop_map(f64::from), Just(f64::NAN)], 8),
        speed_m_s in 0.0..60.0f64,
    ) {
        const COMMANDS: [u16; 24] = [
            16, 16, 16, 17, 18, 19, 20, 21, 22, 22, 30, 31, 36, 82, 93, 112, 114, 177, 177, 178, 179, 189, 601, 600,
        ];
        let items = items.into_iter().map(|(command, params, bearing_deg, distance_m, height_m)| {
            let point = at(bearing_deg, distance_m);
            MissionItem::at(Command(COMMANDS[command]), params, point.lat_deg(), point.lon_deg(), height_m)
        });
        let plan = plan(items.collect());
        let plane = Aircraft::from_ardupilot(|name| values.get(name.len() * 7 % 40).copied());
        let conditions = Conditions::new(&plane, wind(90.0, speed_m_s));
        let flown = rehearse(&plan, &conditions).unwrap();
        for what_if in what_ifs(&plan, &conditions, Trigger::ALL, &[40.0]).unwrap() {
            let range = glide_range(&plan, &conditions, &what_if.at).unwrap();
            prop_assert!(range.len() == 72 || what_if.at.height_m <= 0.0);
            prop_assert!(what_if.flown.is_none_or(|flown| flown.duration_s <= LONGEST_S && flown.distance_m.is_finite()));
        }
        prop_assert!(flown.duration_s <= LONGEST_S && flown.distance_m.is_finite());
        prop_assert!(flown.track.iter().all(|sample| sample.height_m.is_finite() && sample.airspeed_m_s.is_finite()));
    }
}

/// A triangle of some 3 km, with a landing at home.
fn with_landing() -> Vec<MissionItem> {
    let options = LandingOptions { coming_from: Some(at(90.0, 1_500.0)), ..LandingOptions::default() };
    let landing = design_landing(HOME.point().unwrap(), &options).unwrap();
    let mut items = vec![takeoff(50.0), waypoint(0.0, 2_500.0, 80.0), waypoint(45.0, 2_500.0, 80.0)];
    items.extend(landing.items);
    items
}

fn what_if(plane: &Aircraft, cause: Trigger, time_s: f64) -> WhatIf {
    let plan = plan(with_landing());
    let found = what_ifs(&plan, &Conditions::new(plane, wind(270.0, 5.0)), &[cause], &[time_s]).unwrap();
    let [one] = found.try_into().unwrap();
    one
}

#[test]
fn a_return_leaves_the_mission_where_it_is_asked_for() {
    let plane = Aircraft::default();
    let asked = what_if(&plane, Trigger::ReturnAsked, 60.0);
    let flown = asked.flown.clone().unwrap();
    assert_eq!((asked.reaction(), flown.ending), (Reaction::Returns, Ending::Returned));
    assert!((asked.at.time_s - 60.0).abs() < 0.11 && (flown.track[0].time_s - 60.0).abs() < 0.21);
    let as_planned = rehearse(&plan(with_landing()), &Conditions::new(&plane, wind(270.0, 5.0))).unwrap();
    let there = as_planned.track.iter().find(|sample| sample.time_s >= asked.at.time_s).unwrap();
    assert!(distance_m(there.point, asked.at.point) < 5.0, "the flight until then is the plan's");
    let end = flown.track.last().unwrap();
    assert!((end.height_m - 100.0).abs() < 5.0 && distance_m(end.point, HOME.point().unwrap()) < 90.0, "{end:?}");
    assert!(flown.duration_s > 60.0 && flown.distance_m > 1_000.0);
    // Not on the ground.
    let none =
        what_ifs(&plan(with_landing()), &Conditions::new(&plane, wind(0.0, 0.0)), &[Trigger::ReturnAsked], &[0.0]);
    assert_eq!(none, Ok(vec![]));
}

#[test]
fn what_fails_is_answered_as_the_parameters_say() {
    let set = |settings: &[(&str, f64)]| {
        Aircraft::from_ardupilot(|name| settings.iter().find(|(known, _)| *known == name).map(|(_, value)| *value))
    };
    let goes_on = what_if(&set(&[]), Trigger::LinkLost, 60.0);
    assert_eq!((goes_on.decisions.len(), goes_on.flown), (0, None));
    let returns = set(&[("FS_GCS_ENABL", 1.0), ("FS_LONG_ACTN", 1.0), ("FS_LONG_TIMEOUT", 20.0)]);
    let lost = what_if(&returns, Trigger::LinkLost, 60.0);
    assert_eq!(lost.decisions, [Decision { time_s: lost.decisions[0].time_s, reaction: Reaction::Returns }]);
    assert!((lost.decisions[0].time_s - 80.0).abs() < 0.2);
    // With a landing in the mission and RTL_AUTOLAND 2 it comes down.
    let lands = set(&[("FS_GCS_ENABL", 1.0), ("FS_LONG_ACTN", 1.0), ("RTL_AUTOLAND", 2.0)]);
    let landed = what_if(&lands, Trigger::LinkLost, 60.0).flown.unwrap();
    assert_eq!(landed.ending, Ending::Landed);
    let down = landed.touch_down.unwrap();
    assert!(distance_m(down.point, HOME.point().unwrap()) < 120.0, "{down:?}");
    let battery = set(&[("BATT_FS_LOW_ACT", 2.0), ("BATT_LOW_VOLT", 10.5)]);
    let low = what_if(&battery, Trigger::BatteryLow, 60.0);
    assert!((low.decisions[0].time_s - 70.0).abs() < 0.2, "a voltage counts after BATT_LOW_TIMER: {:?}", low.decisions);
    assert_eq!(low.flown.unwrap().ending, Ending::Landed);
    // A circle for five seconds, then home.
    let both = set(&[("FS_SHORT_ACTN", 1.0), ("FS_LONG_ACTN", 1.0)]);
    let circled = what_if(&both, Trigger::RadioLost, 60.0);
    let reactions: Vec<Reaction> = circled.decisions.iter().map(|decision| decision.reaction).collect();
    assert_eq!(reactions, [Reaction::Circles, Reaction::Returns]);
    assert_eq!(circled.flown.unwrap().ending, Ending::Returned);
    let glides = set(&[("FS_SHORT_ACTN", 2.0), ("FS_LONG_ACTN", 2.0)]);
    assert_eq!(what_if(&glides, Trigger::RadioLost, 60.0).flown.unwrap().ending, Ending::Ground);
    let unknown = set(&[("BATT_FS_LOW_ACT", 3.0), ("BATT_LOW_VOLT", 10.5)]);
    assert_eq!(what_if(&unknown, Trigger::BatteryLow, 60.0).flown.unwrap().ending, Ending::NotRehearsed);
}

#[test]
fn a_landing_that_is_broken_off_climbs_and_is_flown_again() {
    let plane = Aircraft::default();
    let plan = plan(with_landing());
    let conditions = Conditions::new(&plane, wind(270.0, 5.0));
    let landed = rehearse(&plan, &conditions).unwrap();
    let (land, down) = (landed.passages.last().unwrap(), landed.touch_down.unwrap());
    let moments = [land.begins_s - 30.0, 0.5 * (land.begins_s + down.time_s), down.time_s - 5.0];
    let asked = what_ifs(&plan, &conditions, &[Trigger::GoAround], &moments).unwrap();
    assert_eq!((asked[0].decisions.len(), &asked[0].flown), (0, &None), "not on the final leg");
    for asked in &asked[1..] {
        assert_eq!(asked.reaction(), Reaction::GoesAround);
        let flown = asked.flown.as_ref().unwrap();
        // The take-off climbed to 50 m, and so does this; then the landing is flown from its beginning.
        let lowest = flown.track.iter().take_while(|sample| sample.height_m < 50.0).map(|sample| sample.height_m);
        assert!(lowest.fold(f64::MAX, f64::min) > 1.0);
        let climbs = flown.track.iter().position(|sample| sample.height_m >= 50.0).unwrap();
        let climb = (flown.track[climbs].height_m - asked.at.height_m) / (flown.track[climbs].time_s - asked.at.time_s);
        assert!((2.0..10.0).contains(&climb), "{climb}");
        let again: Vec<usize> = flown.passages.iter().map(|passage| passage.item).skip(landed.passages.len()).collect();
        assert_eq!(again, [4, 5], "the circle down and the landing");
        assert_eq!(flown.ending, Ending::Landed);
    }
    // A planned abort pattern is flown instead: of two the nearest.
    let mut items = with_landing();
    let marked = |bearing_deg, distance_m| MissionItem {
        command: Command::DO_GO_AROUND,
        ..waypoint(bearing_deg, distance_m, 0.0)
    };
    let first = items.len();
    items.extend([
        marked(0.0, 9_000.0),
        waypoint(0.0, 9_000.0, 60.0),
        marked(0.0, 300.0),
        waypoint(0.0, 1_500.0, 70.0),
    ]);
    let patterned = Plan::from_mission(Mission { home: Some(HOME), items });
    let asked = what_ifs(&patterned, &conditions, &[Trigger::GoAround], &moments[1..2]).unwrap();
    let flown = asked[0].flown.as_ref().unwrap();
    let then = flown.passages[landed.passages.len()..].iter().map(|passage| passage.item).collect::<Vec<_>>();
    assert_eq!((then, flown.ending), (vec![first + 3], Ending::Returned));
    // The landing's own first parameter is how high it climbs.
    let mut items = with_landing();
    let last = items.len() - 1;
    items[last].params[0] = Some(90.0);
    let higher = what_ifs(
        &Plan::from_mission(Mission { home: Some(HOME), items }),
        &conditions,
        &[Trigger::GoAround],
        &moments[1..2],
    )
    .unwrap();
    let climb = &higher[0].flown.as_ref().unwrap().track;
    assert!(climb.iter().any(|sample| sample.height_m > 85.0));
}

#[test]
fn a_landing_is_broken_off_with_wings_level_up_to_its_whole_height() {
    // As an ArduPlane flew it: the take-off's course is forgotten, and only a take-off levels off before its height.
    let plane = Aircraft::default();
    let plan = plan(with_landing());
    for from_deg in [0.0, 90.0, 180.0, 270.0] {
        let conditions = Conditions::new(&plane, wind(from_deg, 6.0));
        let landed = rehearse(&plan, &conditions).unwrap();
        let before_s = [landed.touch_down.unwrap().time_s - 10.0];
        let asked = what_ifs(&plan, &conditions, &[Trigger::GoAround], &before_s).unwrap();
        let flown = asked[0].flown.as_ref().unwrap();
        let climbs: Vec<&Sample> = flown
            .track
            .iter()
            .filter(|sample| sample.time_s > asked[0].at.time_s + 2.0)
            .take_while(|sample| sample.height_m < 50.0)
            .collect();
        assert!(climbs.len() > 10);
        assert!(climbs.iter().all(|sample| sample.bank_deg.abs() < 0.5), "wind from {from_deg}");
        let fastest = climbs.iter().map(|sample| sample.climb_m_s).fold(0.0, f64::max);
        assert!(climbs.last().unwrap().climb_m_s > 0.9 * fastest, "wind from {from_deg}");
    }
}

/// The height that a landing is broken off to is that of the take-off, where the landing has none: of a plane in the
/// air that of its mission.
#[test]
fn a_landing_is_broken_off_to_the_height_of_the_mission_s_take_off() {
    let plan = plan(with_landing());
    let plane = Aircraft::default();
    let index = plan.mission.items.iter().position(|item| item.command == Command::NAV_LAND).unwrap();
    let (point, doing) = (at(0.0, 500.0), Doing::Mission);
    let start = Start::Air {
        point,
        height_m: 25.0,
        heading_deg: 180.0,
        airspeed_m_s: 16.0,
        index,
        doing,
        circled: Circled::Nothing,
    };
    let conditions = Conditions { start, ..Conditions::new(&plane, wind(0.0, 0.0)) };
    let asked = what_ifs(&plan, &conditions, &[Trigger::GoAround], &[0.0]).unwrap();
    let flown = asked[0].flown.as_ref().unwrap();
    let take_off_m = plan.mission.items[0].alt_m().unwrap();
    let turned = flown.track.iter().find(|sample| sample.bank_deg.abs() > 5.0).unwrap();
    assert!(turned.height_m > take_off_m, "{} of {take_off_m}", turned.height_m);
}

/// A flight that is rehearsed from the middle of a circle ends when the whole one did: what was flown of the circle is
/// not flown again.
#[test]
fn a_circle_goes_on_where_the_plane_is() {
    let centre = at(90.0, 800.0);
    let place = (centre.lat_deg(), centre.lon_deg());
    let plane = Aircraft::default();
    for circle in [
        MissionItem::loiter_turns(place.0, place.1, 80.0, 3.0, -80.0),
        MissionItem::loiter_time(place.0, place.1, 80.0, 75.0, true),
        MissionItem::loiter_to_alt(place.0, place.1, 130.0, 80.0),
    ] {
        let command = circle.command;
        let plan = plan(vec![takeoff(50.0), waypoint(45.0, 600.0, 80.0), circle, waypoint(120.0, 1_500.0, 80.0)]);
        let whole = rehearse(&plan, &Conditions::new(&plane, wind(300.0, 4.0))).unwrap();
        let circles = |sample: &&Sample| {
            sample.index == Some(2) && sample.bank_deg.abs() > 15.0 && distance_m(centre, sample.point) < 120.0
        };
        let begins_s = whole.track.iter().find(circles).unwrap().time_s;
        let left_s = whole.passages[2].reached_s.unwrap();
        for part in [0.2, 0.5, 0.8] {
            let now = whole.track.iter().find(|sample| sample.time_s >= begins_s + part * (left_s - begins_s)).unwrap();
            let mut turned_deg = 0.0;
            let mut before = None;
            for sample in whole.track.iter().filter(|sample| (begins_s..=now.time_s).contains(&sample.time_s)) {
                let bearing_deg = inverse(centre, sample.point).bearing_start_deg;
                turned_deg += before.map_or(0.0, |before| crate::geodesy::wrap_180_deg(bearing_deg - before));
                before = Some(bearing_deg);
            }
            let start = Start::Air {
                point: now.point,
                height_m: now.height_m,
                heading_deg: now.heading_deg,
                airspeed_m_s: now.airspeed_m_s,
                index: 2,
                doing: Doing::Mission,
                circled: Circled::Flown { turns: f64::abs(turned_deg) / 360.0, time_s: now.time_s - begins_s },
            };
            let rest = rehearse(&plan, &Conditions { start, ..Conditions::new(&plane, wind(300.0, 4.0)) }).unwrap();
            let off_s = now.time_s + rest.duration_s - whole.duration_s;
            assert!(off_s.abs() < 3.0, "{command:?} {part}: {off_s} s");
        }
    }
}

fn from_now(doing: Doing, settings: &[(&str, f64)], triggers: &[Trigger]) -> (Rehearsal, Vec<WhatIf>) {
    let plane =
        Aircraft::from_ardupilot(|name| settings.iter().find(|(known, _)| *known == name).map(|(_, value)| *value));
    let (plan, point) = (plan(with_landing()), at(45.0, 1_000.0));
    let start = Start::Air {
        point,
        height_m: 90.0,
        heading_deg: 10.0,
        airspeed_m_s: 22.0,
        index: 1,
        doing,
        circled: Circled::Nothing,
    };
    let conditions = Conditions { start, ..Conditions::new(&plane, wind(270.0, 5.0)) };
    (rehearse(&plan, &conditions).unwrap(), what_ifs(&plan, &conditions, triggers, &[0.0]).unwrap())
}

#[test]
fn a_plane_that_flies_no_mission_goes_on_as_its_mode_does() {
    let there = at(0.0, 600.0);
    let end = |flown: &Rehearsal| {
        let last = flown.track.last().unwrap();
        (distance_m(last.point, there), distance_m(last.point, HOME.point().unwrap()), last.height_m)
    };
    let (guided, asked) = from_now(Doing::Guided { to: there, height_m: 70.0 }, &[], &[Trigger::ReturnAsked]);
    let (off_m, _, height_m) = end(&guided);
    assert_eq!(guided.ending, Ending::Unlimited);
    assert!((off_m - 60.0).abs() < 25.0 && (height_m - 70.0).abs() < 4.0, "{off_m} {height_m}");
    assert_eq!(asked[0].flown.as_ref().unwrap().ending, Ending::Returned);
    let (returns, asked) = from_now(Doing::Returning, &[("RTL_AUTOLAND", 2.0)], &[Trigger::LinkLost]);
    assert_eq!((returns.ending, &asked[0].flown), (Ending::Landed, &None));
    let (returned, _) = from_now(Doing::Returning, &[], &[]);
    assert!(returned.ending == Ending::Returned && end(&returned).1 < 90.0);
    let (circles, _) = from_now(Doing::Circling, &[], &[]);
    assert_eq!(circles.ending, Ending::Unlimited);
    let (climbed, _) = from_now(Doing::TookOff { around: there, height_m: 70.0 }, &[], &[]);
    assert_eq!((climbed.ending, end(&climbed)), (Ending::Unlimited, end(&guided)));
    let (piloted, asked) = from_now(Doing::Piloted, &[], Trigger::ALL);
    assert_eq!(piloted.ending, Ending::NotRehearsed, "nobody knows what a pilot will do");
    let stopped = asked.last().unwrap().flown.as_ref().unwrap();
    assert_eq!(stopped.ending, Ending::Ground);
}

#[test]
fn failsafes_tell_the_modes_apart() {
    // As `ArduPlane/events.cpp` lists them: of the radio's two decisions, and of the station's.
    let hold = at(0.0, 600.0);
    let set = [("FS_GCS_ENABL", 1.0)];
    for (doing, radio, station) in [
        (Doing::Mission, [Reaction::GoesOn, Reaction::GoesOn], Reaction::GoesOn),
        (Doing::Guided { to: hold, height_m: 70.0 }, [Reaction::GoesOn, Reaction::GoesOn], Reaction::GoesOn),
        (Doing::Loitering { around: hold, height_m: 70.0 }, [Reaction::GoesOn, Reaction::Returns], Reaction::Returns),
        (Doing::Circling, [Reaction::GoesOn, Reaction::Returns], Reaction::Returns),
        (Doing::TookOff { around: hold, height_m: 70.0 }, [Reaction::GoesOn, Reaction::Returns], Reaction::Returns),
        (Doing::Piloted, [Reaction::Circles, Reaction::Returns], Reaction::Returns),
        (Doing::Soaring, [Reaction::GoesOn, Reaction::Returns], Reaction::Returns),
        (Doing::Returning, [Reaction::GoesOn, Reaction::GoesOn], Reaction::GoesOn),
    ] {
        let (_, asked) = from_now(doing, &set, &[Trigger::RadioLost, Trigger::LinkLost]);
        let decided = |asked: &WhatIf| asked.decisions.iter().map(|decision| decision.reaction).collect::<Vec<_>>();
        assert_eq!((decided(&asked[0]), decided(&asked[1])), (radio.to_vec(), vec![station]), "{doing:?}");
    }
    let mission = [("FS_GCS_ENABL", 3.0), ("FS_LONG_ACTN", 4.0)];
    let (_, none) = from_now(Doing::Piloted, &mission, &[Trigger::LinkLost]);
    assert!(none[0].decisions.is_empty(), "the station is missed in AUTO alone");
    let (_, joins) = from_now(Doing::Piloted, &mission[1..], &[Trigger::RadioLost]);
    assert_eq!(
        (joins[0].reaction(), joins[0].flown.as_ref().unwrap().ending),
        (Reaction::FliesMission, Ending::Landed)
    );
}

#[test]
fn what_is_left_of_the_battery_is_told_where_it_is_known() {
    let power = Airframe { power_cruise_w: Some(100.0), ..Aircraft::default().airframe };
    let left = |battery: Battery, airframe: Airframe| {
        let plane = Aircraft { airframe, battery, ..Aircraft::default() };
        let plan = plan(with_landing());
        let flown = rehearse(&plan, &Conditions::new(&plane, Air::default())).unwrap();
        (flown.battery, flown.energy_wh)
    };
    let whole = Battery { capacity_mah: Some(2_200.0), voltage_v: Some(11.1), ..Battery::default() };
    let (told, used_wh) = left(whole, power);
    let told = told.unwrap();
    assert!((told.capacity_wh - 24.42).abs() < 1e-9 && told.empty_s.is_none());
    assert!((told.left_wh - (24.42 - used_wh.unwrap())).abs() < 1e-9 && (0.2..1.0).contains(&told.left()), "{told:?}");
    // A fifth of it in, and it is empty on the way.
    let (told, _) = left(Battery { charge: 0.05, ..whole }, power);
    let told = told.unwrap();
    assert!(told.left_wh < 0.0 && told.is_below_reserve() && told.empty_s.unwrap() > 5.0, "{told:?}");
    assert!(told.empty_index.is_some());
    // Unknown values are not guessed.
    let lack = |battery: Battery, airframe: Airframe| left(battery, airframe).0.unwrap_err();
    assert_eq!(lack(whole, Aircraft::default().airframe), BatteryLack::Power);
    assert_eq!(lack(Battery { capacity_mah: None, ..whole }, power), BatteryLack::Capacity);
    assert_eq!(lack(Battery { voltage_v: None, ..whole }, power), BatteryLack::Voltage);
}

#[test]
fn a_battery_is_what_its_parameters_and_its_monitor_say() {
    let of = |set: &[(&str, f64)]| {
        Battery::from_ardupilot(|name| set.iter().find(|(known, _)| *known == name).map(|(_, value)| *value))
    };
    let set = [("BATT_CAPACITY", 5_000.0), ("BATT_LOW_MAH", 1_500.0), ("BATT_CRT_MAH", 500.0)];
    let battery = of(&set);
    assert_eq!((battery.capacity_mah, battery.reserve), (Some(5_000.0), 0.3));
    assert_eq!(of(&[("BATT_CAPACITY", 5_000.0), ("BATT_MONITOR", 0.0)]).capacity_mah, None);
    assert_eq!((of(&[]).capacity_mah, of(&[]).reserve), (None, 0.2));
    // The parameter is what the vehicle counts with; without it what was given tells it.
    let told = battery.as_told(Some(15.2), Some(1_000.0), Some(0.5));
    assert_eq!((told.capacity_mah, told.voltage_v, told.charge), (Some(5_000.0), Some(15.2), 0.5));
    let told = of(&[]).as_told(Some(15.2), Some(1_000.0), Some(0.5));
    assert_eq!(told.capacity_mah, Some(2_000.0));
    assert_eq!(of(&[]).as_told(None, Some(50.0), Some(0.98)).capacity_mah, None, "too little to tell");
    let said = BatterySettings { capacity_mah: Some(2_200.0), reserve_pct: Some(40.0), ..BatterySettings::default() };
    assert_eq!((battery.with(&said).capacity_mah, battery.with(&said).reserve), (Some(2_200.0), 0.4));
    assert_eq!(said.fault(), None);
    let drawn = Aircraft::default().with(None, Some(&BatterySettings { power_cruise_w: Some(120.0), ..said }));
    assert_eq!(drawn.airframe.power_cruise_w, Some(120.0));
    assert_eq!(drawn.with(None, Some(&said)).airframe.power_cruise_w, Some(120.0), "what nobody says stays");
    let none = BatterySettings { reserve_pct: Some(f64::NAN), ..said };
    assert_eq!(none.fault().unwrap().0, "reserve_pct");
    assert_eq!(Airframe { pitot: f64::NAN, ..Aircraft::default().airframe }.fault().unwrap().0, "pitot");
    assert_eq!(Aircraft::default().airframe.fault(), None);
    let less = Airframe { thrust_static_m_s2: Some(2.0), thrust_full_m_s2: 3.0, ..Aircraft::default().airframe };
    assert_eq!(less.fault(), Some(("thrust_static_m_s2", 2.0, (3.0, 60.0))));
}

#[test]
fn a_return_joins_the_nearest_leg_of_a_return_path() {
    let path = MissionItem::action(Command::DO_RETURN_PATH_START, [0.0; 4]);
    let mut items = vec![takeoff(50.0), waypoint(0.0, 2_500.0, 80.0), path, waypoint(330.0, 1_500.0, 80.0)];
    items.extend([waypoint(30.0, 1_500.0, 80.0), waypoint(90.0, 1_500.0, 80.0)]);
    items.extend(with_landing().split_off(3));
    let plane = Aircraft { autoland: Autoland::ReturnPath, ..Aircraft::default() };
    let plan = plan(items);
    let found = what_ifs(&plan, &Conditions::new(&plane, Air::default()), &[Trigger::ReturnAsked], &[60.0]).unwrap();
    let flown = found[0].flown.as_ref().unwrap();
    let joined: Vec<usize> = flown.passages.iter().map(|passage| passage.item).filter(|item| *item > 1).collect();
    // The path's first leg crosses 1,300 m north of home, where the plane is.
    assert_eq!((joined[0], flown.ending), (4, Ending::Landed), "{joined:?}");
}

#[test]
fn without_an_engine_the_plane_glides_as_far_as_its_polar_says() {
    let plane = Aircraft::default();
    let plan = plan(vec![takeoff(200.0), waypoint(0.0, 3_000.0, 200.0)]);
    let calm = Conditions::new(&plane, Air::default());
    let found = what_ifs(&plan, &calm, &[Trigger::EngineStopped], &[100.0]).unwrap();
    let stopped = &found[0];
    let flown = stopped.flown.as_ref().unwrap();
    assert_eq!((stopped.reaction(), flown.ending), (Reaction::GoesOn, Ending::Ground));
    let range = glide_range(&plan, &calm, &stopped.at).unwrap();
    let far = |range: &[GeoPoint], index: usize| distance_m(range[index], stopped.at.point);
    // C_D0 0.05 and C_Di 0.01 at C_L 0.45: the best L/D is 10.06, at 14.7 m/s EAS.
    assert!((far(&range, 0) / stopped.at.height_m - 10.06).abs() < 0.3, "{}", far(&range, 0) / stopped.at.height_m);
    assert!(far(&range, 36) < 0.95 * far(&range, 0), "a turn back costs height");
    assert!((far(&range, 18) - far(&range, 54)).abs() < 2.0);
    let windy = Conditions::new(&plane, wind(0.0, 7.0));
    let drifted = glide_range(&plan, &windy, &stopped.at).unwrap();
    assert!(far(&drifted, 0) < 0.6 * far(&range, 0) && far(&drifted, 36) > 1.3 * far(&range, 36));
    // What the autopilot makes of it without knowing lies within what is possible.
    let down = flown.touch_down.unwrap();
    assert!(distance_m(down.point, stopped.at.point) < far(&range, 0) + 5.0);
    let hill = |point: GeoPoint| Some(if point.lat_deg() > stopped.at.point.lat_deg() + 0.004 { 790.0 } else { 600.0 });
    let over = glide_range(&plan, &Conditions { ground: Some(&hill), ..calm }, &stopped.at).unwrap();
    assert!((400.0..520.0).contains(&far(&over, 0)), "{}", far(&over, 0));
    assert!((far(&over, 36) - far(&range, 36)).abs() < 1.0);
}

/// A ridge across the way north of home: 1,500 m away, 120 m high, 600 m wide on each side. A map that is 7 m off
/// everywhere.
fn ridge(point: GeoPoint) -> Option<f64> {
    let line = inverse(HOME.point().unwrap(), point);
    let north_m = line.distance_m * line.bearing_start_deg.to_radians().cos();
    let part = (1.0 - (north_m - 1_500.0).abs() / 600.0).max(0.0);
    (north_m < 3_600.0).then_some(607.0 + 120.0 * part)
}

fn over(items: Vec<MissionItem>, plane: &Aircraft, ground: &Ground<'_>) -> Rehearsal {
    let conditions = Conditions { ground: Some(ground), ..Conditions::new(plane, Air::default()) };
    rehearse(&plan(items), &conditions).unwrap()
}

/// A waypoint at a height above the ground.
fn above_ground(bearing_deg: f64, distance_m: f64, height_m: f64) -> MissionItem {
    MissionItem { frame: MavFrame::GlobalTerrainAlt, ..waypoint(bearing_deg, distance_m, height_m) }
}

#[test]
fn a_height_above_the_ground_is_held_over_a_ridge() {
    let plane = Aircraft::default();
    let items = vec![takeoff(50.0), above_ground(0.0, 400.0, 60.0), above_ground(0.0, 3_000.0, 60.0)];
    let flown = over(items.clone(), &plane, &ridge);
    assert_eq!(flown.home_above_ground_m, Some(-7.0));
    let leg: Vec<&Sample> = flown.track.iter().filter(|sample| sample.index == Some(2)).collect();
    let lowest = nearest_to_ground(leg.iter().copied()).unwrap();
    let low_m = lowest.clearance_m().unwrap();
    assert!((45.0..=60.5).contains(&low_m), "{lowest:?}");
    let top_m = leg.iter().map(|sample| sample.height_m).fold(0.0, f64::max);
    assert!((170.0..200.0).contains(&top_m), "{top_m}");
    assert!(flown.passages[2].height_error_m.unwrap().abs() < 5.0 && flown.passages[2].lacks_ground.is_none());
    // It climbs before the ground does, by what it can climb with half its rate; without looking ahead it does not.
    let foot = |flown: &Rehearsal| {
        let before =
            |sample: &&Sample| sample.index == Some(2) && distance_m(sample.point, HOME.point().unwrap()) < 890.0;
        flown.track.iter().filter(before).map(|sample| sample.height_m).fold(0.0, f64::max)
    };
    let blind = Aircraft { terrain_lookahead_m: 0.0, ..plane };
    let blindly = over(items.clone(), &blind, &ridge);
    assert!(foot(&flown) > foot(&blindly) + 10.0, "{} {}", foot(&flown), foot(&blindly));
    // From home it would have been a flight into the ridge.
    let from_home = vec![takeoff(50.0), waypoint(0.0, 400.0, 60.0), waypoint(0.0, 3_000.0, 60.0)];
    let into = over(from_home, &plane, &ridge);
    assert_eq!(into.ending, Ending::Ground);
    let down = into.touch_down.unwrap();
    assert!((1_150.0..1_250.0).contains(&distance_m(down.point, HOME.point().unwrap())), "{down:?}");
    assert!(down.clearance_m().unwrap().abs() < 2.0);
}

#[test]
fn the_ground_ahead_is_looked_at_within_bounds() {
    use std::sync::atomic::{AtomicU32, Ordering};
    let plane = Aircraft { terrain_lookahead_m: 1e9, terrain_spacing_m: 0.0, ..Aircraft::default() };
    let looks = AtomicU32::new(0);
    // A wall 2 km north, on the way to a place 4,000 km away.
    let wall = |point: GeoPoint| {
        assert!(looks.fetch_add(1, Ordering::Relaxed) < 100_000);
        Some(if distance_m(point, HOME.point().unwrap()) < 2_000.0 { 600.0 } else { 5_000.0 })
    };
    let flown = over(vec![takeoff(50.0), above_ground(0.0, 4e6, 60.0)], &plane, &wall);
    assert_eq!(flown.ending, Ending::Ground);
}

#[test]
fn ground_that_is_not_known_is_said_to_be() {
    let plane = Aircraft::default();
    let items = vec![takeoff(50.0), above_ground(0.0, 3_000.0, 90.0), above_ground(0.0, 4_500.0, 90.0)];
    let lacks = |plane: &Aircraft, ground: Option<&Ground<'_>>| {
        let conditions = Conditions { ground, ..Conditions::new(plane, Air::default()) };
        let flown = rehearse(&plan(items.clone()), &conditions).unwrap();
        flown.passages.iter().map(|passage| passage.lacks_ground).collect::<Vec<_>>()
    };
    // The ridge's map ends before the last item.
    assert_eq!(lacks(&plane, Some(&ridge))[..3], [None, None, Some(GroundLack::Unknown)]);
    assert_eq!(lacks(&plane, None)[..3], [None, Some(GroundLack::Unknown), Some(GroundLack::Unknown)]);
    let off = Aircraft { knows_terrain: false, ..plane };
    assert_eq!(lacks(&off, Some(&ridge))[1], Some(GroundLack::Off));
    // ArduPlane needs the ground at home as well.
    let but_home = |point: GeoPoint| ridge(point).filter(|_| distance_m(point, HOME.point().unwrap()) > 100.0);
    assert_eq!(lacks(&plane, Some(&but_home))[1], Some(GroundLack::Unknown));
}

#[test]
fn a_return_follows_the_ground_where_the_vehicle_is_set_to() {
    let get = |name: &str| match name {
        "TERRAIN_FOLLOW" => Some(16.0),
        "RTL_ALTITUDE" => Some(50.0),
        "TERRAIN_LOOKAHD" => Some(1_000.0),
        _ => None,
    };
    let plane = Aircraft::from_ardupilot(get);
    assert_eq!((plane.return_follows_terrain, plane.terrain_lookahead_m), (true, 1_000.0));
    let items = vec![takeoff(50.0), waypoint(0.0, 400.0, 100.0), waypoint(0.0, 2_900.0, 180.0)];
    let flown = over(items.clone(), &plane, &ridge);
    let back: Vec<&Sample> = flown.track.iter().filter(|sample| sample.index.is_none()).collect();
    let low_m = nearest_to_ground(back.iter().copied()).unwrap().clearance_m().unwrap();
    assert!(flown.ending == Ending::Returned && low_m > 35.0, "{low_m}");
    let straight = Aircraft { return_follows_terrain: false, ..plane };
    assert_eq!(over(items, &straight, &ridge).ending, Ending::Ground);
}

#[test]
fn a_plane_lands_where_its_landing_says_and_not_where_a_map_is_metres_off() {
    let options = LandingOptions { course_deg: Some(180.0), ..LandingOptions::default() };
    let landing = design_landing(HOME.point().unwrap(), &options).unwrap();
    let mut items = vec![takeoff(50.0), waypoint(180.0, 1_000.0, 80.0)];
    items.extend(landing.items);
    let level = over(items.clone(), &Aircraft::default(), &|_| Some(600.0));
    // Bumps of 4 m, every 100 m.
    let bumpy = |point: GeoPoint| Some(600.0 + 4.0 * (point.lat_deg() * 1_112.0).rem_euclid(1.0));
    let flown = over(items.clone(), &Aircraft::default(), &bumpy);
    assert_eq!((flown.ending, level.ending), (Ending::Landed, Ending::Landed));
    assert!(distance_m(flown.touch_down.unwrap().point, level.touch_down.unwrap().point) < 1.0);
    // A landing below the ground ends in it.
    let sunk = |point: GeoPoint| Some(if distance_m(point, HOME.point().unwrap()) > 900.0 { 600.0 } else { 640.0 });
    let land = |items: Vec<MissionItem>| over(items, &Aircraft::default(), &sunk).ending;
    let there = at(180.0, 3_000.0);
    let far = design_landing(there, &LandingOptions { ground_rel_home_m: Some(-40.0), ..options }).unwrap();
    let mut items = vec![takeoff(50.0), waypoint(180.0, 1_000.0, 80.0)];
    items.extend(far.items);
    assert_eq!(land(items.clone()), Ending::Landed, "the ground there is 40 m below home's");
    let too_low = MissionItem::land(there.lat_deg(), there.lon_deg(), -70.0);
    *items.last_mut().unwrap() = too_low;
    assert_eq!(land(items), Ending::Ground);
}

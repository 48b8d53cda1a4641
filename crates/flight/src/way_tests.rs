//! Tests of the way that is drawn: lengths, lines and circles, beside what the walk along a mission counts.

use super::*;
use crate::geodesy::{bearing_deg, polyline_length_m, wrap_180_deg};
use crate::plan::{Home, MavFrame};
use crate::progress::trip;
use crate::rehearsal::Aircraft;
use vencejo_proto::MissionSeq;

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690.0 };
const COPTER: ProgressOptions = ProgressOptions {
    loiter_radius_m: 60.0,
    climb_rate_m_s: 2.5,
    flies_arcs: true,
    own_speed_m_s: None,
    airspeed_min_m_s: None,
    airspeed_max_m_s: None,
};

fn home() -> GeoPoint {
    HOME.point().expect("on Earth")
}

fn at(bearing_deg: f64, distance_m: f64) -> GeoPoint {
    direct(home(), bearing_deg, distance_m)
}

fn item(command: Command, params: [f64; 4], point: GeoPoint, alt_m: f64) -> MissionItem {
    MissionItem::at(command, params, point.lat_deg(), point.lon_deg(), alt_m)
}

fn waypoint(point: GeoPoint) -> MissionItem {
    item(Command::NAV_WAYPOINT, [0.0; 4], point, 80.0)
}

fn turns(turns: f64, radius_m: f64, exit: f64) -> MissionItem {
    item(Command::NAV_LOITER_TURNS, [turns, 0.0, radius_m, exit], at(0.0, 1_000.0), 80.0)
}

fn way_of(items: Vec<MissionItem>, options: &ProgressOptions) -> Way {
    way(&Mission { home: Some(HOME), items }, 20.0, options)
}

fn line(leg: &Leg) -> Vec<GeoPoint> {
    let points = leg.lat_deg.iter().zip(&leg.lon_deg);
    points.map(|(lat_deg, lon_deg)| GeoPoint::new(*lat_deg, *lon_deg).expect("on Earth")).collect()
}

fn leg_of(way: &Way, index: usize) -> &Leg {
    way.stops[index].leg.as_ref().expect("a leg")
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a} and {b}");
}

#[test]
fn legs_say_where_they_come_from_and_what_they_are() {
    let items = vec![
        item(Command::NAV_TAKEOFF, [12.0, 0.0, 0.0, 0.0], at(270.0, 300.0), 50.0),
        MissionItem::change_airspeed(25.0),
        waypoint(at(0.0, 700.0)),
        waypoint(at(90.0, 700.0)),
        item(Command::NAV_LAND, [0.0; 4], at(90.0, 60.0), 0.0),
        MissionItem::return_to_launch(),
    ];
    let way = way_of(items, &ProgressOptions::default());
    let told: Vec<_> = way.stops.iter().map(|stop| (stop.item, stop.leg.as_ref().expect("a leg"))).collect();
    let kinds: Vec<_> = told.iter().map(|(item, leg)| (*item, leg.from_item, leg.kind)).collect();
    assert_eq!(
        kinds,
        [
            (1, None, LegKind::Takeoff),
            (3, Some(1), LegKind::Takeoff),
            (4, Some(3), LegKind::Flown),
            (5, Some(4), LegKind::Approach),
            (6, Some(5), LegKind::Return),
        ]
    );
    near(told[0].1.length_m, 300.0, 0.01);
    near(told[0].1.course_deg, 270.0, 0.01);
    assert_eq!(line(told[2].1).len(), 2);
    near(distance_m(line(told[4].1)[1], home()), 0.0, 0.02);
}

#[test]
fn the_vehicles_own_speed_comes_back() {
    let circle = MissionItem::loiter_time(at(0.0, 1_000.0).lat_deg(), at(0.0, 1_000.0).lon_deg(), 80.0, 100.0, true);
    let slow_and_back = [MissionItem::change_airspeed(12.0), MissionItem::change_airspeed(-2.0)];
    for (changes, length_m) in [(&slow_and_back[..1], 1_200.0), (&slow_and_back[..], 2_000.0)] {
        let way = way_of([changes, std::slice::from_ref(&circle)].concat(), &ProgressOptions::default());
        near(way.stops[0].loiter.expect("a circle").length_m.expect("a length"), length_m, 0.01);
    }
}

#[test]
fn without_home_it_begins_at_the_first_place_and_the_same_place_is_no_leg() {
    let items = vec![waypoint(at(0.0, 500.0)), waypoint(at(0.0, 500.0)), MissionItem::return_to_launch()];
    let way = way(&Mission { home: None, items }, 20.0, &ProgressOptions::default());
    assert_eq!(
        way.stops.iter().map(|stop| (stop.item, stop.leg.is_none())).collect::<Vec<_>>(),
        [(1, true), (2, true)]
    );
    assert_eq!(way_of(Vec::new(), &COPTER), Way::default());
}

#[test]
fn an_arc_turns_by_its_angle_and_ends_where_it_should() {
    let (from, to) = (at(0.0, 100.0), at(0.0, 500.0));
    for turn_deg in [90.0, -90.0, 180.0, 270.0, -300.0] {
        let items = vec![waypoint(from), item(Command::NAV_ARC_WAYPOINT, [turn_deg, 0.0, 0.0, 0.0], to, 80.0)];
        let way = way_of(items.clone(), &COPTER);
        let leg = leg_of(&way, 1);
        let points = line(leg);
        near(polyline_length_m(&points), leg.length_m, 0.005 * leg.length_m);
        let last = bearing_deg(points[points.len() - 2], to);
        let turned = last - bearing_deg(from, points[1]) - turn_deg * (1.0 - 1.0 / (points.len() - 1) as f64);
        near(wrap_180_deg(turned), 0.0, 0.2);
        near(distance_m(points[points.len() - 1], to), 0.0, 0.02);
        // what the walk counts
        let counted = trip(&Mission { home: Some(HOME), items }, Some(20.0), &COPTER);
        near(counted.distance_m.expect("an end"), 100.0 + leg.length_m, 0.5);
        // a plane passes over it
        let plane = way_of(
            vec![waypoint(from), item(Command::NAV_ARC_WAYPOINT, [turn_deg, 0.0, 0.0, 0.0], to, 80.0)],
            &ProgressOptions::default(),
        );
        assert_eq!(plane.stops.len(), 1);
    }
    for straight_deg in [0.0, 360.0] {
        let items = vec![waypoint(from), item(Command::NAV_ARC_WAYPOINT, [straight_deg, 0.0, 0.0, 0.0], to, 80.0)];
        let way = way_of(items, &COPTER);
        assert_eq!(line(leg_of(&way, 1)).len(), 2);
        near(leg_of(&way, 1).length_m, 400.0, 0.01);
    }
}

#[test]
fn a_radius_of_a_metre_and_less_is_none() {
    for (own_m, flown_m) in [(1.0, 60.0), (-1.0, -60.0), (0.0, 60.0), (-0.0, 60.0), (2.0, 2.0), (-45.0, -45.0)] {
        assert_eq!(own_radius_m(own_m), flown_m, "{own_m}");
        assert_eq!(
            Aircraft::from_ardupilot(|name| (name == "WP_LOITER_RAD").then_some(own_m)).loiter_radius_m,
            flown_m
        );
        let options = ProgressOptions { loiter_radius_m: own_m, ..ProgressOptions::default() };
        for item_m in [0.0, 1.0, -1.0, 0.4] {
            let mission = Mission { home: Some(HOME), items: vec![turns(3.0, item_m, 0.0)] };
            let loiter = way(&mission, 20.0, &options).stops[0].loiter.expect("a circle");
            let is_clockwise = flown_m > 0.0 && item_m >= 0.0;
            let found = (loiter.radius_m, loiter.is_clockwise, loiter.is_own_radius, loiter.is_estimate);
            assert_eq!(found, (flown_m.abs(), is_clockwise, false, true), "{own_m} {item_m}");
            let circles_m = 3.0 * std::f64::consts::TAU * flown_m.abs();
            near(loiter.length_m.expect("known"), circles_m, 0.01);
            near(trip(&mission, Some(20.0), &options).distance_m.expect("known"), 1_000.0 + circles_m, 0.1);
        }
    }
}

#[test]
fn circles_are_touched_in_their_sense_and_left_on_the_tangent_when_they_say_so() {
    for radius_m in [60.0, -60.0] {
        let way = way_of(vec![turns(1.0, radius_m, 1.0), waypoint(at(0.0, 3_000.0))], &ProgressOptions::default());
        let loiter = way.stops[0].loiter.expect("a circle");
        assert_eq!((loiter.radius_m, loiter.is_clockwise, loiter.is_own_radius), (60.0, radius_m > 0.0, true));
        let entry = *line(leg_of(&way, 0)).last().expect("an end");
        near(distance_m(entry, at(0.0, 1_000.0)), 60.0, 0.05);
        // flown northwards, a clockwise circle is passed on its left side: its centre lies on the right
        assert_eq!(entry.lon_deg() < home().lon_deg(), radius_m > 0.0);
        let exit = line(leg_of(&way, 1))[0];
        near(distance_m(exit, at(0.0, 1_000.0)), 60.0, 0.05);
        assert_eq!(exit.lon_deg() < home().lon_deg(), radius_m > 0.0);
        // lengths are those from place to place
        near(leg_of(&way, 0).length_m, 1_000.0, 0.01);
    }
    let way = way_of(vec![turns(1.0, 60.0, 0.0), waypoint(at(0.0, 3_000.0))], &ProgressOptions::default());
    near(distance_m(line(leg_of(&way, 1))[0], at(0.0, 1_000.0)), 0.0, 0.02);
    // from the inside there is no tangent
    let way = way_of(vec![turns(1.0, 5_000.0, 0.0)], &ProgressOptions::default());
    near(distance_m(*line(leg_of(&way, 0)).last().expect("an end"), at(0.0, 1_000.0)), 0.0, 0.02);
}

#[test]
fn circling_is_counted_as_the_walk_counts_it() {
    let own = |command, params| item(command, params, at(0.0, 1_000.0), 80.0);
    for (circle, kind, is_estimate) in [
        (turns(2.0, -100.0, 0.0), Circling::Turns, false),
        (turns(2.0, 0.0, 0.0), Circling::Turns, true),
        (own(Command::NAV_LOITER_TIME, [30.0, 0.0, -1.0, 0.0]), Circling::Time, true),
    ] {
        let found = way_of(vec![circle.clone()], &ProgressOptions::default());
        let loiter = found.stops[0].loiter.expect("a circle");
        assert_eq!((loiter.kind, loiter.is_estimate, loiter.changed_before), (kind, is_estimate, 1.0));
        let counted = trip(&Mission { home: Some(HOME), items: vec![circle] }, Some(20.0), &ProgressOptions::default());
        near(1_000.0 + loiter.length_m.expect("an end"), counted.distance_m.expect("an end"), 0.05);
        near(50.0 + loiter.time_s.expect("an end"), counted.time_s.expect("an end"), 0.05);
    }
    // 300 m up at 2.5 m/s are 120 s, of which 5 pass on the leg of 100 m
    let climb = item(Command::NAV_LOITER_TO_ALT, [0.0, 60.0, 0.0, 1.0], at(0.0, 1_100.0), 380.0);
    let found = way_of(vec![waypoint(at(0.0, 1_000.0)), climb.clone()], &ProgressOptions::default());
    let loiter = found.stops[1].loiter.expect("a circle");
    near(loiter.changed_before, 5.0 / 120.0, 1e-4);
    near(loiter.time_s.expect("an end"), 115.0, 0.01);
    // above the ground the distance is unknown
    let terrain = MissionItem { frame: MavFrame::GlobalTerrainAlt, ..climb };
    let found = way_of(vec![waypoint(at(0.0, 1_000.0)), terrain], &ProgressOptions::default());
    assert_eq!(found.stops[1].loiter.expect("a circle").length_m, None);
    let endless = own(Command::NAV_LOITER_UNLIM, [0.0, 0.0, -80.0, 0.0]);
    let loiter = way_of(vec![endless], &ProgressOptions::default()).stops[0].loiter.expect("a circle");
    assert_eq!((loiter.kind, loiter.is_clockwise, loiter.length_m), (Circling::Unlimited, false, None));
}

#[test]
fn a_spline_bends_between_its_neighbours() {
    let spline = |point| item(Command::NAV_SPLINE_WAYPOINT, [0.0; 4], point, 80.0);
    let items = vec![waypoint(at(0.0, 400.0)), spline(at(45.0, 800.0)), spline(at(90.0, 800.0))];
    let way = way_of(items, &ProgressOptions::default());
    let leg = leg_of(&way, 1);
    let length_m = polyline_length_m(&line(leg));
    assert!(length_m > leg.length_m * 1.001 && length_m < leg.length_m * 2.0, "{length_m}");
}

#[test]
fn jumps_lead_to_items_that_there_are() {
    let tag = MissionItem::action(Command::JUMP_TAG, [7.0, 0.0, 0.0, 0.0]);
    let to_tag = MissionItem::action(Command::DO_JUMP_TAG, [7.0, 1.0, 0.0, 0.0]);
    let items = vec![tag, waypoint(at(0.0, 500.0)), to_tag, MissionItem::jump(MissionSeq(9), 1)];
    assert_eq!(way_of(items, &COPTER).jumps, [Jump { item: 3, to_item: 1 }]);
}

#[test]
fn a_line_across_the_ocean_bends_on_the_map() {
    let items = vec![waypoint(at(270.0, 100_000.0))];
    assert_eq!(line(leg_of(&way_of(items, &COPTER), 0)).len(), 6);
}

#[test]
fn an_approach_tells_how_it_goes_down() {
    let descent = |high_m: f64, far_m: f64| {
        let high = item(Command::NAV_WAYPOINT, [0.0; 4], at(0.0, far_m), high_m);
        let land = item(Command::NAV_LAND, [0.0; 4], home(), 0.0);
        let way = way_of(vec![high, land], &ProgressOptions::default());
        assert_eq!(leg_of(&way, 0).descent, None, "no approach");
        leg_of(&way, 1).descent.map(|descent| (descent.drop_m, descent.is_doubtful))
    };
    assert_eq!(descent(40.0, 500.0), Some((40.0, false)));
    assert_eq!(descent(50.0, 500.0), Some((50.0, false)), "just as steep as may be");
    assert_eq!(descent(60.0, 500.0), Some((60.0, true)));
    assert_eq!(descent(0.0, 500.0), Some((0.0, true)), "level");
    let over_terrain = MissionItem { frame: MavFrame::GlobalTerrainAlt, ..waypoint(at(0.0, 500.0)) };
    let way = way_of(vec![over_terrain, item(Command::NAV_LAND, [0.0; 4], home(), 0.0)], &ProgressOptions::default());
    assert_eq!(leg_of(&way, 1).descent, None, "from another level");
}

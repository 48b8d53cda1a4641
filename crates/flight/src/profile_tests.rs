//! Tests of the height profile: heights at items and round circles, and the ground below.

use super::*;
use crate::progress::ProgressOptions;
use crate::way::way;

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690.0 };

fn at(bearing_deg: f64, distance_m: f64) -> GeoPoint {
    direct(HOME.point().expect("on Earth"), bearing_deg, distance_m)
}

fn item(command: Command, params: [f64; 4], point: GeoPoint, alt_m: f64) -> MissionItem {
    MissionItem::at(command, params, point.lat_deg(), point.lon_deg(), alt_m)
}

fn waypoint(distance_m: f64, alt_m: f64) -> MissionItem {
    item(Command::NAV_WAYPOINT, [0.0; 4], at(270.0, distance_m), alt_m)
}

/// Out to the west and back to a landing.
fn out_and_back() -> Vec<MissionItem> {
    let takeoff = item(Command::NAV_TAKEOFF, [12.0, 0.0, 0.0, 0.0], at(270.0, 300.0), 50.0);
    let land = item(Command::NAV_LAND, [0.0; 4], at(270.0, 300.0), 0.0);
    vec![takeoff, waypoint(1_300.0, 100.0), waypoint(3_300.0, 100.0), land]
}

fn over_terrain(item: MissionItem) -> MissionItem {
    MissionItem { frame: MavFrame::GlobalTerrainAlt, ..item }
}

/// Over a ground that is given by the distance from home.
fn over(items: Vec<MissionItem>, height_m: impl Fn(f64) -> Option<f64> + Sync) -> Profile {
    let mission = Mission { home: Some(HOME), items };
    let way = way(&mission, 20.0, &ProgressOptions::default());
    let home = HOME.point().expect("on Earth");
    profile(&mission, &way, &|point| height_m(distance_m(home, point)), 30.0)
}

fn flat(items: Vec<MissionItem>) -> Profile {
    over(items, |_| Some(690.0))
}

fn ground(items: Vec<MissionItem>, height_m: impl Fn(f64) -> Option<f64> + Sync) -> ProfileGround {
    over(items, height_m).ground.expect("home is known")
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a} and {b}");
}

#[test]
fn the_line_has_home_and_the_items_and_what_is_circled() {
    let turns = item(Command::NAV_LOITER_TURNS, [2.0, 0.0, 50.0, 0.0], at(270.0, 1_000.0), 80.0);
    let profile = flat(vec![turns, waypoint(2_000.0, 80.0)]);
    near(profile.length_m, 2_000.0 + 200.0 * std::f64::consts::PI, 0.2);
    let told: Vec<_> = profile.points.iter().map(|point| (point.item, point.is_item)).collect();
    assert_eq!(told, [(None, false), (Some(1), true), (Some(1), false), (Some(2), true)]);
    assert!(profile.points.iter().all(|point| point.is_certain && !point.is_beyond));
    let [circle] = profile.loiters[..] else { panic!("one circle: {:?}", profile.loiters) };
    assert_eq!((circle.item, circle.kind, circle.is_unknown), (1, Circling::Turns, false));
    near(circle.to_m - circle.from_m, 200.0 * std::f64::consts::PI, 0.2);
}

#[test]
fn the_height_of_a_climbing_circle_stands_where_it_is_reached() {
    let climb = item(Command::NAV_LOITER_TO_ALT, [0.0, 60.0, 0.0, 0.0], at(270.0, 1_100.0), 400.0);
    let points = flat(vec![waypoint(1_000.0, 100.0), climb]).points;
    let of_climb: Vec<_> = points.iter().filter(|point| point.item == Some(2)).collect();
    assert_eq!(of_climb.iter().map(|point| point.is_item).collect::<Vec<_>>(), [false, true]);
    assert!(of_climb[0].alt_rel_home_m > 100.0 && of_climb[0].alt_rel_home_m < 130.0, "{}", of_climb[0].alt_rel_home_m);
    assert_eq!(of_climb[1].alt_rel_home_m, 400.0);
}

#[test]
fn what_comes_after_a_circle_without_end_lies_beyond_and_guesses_are_called_so() {
    let wait = item(Command::NAV_LOITER_UNLIM, [0.0, 0.0, 60.0, 0.0], at(270.0, 1_000.0), 80.0);
    let profile = flat(vec![wait, waypoint(2_000.0, 80.0), MissionItem::return_to_launch()]);
    assert_eq!(profile.points.iter().map(|point| point.is_beyond).collect::<Vec<_>>(), [false, false, true, true]);
    assert_eq!(profile.loiters.len(), 1);
    assert!(!profile.loiters[0].is_unknown);
    // The height of a return is not in the plan.
    let last = profile.points.last().expect("points");
    assert_eq!((last.is_certain, last.alt_rel_home_m), (false, 80.0));

    let over_unknown = over(vec![over_terrain(waypoint(500.0, 60.0))], |_| None);
    assert_eq!((over_unknown.points[1].alt_rel_home_m, over_unknown.points[1].is_certain), (60.0, false));
    let mission = Mission { home: None, items: out_and_back() };
    let way = way(&mission, 20.0, &ProgressOptions::default());
    let homeless = profile_without_ground(&mission, &way);
    assert_eq!((homeless.points[0].item, homeless.ground), (Some(1), None));
    assert_eq!(profile_without_ground(&Mission::default(), &Way::default()), Profile::default());
}

fn profile_without_ground(mission: &Mission, way: &Way) -> Profile {
    profile(mission, way, &|_| None, 30.0)
}

#[test]
fn the_ground_is_looked_up_all_along_circles_included() {
    let turns = item(Command::NAV_LOITER_TURNS, [2.0, 0.0, 100.0, 0.0], at(270.0, 800.0), 80.0);
    let mission = Mission { home: Some(HOME), items: vec![turns, waypoint(1_600.0, 80.0)] };
    let way = way(&mission, 20.0, &ProgressOptions::default());
    let found = samples(&mission, &way);
    assert!(found.len() > 100 && found.len() < 500, "{}", found.len());
    assert!(found.windows(2).all(|pair| pair[0].distance_m <= pair[1].distance_m + 1e-6));
    let round: Vec<_> = found.iter().filter(|one| one.distance_m > 810.0 && one.distance_m < 1_400.0).collect();
    assert!(round.len() > 20, "{}", round.len());
    for one in round {
        near(distance_m(one.at, at(270.0, 800.0)), 100.0, 1.0);
    }
    near(found.last().expect("places").distance_m, flat(mission.items.clone()).length_m, 0.1);
    assert!(ground(out_and_back(), |_| Some(690.0)).distance_m.len() <= 410);

    // Once around one without end, and the shorter way over the date line.
    let wait = item(Command::NAV_LOITER_UNLIM, [0.0, 0.0, 60.0, 0.0], at(270.0, 800.0), 80.0);
    let told = ground(vec![wait], |_| Some(690.0));
    assert_eq!(told.distance_m.iter().filter(|distance_m| **distance_m > 799.9).count(), 39);
    let west = Home { lat_deg: -16.8, lon_deg: 179.98, alt_amsl_m: 5.0 };
    let mission = Mission { home: Some(west), items: vec![MissionItem::waypoint(-16.8, -179.98, 90.0)] };
    let way = crate::way::way(&mission, 20.0, &ProgressOptions::default());
    assert!(samples(&mission, &way).iter().all(|one| one.at.lon_deg().abs() > 179.97));
}

#[test]
fn the_plane_is_compared_with_the_ground_below_it() {
    // Flat, 10 m above the ground at home: the climb to 50 m ends 40 m above it, and it only gets higher from there.
    let told = ground(out_and_back(), |far_m| Some(if far_m < 1.0 { 690.0 } else { 700.0 }));
    assert_eq!((told.unknown, told.too_low.len()), (0, 0));
    near(told.lowest.expect("known").clearance_m, 40.0, 0.6);

    // A hill is reported once for the way out and once for the way back, counted from the ground at home whatever the
    // map is off there.
    for off_m in [0.0, 10.0] {
        let told = ground(out_and_back(), |far_m| {
            Some(690.0 + off_m + if far_m > 1_800.0 && far_m < 2_400.0 { 85.0 } else { 0.0 })
        });
        assert!((1_800.0..1_830.0).contains(&told.too_low[0].begin.distance_m), "{:?}", told.too_low);
        near(told.too_low[0].to_m, 2_400.0, 25.0);
        near(told.too_low[0].begin.clearance_m, 15.0, 0.01);
        assert_eq!((told.lowest.map(|lowest| lowest.clearance_m), told.ground_rel_home_m[0]), (Some(15.0), Some(0.0)));
    }
}

#[test]
fn a_climb_into_a_hill_is_told_and_the_error_of_a_map_at_home_is_not() {
    let hill = |far_m: f64| Some(if far_m > 100.0 && far_m < 200.0 { 760.0 } else { 690.0 });
    assert_eq!(ground(out_and_back(), hill).too_low.len(), 1);
    assert!(ground(out_and_back(), |_| Some(698.0)).too_low.is_empty());
}

#[test]
fn a_height_over_the_terrain_follows_it() {
    let mut items = out_and_back();
    items.truncate(2);
    items.push(over_terrain(waypoint(3_300.0, 100.0)));
    let slope = |far_m: f64| Some(690.0 + (far_m - 1_500.0).max(0.0) / 5.0);
    let profile = over(items, slope);
    let told = profile.ground.expect("home is known");
    assert!(told.too_low.is_empty(), "{:?}", told.too_low);
    let last = profile.points.last().expect("points");
    assert!(last.is_item && last.is_certain);
    near(last.alt_rel_home_m, 100.0 + 360.0, 0.01);
    let between: Vec<_> = profile.points.iter().filter(|point| point.item == Some(3) && !point.is_item).collect();
    assert!(between.len() > 50, "{}", between.len());
    assert!(between.iter().all(|point| point.distance_m > 1_300.0 && point.distance_m < last.distance_m));
    // 100 m above the ground all the way, since it began so.
    for point in between {
        let ground_m = ((point.distance_m - 1_500.0) / 5.0).max(0.0);
        near(point.alt_rel_home_m, 100.0 + ground_m, 0.6);
    }
}

#[test]
fn what_is_not_known_stays_unknown() {
    let told = ground(out_and_back(), |_| None);
    assert_eq!((told.lowest, told.unknown), (None, told.distance_m.len()));
    assert!(told.too_low.is_empty() && told.ground_rel_home_m.iter().all(Option::is_none));
    // Where only the end of a leg is known, that is.
    let told = ground(vec![over_terrain(waypoint(500.0, 20.0))], |far_m| (far_m > 499.0).then_some(690.0));
    assert_eq!(told.distance_m.len() - told.unknown, 1);
}

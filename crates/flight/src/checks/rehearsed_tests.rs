//! Tests of the findings from rehearsals: each provoked once, and flights without findings.

use super::*;
use crate::checks::{CheckContext, check_plan};
use crate::geodesy::direct;
use crate::landing::{LandingOptions, design_landing};
use crate::plan::{Fence, FenceShape, FenceZone, Home, Mission};
use crate::rehearsal::{Air, Aircraft};

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };

fn waypoint(bearing_deg: f64, distance_m: f64, height_m: f64) -> MissionItem {
    let point = direct(HOME.point().unwrap(), bearing_deg, distance_m);
    MissionItem::waypoint(point.lat_deg(), point.lon_deg(), height_m)
}

fn found(items: Vec<MissionItem>, fence: Fence, wind: Wind) -> Vec<(FindingCode, Option<usize>)> {
    let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
    let items = std::iter::once(takeoff).chain(items).collect();
    let plan = Plan { fence, ..Plan::from_mission(Mission { home: Some(HOME), items }) };
    let plane = Aircraft::default();
    let (_, found) = rehearse_and_check(&plan, &Conditions::new(&plane, Air::from(wind)), CLEARANCE_M).unwrap();
    found.iter().map(|finding| (finding.code(), finding.item)).collect()
}

#[test]
fn a_plan_that_can_be_flown_is_let_be() {
    let landing =
        design_landing(HOME.point().unwrap(), &LandingOptions { course_deg: Some(270.0), ..LandingOptions::default() });
    let items = [waypoint(0.0, 800.0, 70.0), waypoint(60.0, 1_500.0, 80.0)];
    let wind = Wind { from_deg: 280.0, speed_m_s: 5.0 };
    assert_eq!(found(items.into_iter().chain(landing.unwrap().items).collect(), Fence::default(), wind), []);
}

#[test]
fn what_the_lines_do_not_show_is_found() {
    let calm = Wind::default();
    let high = vec![waypoint(0.0, 800.0, 70.0), waypoint(0.0, 1_200.0, 300.0)];
    assert_eq!(found(high, Fence::default(), calm), [(FindingCode::HeightNotReached, Some(3))]);
    // Back past the start of the turn: 60 m are less than the plane can turn in.
    let narrow = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(3.4, 1_000.0, 60.0), waypoint(3.4, 900.0, 60.0)];
    let codes = found(narrow, Fence::default(), Wind { from_deg: 270.0, speed_m_s: 9.0 });
    assert!(codes.contains(&(FindingCode::WaypointMissed, Some(4))), "{codes:?}");
    // Passed abeam in a turn: counted as reached, and never near.
    let abeam = vec![
        waypoint(0.0, 1_000.0, 60.0),
        waypoint(6.84, 1_007.2, 60.0),
        waypoint(6.12, 1_126.4, 60.0),
        waypoint(24.06, 1_226.5, 60.0),
    ];
    let codes = found(abeam, Fence::default(), Wind { from_deg: 180.0, speed_m_s: 9.0 });
    assert!(codes.contains(&(FindingCode::WaypointMissed, Some(4))), "{codes:?}");
    // Without turns, short legs do not matter.
    let straight = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(0.0, 1_040.0, 60.0), waypoint(0.0, 1_500.0, 60.0)];
    let items = std::iter::once(MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0)).chain(straight.clone());
    let mission = Mission { home: Some(HOME), items: items.collect() };
    let short = |found: &[Finding]| found.iter().any(|finding| finding.code() == FindingCode::ShortLeg);
    let drawn = check_plan(&Plan::from_mission(mission), &CheckContext::default());
    assert!(short(&drawn) && found(straight, Fence::default(), calm).is_empty());
    assert!(!short(&with_flown(drawn, [])));
    let center = HOME.point().unwrap();
    let zone = FenceZone { inclusion: true, shape: FenceShape::Circle { center, radius_m: 1_030.0 } };
    let fence = Fence { zones: vec![zone], return_point: None };
    let near = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(-10.0, 990.0, 60.0)];
    let fast = Wind { from_deg: 180.0, speed_m_s: 9.0 };
    assert_eq!(found(near, fence, fast), [(FindingCode::LeavesFence, Some(3))]);
    let gale = Wind { from_deg: 0.0, speed_m_s: 30.0 };
    assert_eq!(found(vec![waypoint(0.0, 2_000.0, 60.0)], Fence::default(), gale), [(FindingCode::HeldByWind, Some(2))]);
    let land = MissionItem::land(HOME.lat_deg, HOME.lon_deg, 0.0);
    let steep = vec![waypoint(90.0, 1_500.0, 60.0), waypoint(90.0, 350.0, 60.0), land];
    let codes = found(steep, Fence::default(), Wind { from_deg: 90.0, speed_m_s: 6.0 });
    assert_eq!(codes, [(FindingCode::LandsOff, Some(4)), (FindingCode::LandsDownwind, Some(4))]);
}

#[test]
fn a_plan_from_a_hill_into_the_valley_meets_no_ground_that_is_not_known() {
    let valley = direct(HOME.point().unwrap(), 0.0, 3_000.0);
    let options = LandingOptions { course_deg: Some(0.0), ground_rel_home_m: Some(-80.0), ..LandingOptions::default() };
    let landing = design_landing(valley, &options).unwrap().items;
    let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
    let items: Vec<_> = [takeoff, waypoint(0.0, 2_000.0, -40.0)].into_iter().chain(landing).collect();
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    let plane = Aircraft::default();
    let over = |ground: Option<&crate::rehearsal::Ground<'_>>| {
        let conditions = Conditions { ground, ..Conditions::new(&plane, Air::default()) };
        let (flown, found) = rehearse_and_check(&plan, &conditions, CLEARANCE_M).unwrap();
        let errors = found.into_iter().filter(|finding| finding.severity == Severity::Error);
        (flown.ending, errors.map(|finding| (finding.code(), finding.item)).collect::<Vec<_>>())
    };
    assert_eq!(over(None), (Ending::Landed, vec![]));
    let flat = |_: GeoPoint| Some(600.0);
    assert_eq!(over(Some(&flat)), (Ending::Ground, vec![(FindingCode::FliesIntoGround, Some(2))]));
    let away_m = |point: GeoPoint| inverse(HOME.point().unwrap(), point).distance_m;
    let deep = |point: GeoPoint| Some(600.0 - (0.2 * (away_m(point) - 100.0)).clamp(0.0, 80.0));
    assert_eq!(over(Some(&deep)), (Ending::Landed, vec![]));
}

#[test]
fn a_battery_that_does_not_last_is_found() {
    use crate::rehearsal::{Airframe, Battery};
    let found = |charge: f64, power_w: Option<f64>| {
        let airframe = Airframe { power_cruise_w: power_w, ..Aircraft::default().airframe };
        let battery = Battery { capacity_mah: Some(2_200.0), voltage_v: Some(11.1), charge, ..Battery::default() };
        let plane = Aircraft { airframe, battery, ..Aircraft::default() };
        let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
        let items =
            vec![takeoff, waypoint(0.0, 2_000.0, 60.0), MissionItem::action(Command::NAV_RETURN_TO_LAUNCH, [0.0; 4])];
        let plan = Plan::from_mission(Mission { home: Some(HOME), items });
        rehearse_and_check(&plan, &Conditions::new(&plane, Air::default()), CLEARANCE_M).unwrap().1
    };
    assert_eq!(found(1.0, Some(100.0)), []);
    let low = found(0.5, Some(100.0));
    assert_eq!((low[0].code(), low[0].severity), (FindingCode::BatteryBelowReserve, Severity::Warning));
    assert!(low[0].message.contains("20 % should be"), "{}", low[0].message);
    let empty = found(0.05, Some(100.0));
    assert_eq!((empty[0].code(), empty[0].severity), (FindingCode::BatteryEmpty, Severity::Error));
    assert_eq!(found(0.05, None), [], "nothing is found where the power is not known");
}

#[test]
fn a_go_around_into_a_hill_is_found() {
    let plane = Aircraft::default();
    let options = LandingOptions { course_deg: Some(270.0), ..LandingOptions::default() };
    let landing = design_landing(HOME.point().unwrap(), &options).unwrap();
    let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
    let items: Vec<_> = [takeoff, waypoint(0.0, 800.0, 70.0)].into_iter().chain(landing.items).collect();
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    // A wall of a hill 120 m beyond the point, where only a plane that climbs away comes.
    let hill = |at: GeoPoint| {
        let line = inverse(HOME.point().unwrap(), at);
        let west_m = -line.distance_m * line.bearing_start_deg.to_radians().sin();
        Some(if west_m > 120.0 { 680.0 } else { 600.0 })
    };
    let conditions = Conditions {
        start: crate::rehearsal::Start::Ground { heading_deg: Some(90.0) },
        ..Conditions::new(&plane, Air::default())
    };
    let codes = |conditions: &Conditions<'_>| -> Vec<_> {
        let (_, found) = rehearse_and_check(&plan, conditions, CLEARANCE_M).unwrap();
        found.iter().map(|finding| (finding.code(), finding.item)).collect()
    };
    let about = (FindingCode::GoAroundHitsGround, Some(5));
    assert!(!codes(&conditions).contains(&about));
    assert!(codes(&Conditions { ground: Some(&hill), ..conditions }).contains(&about));
}

#[test]
fn returns_from_the_way_are_looked_at() {
    // Round a hill of 120 m and a zone to keep out of, 1 km north; home is flat.
    let way = [(60.0, 1_200.0), (0.0, 2_400.0), (-60.0, 1_200.0)];
    let items = way.map(|(bearing_deg, distance_m)| waypoint(bearing_deg, distance_m, 80.0));
    let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
    let items: Vec<MissionItem> = std::iter::once(takeoff).chain(items).collect();
    let center = direct(HOME.point().unwrap(), 0.0, 1_000.0);
    let zone = FenceZone { inclusion: false, shape: FenceShape::Circle { center, radius_m: 200.0 } };
    let fence = Fence { zones: vec![zone], return_point: None };
    let plan = Plan { fence, ..Plan::from_mission(Mission { home: Some(HOME), items }) };
    let hill =
        |point: GeoPoint| Some(600.0 + if crate::geodesy::distance_m(point, center) < 150.0 { 120.0 } else { 0.0 });
    let plane = Aircraft::default();
    let codes = |conditions: &Conditions<'_>| -> Vec<(FindingCode, Option<usize>)> {
        let (_, found) = rehearse_and_check(&plan, conditions, CLEARANCE_M).unwrap();
        found.iter().map(|finding| (finding.code(), finding.item)).collect()
    };
    let flat = Conditions::new(&plane, Air::default());
    let across = codes(&flat);
    assert!(across.contains(&(FindingCode::ReturnLeavesFence, Some(3))), "{across:?}");
    assert!(across.iter().all(|(code, _)| *code == FindingCode::ReturnLeavesFence), "{across:?}");
    let into = codes(&Conditions { ground: Some(&hill), ..flat });
    assert!(into.iter().any(|(code, _)| *code == FindingCode::ReturnHitsGround), "{into:?}");
    let higher = Aircraft { return_height_m: 150.0, ..plane };
    let over = codes(&Conditions { ground: Some(&hill), plane: &higher, ..flat });
    assert!(over.iter().all(|(code, _)| *code != FindingCode::ReturnHitsGround), "{over:?}");
}

#[test]
fn the_whole_flight_is_held_against_the_fence() {
    let way = || [(30.0, 900.0), (12.0, 2_400.0), (0.0, 2_600.0)].map(|(to, far_m)| waypoint(to, far_m, 80.0)).to_vec();
    let center = direct(HOME.point().unwrap(), 0.0, 1_000.0);
    let around = |radius_m: f64| {
        let zone = FenceZone { inclusion: false, shape: FenceShape::Circle { center, radius_m } };
        Fence { zones: vec![zone], return_point: None }
    };
    let calm = Wind::default();
    // The way back, which the mission asks for or which is flown after its last item, goes through a zone that is
    // crossed in 4 s.
    let asked = [way(), vec![MissionItem::return_to_launch()]].concat();
    assert!(found(asked, around(45.0), calm).contains(&(FindingCode::LeavesFence, Some(5))));
    assert!(found(way(), around(45.0), calm).contains(&(FindingCode::LeavesFence, Some(4))));
    // As wide a zone on the way back from the moments of the last leg but one.
    let landing = design_landing(
        direct(HOME.point().unwrap(), 270.0, 3_000.0),
        &LandingOptions { course_deg: Some(180.0), ..LandingOptions::default() },
    );
    let elsewhere = [way(), landing.unwrap().items].concat();
    let codes = found(elsewhere, around(45.0), calm);
    assert!(codes.contains(&(FindingCode::ReturnLeavesFence, Some(4))), "{codes:?}");
    assert!(codes.iter().all(|(code, _)| *code != FindingCode::LeavesFence), "{codes:?}");
}

#[test]
fn what_is_broken_before_any_item_is_told_of_the_way_home() {
    // Nothing to fly: the plane circles over home.
    let speed = MissionItem::action(Command::DO_CHANGE_SPEED, [0.0, 20.0, -1.0, 0.0]);
    let center = HOME.point().unwrap();
    let zone = FenceZone { inclusion: true, shape: FenceShape::Circle { center, radius_m: 40.0 } };
    let fence = Fence { zones: vec![zone], return_point: None };
    let plan = Plan { fence, ..Plan::from_mission(Mission { home: Some(HOME), items: vec![speed] }) };
    let plane = Aircraft::default();
    let (_, found) = rehearse_and_check(&plan, &Conditions::new(&plane, Air::default()), CLEARANCE_M).unwrap();
    let codes: Vec<_> = found.iter().map(|finding| (finding.code(), finding.item)).collect();
    assert_eq!(codes, [(FindingCode::LeavesFence, None)]);
    assert!(found[0].message.contains("on the way to home the plane leaves"), "{}", found[0].message);
}

#[test]
fn the_ground_is_kept_away_from() {
    let calm = Air::default();
    let found_from = |height_m: f64, items: Vec<MissionItem>, ground: &crate::rehearsal::Ground<'_>| {
        let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, height_m, 12.0);
        let items = std::iter::once(takeoff).chain(items).collect();
        let plan = Plan::from_mission(Mission { home: Some(HOME), items });
        let plane = Aircraft::default();
        let conditions = Conditions { ground: Some(ground), ..Conditions::new(&plane, calm) };
        let (_, found) = rehearse_and_check(&plan, &conditions, CLEARANCE_M).unwrap();
        let of_flight = |finding: &Finding| finding.code() != FindingCode::ReturnHitsGround;
        let found = found.into_iter().filter(of_flight);
        found.map(|finding| (finding.item, finding.kind)).collect::<Vec<_>>()
    };
    let found = |items: Vec<MissionItem>, ground: &crate::rehearsal::Ground<'_>| found_from(50.0, items, ground);
    let away_m = |point: GeoPoint| inverse(HOME.point().unwrap(), point).distance_m;
    // A hill of 60 m, 2 km north of home, 300 m round.
    let top = direct(HOME.point().unwrap(), 0.0, 2_000.0);
    let hill = |point: GeoPoint| Some(600.0 + if inverse(top, point).distance_m < 300.0 { 60.0 } else { 0.0 });
    // Low all the way: the climb does not excuse that.
    let flat = |_: GeoPoint| Some(600.0);
    let creeping = vec![waypoint(0.0, 800.0, 20.0), waypoint(0.0, 2_000.0, 20.0), waypoint(90.0, 2_000.0, 20.0)];
    let creeping = found_from(20.0, creeping, &flat);
    assert!(matches!(creeping[..], [(Some(3), FindingKind::NearGround { .. }), (Some(4), _)]), "{creeping:?}");
    let high = || vec![waypoint(0.0, 800.0, 95.0), waypoint(0.0, 3_000.0, 95.0)];
    assert_eq!(found(high(), &hill), []);
    let [(Some(3), FindingKind::NearGround { clearance_m, wanted_m, lat_deg, .. })] =
        found(vec![waypoint(0.0, 800.0, 75.0), waypoint(0.0, 3_000.0, 75.0)], &hill)[..]
    else {
        panic!("15 m above the hill")
    };
    assert!((13.0..17.0).contains(&clearance_m) && wanted_m == 30.0, "{clearance_m}");
    assert!((lat_deg - top.lat_deg()).abs() < 0.003);
    let low = found(vec![waypoint(0.0, 800.0, 50.0), waypoint(0.0, 3_000.0, 50.0)], &hill);
    let [(Some(3), FindingKind::FliesIntoGround { lat_deg, .. })] = low[..] else { panic!("{low:?}") };
    assert!((lat_deg - top.lat_deg() + 0.0027).abs() < 0.0003, "at its foot");
    // Ground that rises as fast as the plane climbs after its take-off: half the height is not left.
    let rising = |point: GeoPoint| Some(600.0 + 0.08 * (away_m(point) - 200.0).clamp(0.0, 1_500.0));
    let codes: Vec<_> = found(high(), &rising).iter().map(|(item, kind)| (*item, kind.code())).collect();
    assert!(
        codes.contains(&(Some(2), FindingCode::NearGround)) || codes.contains(&(Some(3), FindingCode::FliesIntoGround)),
        "{codes:?}"
    );
    // Home far from the ground: everything above sea level is off.
    let sea = |_: GeoPoint| Some(0.0);
    assert_eq!(found(high(), &sea), [(None, FindingKind::HomeOffGround { difference_m: 600.0, is_above: true })]);
    let frame = crate::plan::MavFrame::GlobalTerrainAlt;
    let terrain = MissionItem { frame, ..waypoint(0.0, 800.0, 75.0) };
    let unknown = |point: GeoPoint| (away_m(point) < 300.0).then_some(600.0);
    assert_eq!(
        found(vec![terrain], &unknown),
        [(Some(2), FindingKind::GroundNotKnown { alt_m: Some(75.0), is_off: false })]
    );
}

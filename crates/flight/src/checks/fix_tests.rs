//! Tests of the remedies: each resolves its finding and brings no error.

use super::*;
use crate::checks::CLEARANCE_M;
use crate::landing::{Wind, design_landing};
use crate::plan::{Home, Mission};
use crate::rehearsal::{Air, Ground};
use vencejo_proto::MissionSeq;

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };
const CALM: Wind = Wind { from_deg: 0.0, speed_m_s: 0.0 };

fn home() -> GeoPoint {
    HOME.point().unwrap()
}

fn waypoint(bearing_deg: f64, distance_m: f64, height_m: f64) -> MissionItem {
    let point = direct(home(), bearing_deg, distance_m);
    MissionItem::waypoint(point.lat_deg(), point.lon_deg(), height_m)
}

fn landing(course_deg: f64, wind: Wind) -> Vec<MissionItem> {
    let options = LandingOptions { course_deg: Some(course_deg), wind: Some(wind), ..LandingOptions::default() };
    design_landing(home(), &options).unwrap().items
}

/// A take-off, then these; the fix of the finding of that code, verified independently of `fixes`.
fn fixed(
    code: FindingCode,
    items: Vec<MissionItem>,
    wind: Wind,
    context: CheckContext,
    ground: Option<&Ground<'_>>,
) -> (Plan, Fix) {
    let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
    let items = if code == FindingCode::NoTakeoff { items } else { std::iter::once(takeoff).chain(items).collect() };
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    let plane = Aircraft::default();
    let conditions = Some(Conditions { ground, ..Conditions::new(&plane, Air::from(wind)) });
    let inspection = Inspection { context, conditions, clearance_m: CLEARANCE_M };
    let before = inspection.findings(&plan);
    assert!(before.iter().any(|finding| finding.code() == code), "{code}: {before:?}");
    let all = fixes(&plan, &inspection);
    let fix = all.into_iter().find(|(finding, _)| finding.code() == code);
    let (_, fix) = fix.unwrap_or_else(|| panic!("{code}: nothing resolves it: {before:?}"));
    let after = fix.applied(&plan);
    let resolved = Inspection {
        context: CheckContext {
            finds_landing: if code == FindingCode::LandStartDisabled { Some(true) } else { context.finds_landing },
            ..context
        },
        ..inspection
    };
    let left = resolved.findings(&after);
    assert!(left.iter().all(|finding| finding.code() != code), "{code}: {fix:?}: {left:?}");
    let errors = |found: &[Finding]| found.iter().filter(|one| one.severity == Severity::Error).count();
    assert!(errors(&left) <= errors(&before), "{code}: {left:?}");
    (after, fix)
}

#[test]
fn what_is_told_resolves_the_finding_and_brings_no_error() {
    use FindingCode as Code;
    let wind = Wind { from_deg: 270.0, speed_m_s: 6.0 };
    let (any, on_ground) = (CheckContext::default(), CheckContext { on_ground: Some(true), ..CheckContext::default() });
    let round = || vec![waypoint(0.0, 800.0, 80.0), waypoint(60.0, 1_200.0, 80.0)];
    let with = |more: Vec<MissionItem>| round().into_iter().chain(more).collect::<Vec<_>>();
    let disabled = CheckContext { finds_landing: Some(false), ..any };
    let mut many = MissionItem::at(Command::NAV_LOITER_TURNS, [2.0, 0.0, 60.0, 1.0], 40.34, -3.79, 80.0);
    many.params[0] = Some(-4.0);
    let steep = || {
        vec![
            waypoint(90.0, 1_500.0, 60.0),
            waypoint(90.0, 350.0, 60.0),
            MissionItem::land(HOME.lat_deg, HOME.lon_deg, 0.0),
        ]
    };
    let missed = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(3.4, 1_000.0, 60.0), waypoint(3.4, 900.0, 60.0)];
    let cases = [
        (Code::EndlessJump, with(vec![MissionItem::jump(MissionSeq(2), -1)]), CALM, any),
        (Code::IdleJump, with(vec![MissionItem::jump(MissionSeq(4), 3), MissionItem::return_to_launch()]), CALM, any),
        (Code::NoLanding, round(), wind, any),
        (Code::NoTakeoff, with(landing(270.0, wind)), wind, on_ground),
        (
            Code::TakeoffTooLow,
            [vec![MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, -5.0, 12.0)], round()].concat(),
            CALM,
            any,
        ),
        (Code::LandsDownwind, with(landing(90.0, wind)), wind, any),
        (Code::SteepApproach, steep(), wind, any),
        (Code::LandStartDisabled, with(landing(270.0, wind)), wind, disabled),
        (Code::HeightNotReached, vec![waypoint(0.0, 800.0, 70.0), waypoint(0.0, 1_200.0, 300.0)], CALM, any),
        (Code::WaypointMissed, missed, Wind { from_deg: 270.0, speed_m_s: 9.0 }, any),
        (Code::ParamOutOfRange, with(vec![many]), CALM, any),
    ];
    for (code, items, wind, context) in cases {
        let (_, fix) = fixed(code, items, wind, context, None);
        assert!(!fix.message().is_empty());
        if code == Code::LandStartDisabled {
            assert_eq!(fix.message(), "set RTL_AUTOLAND to 2");
        }
    }
    let deep = vec![waypoint(0.0, 1_000.0, 50.0), waypoint(0.0, 2_000.0, -40.0), waypoint(90.0, 2_000.0, 60.0)];
    let flat = |_: GeoPoint| Some(600.0);
    fixed(Code::FliesIntoGround, deep, CALM, any, Some(&flat));
    let narrow = CheckContext { airspeed_min_m_s: Some(12.0), airspeed_max_m_s: Some(30.0), ..any };
    let (after, _) = fixed(Code::SpeedNotTaken, with(vec![MissionItem::change_airspeed(8.0)]), CALM, narrow, None);
    assert_eq!(after.mission.items[3].param(2), Some(12.0));
    // A hill of 60 m under the second leg.
    let top = direct(home(), 0.0, 2_000.0);
    let hill = |point: GeoPoint| Some(600.0 + if inverse(top, point).distance_m < 300.0 { 60.0 } else { 0.0 });
    let low = vec![waypoint(0.0, 800.0, 75.0), waypoint(0.0, 3_000.0, 75.0)];
    let (after, fix) = fixed(Code::NearGround, low, CALM, any, Some(&hill));
    assert_eq!((fix.first, fix.count), (1, 2));
    assert!(after.mission.items[1..].iter().all(|item| item.alt_m().unwrap() > 85.0));
}

#[test]
fn a_return_that_lands_is_flown_as_it_would_be() {
    // Straight from the far legs to the landing lies a ridge that the landing's height does not clear; over home the
    // way is free.
    let at = |north_m: f64, east_m: f64| direct(direct(home(), 0.0, north_m), 90.0, east_m);
    let ridge = |point: GeoPoint| {
        let [north_m, east_m, _] = crate::geodesy::LocalFrame::new(home(), 0.0).ned_m(point, 0.0);
        let is_ridge = (900.0..1_500.0).contains(&north_m) && (300.0..2_700.0).contains(&east_m);
        Some(if is_ridge { 770.0 } else { 600.0 })
    };
    let to = |north_m, east_m, height_m| {
        let point = at(north_m, east_m);
        MissionItem::waypoint(point.lat_deg(), point.lon_deg(), height_m)
    };
    let start = at(0.0, 1_500.0);
    let items = vec![
        MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 60.0, 12.0),
        to(1_200.0, -400.0, 100.0),
        to(2_600.0, 1_500.0, 100.0),
        to(1_200.0, -600.0, 100.0),
        to(0.0, -300.0, 80.0),
        MissionItem::land_start(start.lat_deg(), start.lon_deg(), 40.0),
        MissionItem::loiter_to_alt(start.lat_deg(), start.lon_deg(), 40.0, 100.0),
        MissionItem::land(at(0.0, 800.0).lat_deg(), at(0.0, 800.0).lon_deg(), 0.0),
    ];
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    let plane = Aircraft { return_height_m: 220.0, ..Aircraft::default() };
    let conditions = Some(Conditions { ground: Some(&ridge), ..Conditions::new(&plane, Air::from(CALM)) });
    let context = CheckContext { finds_landing: Some(false), ..CheckContext::default() };
    let all = fixes(&plan, &Inspection { context, conditions, clearance_m: CLEARANCE_M });
    let told = all.iter().find(|(finding, _)| finding.code() == FindingCode::LandStartDisabled);
    assert_eq!(told.map(|(_, fix)| fix.message()), Some("set RTL_AUTOLAND to 1".to_owned()));
}

#[test]
fn jumps_lead_where_they_led() {
    let items = vec![
        MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0),
        waypoint(0.0, 800.0, 80.0),
        waypoint(0.0, 1_600.0, 80.0),
        MissionItem::jump(MissionSeq(3), 2),
        MissionItem::jump(MissionSeq(2), 1),
    ];
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    let targets = |fix: &Fix| {
        let items = fix.applied(&plan).mission.items;
        items
            .iter()
            .filter(|item| item.command == Command::DO_JUMP)
            .map(|item| item.param(1).unwrap())
            .collect::<Vec<_>>()
    };
    let kind = || FixKind::DeleteItem {};
    let added = waypoint(90.0, 100.0, 50.0);
    assert_eq!(targets(&Fix { kind: kind(), first: 2, count: 0, items: vec![added.clone()] }), [4.0, 2.0]);
    assert_eq!(targets(&Fix { kind: kind(), first: 1, count: 1, items: vec![] }), [2.0, 2.0]);
    assert_eq!(targets(&Fix { kind: kind(), first: 1, count: 2, items: vec![added; 3] }), [3.0, 2.0]);
}

#[test]
fn what_cannot_be_resolved_is_not_told() {
    let wind = Wind { from_deg: 0.0, speed_m_s: 30.0 };
    let items = vec![MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0), waypoint(0.0, 2_000.0, 60.0)];
    let plan = Plan::from_mission(Mission { home: Some(HOME), items });
    let plane = Aircraft::default();
    let conditions = Some(Conditions::new(&plane, Air::from(wind)));
    let inspection = Inspection { context: CheckContext::default(), conditions, clearance_m: CLEARANCE_M };
    let found = inspection.findings(&plan);
    assert!(found.iter().any(|finding| finding.code() == FindingCode::HeldByWind));
    assert!(fixes(&plan, &inspection).iter().all(|(finding, _)| finding.code() != FindingCode::HeldByWind));
    // Nor without home, from which everything is laid out.
    let lost = Plan::from_mission(Mission { home: None, items: vec![waypoint(0.0, 800.0, 60.0)] });
    let inspection = Inspection { conditions: None, ..inspection };
    assert_eq!(fixes(&lost, &inspection), []);
}

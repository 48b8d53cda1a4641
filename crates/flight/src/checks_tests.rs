//! Tests of the checks: each finding provoked once, and a sound plan without findings.

use std::collections::HashSet;

use proptest::prelude::*;
use vencejo_proto::MissionSeq;

use super::*;
use crate::geodesy::direct;
use crate::plan::{Fence, FenceShape, FenceZone, MavFrame, Mission, Rally, RallyPoint};

const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };

fn at(bearing_deg: f64, distance_m: f64) -> GeoPoint {
    direct(HOME.point().unwrap(), bearing_deg, distance_m)
}

fn waypoint(bearing_deg: f64, distance_m: f64, alt_m: f64) -> MissionItem {
    let point = at(bearing_deg, distance_m);
    MissionItem::waypoint(point.lat_deg(), point.lon_deg(), alt_m)
}

/// A sound mission: up, round, and down on a slope of 7.5 %. Indices of `sound`: 0 take-off, 1 to 3
/// waypoints, 4 start of landing, 5 approach, 6 landing.
fn sound() -> Vec<MissionItem> {
    let takeoff = at(270.0, 300.0);
    let touch_down = at(90.0, 60.0);
    vec![
        MissionItem::takeoff(takeoff.lat_deg(), takeoff.lon_deg(), 60.0, 12.0),
        waypoint(270.0, 700.0, 80.0),
        waypoint(0.0, 700.0, 100.0),
        waypoint(90.0, 1_400.0, 70.0),
        MissionItem::land_start(0.0, 0.0, 0.0),
        waypoint(90.0, 600.0, 40.0),
        MissionItem::land(touch_down.lat_deg(), touch_down.lon_deg(), 0.0),
    ]
}

fn context() -> CheckContext {
    CheckContext { position: Some(HOME.point().unwrap()), on_ground: Some(true), ..CheckContext::default() }
}

fn plan(items: Vec<MissionItem>) -> Plan {
    Plan::from_mission(Mission { home: Some(HOME), items })
}

fn found(plan: &Plan) -> Vec<(FindingCode, Severity, Option<usize>)> {
    let findings = check_plan(plan, &context());
    #[cfg(feature = "describe")]
    findings.iter().for_each(assert_json);
    findings.into_iter().map(|f| (f.code(), f.severity, f.item.map(|number| number - 1))).collect()
}

/// As JSON a finding is its code, and its figures under their names.
#[cfg(feature = "describe")]
fn assert_json(finding: &Finding) {
    let told = serde_json::to_value(finding).expect("JSON");
    assert_eq!(told["code"], finding.code().as_str());
    let figures = finding.kind.figures().into_iter().map(|(name, figure)| {
        let value = match figure {
            Figure::Absent => serde_json::Value::Null,
            Figure::Flag(flag) => flag.into(),
            Figure::Count(count) => count.into(),
            Figure::Number(number) => number.into(),
            Figure::Word(word) => word.into(),
        };
        (name.to_owned(), value)
    });
    assert_eq!(told["figures"], serde_json::Value::Object(figures.collect()), "{finding}");
}

/// Changes the sound mission and expects exactly one finding.
fn check(change: impl FnOnce(&mut Vec<MissionItem>), code: FindingCode, severity: Severity, item: Option<usize>) {
    let mut items = sound();
    change(&mut items);
    assert_eq!(found(&plan(items)), [(code, severity, item)]);
}

#[test]
fn a_sound_plan_has_no_findings() {
    assert_eq!(check_plan(&plan(sound()), &context()), []);
}

#[test]
fn the_recorded_mission_is_accepted() {
    // captures/mission-upload-items.tlog, which a real ArduPlane flew
    let flown = "QGC WPL 110\n\
        0 1 0 16 0 0 0 0 40.3332 -3.7978 600 1\n1 0 3 22 12 0 0 0 40.3332 -3.8013352 60 1\n\
        2 0 3 16 0 0 0 0 40.3332 -3.806049 80 1\n3 0 3 16 0 0 0 0 40.3376915 -3.8084058 100 1\n\
        4 0 3 16 0 0 0 0 40.3412848 -3.8013352 100 1\n5 0 3 16 0 0 0 0 40.3394881 -3.7919078 90 1\n\
        6 0 3 16 0 0 0 0 40.3332 -3.7883725 80 1\n7 0 3 18 1 0 80 1 40.330505 -3.7907294 80 1\n\
        8 0 3 178 0 14 -1 0 0 0 0 1\n9 0 3 189 0 0 0 0 40.3323016 -3.7871941 60 1\n\
        10 0 3 16 0 0 0 0 40.3332 -3.7901401 40 1\n11 0 3 21 0 0 0 1 40.3332 -3.7970929 0 1\n";
    let plan = crate::formats::read_waypoints(flown.as_bytes()).unwrap().plan;
    assert_eq!(check_plan(&plan, &context()), []);
}

#[test]
fn values_and_commands() {
    use FindingCode::*;
    use Severity::{Error, Warning};
    check(|items| items[1].params[4] = Some(f64::NAN), BadValue, Error, Some(1));
    check(|items| items[2].params[6] = Some(90_000.0), BadValue, Error, Some(2));
    check(|items| items[2].frame = MavFrame::Other(1), BadValue, Error, Some(2));
    check(|items| items.insert(2, MissionItem::action(Command(82), [0.0; 4])), UnsupportedCommand, Error, Some(2));
    check(|items| items.insert(2, MissionItem::action(Command(5001), [0.0; 4])), UnsupportedCommand, Error, Some(2));
    check(|items| items.insert(2, MissionItem::action(Command(9999), [0.0; 4])), UnsupportedCommand, Error, Some(2));
    check(
        |items| items.insert(2, MissionItem::action(Command::CONDITION_YAW, [0.0; 4])),
        IgnoredCommand,
        Warning,
        Some(2),
    );
    check(
        |items| items.insert(2, MissionItem::action(Command::DO_VTOL_TRANSITION, [3.0, 0.0, 0.0, 0.0])),
        IgnoredCommand,
        Warning,
        Some(2),
    );
    check(|items| items[1].params[1] = Some(300.0), ParamOutOfRange, Error, Some(1));
    check(|items| items[1].params[1] = Some(2.5), ParamChanged, Warning, Some(1));
    check(|items| items[1].params[0] = Some(10.0), ParamChanged, Warning, Some(1));
    check(|items| items[1].params[6] = None, MissingPosition, Error, Some(1));
    // Commands that the vehicle executes give no finding.
    for command in [Command::DO_GIMBAL_MANAGER_PITCHYAW, Command::DO_GO_AROUND] {
        let mut items = sound();
        items.insert(2, MissionItem::action(command, [0.0; 4]));
        assert_eq!(found(&plan(items)), []);
    }
    let limits = CheckContext { airspeed_min_m_s: Some(12.0), airspeed_max_m_s: Some(30.0), ..context() };
    for (kind, speed_m_s, is_taken) in
        [(0.0, 12.0, true), (0.0, 8.0, false), (0.0, 30.5, false), (0.0, -2.0, true), (1.0, 8.0, true)]
    {
        let mut items = sound();
        items.insert(2, MissionItem::action(Command::DO_CHANGE_SPEED, [kind, speed_m_s, -1.0, 0.0]));
        assert_eq!(found(&plan(items.clone())), [], "limits that are not known");
        let codes: Vec<_> = check_plan(&plan(items), &limits).iter().map(Finding::code).collect();
        assert_eq!(codes, if is_taken { vec![] } else { vec![SpeedNotTaken] }, "{kind} {speed_m_s}");
    }
}

#[test]
fn places() {
    use FindingCode::*;
    use Severity::{Error, Warning};
    let moved = |index: usize, point: GeoPoint| {
        move |items: &mut Vec<MissionItem>| {
            items[index].params[4] = Some(point.lat_deg());
            items[index].params[5] = Some(point.lon_deg());
        }
    };
    check(|items| items[2].params[4..6].fill(Some(0.0)), ZeroCoordinates, Error, Some(2));
    check(|items| items[2].params[4..6].fill(None), MissingPosition, Error, Some(2));
    check(moved(2, at(0.0, 21_000.0)), FarFromHome, Warning, Some(2));
    check(moved(1, at(0.0, 6_000.0)), FarFirst, Warning, Some(1));
    check(moved(2, at(0.0, 201_000.0)), OutOfReach, Error, Some(2));
    check(moved(2, at(270.0, 730.0)), ShortLeg, Warning, Some(2));
    check(|items| items[2].params[6] = Some(0.0), BelowHome, Warning, Some(2));
    check(
        |items| {
            items[2].frame = MavFrame::Global;
            items[2].params[6] = Some(599.0);
        },
        BelowHome,
        Warning,
        Some(2),
    );
    // A landing lies on the ground; hardly so far below home.
    for (alt_amsl_m, is_told) in [(600.0, false), (555.0, false), (545.0, true), (0.0, true)] {
        let mut items = sound();
        let place = at(90.0, 400.0);
        items[6].params[4..7].copy_from_slice(&[place.lat_deg(), place.lon_deg(), alt_amsl_m].map(Some));
        items[6].frame = MavFrame::Global;
        assert_eq!(found(&plan(items)).contains(&(BelowHome, Warning, Some(6))), is_told, "{alt_amsl_m}");
    }
    // On the field of home it lies where the field is.
    for (height_m, is_told) in [(12.0, false), (-12.0, false), (50.0, true), (-20.0, true), (-600.0, true)] {
        let mut items = sound();
        let home = HOME.point().expect("a place");
        let place = [home.lat_deg(), home.lon_deg(), height_m];
        items[6].params[4..7].copy_from_slice(&place.map(Some));
        assert_eq!(found(&plan(items)).contains(&(LandingOffField, Error, Some(6))), is_told, "{height_m}");
    }
    // What follows a return is not flown.
    let mut items = sound();
    items.insert(2, MissionItem::return_to_launch());
    assert_eq!(found(&plan(items)), [(EndlessLoiter, Warning, Some(2))]);
    check(|items| items[0].params[6] = Some(0.0), TakeoffTooLow, Error, Some(0));
    check(|items| items[0].params[6] = None, MissingPosition, Error, Some(0));
    check(|items| items[0].params[5] = None, MissingPosition, Error, Some(0));
}

#[test]
fn beginning_and_end() {
    use FindingCode::*;
    use Severity::{Error, Warning};
    check(
        |items| {
            items.remove(0);
        },
        NoTakeoff,
        Error,
        Some(0),
    );
    check(|items| items.truncate(4), NoLanding, Warning, Some(3));
    check(
        |items| items.extend([waypoint(0.0, 900.0, 80.0), MissionItem::return_to_launch()]),
        ItemsAfterLanding,
        Warning,
        Some(6),
    );
    check(|items| items[2].command = Command::NAV_LOITER_UNLIM, EndlessLoiter, Warning, Some(2));
    check(|items| items[6] = MissionItem::return_to_launch(), LandStartWithoutLanding, Error, Some(4));
    check(|items| items[5].params[6] = Some(80.0), SteepApproach, Warning, Some(6));
    let flat = |items: &mut Vec<MissionItem>| (items[5].params[6], items[6].params[6]) = (Some(3.0), Some(5.0));
    check(flat, FlatApproach, Warning, Some(6));

    let mut items = sound();
    items.remove(0);
    let in_the_air = CheckContext { on_ground: Some(false), ..context() };
    assert_eq!(check_plan(&plan(items), &in_the_air), []);
    let mut waits_to_land = sound();
    waits_to_land[3].command = Command::NAV_LOITER_UNLIM;
    assert_eq!(found(&plan(waits_to_land)), [], "a return flies the landing sequence after it");
    let mut two_landings = sound();
    two_landings.extend_from_slice(&sound()[4..]);
    assert_eq!(found(&plan(two_landings)), []);
}

#[test]
fn a_landing_sequence_that_keeps_a_vehicle_from_arming_is_told() {
    let start = sound().iter().position(|item| item.command == Command::DO_LAND_START).expect("one");
    for (finds_landing, told) in [(None, vec![]), (Some(true), vec![]), (Some(false), vec![Some(start + 1)])] {
        let findings = check_plan(&plan(sound()), &CheckContext { finds_landing, ..context() });
        assert_eq!(findings.iter().map(|one| one.item).collect::<Vec<_>>(), told, "{findings:?}");
        assert!(findings.iter().all(|one| one.code() == FindingCode::LandStartDisabled), "{findings:?}");
    }
}

#[test]
fn what_waits_or_acts_needs_no_takeoff_before_it() {
    let delay = || MissionItem::action(Command::NAV_DELAY, [60.0, -1.0, -1.0, -1.0]);
    let script = || MissionItem::action(Command::NAV_SCRIPT_TIME, [1.0, 5.0, 0.0, 0.0]);
    let servo = || MissionItem::action(Command::DO_SET_SERVO, [7.0, 1_500.0, 0.0, 0.0]);
    // nothing is flown
    assert_eq!(found(&plan(vec![servo(), delay(), script()])), []);
    // waiting on the ground, and after the landing
    let mut items = sound();
    items.insert(0, delay());
    items.push(delay());
    assert_eq!(found(&plan(items)), []);
    // carried up by a balloon
    let mut items = sound();
    items[0] = MissionItem::action(Command::NAV_ALTITUDE_WAIT, [8_000.0, 50.0, 0.0, 0.0]);
    assert_eq!(found(&plan(items)), []);
}

#[test]
fn what_an_arduplane_takes_is_no_error() {
    use FindingCode::{IgnoredCommand, ParamOutOfRange, ZeroCoordinates};
    use Severity::Warning;
    // 16 bits of metres, flown as they are
    let mut items = sound();
    items[6].params[0] = Some(630.0);
    assert_eq!(found(&plan(items)), []);
    // kept as it is, though no value of a compass
    let mut items = sound();
    items.insert(2, MissionItem::action(Command::CONDITION_YAW, [640.0, 0.0, 1.0, 0.0]));
    assert_eq!(found(&plan(items)), [(IgnoredCommand, Warning, Some(2)), (ParamOutOfRange, Warning, Some(2))]);
    // any number above 0 says yes
    check(
        |items| {
            let point = at(45.0, 900.0);
            items.insert(3, MissionItem::loiter_turns(point.lat_deg(), point.lon_deg(), 100.0, 1.0, 80.0));
            items[3].params[3] = Some(2.0);
        },
        ParamOutOfRange,
        Warning,
        Some(3),
    );
    // where the plane is then
    check(|items| items[6].params[4..6].fill(Some(0.0)), ZeroCoordinates, Warning, Some(6));
    let home = |how| MissionItem {
        frame: MavFrame::Global,
        ..MissionItem::at(Command::DO_SET_HOME, [how, 0.0, 0.0, 0.0], 0.0, 0.0, 600.0)
    };
    let mut items = sound();
    items.insert(2, home(1.0));
    assert_eq!(found(&plan(items)), []);
    // 0/0/0 ends the pointing at a place
    let roi = |command, alt_m| MissionItem::at(command, [0.0; 4], 0.0, 0.0, alt_m);
    for command in [Command::DO_SET_ROI, Command::DO_SET_ROI_LOCATION] {
        let mut items = sound();
        items.insert(2, roi(command, 0.0));
        assert_eq!(found(&plan(items)), [], "{command:?}");
        // but at a height it is a place in the Atlantic
        check(|items| items.insert(2, roi(command, 50.0)), ZeroCoordinates, Severity::Error, Some(2));
    }
    // but home is not to be in the Atlantic
    check(|items| items.insert(2, home(0.0)), ZeroCoordinates, Severity::Error, Some(2));
}

#[test]
fn jumps() {
    use FindingCode::*;
    use Severity::{Error, Warning};
    let insert = |target, repeats| {
        move |items: &mut Vec<MissionItem>| items.insert(4, MissionItem::jump(MissionSeq(target), repeats))
    };
    let mut items = sound();
    insert(2, 3)(&mut items);
    assert_eq!(found(&plan(items)), []);
    check(insert(0, 1), JumpTarget, Error, Some(4));
    check(insert(99, 1), JumpTarget, Error, Some(4));
    check(insert(2, -1), EndlessJump, Warning, Some(4));
    check(insert(5, 2), IdleJump, Error, Some(4));
    // An endless jump already implies that the mission neither lands nor returns.
    let tag = MissionItem::action(Command::JUMP_TAG, [3.0, 0.0, 0.0, 0.0]);
    let back = MissionItem::action(Command::DO_JUMP_TAG, [3.0, -1.0, 0.0, 0.0]);
    let mut items = sound();
    items.truncate(3);
    items.insert(1, tag);
    items.push(back);
    assert_eq!(found(&plan(items)), [(EndlessJump, Warning, Some(4))]);
    check(
        |items| items.insert(4, MissionItem::action(Command::DO_JUMP_TAG, [3.0, 1.0, 0.0, 0.0])),
        JumpTarget,
        Error,
        Some(4),
    );
    check(
        |items| (0..16).for_each(|_| items.insert(4, MissionItem::jump(MissionSeq(2), 1))),
        TooManyJumps,
        Warning,
        None,
    );
}

#[test]
fn sizes() {
    assert_eq!(found(&Plan::default()), [(FindingCode::EmptyMission, Severity::Error, None)]);
    let rally =
        Rally { points: vec![RallyPoint { point: at(0.0, 100.0), alt_m: 60.0, frame: MavFrame::GlobalRelativeAlt }] };
    let rally_alone = Plan { rally, ..Plan::default() };
    assert_eq!(found(&rally_alone), [(FindingCode::EmptyMission, Severity::Warning, None)]);
    let mut items = sound();
    let more = std::iter::repeat_n(waypoint(0.0, 700.0, 100.0), 650);
    items.splice(2..2, more);
    assert_eq!(found(&plan(items)), [(FindingCode::TooManyItems, Severity::Error, None)]);
}

#[test]
fn fences() {
    use FindingCode::{AreaOutOfReach, BadFence, BadRally, LegCrossesFence, OutsideFence, ReturnPointOutsideFence};
    let circle = |inclusion, center, radius_m| FenceZone { inclusion, shape: FenceShape::Circle { center, radius_m } };
    let square = |inclusion, center: GeoPoint, half_deg: f64| FenceZone {
        inclusion,
        shape: FenceShape::Polygon {
            vertices: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                .map(|(lat, lon)| {
                    GeoPoint::new(center.lat_deg() + lat * half_deg, center.lon_deg() + lon * half_deg).unwrap()
                })
                .to_vec(),
        },
    };
    let home = HOME.point().unwrap();
    let fenced = |zone: FenceZone| Plan { fence: Fence { zones: vec![zone], return_point: None }, ..plan(sound()) };
    let codes = |zone| found(&fenced(zone)).into_iter().map(|(code, _, item)| (code, item)).collect::<Vec<_>>();
    assert_eq!(codes(circle(true, home, 2_000.0)), []);
    assert_eq!(codes(square(true, home, 0.05)), []);
    assert_eq!(codes(circle(true, home, 1_000.0)), [(OutsideFence, Some(3))]);
    assert_eq!(codes(square(true, home, 0.01)), [(OutsideFence, Some(3))]);
    // on the leg from item 1 (west) to item 2 (north)
    let middle = at(315.0, 495.0);
    assert_eq!(codes(circle(false, middle, 50.0)), [(LegCrossesFence, Some(2))]);
    assert_eq!(codes(square(false, middle, 0.0005)), [(LegCrossesFence, Some(2))]);
    assert_eq!(codes(circle(false, at(180.0, 500.0), 50.0)), []);
    let mut returns = fenced(circle(false, middle, 50.0));
    returns.mission.items.insert(2, MissionItem::return_to_launch());
    assert!(found(&returns).iter().all(|(code, ..)| *code != LegCrossesFence), "it never flies there");
    assert_eq!(codes(circle(true, at(0.0, 5_000.0), 1_000.0))[0], (OutsideFence, None));
    assert_eq!(codes(circle(true, home, 0.0)), [(BadFence, None)]);
    // Two fields of which one is enough where the vehicle takes their union.
    let zones = vec![circle(true, at(0.0, 5_000.0), 1_000.0), circle(true, home, 2_000.0)];
    let both = Fence { zones, return_point: None };
    let both = Plan { fence: both, ..plan(sound()) };
    let union = CheckContext { is_fence_union: true, ..context() };
    assert!(has_errors(&check_plan(&both, &context())) && check_plan(&both, &union).is_empty());
    // The point that a breach leads to.
    let returning = |zone: FenceZone, to: GeoPoint| {
        let fence = Fence { zones: vec![zone], return_point: Some((to, 60.0)) };
        found(&Plan { fence, ..plan(sound()) }).into_iter().map(|(code, ..)| code).collect::<Vec<_>>()
    };
    assert_eq!(returning(circle(true, home, 2_000.0), at(90.0, 1_900.0)), []);
    assert_eq!(returning(circle(true, home, 2_000.0), at(90.0, 2_100.0)), [ReturnPointOutsideFence]);
    assert_eq!(returning(circle(false, at(180.0, 500.0), 50.0), at(180.0, 480.0)), [ReturnPointOutsideFence]);
    assert_eq!(returning(circle(false, at(180.0, 500.0), 50.0), GeoPoint::new(0.0, 0.0).unwrap()), [BadFence]);

    let mut low = plan(sound());
    low.rally.points = vec![RallyPoint { point: home, alt_m: -5.0, frame: MavFrame::GlobalRelativeAlt }];
    assert_eq!(found(&low), [(BadRally, Severity::Warning, None)]);
    low.rally.points[0].alt_m = 40_000.0;
    assert_eq!(found(&low), [(BadRally, Severity::Error, None)]);
    low.rally.points[0].alt_m = f64::NAN;
    assert_eq!(found(&low), [(BadRally, Severity::Error, None)]);

    // Confused coordinates: no fence where it is wanted, and a return to another continent.
    let (away, swapped) = (at(0.0, 250_000.0), GeoPoint::new(home.lon_deg(), home.lat_deg()).unwrap());
    let far = |zone: FenceZone| {
        check_plan(&fenced(zone), &context()).into_iter().find(|found| found.kind.code() == AreaOutOfReach)
    };
    for (zone, km) in [(circle(false, away, 1_000.0), 249.0), (square(false, away, 0.1), 238.9)] {
        let Some(Finding {
            kind: FindingKind::AreaOutOfReach { fence_zone, distance_m, is_swapped, .. },
            severity,
            ..
        }) = far(zone)
        else {
            panic!("not told")
        };
        assert_eq!((fence_zone, is_swapped, severity), (Some(1), false, Severity::Warning));
        assert!((distance_m / 1_000.0 - km).abs() < 1.0, "{distance_m}");
    }
    assert!(far(circle(false, away, 60_000.0)).is_none(), "its edge is in reach");
    assert!(far(square(true, home, 5.0)).is_none(), "it is around home");
    assert!(far(square(false, at(0.0, 339_000.0), 3.0)).is_none(), "its long edge passes near home");
    let opposite =
        |east_deg: f64| GeoPoint::new(home.lat_deg() + east_deg.abs(), home.lon_deg() + 180.0 + east_deg).unwrap();
    let corners = [-0.1, 0.0, 0.1].map(opposite);
    let around_the_world = FenceZone { inclusion: false, shape: FenceShape::Polygon { vertices: corners.to_vec() } };
    assert!(far(around_the_world).is_some(), "its edges do not pass home");
    assert!(far(circle(false, swapped, 100.0)).is_some_and(|found| found.remedy.contains("swapped")));
    let mut lost = plan(sound());
    lost.rally.points = vec![RallyPoint { point: swapped, alt_m: 50.0, frame: MavFrame::GlobalRelativeAlt }];
    assert_eq!(found(&lost), [(AreaOutOfReach, Severity::Error, None)]);
    assert_eq!(returning(circle(true, home, 2_000.0), away), [AreaOutOfReach, ReturnPointOutsideFence]);

    let mut high = plan(sound());
    high.fence.return_point = Some((home, 90_000.0));
    assert_eq!(found(&high), [(BadFence, Severity::Error, None)]);
}

// fault 29: 200 and more unsafe plans, each refused, with its item and what to do
#[test]
fn two_hundred_unsafe_plans_are_refused_with_the_reason() {
    type Spoil = (&'static str, fn(&mut MissionItem));
    let at_items: [Spoil; 17] = [
        ("no number", |item| item.params[4] = Some(f64::NAN)),
        ("endless", |item| item.params[5] = Some(f64::INFINITY)),
        ("no height", |item| item.params[6] = Some(f64::NEG_INFINITY)),
        ("91° north", |item| item.params[4] = Some(91.0)),
        ("181° east", |item| item.params[5] = Some(181.0)),
        ("ninety kilometres up", |item| item.params[6] = Some(90_000.0)),
        ("ninety kilometres down", |item| item.params[6] = Some(-90_000.0)),
        ("nowhere", |item| item.params[4..7].fill(None)),
        ("0/0", |item| item.params[4..6].fill(Some(0.0))),
        ("without a longitude", |item| item.params[5] = None),
        ("local metres", |item| item.frame = MavFrame::Other(1)),
        ("an unknown frame", |item| item.frame = MavFrame::Other(200)),
        ("an unknown command", |item| item.command = Command(9_999)),
        ("a fence's corner", |item| item.command = Command(5_001)),
        ("a spline", |item| item.command = Command(82)),
        ("a jump to nowhere", |item| *item = MissionItem::jump(MissionSeq(99), 1)),
        ("a jump to home", |item| *item = MissionItem::jump(MissionSeq(0), 1)),
    ];
    // Missions of several lengths, spoiled at every place that has one.
    let mut refused = 0;
    for more in [0, 3, 9] {
        let mut whole = sound();
        whole.splice(2..2, (0..more).map(|n| waypoint(180.0 + f64::from(n) * 10.0, 900.0, 90.0)));
        assert!(!has_errors(&check_plan(&plan(whole.clone()), &context())), "{more}: as it is it can be sent");
        for (name, spoil) in at_items {
            for at in
                (0..whole.len()).filter(|at| whole[*at].has_position() && whole[*at].command != Command::DO_LAND_START)
            {
                // At 0/0 a take-off goes straight on, and a landing is where the plane is then.
                if name == "0/0" && (whole[at].command.is_takeoff() || whole[at].command.is_landing()) {
                    continue;
                }
                let mut items = whole.clone();
                spoil(&mut items[at]);
                let findings = check_plan(&plan(items), &context());
                assert!(has_errors(&findings), "{name} at item {at}: {findings:?}");
                let errors: Vec<_> = findings.iter().filter(|one| one.severity == Severity::Error).collect();
                let told = errors.iter().map(|one| one.to_string()).collect::<Vec<_>>();
                assert!(errors.iter().any(|one| one.item == Some(at + 1)), "{name} at item {at}: {told:?}");
                assert!(told.iter().all(|text| text.len() > 20), "{told:?}");
                refused += 1;
            }
        }
    }
    println!("{refused} unsafe plans");
    assert!(refused >= 200, "{refused}");
}

#[test]
fn messages_call_items_by_their_seq_and_say_what_to_do() {
    let mut items = sound();
    items[2].params[4..6].fill(Some(0.0));
    let findings = check_plan(&plan(items), &context());
    assert!(has_errors(&findings));
    assert_eq!(findings[0].to_string(), "item 3 (NAV_WAYPOINT) lies at 0/0, in the Atlantic: place it on the map");
}

#[test]
fn figures_have_names_and_units() {
    let mut items = sound();
    items[5].params[6] = Some(80.0);
    items[1].params[1] = Some(300.0);
    let findings = check_plan(&plan(items), &context());
    let figures: Vec<_> = findings.iter().map(|one| (one.code().as_str(), one.kind.figures())).collect();
    let [range, steep] = &figures[..] else { panic!("{figures:?}") };
    assert_eq!(range.0, "param-out-of-range");
    assert_eq!(range.1[0], ("param", Figure::Count(2)));
    assert_eq!(range.1[2], ("value", Figure::Number(300.0)));
    assert_eq!(steep.0, "steep-approach");
    assert_eq!(steep.1[0], ("drop_m", Figure::Number(80.0)));
    assert!(matches!(steep.1[2], ("wanted_length_m", Figure::Number(wanted)) if (wanted - 800.0).abs() < 1e-6));
    assert!(findings[1].message.ends_with("drops 80 m in 540 m; the plane will land long"), "{}", findings[1]);
    // not a number is reported as unknown
    assert_eq!(Figure::from(f64::NAN), Figure::Absent);
    assert_eq!(Figure::from(None::<usize>), Figure::Absent);
}

#[test]
fn arcs_are_passed_over_by_planes_alone() {
    let mut items = sound();
    items[2].command = Command::NAV_ARC_WAYPOINT;
    items[2].params[..4].copy_from_slice(&[Some(90.0), None, None, None]);
    let codes = |flies_arcs| {
        let context = CheckContext { flies_arcs, ..context() };
        check_plan(&plan(items.clone()), &context).iter().map(|one| one.code()).collect::<Vec<_>>()
    };
    assert_eq!(codes(false), [FindingCode::IgnoredCommand]);
    assert_eq!(codes(true), []);
}

#[test]
fn codes_are_unique() {
    let texts: HashSet<_> = FindingCode::ALL.iter().map(|code| code.as_str()).collect();
    assert_eq!(texts.len(), FindingCode::ALL.len());
}

proptest! {
    #[test]
    fn any_plan_is_checked(
        items in prop::collection::vec(
            (any::<u16>().prop_map(|n| n % 260), any::<u8>(), prop::array::uniform7(prop::option::of(any::<f64>()))),
            0..60,
        ),
    ) {
        let items: Vec<_> = items.into_iter().map(|(command, frame, params)| MissionItem {
            command: Command(command), frame: frame.into(), params, autocontinue: true,
        }).collect();
        let plan = plan(items);
        // whatever the checks let through can be sent
        if !has_errors(&check_plan(&plan, &context())) {
            let wire = plan.mission.to_wire(vencejo_proto::Address::new(1, 1), true);
            prop_assert!(wire.is_ok());
        }
        let _ = crate::progress::trip(&plan.mission, Some(20.0), &crate::progress::ProgressOptions::default());
    }
}

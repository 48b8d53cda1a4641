//! Courses and climbs for a plane in GUIDED, velocities for what hovers, and texts of our own.

use vencejo_proto::ComponentId;

use super::*;
use crate::telemetry::Severity;

const COPTER: u8 = 2;
const GUIDED_PLANE: u32 = 15;
const GUIDED_COPTER: u32 = 4;

fn flying(mav_type: u8, mode: u32) -> World<Station, Plane> {
    let mut plane = Plane::new();
    (plane.mav_type, plane.mode, plane.is_armed) = (mav_type, mode, true);
    let mut world = World::new(Station::new(), plane, Faults::default(), 1);
    wait(&mut world, 3_000);
    world
}

fn course(course_deg: f64) -> Request {
    Request::GuidedCourse { course_deg, accel_m_s2: 5.0 }
}

fn climb(alt_m: f64, rate_m_s: f64) -> Request {
    Request::GuidedClimb { alt_m, alt_frame: AltFrame::Amsl, rate_m_s: Some(rate_m_s), below_home: false }
}

fn velocity(forward_m_s: f64, down_m_s: f64) -> Request {
    Request::Velocity { forward_m_s, right_m_s: 1.0, down_m_s, yaw_rate_rad_s: -0.5 }
}

// An ArduPlane reads no speed from DO_REPOSITION, and drops the one that it has when the mode changes.
#[test]
fn a_speed_follows_the_go_to_of_a_plane() {
    const LOITER: u32 = 12;
    let mut request = reposition(40.334, -3.79, 80.0);
    let Request::Reposition { speed_m_s, .. } = &mut request else { unreachable!() };
    *speed_m_s = Some(14.0);
    assert_eq!(request.command(), Command::DO_REPOSITION, "what is unknown while nothing is answered");
    for (mav_type, mode, guided, speeds) in [(1, LOITER, GUIDED_PLANE, 1), (COPTER, 5, GUIDED_COPTER, 0)] {
        let mut world = flying(mav_type, mode);
        let before = world.plane.commands.len();
        assert_eq!(ask(&mut world, request.clone()), Ok(Reply::Done));
        assert_eq!(world.plane.mode, guided);
        let sent: Vec<_> = world.plane.commands[before..].iter().map(|sent| (sent.command, sent.params)).collect();
        assert_eq!(sent, vec![(Command::DO_CHANGE_SPEED.0, [0.0, 14.0, -1.0, 0.0, 0.0, 0.0, 0.0]); speeds]);
    }
    // A pilot who takes the plane meanwhile keeps his own speed.
    const AUTO: u32 = 10;
    let mut world = flying(1, GUIDED_PLANE);
    world.plane.unanswered = Some(Command::DO_CHANGE_SPEED);
    let id = start(&mut world, request);
    wait(&mut world, 300);
    world.plane.mode = AUTO;
    let ended = end(&mut world, id, 60);
    assert!(matches!(ended, Err(VehicleError::NotConfirmed { .. })), "{ended:?}");
    let speeds = world.plane.commands.iter().filter(|sent| sent.command == Command::DO_CHANGE_SPEED.0);
    assert_eq!(speeds.count(), 1);
}

#[test]
fn a_plane_in_guided_takes_courses_and_climbs() {
    let mut world = flying(1, GUIDED_PLANE);
    assert_eq!(ask(&mut world, course(359.999_999_999)), Ok(Reply::Done));
    assert_eq!(ask(&mut world, climb(700.0, 2.5)), Ok(Reply::Done));
    let [heading, altitude] = world.plane.ints[..] else { panic!("two commands: {:?}", world.plane.ints) };
    assert_eq!((heading.command, heading.params[0], heading.params[2]), (Command::GUIDED_CHANGE_HEADING.0, 0.0, 5.0));
    assert!((359.9..360.0).contains(&heading.params[1]), "below 360 in 32 bits too: {}", heading.params[1]);
    assert_eq!((altitude.command, altitude.frame), (Command::GUIDED_CHANGE_ALTITUDE.0, 0));
    assert_eq!((altitude.params[2], altitude.z), (2.5, 700.0));
}

#[test]
fn the_zeros_of_a_position_that_was_never_filled_in_are_refused() {
    let mut world = flying(1, GUIDED_PLANE);
    let home = |lat_deg, lon_deg| Request::SetHome { lat_deg, lon_deg, alt_amsl_m: lat_deg.map(|_| 0.0) };
    for request in [reposition(0.0, 0.0, 60.0), reposition(1e-9, -1e-9, 60.0), home(Some(0.0), Some(0.0))] {
        assert!(matches!(ask(&mut world, request), Err(VehicleError::InvalidValue { field: "lat_deg", .. })));
    }
    assert_eq!(world.plane.ints, [], "nothing was sent");
    for request in [reposition(0.0, 0.001, 60.0), home(Some(0.001), Some(0.0))] {
        let error = ask(&mut world, request).expect_err("far from there").to_string();
        assert!(error.starts_with("the distance from home"), "one zero is a place: {error}");
    }
    assert_eq!(ask(&mut world, home(None, None)), Ok(Reply::Done));
}

#[test]
fn what_the_mode_or_the_values_rule_out_is_not_sent() {
    let mut plane = flying(1, 10);
    let mut guided = flying(1, GUIDED_PLANE);
    let mut copter = flying(COPTER, 5);
    let mut refused = 0;
    for (world, requests) in [
        (&mut plane, vec![course(90.0), climb(700.0, 2.0), velocity(1.0, 0.0)]),
        (&mut copter, vec![velocity(1.0, 0.0), course(90.0)]),
    ] {
        for request in requests {
            assert!(matches!(ask(world, request), Err(VehicleError::InvalidValue { field: "the mode", .. })));
            refused += 1;
        }
    }
    for request in [course(360.0), course(-1.0), course(f64::NAN), climb(0.0, 2.0), climb(-1.0, 2.0), climb(90.0, 0.0)]
    {
        assert!(matches!(ask(&mut guided, request), Err(VehicleError::InvalidValue { .. })));
        refused += 1;
    }
    assert_eq!(refused, 11);
    for world in [&plane, &guided, &copter] {
        assert!(world.plane.ints.is_empty() && world.plane.velocities.is_empty());
    }
}

#[test]
fn a_copter_in_guided_takes_velocities_relative_to_its_heading() {
    let mut world = flying(COPTER, GUIDED_COPTER);
    assert_eq!(ask(&mut world, velocity(3.0, -1.0)), Ok(Reply::Done));
    wait(&mut world, 100);
    let [target] = &world.plane.velocities[..] else { panic!("one: {:?}", world.plane.velocities) };
    assert_eq!((target.vx, target.vy, target.vz, target.yaw_rate), (3.0, 1.0, -1.0, -0.5));
    // Position, acceleration and yaw are ignored: velocity and turn rate are not (MAVLink, POSITION_TARGET_TYPEMASK).
    assert_eq!((target.type_mask.bits(), target.coordinate_frame as u32), (0b0101_1100_0111, 9));
    for wrong in [velocity(f64::NAN, 0.0), velocity(51.0, 0.0), velocity(0.0, f64::INFINITY)] {
        assert!(matches!(ask(&mut world, wrong), Err(VehicleError::InvalidValue { .. })));
    }
    assert_eq!(world.plane.velocities.len(), 1);
}

#[test]
fn a_note_stands_beside_the_vehicles_texts_and_is_never_its_reason() {
    let mut world = connected();
    world.plane.refuses = Some(vec![]);
    let note = Request::Note { severity: Severity::WARNING, text: "refused:\n".to_owned() + &"x".repeat(600) };
    assert_eq!(ask(&mut world, note), Ok(Reply::Done));
    let kept = world.station.vehicle.texts().iter().last().expect("kept").clone();
    assert_eq!((kept.severity, kept.component), (Severity::WARNING, ComponentId::GROUND_STATION));
    assert!(kept.text.starts_with("refused:x") && kept.text.chars().count() < 500, "clean and short: {}", kept.text);
    assert!(world.station.events.contains(&VehicleEvent::Text(kept)));
    let error = ask(&mut world, ARM).expect_err("refused");
    assert!(matches!(&error, VehicleError::CommandRefused { reasons, .. } if reasons.is_empty()), "{error}");
}

//! What a plane says, by values that anybody can check.

use vencejo_flight::plan::{Home, Mission};
use vencejo_vehicle::modes::{FlightMode, ModeFamily};
use vencejo_vehicle::telemetry::{Attitude, GpsFix, HeartbeatState, Position};
use vencejo_vehicle::telemetry::{Sampled, Telemetry};

use super::*;
use crate::ros2::cdr::Cdr;
use crate::ros2::name::{Namespace, Place};

fn at(ms: u64) -> MonoTime {
    MonoTime::from_millis(ms)
}

fn sampled<T>(value: T, ms: u64) -> Option<Sampled<T>> {
    Some(Sampled { value, at: at(ms), invalid: false })
}

fn plane() -> Telemetry {
    Telemetry {
        position: sampled(
            Position {
                lat_deg: Some(40.001),
                lon_deg: Some(-3.0),
                alt_amsl_m: Some(650.0),
                alt_rel_home_m: Some(50.0),
                velocity_north_m_s: Some(20.0),
                velocity_east_m_s: Some(0.0),
                velocity_down_m_s: Some(-1.0),
                heading_deg: Some(0.0),
            },
            1_000,
        ),
        attitude: sampled(
            Attitude {
                roll_rad: Some(0.5),
                pitch_rad: Some(0.0),
                yaw_rad: Some(0.0),
                roll_rate_rad_s: Some(0.1),
                pitch_rate_rad_s: Some(0.2),
                yaw_rate_rad_s: Some(0.3),
            },
            900,
        ),
        ..Telemetry::default()
    }
}

const HOME: Home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };

fn gps(alt_ellipsoid_m: Option<f64>) -> Gps {
    Gps {
        fix: GpsFix(3),
        fix_name: GpsFix(3).name(),
        satellites: Some(10),
        hdop: Some(1.0),
        vdop: None,
        lat_deg: Some(40.0),
        lon_deg: Some(-3.0),
        alt_amsl_m: Some(649.0),
        alt_ellipsoid_m,
        groundspeed_m_s: None,
        course_deg: None,
        horizontal_accuracy_m: Some(2.0),
        vertical_accuracy_m: Some(3.0),
    }
}

fn with<T>(telemetry: &Telemetry, now_ms: u64, look: impl Fn(&Moment<'_>) -> T) -> T {
    let place = Place::new(Names::Mavros, &Namespace::default(), Some("plane7"), 1);
    let mission =
        Mission { home: None, items: vec![MissionItem::waypoint(40.001, -3.0, 80.0), MissionItem::return_to_launch()] };
    let (now, utc_ns) = (at(now_ms), 1_700_000_000_500_000_000);
    look(&Moment { telemetry, now, utc_ns, place: &place, home: Some(HOME), mission: Some(&mission) })
}

#[test]
fn a_plane_that_banks_to_the_right_rolls_positive_and_turns_clockwise() {
    let telemetry = plane();
    let said = with(&telemetry, 1_000, imu).expect("known").1;
    assert!((said.orientation.x - (0.25_f64.sin() * std::f64::consts::FRAC_PI_4.cos())).abs() < 1e-12);
    let rates = &said.angular_velocity;
    assert_eq!((rates.x, rates.y, rates.z), (0.1, -0.2, -0.3));
    assert_eq!(said.linear_acceleration_covariance[0], -1.0, "it is not told");
    assert_eq!(
        (said.header.stamp.sec, said.header.stamp.nanosec),
        (1_700_000_000, 400_000_000),
        "when it came, 0.1 s ago"
    );
    assert_eq!(said.header.frame_id, "plane7/base_link");

    let (_, odometry) = with(&telemetry, 1_000, odometry).expect("known");
    let place = &odometry.pose.pose.position;
    assert!(place.x.abs() < 1e-6 && (place.y - 111.0).abs() < 0.1 && place.z == 50.0, "{place:?}");
    // In the body: forward 20; what climbs at 1 m/s is seen by a plane on its right side partly to the left.
    let speed = &odometry.twist.twist.linear;
    let (left, up) = (0.5_f64.sin(), 0.5_f64.cos());
    assert!((speed.x - 20.0).abs() < 1e-9 && (speed.y - left).abs() < 1e-9 && (speed.z - up).abs() < 1e-9, "{speed:?}");
    let local = with(&telemetry, 1_000, velocity_local).expect("known").1.twist.linear;
    assert_eq!((local.x, local.y, local.z), (0.0, 20.0, 1.0));
}

#[test]
fn a_height_is_above_the_ellipsoid_or_not_a_number() {
    let mut telemetry = plane();
    let fix = with(&telemetry, 1_000, global).expect("known").1;
    assert!(fix.altitude.is_nan() && fix.position_covariance_type == 0 && fix.status.status == -2);
    telemetry.gps = sampled(gps(None), 1_000);
    assert!(with(&telemetry, 1_000, global).expect("known").1.altitude.is_nan(), "never above the sea");
    telemetry.gps = sampled(gps(Some(700.0)), 1_000);
    let fix = with(&telemetry, 1_000, global).expect("known").1;
    assert_eq!((fix.altitude, fix.latitude, fix.status.status), (701.0, 40.001, 0));
    assert_eq!((fix.position_covariance[4], fix.position_covariance[8], fix.position_covariance_type), (4.0, 9.0, 1));
    let raw = with(&telemetry, 1_000, raw_fix).expect("known").1;
    assert_eq!((raw.altitude, raw.position_covariance_type), (700.0, 2));
}

#[test]
fn nothing_is_said_that_is_not_known_or_old_or_was_said() {
    let empty = Telemetry::default();
    for names in [Names::Mavros, Names::ArduPilot] {
        let mut source = StateSource::new(topics(names));
        assert_eq!(with(&empty, 0, |_| 0), 0);
        let place = Place::new(names, &Namespace::default(), None, 1);
        let moment = |now: u64, telemetry| Moment {
            telemetry,
            now: at(now),
            utc_ns: 0,
            place: &place,
            home: None,
            mission: None,
        };
        assert!(source.due(&moment(0, &empty)).is_empty());
        let telemetry = plane();
        let said = |source: &mut StateSource, now| {
            let due = source.due(&moment(now, &telemetry));
            due.into_iter().map(|(index, _)| source.topics()[index].name).collect::<Vec<_>>()
        };
        let first = said(&mut source, 1_000);
        assert!(first.iter().any(|name| name.contains("imu")), "{first:?}");
        assert!(
            !first.iter().any(|name| *name == "pose/filtered" || *name == "/tf" || *name == "local_position/pose"),
            "no home: {first:?}"
        );
        assert!(said(&mut source, 2_000).is_empty(), "nothing is new");
        let mut late = StateSource::new(topics(names));
        assert!(said(&mut late, 60_000).is_empty(), "too old");
    }
}

/// What stays the same is said again after 5 s, for whoever came since; what changes within a second.
#[test]
fn a_mission_is_said_when_it_changes_and_again() {
    let mut telemetry = plane();
    let place = Place::new(Names::Mavros, &Namespace::default(), Some("plane7"), 1);
    let mut source = StateSource::new(topics(Names::Mavros));
    let index = source.topics().iter().position(|topic| topic.name == "mission/waypoints").expect("a topic");
    let mission = |alt_m: f64| Mission { home: Some(HOME), items: vec![MissionItem::waypoint(40.001, -3.0, alt_m)] };
    let mut said = |now: u64, mission: &Mission| {
        telemetry.heartbeat = heartbeat(now);
        let moment = Moment {
            telemetry: &telemetry,
            now: at(now),
            utc_ns: 0,
            place: &place,
            home: Some(HOME),
            mission: Some(mission),
        };
        let due = source.due(&moment).into_iter().find(|(due, _)| *due == index);
        due.map(|(_, bytes)| WaypointList::from_bytes(&bytes).expect("a list").waypoints)
    };
    let first = said(1_000, &mission(80.0)).expect("it is new");
    assert_eq!((first.len(), first[0].frame, first[0].z_alt, first[1].z_alt), (2, 0, 600.0, 80.0), "home is item 0");
    let times: Vec<_> = (1..=12).filter(|half| said(1_000 + half * 500, &mission(80.0)).is_some()).collect();
    assert_eq!(times, [10], "5 s later");
    assert!(said(7_500, &mission(90.0)).is_none(), "not each tick");
    assert_eq!(said(8_000, &mission(90.0)).map(|list| list[1].z_alt), Some(90.0));
    let none = Mission { home: None, items: Vec::new() };
    assert_eq!(said(9_000, &none).map(|list| list.len()), Some(0), "removed");
}

fn heartbeat(ms: u64) -> Option<Sampled<HeartbeatState>> {
    let mode = FlightMode { family: ModeFamily::ArduPlane, custom_mode: 10 };
    let (is_armed, system_status) = (true, SystemStatus::Active);
    sampled(
        HeartbeatState { mode, mode_number: 10, is_armed, system_status, mav_type: 1, autopilot: 3, base_mode: 217 },
        ms,
    )
}

#[test]
fn a_plane_that_is_lost_is_said_to_be() {
    let mut telemetry = plane();
    telemetry.heartbeat = heartbeat(1_000);
    let said = with(&telemetry, 1_000, state).expect("known").1;
    assert_eq!((said.connected, said.armed, said.mode.as_str(), said.system_status), (true, true, "AUTO", 4));
    let health = with(&telemetry, 1_000, diagnosis::of);
    assert_eq!(
        (health[0].level, health[0].name.as_str(), health[0].message.as_str()),
        (0, "plane7: Heartbeat", "AUTO, armed")
    );
    let said = with(&telemetry, 8_000, state).expect("known").1;
    assert_eq!((said.connected, said.armed, said.mode.as_str()), (false, false, ""));
    let health = with(&telemetry, 8_000, diagnosis::of);
    assert_eq!((health.len(), health[0].level, health[0].message.as_str()), (1, 3, "nothing heard for 7 s"));
    let way = with(&telemetry, 1_000, path).expect("known").1;
    assert_eq!(way.poses.len(), 1, "what has no place is no pose");
    assert_eq!(way.poses[0].pose.position.z, 80.0);
    assert!(with(&telemetry, 8_000, path).is_none());
}

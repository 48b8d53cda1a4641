//! Targets that no flight means are refused: out of reach, or under the ground. So is following a mission to them.

use vencejo_proto::dialect::{MavModeFlag, SET_MODE_DATA, TERRAIN_REPORT_DATA};

use super::*;

const HERE: (f64, f64) = (40.3340, -3.7990);

fn go_to(place: (f64, f64), alt_m: f64, alt_frame: AltFrame, below_home: bool) -> Request {
    match reposition(place.0, place.1, alt_m) {
        Request::Reposition { lat_deg, lon_deg, radius_m, turn, speed_m_s, change_mode, .. } => Request::Reposition {
            lat_deg,
            lon_deg,
            alt_m,
            alt_frame,
            radius_m,
            turn,
            speed_m_s,
            change_mode,
            below_home,
        },
        other => other,
    }
}

fn refusal(world: &mut Pair, request: Request) -> String {
    let sent = (world.plane.commands.len(), world.plane.ints.len());
    let error = ask(world, request).expect_err("refused").to_string();
    assert_eq!((world.plane.commands.len(), world.plane.ints.len()), sent, "{error}");
    error
}

#[test]
fn a_position_out_of_reach_is_refused_and_swapped_coordinates_are_told() {
    let mut world = connected();
    let swapped = refusal(&mut world, reposition(-3.7978, 40.3332, 80.0));
    assert!(swapped.contains("6639 km") && swapped.contains("are latitude and longitude swapped?"), "{swapped}");
    let far = refusal(&mut world, reposition(43.0, -8.0, 80.0));
    assert!(far.contains("at most 200 km") && !far.contains("swapped"), "{far}");
    let home = Request::SetHome { lat_deg: Some(-3.7978), lon_deg: Some(40.3332), alt_amsl_m: Some(600.0) };
    assert!(refusal(&mut world, home).contains("swapped?"));
    assert_eq!(ask(&mut world, reposition(42.1, -3.7978, 80.0)), Ok(Reply::Done), "196 km");
}

fn swapped_mission() -> Vec<MissionItem> {
    let takeoff = MissionItem::takeoff(40.3332, -3.7990, 50.0, 12.0);
    vec![takeoff, MissionItem::waypoint(-3.8030, 40.3340, 80.0), MissionItem::land(-3.7978, 40.3332, 0.0)]
}

fn put(items: Vec<MissionItem>) -> Request {
    Request::UploadPlan { kind: PlanKind::Mission, items, home: None, despite_findings: false }
}

fn starts() -> [Request; 6] {
    let raw = CommandLong { target: PLANE, command: Command::MISSION_START.0, confirmation: 0, params: [0.0; 7] };
    [
        mode("auto"),
        Request::SetMode { mode: ModeChoice::Custom(10) },
        Request::MissionStart { from_item: None },
        Request::MissionStart { from_item: Some(1) },
        Request::MissionResume,
        Request::RawCommandLong(raw),
    ]
}

// Before home and a position were heard, the checks could not judge it.
#[test]
fn a_mission_that_leads_out_of_reach_is_not_followed_whoever_sent_it() {
    let mut world = connected();
    ask(&mut world, put(swapped_mission())).expect("uploaded");
    for request in starts() {
        let error = refusal(&mut world, request);
        assert!(error.contains("item 2 of the mission") && error.contains("6639 km"), "{error}");
        assert!(error.contains("are latitude and longitude swapped?"), "{error}");
    }
    let auto =
        SET_MODE_DATA { custom_mode: 10, target_system: 1, base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED };
    let (auto, now) = (Message::Dialect(MavMessage::SET_MODE(auto)), world.now);
    let error = world.station.vehicle.on_sending(&auto, false, now).expect_err("held back");
    assert!(matches!(error, VehicleError::OutOfReach { item: 2, is_swapped: true, .. }), "{error}");

    // Armed in AUTO it would fly off; armed in another mode it flies what the pilot does.
    assert_eq!(ask(&mut world, ARM), Ok(Reply::Done));
    assert_eq!(ask(&mut world, Request::Disarm { force: false }), Ok(Reply::Done));
    world.plane.mode = 10;
    wait(&mut world, 2_000);
    assert!(refusal(&mut world, ARM).contains("item 2 of the mission"));
    assert_eq!(ask(&mut world, mode("FBWA")), Ok(Reply::Done));
    assert_eq!(ask(&mut world, Request::DespiteMixedPlan(Box::new(mode("auto")))), Ok(Reply::Done), "by override");
    assert_eq!(ask(&mut world, mode("FBWA")), Ok(Reply::Done));
    ask(&mut world, upload()).expect("corrected");
    assert_eq!(ask(&mut world, mode("auto")), Ok(Reply::Done));
}

#[test]
fn a_mission_is_not_started_before_its_distance_can_be_judged() {
    let mut world = connected();
    ask(&mut world, upload()).expect("uploaded");
    let unknown = |world: &mut Pair| {
        world.station.vehicle.telemetry.home = None;
        world.station.vehicle.telemetry.position = None;
    };
    for request in starts() {
        unknown(&mut world);
        assert!(refusal(&mut world, request).contains("where home is"));
    }
    // In flight it is not kept from its mission.
    world.plane.landed = MavLandedState::MAV_LANDED_STATE_IN_AIR;
    wait(&mut world, 2_000);
    unknown(&mut world);
    assert_eq!(ask(&mut world, mode("auto")), Ok(Reply::Done));
}

// Home lies at 600.09 m.
#[test]
fn an_altitude_far_below_home_is_refused_unless_it_is_meant() {
    let mut world = connected();
    for (alt_m, alt_frame, below) in [
        (100.0, AltFrame::Amsl, "500 m below home"),
        (-50.0, AltFrame::RelHome, "50 m below home"),
        (-30.0, AltFrame::Terrain, "30 m below the ground"),
    ] {
        let change = |below_home| Request::ChangeAltitude { alt_m, alt_frame, below_home };
        for request in [go_to(HERE, alt_m, alt_frame, false), change(false)] {
            let error = refusal(&mut world, request);
            assert!(error.contains(below) && error.contains("below_home"), "{error}");
        }
        assert_eq!(ask(&mut world, go_to(HERE, alt_m, alt_frame, true)), Ok(Reply::Done));
        assert_eq!(ask(&mut world, change(true)), Ok(Reply::Done));
    }
    for (alt_m, alt_frame) in [(-19.0, AltFrame::RelHome), (582.0, AltFrame::Amsl)] {
        assert_eq!(ask(&mut world, go_to(HERE, alt_m, alt_frame, false)), Ok(Reply::Done), "{alt_m}");
    }
}

#[test]
fn near_the_plane_the_ground_that_it_reports_decides() {
    let mut world = connected();
    let ground = |world: &mut Pair, terrain_height: f32| {
        let (lat, lon) = (403_332_000, -37_978_000);
        let report = TERRAIN_REPORT_DATA { lat, lon, spacing: 100, terrain_height, loaded: 9, ..Default::default() };
        let report = Message::Dialect(MavMessage::TERRAIN_REPORT(report));
        world.station.vehicle.on_message(PLANE.component, &report, world.now);
    };
    let (far, home) = ((40.3440, -3.7990), AltFrame::RelHome);
    ground(&mut world, 300.0);
    assert_eq!(ask(&mut world, go_to(HERE, -200.0, home, false)), Ok(Reply::Done), "100 m above the valley");
    assert!(refusal(&mut world, go_to(far, -200.0, home, false)).contains("200 m below home"));
    ground(&mut world, 900.0);
    let error = refusal(&mut world, go_to(HERE, 200.0, home, false));
    assert!(error.contains("100 m below the ground under the vehicle"), "{error}");
    let climb = Request::ChangeAltitude { alt_m: 200.0, alt_frame: home, below_home: false };
    assert!(refusal(&mut world, climb).contains("at most 20 m below it"));
    assert_eq!(ask(&mut world, go_to(far, 200.0, home, false)), Ok(Reply::Done));
    // 450 m down a slope of 20 % it is 60 m above the ground there, and 30 m below that under the plane.
    let downhill = (40.3332, -3.7978 + 0.0053);
    assert_eq!(ask(&mut world, go_to(downhill, 270.0, home, false)), Ok(Reply::Done));
}

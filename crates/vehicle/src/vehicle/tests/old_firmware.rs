//! The aggregate against ArduPlane 3.x on an APM 2: MAVLink 1 and nothing that is younger than it.

use std::time::Duration;

use vencejo_flight::plan::{Command, MissionItem, PlanKind};
use vencejo_proto::dialect::MavDataStream;
use vencejo_proto::{MavVersion, MissionSeq, MonoTime};

use super::{ARM, Station, mode};
use crate::choice::{AltFrame, Turn};
use crate::command::CommandResult;
use crate::error::VehicleError;
use crate::plan_state::PlanState;
use crate::request::{Reply, Request, RequestId, VehicleEvent};
use crate::transfer::testing::{Faults, OldPlane, World};
use crate::transfer::{NoPlanKinds, TransferError};

type Pair = World<Station, OldPlane>;

const COMMAND_INT: u32 = 75;
const MISSION_ITEM: u32 = 39;
const SET_MODE: u32 = 11;

/// Ids that its firmware does not know.
const YOUNGER: [u32; 3] = [73, 51, 110];

fn connect(plane: OldPlane, faults: Faults, seed: u64) -> Pair {
    let mut world = World::new(Station::new(), plane, faults, seed);
    world.version = MavVersion::V1;
    world.station.vehicle.on_protocol_version(MavVersion::V1);
    wait(&mut world, 8_000);
    world
}

fn connected() -> Pair {
    connect(OldPlane::new(), Faults::default(), 1)
}

fn wait(world: &mut Pair, ms: u64) {
    let until = world.now + Duration::from_millis(ms);
    world.run(until, |_, _| false);
}

fn start(world: &mut Pair, request: Request) -> RequestId {
    let now = world.now;
    world.station.vehicle.request(request, now)
}

fn ask(world: &mut Pair, request: Request) -> Result<Reply, VehicleError> {
    let id = start(world, request);
    let until = world.now + Duration::from_secs(300);
    assert!(world.run(until, |station, _| station.results.contains_key(&id)), "no result");
    world.station.results[&id].clone()
}

/// What ArduPlane 3.x can hold.
fn mission() -> Vec<MissionItem> {
    vec![
        MissionItem::takeoff(40.333_212_3, -3.799_012_3, 50.0, 12.0),
        MissionItem::waypoint(40.334_034_5, -3.803_056_7, 80.5),
        MissionItem::change_airspeed(14.0),
        MissionItem::loiter_turns(40.335_078_9, -3.800_011_1, 80.0, 2.0, -60.0),
        MissionItem::loiter_unlimited(40.336_022_2, -3.801_033_3, 80.0, 0.0),
        MissionItem::jump(MissionSeq(2), 3),
        MissionItem::land(40.333_244_4, -3.797_855_5, 0.0),
    ]
}

fn upload(kind: PlanKind, items: Vec<MissionItem>) -> Request {
    Request::UploadPlan { kind, items, home: None, despite_findings: false }
}

fn go_to(change_mode: bool) -> Request {
    Request::Reposition {
        lat_deg: 40.340_012_3,
        lon_deg: -3.800_045_6,
        alt_m: 90.0,
        alt_frame: AltFrame::RelHome,
        radius_m: None,
        turn: Turn::Clockwise,
        speed_m_s: None,
        change_mode,
        below_home: false,
    }
}

#[test]
fn its_telemetry_is_asked_for_by_streams() {
    let world = connected();
    assert!(world.station.events.contains(&VehicleEvent::StreamsFellBack));
    assert!(world.plane.streams.contains(&MavDataStream::MAV_DATA_STREAM_POSITION));
    let vehicle = &world.station.vehicle;
    assert!(vehicle.telemetry().attitude.is_some() && vehicle.telemetry().version.is_none());
    assert_eq!(vehicle.telemetry().mission.expect("a current item").value.total, None, "MAVLink 1 has no total");
}

#[test]
fn it_is_armed_and_its_mode_set() {
    let mut world = connected();
    assert_eq!(ask(&mut world, ARM), Ok(Reply::Done));
    assert!(world.plane.is_armed);
    assert_eq!(ask(&mut world, mode("AUTO")), Ok(Reply::Done));
    assert_eq!((world.plane.mode, world.plane.count_heard(SET_MODE)), (10, 1));
    // A message without acknowledgement that gets lost is sent again after the heartbeat has shown it.
    world.plane.deaf_to = (SET_MODE, 2);
    assert_eq!(ask(&mut world, mode("LOITER")), Ok(Reply::Done));
    assert_eq!((world.plane.mode, world.plane.count_heard(SET_MODE)), (12, 2));
    // Not when the pilot has taken another mode meanwhile.
    world.plane.deaf_to = (SET_MODE, 1);
    let id = start(&mut world, mode("RTL"));
    wait(&mut world, 300);
    world.plane.mode = 0;
    wait(&mut world, 10_000);
    let error = world.station.results[&id].clone().expect_err("overtaken");
    assert!(matches!(&error, VehicleError::NotConfirmed { observed, .. } if observed == "mode MANUAL"), "{error}");
    assert_eq!((world.plane.mode, world.plane.count_heard(SET_MODE)), (0, 2));
    assert_eq!(ask(&mut world, Request::Disarm { force: false }), Ok(Reply::Done));
    assert!(!world.plane.is_armed);
}

#[test]
fn its_mission_goes_both_ways() {
    let mut world = connected();
    let reply = ask(&mut world, upload(PlanKind::Mission, mission())).expect("uploaded");
    let Reply::Plan { items, state: PlanState::Verified { count, hash }, position_error_m, .. } = reply else {
        panic!("{reply:?}")
    };
    assert_eq!((items.len(), count, world.plane.mission.len()), (7, 7, 8));
    let error_m = position_error_m.expect("floats");
    assert!(error_m > 0.01 && error_m < 0.8, "{error_m}");
    // It stays known: the vehicle tells no total that would contradict it.
    wait(&mut world, 5_000);
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), PlanState::Verified { count, hash });
    let reply = ask(&mut world, Request::DownloadPlan { kind: PlanKind::Mission }).expect("downloaded");
    let Reply::Plan { home, state, .. } = reply else { panic!("{reply:?}") };
    assert_eq!(state, PlanState::Verified { count: 7, hash }, "the same");
    assert!(home.is_some_and(|home| (home.lat_deg - 40.3332).abs() < 1e-5));
    assert_eq!(ask(&mut world, Request::MissionStart { from_item: Some(2) }), Ok(Reply::Done));
    assert_eq!((world.plane.current, world.plane.mode), (2, 10));
    ask(&mut world, Request::ClearPlan { kind: PlanKind::Mission }).expect("cleared");
    assert!(world.plane.mission.is_empty());
    assert!(YOUNGER.iter().all(|id| world.plane.count_heard(*id) == 0), "nothing that it does not know");
}

#[test]
fn what_it_does_not_keep_is_told() {
    let mut world = connected();
    let mut items = mission();
    // A radius for a loiter without end came later.
    items[4] = MissionItem::loiter_unlimited(40.336, -3.801, 80.0, 90.0);
    let error = ask(&mut world, upload(PlanKind::Mission, items)).expect_err("not as sent");
    assert!(matches!(error, VehicleError::Transfer(TransferError::NotAsSent { .. })), "{error}");
    let newer = vec![MissionItem::loiter_to_alt(40.336, -3.801, 80.0, 90.0)];
    let error = ask(&mut world, upload(PlanKind::Mission, newer)).expect_err("refused");
    assert!(matches!(error, VehicleError::Transfer(TransferError::Refused { .. })), "{error}");
}

#[test]
fn a_fence_never_replaces_its_mission() {
    let mut world = connected();
    ask(&mut world, upload(PlanKind::Mission, mission())).expect("uploaded");
    let before = world.plane.mission.clone();
    let known = world.station.vehicle.plan_state(PlanKind::Fence);
    let heard = world.plane.heard.len();
    for kind in [PlanKind::Fence, PlanKind::Rally] {
        let items = vec![MissionItem::waypoint(40.3, -3.8, 50.0)];
        for request in [upload(kind, items), Request::DownloadPlan { kind }, Request::ClearPlan { kind }] {
            let error = ask(&mut world, request).expect_err("not by the mission protocol");
            let reason = NoPlanKinds::OldFirmware;
            assert_eq!(error, VehicleError::Transfer(TransferError::OnlyMission { kind, reason }));
        }
    }
    assert_eq!((world.plane.heard.len(), &world.plane.mission), (heard, &before), "nothing was sent");
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Fence), known);
}

#[test]
fn its_parameters_are_listed_and_set() {
    let mut world = connected();
    let Ok(Reply::Parameters(params)) = ask(&mut world, Request::ParamList) else { panic!("no list") };
    assert_eq!(params.len(), world.plane.params.len());
    let set = Request::ParamSet { name: "TRIM_ARSPD_CM".into(), value: 1350.0 };
    assert!(matches!(ask(&mut world, set), Ok(Reply::Parameter(param)) if param.value.as_f64() == 1350.0));
    assert!(world.plane.params.iter().any(|(name, value)| name.as_str() == "TRIM_ARSPD_CM" && *value == 1350.0));
    // Mode TAKEOFF and its parameter came later: nothing is armed or switched for it.
    let error = ask(&mut world, Request::Takeoff { alt_rel_home_m: 50.0 }).expect_err("no such parameter");
    assert!(matches!(error, VehicleError::Transfer(TransferError::UnknownParam { told: false, .. })), "{error}");
    assert_eq!(world.plane.mode, 5);
}

#[test]
fn it_goes_where_it_is_told() {
    let mut world = connected();
    ask(&mut world, upload(PlanKind::Mission, mission())).expect("uploaded");
    let known = world.station.vehicle.plan_state(PlanKind::Mission);
    let error = ask(&mut world, go_to(false)).expect_err("it would change the mode");
    assert!(matches!(error, VehicleError::TooOld { .. }), "{error}");
    let Request::Reposition { lat_deg, lon_deg, alt_m, .. } = go_to(true) else { unreachable!() };
    for (radius_m, turn, alt_frame) in [
        (Some(60.0), Turn::Clockwise, AltFrame::RelHome),
        (None, Turn::CounterClockwise, AltFrame::RelHome),
        (None, Turn::Clockwise, AltFrame::Terrain),
    ] {
        let wish = Request::Reposition {
            lat_deg,
            lon_deg,
            alt_m,
            alt_frame,
            radius_m,
            turn,
            speed_m_s: None,
            change_mode: true,
            below_home: false,
        };
        let error = ask(&mut world, wish).expect_err("not on this firmware");
        assert!(matches!(error, VehicleError::TooOld { .. }), "{error}");
    }
    assert_eq!(world.plane.guided, None);
    assert_eq!(ask(&mut world, go_to(true)), Ok(Reply::Done));
    let guided = world.plane.guided.expect("a target");
    assert!((guided.lat_e7 - 403_400_123).abs() < 60 && (guided.lng_e7 + 38_000_456).abs() < 10, "{guided:?}");
    assert!((guided.alt_cm, guided.is_relative, world.plane.mode) == (9_000, true, 15));

    // In GUIDED already, only the acknowledgement proves that it came.
    let before = world.plane.count_heard(MISSION_ITEM);
    world.plane.deaf_to = (MISSION_ITEM, 2);
    assert_eq!(ask(&mut world, go_to(false)), Ok(Reply::Done));
    assert_eq!(world.plane.count_heard(MISSION_ITEM), before + 1);
    world.plane.mute = 100;
    let error = ask(&mut world, go_to(false)).expect_err("no answer");
    assert!(matches!(error, VehicleError::CommandTimeout { attempts: 3.., .. }), "{error}");
    world.plane.mute = 0;

    let climb = Request::ChangeAltitude { alt_m: 120.0, alt_frame: AltFrame::RelHome, below_home: false };
    assert_eq!(ask(&mut world, climb), Ok(Reply::Done));
    assert_eq!(world.plane.height.map(|height| height.alt_cm), Some(12_000));
    // The acknowledgements were not taken for another station's upload.
    assert_eq!(world.station.vehicle.plan_state(PlanKind::Mission), known);
    assert_eq!(world.plane.count_heard(COMMAND_INT), 0);
}

#[test]
fn a_target_that_the_pilot_has_overruled_is_not_sent_again() {
    let mut world = connected();
    world.plane.deaf_to = (MISSION_ITEM, 1);
    let id = start(&mut world, go_to(true));
    wait(&mut world, 100);
    world.plane.mode = 0;
    wait(&mut world, 10_000);
    let error = world.station.results[&id].clone().expect_err("overruled");
    assert!(matches!(error, VehicleError::NotConfirmed { .. }), "{error}");
    assert_eq!((world.plane.mode, world.plane.count_heard(MISSION_ITEM)), (0, 0));
}

#[test]
fn a_target_and_a_plan_do_not_mix() {
    let mut world = connected();
    let plan = start(&mut world, upload(PlanKind::Mission, mission()));
    let error = ask(&mut world, go_to(true)).expect_err("the upload runs");
    assert!(matches!(error, VehicleError::TransferBusy { .. }), "{error}");
    wait(&mut world, 20_000);
    assert!(world.station.results[&plan].is_ok());
    let target = start(&mut world, go_to(true));
    let error = ask(&mut world, upload(PlanKind::Mission, mission())).expect_err("a target is on its way");
    assert!(matches!(error, VehicleError::TransferBusy { .. }), "{error}");
    wait(&mut world, 5_000);
    assert_eq!(world.station.results[&target], Ok(Reply::Done));
}

#[test]
fn home_goes_by_a_command_that_it_knows_or_refuses() {
    let mut world = connected();
    let home = Request::SetHome { lat_deg: Some(40.3332), lon_deg: Some(-3.7978), alt_amsl_m: Some(600.0) };
    for request in [home, Request::SetHome { lat_deg: None, lon_deg: None, alt_amsl_m: None }] {
        let error = ask(&mut world, request).expect_err("it came in 3.3");
        let VehicleError::CommandRefused { command, result, .. } = error else { panic!("{error}") };
        assert_eq!((command, result), (Command::DO_SET_HOME, CommandResult::UNSUPPORTED));
    }
    assert_eq!(world.plane.count_heard(COMMAND_INT), 0);
}

#[test]
fn the_last_of_them_tells_its_version() {
    let mut plane = OldPlane::new();
    plane.has_version = true;
    let mut world = connect(plane, Faults::default(), 1);
    let version = world.station.vehicle.telemetry().version.expect("a version").value;
    assert!(!version.has_ftp());
    // It is known by what it says then, not by how it says it.
    world.station.vehicle.on_protocol_version(MavVersion::V2);
    let reply = ask(&mut world, upload(PlanKind::Mission, mission())).expect("uploaded");
    assert!(matches!(reply, Reply::Plan { position_error_m: Some(_), .. }), "{reply:?}");
    assert_eq!(ask(&mut world, go_to(true)), Ok(Reply::Done));
    assert!(YOUNGER.iter().all(|id| world.plane.count_heard(*id) == 0));
}

#[test]
fn a_bad_link_makes_it_slower_but_nothing_false() {
    let mut done = 0;
    for seed in 0..40 {
        let mut world = connect(OldPlane::new(), Faults { duplicates: 0.1, reorder: 0.1, ..Faults::loss(0.1) }, seed);
        match ask(&mut world, upload(PlanKind::Mission, mission())) {
            Ok(Reply::Plan { .. }) => {
                done += 1;
                assert_eq!(world.plane.mission.len(), 8);
                assert!((world.plane.mission[7].lat_e7 - 403_332_444).abs() < 60);
            }
            Ok(other) => panic!("{other:?}"),
            Err(VehicleError::Transfer(error)) => println!("seed {seed}: {error:?}"),
            Err(error) => panic!("{error}"),
        }
        assert!(YOUNGER.iter().all(|id| world.plane.count_heard(*id) == 0));
    }
    println!("{done} of 40 uploads succeeded with 10 % loss each way");
    assert!(done >= 38, "{done} of 40");
}

#[test]
fn mavlink_1_alone_is_no_reason_for_floats_but_one_against_fences() {
    // A vehicle of today whose port is set to MAVLink 1, once it has told its version.
    let mut station = Station::new();
    let heartbeat = vencejo_proto::Message::Heartbeat(vencejo_proto::Heartbeat {
        mav_type: 1,
        autopilot: 3,
        mavlink_version: 3,
        ..Default::default()
    });
    let version = vencejo_proto::Message::Dialect(vencejo_proto::dialect::MavMessage::AUTOPILOT_VERSION(
        vencejo_proto::dialect::AUTOPILOT_VERSION_DATA {
            capabilities: vencejo_proto::dialect::MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_INT
                | vencejo_proto::dialect::MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT,
            ..Default::default()
        },
    ));
    let component = super::PLANE.component;
    station.vehicle.on_protocol_version(MavVersion::V1);
    station.vehicle.on_message(component, &heartbeat, MonoTime::ZERO);
    station.vehicle.on_message(component, &version, MonoTime::ZERO);
    assert_eq!(station.vehicle.item_form(), crate::transfer::ItemForm::Integer);
    assert_eq!(station.vehicle.no_plan_kinds(), Some(NoPlanKinds::Mavlink1));
    assert!(station.vehicle.has_command_int());
    station.vehicle.on_protocol_version(MavVersion::V2);
    assert_eq!(station.vehicle.no_plan_kinds(), None);
}

// fault 11: ArduPlane 3.x, which knows no TIMESYNC: not called unreached while it answers other things; told ≤ 5 s when
// it does not, and back at the next answer
#[test]
fn an_old_plane_that_knows_no_timesync_is_reached_while_it_answers_anything() {
    for (faults, seed) in
        [(Faults::default(), 1), (Faults::loss(0.2), 2), (Faults::round_trip(Duration::from_secs(1)), 3)]
    {
        let mut world = connect(OldPlane::new(), faults, seed);
        wait(&mut world, 60_000);
        for _ in 0..3 {
            let result = ask(&mut world, upload(PlanKind::Mission, mission()));
            assert!(seed == 2 || result.is_ok(), "{result:?}");
            wait(&mut world, 30_000);
        }
        assert!(!world.station.events.contains(&VehicleEvent::Unreached), "seed {seed}");
    }
    for request in [upload(PlanKind::Mission, mission()), ARM] {
        let mut world = connected();
        wait(&mut world, 30_000);
        assert_eq!(world.station.vehicle.is_reached(world.now), None, "nothing was asked for long");
        world.faults.is_deaf = true;
        wait(&mut world, 30_000);
        assert!(!world.station.events.contains(&VehicleEvent::Unreached), "nobody asked it anything");
        let now = world.now;
        start(&mut world, request);
        let is_told = |station: &mut Station, _: &mut OldPlane| station.events.contains(&VehicleEvent::Unreached);
        assert!(world.run(now + Duration::from_secs(5), is_told), "told within 5 s");
        world.faults.is_deaf = false;
        let now = world.now;
        let is_back = |station: &mut Station, _: &mut OldPlane| station.events.contains(&VehicleEvent::Reached);
        assert!(world.run(now + Duration::from_secs(1), is_back), "back within a second");
    }
}

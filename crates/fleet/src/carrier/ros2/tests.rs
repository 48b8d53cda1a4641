//! A plane in ROS 2, at a real router, seen and asked as a node of ROS would.

mod replayed;
mod tls;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use vencejo_flight::plan::{Command, Home, Mission, MissionItem, PlanKind};
use vencejo_proto::dialect::{
    EXTENDED_SYS_STATE_DATA, HOME_POSITION_DATA, MISSION_ITEM_REACHED_DATA, MavLandedState, MavMessage,
    RC_CHANNELS_DATA,
};
use vencejo_proto::{Address, Heartbeat, Message as Mavlink, StatusText as MavlinkText};
use vencejo_station::{Carried, FarHeld, FarWish, Remote, Station, StationConfig, Telling};
use vencejo_vehicle::command::CommandResult;
use vencejo_vehicle::{AltFrame, Danger, PlanState, Reply, Request, VehicleError, VehicleId};
use zenoh::Session;

use super::{Gateway, GatewayConfig, RosPapers, RosRouter, examine};
use crate::carrier::endpoint::Endpoint;
use crate::carrier::network::{self, Part};
use crate::error::FleetError;
use crate::ros2::cdr::Cdr;
use crate::ros2::message::{
    CommandBool, CommandHome, CommandLong, CommandTOL, Commanded, CommandedPlace, CurrentWanted, Empty, ExtendedState,
    GeoPoint, GeoPose, GeoPoseStamped, Header, HomePosition, HomeWanted, Log, LongWanted, Message, MissionPushed,
    Pulled, Pushed, Quaternion, RCIn, Service, SetBool, State, StatusText, Succeeded, Switch, Time, Told, Trigger,
    Waypoint, WaypointClear, WaypointPull, WaypointPush, WaypointReached, WaypointSetCurrent,
};
use crate::ros2::mission;
use crate::ros2::name::{Names, Namespace};
use crate::ros2::setpoint;
use crate::ros2::token::{Attachment, key};

/// How long is waited for what comes at once.
const WAIT: Duration = Duration::from_secs(30);

/// A plane that does what it is asked, or does not end it.
#[derive(Default)]
struct Far(Mutex<Vec<(Request, String)>>, AtomicBool);

impl Remote for Far {
    fn request(
        self: Arc<Self>,
        request: Request,
        _confirmed: Option<Danger>,
        operator: String,
        _telling: Telling,
    ) -> Carried {
        let (home, items) = (Some(HOME), vec![MissionItem::takeoff(40.001, -3.0, 50.0, 10.0), far_waypoint(80.0)]);
        let end = match request {
            Request::DownloadPlan { kind } => {
                Ok(Reply::Plan { kind, items, home, state: PlanState::Empty, position_error_m: None })
            }
            // It takes no landing.
            Request::RawCommandLong(ref long) if long.command == Command::NAV_LAND.0 => {
                let (target, command, result) = (Address::new(1, 1), Command::NAV_LAND, CommandResult::DENIED);
                let reasons = Vec::new();
                Err(VehicleError::CommandRefused { target: target.into(), command, result, reasons, cure: None }.into())
            }
            _ => Ok(Reply::Done),
        };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((request, operator));
        if self.1.load(Ordering::Relaxed) {
            return Box::pin(std::future::pending());
        }
        Box::pin(async { end })
    }

    fn control(self: Arc<Self>, _: FarWish, _: String) -> Carried {
        Box::pin(async { Ok(Reply::Done) })
    }

    fn held(&self) -> FarHeld {
        FarHeld::default()
    }
}

const HOME: Home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };

fn far_waypoint(alt_m: f64) -> MissionItem {
    MissionItem::waypoint(40.01, -3.0, alt_m)
}

async fn router() -> (Session, Endpoint) {
    let at: Endpoint = "tcp/127.0.0.1:0".parse::<Endpoint>().and_then(Endpoint::with_port).expect("a port");
    (network::open(Part::Router(&at, &[], None), None).await.expect("a router"), at)
}

fn config(at: &Endpoint, is_operator: bool) -> GatewayConfig {
    GatewayConfig {
        router: RosRouter::new(&at.to_string(), &RosPapers::default()).expect("a router"),
        domain: 0,
        names: Names::Mavros,
        namespace: Namespace::default(),
        is_operator,
    }
}

fn beat(station: &Station, id: VehicleId) {
    beat_in(station, id, 5, false);
}

fn beat_in(station: &Station, id: VehicleId, custom_mode: u32, is_armed: bool) {
    let base_mode = if is_armed { 0x81 } else { 1 };
    let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, custom_mode, base_mode, ..Heartbeat::default() };
    assert!(station.on_remote(id, &[(Mavlink::Heartbeat(heartbeat), station.now())]));
}

/// Asks as a client of ROS does, until the service is there.
async fn call<S: Service>(session: &Session, name: &str, request: S::Request) -> S::Response {
    let (key, asked) = (key(0, name, S::TYPE, S::HASH), Attachment { sequence: 3, sent_ns: 1, gid: [7; 16] });
    let answered = async {
        loop {
            let get = session.get(&key).payload(request.to_bytes()).attachment(asked.to_bytes()).timeout(WAIT);
            let replies = get.await.expect("asked");
            if let Ok(reply) = replies.recv_async().await
                && let Ok(sample) = reply.into_result()
            {
                let attachment = sample.attachment().map(|bytes| bytes.to_bytes().into_owned()).expect("attached");
                let attachment = Attachment::read(&attachment).expect("an attachment");
                assert_eq!((attachment.sequence, attachment.gid), (3, [7; 16]));
                return S::Response::from_bytes(&sample.payload().to_bytes()).expect("an answer");
            }
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(WAIT, answered).await.expect("the service")
}

#[tokio::test(flavor = "multi_thread")]
async fn a_plane_is_seen_and_acts_for_an_operator_alone() {
    let (router, at) = router().await;
    let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
    let far = Arc::new(Far::default());
    let id = station.adopt("plane-7", Address::new(1, 1), far.clone()).expect("there is room");
    beat(&station, id);
    let states =
        router.declare_subscriber(key(0, "/plane_7/mavros/state", State::TYPE, State::HASH)).await.expect("declared");
    let reader = Gateway::start(station.clone(), config(&at, false), &Handle::current()).expect("a gateway");
    let state = tokio::time::timeout(WAIT, states.recv_async()).await.expect("in time").expect("a message");
    let attachment = state.attachment().map(|bytes| bytes.to_bytes().into_owned()).expect("attached");
    assert_eq!(Attachment::read(&attachment).map(|attachment| attachment.sequence), Some(1));
    let state = State::from_bytes(&state.payload().to_bytes()).expect("a state");
    assert_eq!((state.connected, state.armed, state.mode.as_str()), (true, false, "FBWA"));

    let arm = "/plane_7/mavros/vencejo/arm";
    let told: Told = call::<SetBool>(&router, arm, Switch { data: true }).await;
    assert!(!told.success && told.message.contains("--ros2-role operator"), "{told:?}");
    assert!(far.0.lock().unwrap_or_else(PoisonError::into_inner).is_empty(), "nothing was asked of it");
    let found = examine(&config(&at, false).router, 0).await.expect("reached");
    let services: Vec<_> = found.nodes.iter().map(|node| (node.name.as_str(), node.services)).collect();
    assert_eq!(services, [("/plane_7/mavros", 15), ("/plane_7/mavros/param", 8)]);
    assert_eq!((found.nodes[0].publishers, found.nodes[0].subscriptions), (23, 1), "its topics, and its log");
    assert_eq!(found.findings, []);
    assert_eq!(reader.status().planes, [(id.number(), "/plane_7/mavros".to_owned())]);
    reader.close().await;

    beat(&station, id);
    let gateway = Gateway::start(station.clone(), config(&at, true), &Handle::current()).expect("a gateway");
    let armed: Commanded = call::<CommandBool>(&router, "/plane_7/mavros/cmd/arming", Switch { data: true }).await;
    assert_eq!(armed, Commanded { success: true, result: 0 });
    let home = Empty { structure_needs_at_least_one_member: 0 };
    let told = call::<Trigger>(&router, "/plane_7/mavros/vencejo/return_to_launch", home.clone()).await;
    assert!(told.success, "{told:?}");
    let asked = far.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let ros = || "ROS 2".to_owned();
    assert_eq!(asked, [(Request::Arm { force: false }, ros()), (Request::ReturnToLaunch, ros())]);

    // Home is counted, as on the wire.
    let pulled: Pulled = call::<WaypointPull>(&router, "/plane_7/mavros/mission/pull", home).await;
    assert_eq!(pulled, Pulled { success: true, wp_received: 3 });
    let push = async |start_index: u16, waypoints: Vec<Waypoint>| -> Pushed {
        call::<WaypointPush>(&router, "/plane_7/mavros/mission/push", MissionPushed { start_index, waypoints }).await
    };
    let list = |alt_m: f64| {
        let items = vec![MissionItem::takeoff(40.001, -3.0, 50.0, 10.0), far_waypoint(alt_m)];
        mission::list(&Mission { home: Some(HOME), items }, true, None).waypoints
    };
    assert_eq!(push(0, list(90.0)).await, Pushed { success: true, wp_transfered: 3 });
    // One of them, in what is on board.
    assert_eq!(push(2, list(110.0)[2..].to_vec()).await, Pushed { success: true, wp_transfered: 1 });
    let refused = Pushed { success: false, wp_transfered: 0 };
    let mut astray = list(90.0);
    astray.push(Waypoint { command: 177, param1: 99.0, ..astray[1].clone() });
    // A jump to nowhere, off the Earth, beyond the end, and none at all.
    for (start, waypoints) in [(0, astray), (0, list(f64::NAN)), (3, list(90.0)), (0, Vec::new())] {
        assert_eq!(push(start, waypoints).await, refused, "{start}");
    }
    let asked = far.0.lock().unwrap_or_else(PoisonError::into_inner).split_off(2);
    let uploads: Vec<_> = asked
        .iter()
        .map(|(request, _)| match request {
            Request::UploadPlan { items, home: Some(HOME), despite_findings: false, .. } => {
                items.iter().filter_map(MissionItem::alt_m).collect()
            }
            Request::DownloadPlan { .. } => Vec::new(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(uploads, [vec![], vec![50.0, 90.0], vec![], vec![50.0, 110.0], vec![]]);
    // It gives control to whoever asks, and does not take it from them.
    assert!(station.operator().request(station.now()));
    let told = call::<SetBool>(&router, arm, Switch { data: false }).await;
    assert!(!told.success && told.message.starts_with("program holds control"), "{told:?}");
    let asked = || far.0.lock().unwrap_or_else(PoisonError::into_inner).len();
    assert_eq!(asked(), 2);

    // A client of ROS waits for ever: the 17th is told as well.
    station.operator().release(station.now());
    far.1.store(true, Ordering::Relaxed);
    let (key, mut under_way) = (key(0, arm, SetBool::TYPE, SetBool::HASH), Vec::new());
    for sequence in 0..16 {
        let attachment = Attachment { sequence, sent_ns: 1, gid: [7; 16] };
        let get = router.get(&key).payload(Switch { data: false }.to_bytes()).attachment(attachment.to_bytes());
        under_way.push(get.timeout(WAIT).await.expect("asked"));
    }
    let taken = async {
        while asked() < 18 {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(WAIT, taken).await.expect("16 under way");
    let told = call::<SetBool>(&router, arm, Switch { data: false }).await;
    assert!(!told.success && told.message.contains("ask again"), "{told:?}");
    gateway.close().await;
    station.close().await;
}

/// A position to fly to.
fn position(latitude: f64) -> Vec<u8> {
    let position = GeoPoint { latitude, longitude: -3.0, altitude: 700.0 };
    let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    let header = Header { stamp: Time { sec: 0, nanosec: 0 }, frame_id: String::new() };
    GeoPoseStamped { header, pose: GeoPose { position, orientation } }.to_bytes()
}

/// Calls of MAVROS for what the plane is to do, each the request that every door has for it.
#[tokio::test(flavor = "multi_thread")]
async fn it_takes_off_lands_and_is_sent_to_positions() {
    let (router, at) = router().await;
    let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
    let far = Arc::new(Far::default());
    let id = station.adopt("plane-7", Address::new(1, 1), far.clone()).expect("there is room");
    beat_in(&station, id, 15, true);
    let log = router.declare_subscriber(key(0, "/rosout", Log::TYPE, Log::HASH)).await.expect("declared");
    let gateway = Gateway::start(station.clone(), config(&at, true), &Handle::current()).expect("a gateway");
    let named = |name: &str| format!("/plane_7/mavros/{name}");
    let asked = || -> Vec<Request> {
        let mut asked = far.0.lock().unwrap_or_else(PoisonError::into_inner);
        asked.drain(..).map(|(request, _)| request).collect()
    };
    let done = Commanded { success: true, result: 0 };
    let place = |altitude| CommandedPlace { min_pitch: 0.0, yaw: 0.0, latitude: 0.0, longitude: 0.0, altitude };
    assert_eq!(call::<CommandTOL>(&router, &named("cmd/takeoff"), place(60.0)).await, done);
    assert_eq!(call::<CommandTOL>(&router, &named("cmd/land"), place(0.0)).await, done);
    let home = |current_gps| HomeWanted { current_gps, yaw: 0.0, latitude: 40.5, longitude: -3.5, altitude: 610.0 };
    let refused = Commanded { success: false, result: 4 };
    assert_eq!(call::<CommandHome>(&router, &named("cmd/set_home"), home(true)).await, refused, "in flight");
    for (wp_seq, success) in [(2, true), (0, false)] {
        let told = call::<WaypointSetCurrent>(&router, &named("mission/set_current"), CurrentWanted { wp_seq }).await;
        assert_eq!(told, Succeeded { success }, "{wp_seq}: waypoint 0 is home");
    }
    let wanted = [Request::Takeoff { alt_rel_home_m: 60.0 }, Request::Land, Request::SetCurrentItem { item: 2 }];
    assert_eq!(asked(), wanted);

    // Any command, as by every other door: what is dangerous needs a confirmation, which ROS has no word for.
    let long = |command: Command, broadcast, param1| LongWanted {
        broadcast,
        command: command.0,
        confirmation: 0,
        param1,
        param2: 0.0,
        param3: 0.0,
        param4: f32::NAN,
        param5: 0.0,
        param6: 0.0,
        param7: 0.0,
    };
    for (command, broadcast, param1, success, result) in [
        (Command::DO_CHANGE_SPEED, false, 1.0, true, 0),
        (Command::NAV_LAND, false, 0.0, false, 2),
        (Command::DO_FLIGHTTERMINATION, false, 1.0, false, 4),
        (Command::COMPONENT_ARM_DISARM, false, 0.0, false, 4),
        (Command::DO_CHANGE_SPEED, true, 1.0, false, 4),
        (Command::DO_CHANGE_SPEED, false, f32::INFINITY, false, 4),
    ] {
        let told = call::<CommandLong>(&router, &named("cmd/command"), long(command, broadcast, param1)).await;
        assert_eq!(told, Commanded { success, result }, "{command:?} {broadcast} {param1}");
    }
    let sent: Vec<_> = asked()
        .iter()
        .map(|request| match request {
            Request::RawCommandLong(long) => (long.target, Command(long.command)),
            other => panic!("{other:?}"),
        })
        .collect();
    let autopilot = Address::new(0, 0);
    assert_eq!(sent, [(autopilot, Command::DO_CHANGE_SPEED), (autopilot, Command::NAV_LAND)]);
    let told = call::<SetBool>(&router, &named("vencejo/arm"), Switch { data: false }).await;
    assert!(
        !told.success && told.message.contains("the web app, or Python with confirm=\"disarm-in-flight\""),
        "{told:?}"
    );

    // An armed plane keeps its mission.
    let nothing = || Empty { structure_needs_at_least_one_member: 0 };
    let told = call::<WaypointClear>(&router, &named("mission/clear"), nothing()).await;
    assert_eq!(told, Succeeded { success: false });
    let told = call::<Trigger>(&router, &named("vencejo/mission_clear"), nothing()).await;
    assert!(!told.success && told.message.contains("disarm it first"), "{told:?}");
    assert_eq!(asked(), []);
    beat_in(&station, id, 15, false);
    assert!(call::<WaypointClear>(&router, &named("mission/clear"), nothing()).await.success);
    assert_eq!(asked(), [Request::ClearPlan { kind: PlanKind::Mission }]);
    for current_gps in [true, false] {
        beat_in(&station, id, 15, false);
        assert_eq!(call::<CommandHome>(&router, &named("cmd/set_home"), home(current_gps)).await, done);
    }
    let there = |lat_deg, lon_deg, alt_amsl_m| Request::SetHome { lat_deg, lon_deg, alt_amsl_m };
    assert_eq!(asked(), [there(None, None, None), there(Some(40.5), Some(-3.5), Some(610.0))]);

    // A target that is repeated is one order, another one another order, and in another mode it is none.
    let (name, hash) = (named(setpoint::TOPIC), GeoPoseStamped::HASH);
    let publisher = router.declare_publisher(key(0, &name, GeoPoseStamped::TYPE, hash)).await.expect("declared");
    let publish = async |latitude: f64| {
        let attachment = Attachment { sequence: 1, sent_ns: 1, gid: [7; 16] };
        publisher.put(position(latitude)).attachment(attachment.to_bytes()).await.expect("sent");
    };
    let until_flown = async |latitude: f64| {
        let mut ten_hz = tokio::time::interval(Duration::from_millis(100));
        let flown = async {
            while far.0.lock().unwrap_or_else(PoisonError::into_inner).last().is_none_or(
                |(request, _)| !matches!(request, Request::Reposition { lat_deg, .. } if *lat_deg == latitude),
            ) {
                beat_in(&station, id, 15, true);
                publish(latitude).await;
                ten_hz.tick().await;
            }
        };
        tokio::time::timeout(WAIT, flown).await.expect("it is flown to");
    };
    for latitude in [40.01, 40.02] {
        until_flown(latitude).await;
    }
    let flown: Vec<_> = asked()
        .into_iter()
        .map(|request| match request {
            Request::Reposition { lat_deg, lon_deg, alt_m, alt_frame, change_mode: false, .. } => {
                (lat_deg, lon_deg, alt_m, alt_frame)
            }
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(flown, [40.01, 40.02].map(|lat_deg| (lat_deg, -3.0, 700.0, AltFrame::Amsl)));
    beat_in(&station, id, 11, true);
    publish(40.03).await;
    let refused = async {
        loop {
            let line = log.recv_async().await.expect("a line");
            let line = Log::from_bytes(&line.payload().to_bytes()).expect("a line");
            if line.msg.starts_with("setpoint_position/global: it is in RTL") {
                return line.level;
            }
        }
    };
    assert_eq!(tokio::time::timeout(WAIT, refused).await.expect("it says why not"), 30);
    assert_eq!(asked(), []);
    gateway.close().await;
    station.close().await;
}

/// A message of a topic, of which is said again and again what makes it: who listens is not there at once.
async fn heard<M: Message>(router: &Session, name: &str, say: impl Fn()) -> M {
    let key = key(0, &format!("/plane_7/mavros/{name}"), M::TYPE, M::HASH);
    let messages = router.declare_subscriber(key).await.expect("declared");
    let first = async {
        let mut again = tokio::time::interval(Duration::from_millis(100));
        loop {
            tokio::select! {
                _ = again.tick() => say(),
                sample = messages.recv_async() => {
                    return M::from_bytes(&sample.expect("a message").payload().to_bytes()).expect("a message");
                }
            }
        }
    };
    tokio::time::timeout(WAIT, first).await.expect("in time")
}

/// What happens comes when it happens, and home again and again.
#[tokio::test(flavor = "multi_thread")]
async fn its_home_its_state_its_texts_and_its_waypoints_are_told() {
    let (router, at) = router().await;
    let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
    let far = Arc::new(Far::default());
    let id = station.adopt("plane-7", Address::new(1, 1), far.clone()).expect("there is room");
    beat_in(&station, id, 15, false);
    let gateway = Gateway::start(station.clone(), config(&at, false), &Handle::current()).expect("a gateway");
    let until_there = async {
        while gateway.status().planes.is_empty() {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(WAIT, until_there).await.expect("it is shown");
    let say = |said: Mavlink| {
        beat_in(&station, id, 15, false);
        assert!(station.on_remote(id, &[(said, station.now())]));
    };
    let home =
        HOME_POSITION_DATA { latitude: 400_000_000, longitude: -30_000_000, altitude: 600_000, ..Default::default() };
    let home = Mavlink::Dialect(MavMessage::HOME_POSITION(home));
    let told: HomePosition = heard(&router, "home_position/home", || say(home.clone())).await;
    assert_eq!((told.geo.latitude, told.geo.longitude, told.header.frame_id.as_str()), (40.0, -3.0, "plane_7/map"));
    assert!(told.geo.altitude.is_nan(), "above the ellipsoid, which no receiver has told");
    let landed =
        EXTENDED_SYS_STATE_DATA { landed_state: MavLandedState::MAV_LANDED_STATE_LANDING, ..Default::default() };
    let landed = Mavlink::Dialect(MavMessage::EXTENDED_SYS_STATE(landed));
    let told: ExtendedState = heard(&router, "extended_state", || say(landed.clone())).await;
    assert_eq!((told.vtol_state, told.landed_state), (0, 4));
    let radio = RC_CHANNELS_DATA {
        chancount: 3,
        chan1_raw: 1100,
        chan2_raw: u16::MAX,
        chan3_raw: 1900,
        rssi: 255,
        ..Default::default()
    };
    let radio = Mavlink::Dialect(MavMessage::RC_CHANNELS(radio));
    let told: RCIn = heard(&router, "rc/in", || say(radio.clone())).await;
    assert_eq!((told.rssi, told.channels), (255, vec![1100, u16::MAX, 1900]));
    let text = MavlinkText { severity: 4, text: "Terrain data missing".into(), id: 0, chunk_seq: 0 };
    let told: StatusText = heard(&router, "statustext/recv", || say(Mavlink::StatusText(text.clone()))).await;
    assert_eq!((told.severity, told.text.as_str()), (4, "Terrain data missing"));
    // Who only reads flies to no position.
    let wanted = key(0, "/plane_7/mavros/setpoint_position/global", GeoPoseStamped::TYPE, GeoPoseStamped::HASH);
    let attachment = Attachment { sequence: 1, sent_ns: 1, gid: [7; 16] };
    router.put(wanted, position(40.01)).attachment(attachment.to_bytes()).await.expect("sent");
    let reached = MISSION_ITEM_REACHED_DATA { seq: 3 };
    let reached = Mavlink::Dialect(MavMessage::MISSION_ITEM_REACHED(reached));
    let told: WaypointReached = heard(&router, "mission/reached", || say(reached.clone())).await;
    assert_eq!(told.wp_seq, 3);
    assert!(far.0.lock().unwrap_or_else(PoisonError::into_inner).is_empty(), "nothing was asked of it");
    gateway.close().await;
    station.close().await;
}

#[tokio::test]
async fn what_cannot_be_reached_or_would_be_open_to_all_is_refused() {
    let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
    let meant = RosPapers { is_plain_meant: true, ..RosPapers::default() };
    let elsewhere = RosRouter::new("tcp/192.0.2.1:7447", &meant).expect("for who only reads");
    let open = GatewayConfig { router: elsewhere, ..config(&"tcp/127.0.0.1:1".parse().expect("an address"), true) };
    let refused = Gateway::start(station.clone(), open, &Handle::current()).map(drop);
    assert!(matches!(refused, Err(FleetError::RosOperator(_))), "{refused:?}");
    let nobody = RosRouter::new("tcp/127.0.0.1:1", &RosPapers::default()).expect("an address");
    assert_eq!(missed(&nobody).await.0, "no-router");
    assert!(matches!(examine(&nobody, 233).await, Err(FleetError::Ros(_))));
    station.close().await;
}

async fn missed(router: &RosRouter) -> (&'static str, String) {
    match examine(router, 0).await {
        Err(FleetError::RosUnreached { code, problem, .. }) => (code, problem),
        other => panic!("{other:?}"),
    }
}

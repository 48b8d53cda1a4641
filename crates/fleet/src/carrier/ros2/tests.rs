//! A plane in ROS 2, at a real router, seen and asked as a node of ROS would.

mod tls;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use vencejo_flight::plan::{Home, Mission, MissionItem};
use vencejo_proto::{Address, Heartbeat, Message as Mavlink};
use vencejo_station::{Carried, FarHeld, Remote, Station, StationConfig, Telling};
use vencejo_vehicle::{Danger, PlanState, Reply, Request, VehicleId};
use zenoh::Session;

use super::{Gateway, GatewayConfig, RosPapers, RosRouter, examine};
use crate::carrier::endpoint::Endpoint;
use crate::carrier::network::{self, Part};
use crate::error::FleetError;
use crate::ros2::cdr::Cdr;
use crate::ros2::message::{
    CommandBool, Commanded, Empty, Message, MissionPushed, Pulled, Pushed, Service, SetBool, State, Switch, Told,
    Trigger, Waypoint, WaypointPull, WaypointPush,
};
use crate::ros2::mission;
use crate::ros2::name::{Names, Namespace};
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
        let reply = match request {
            Request::DownloadPlan { kind } => {
                Reply::Plan { kind, items, home, state: PlanState::Empty, position_error_m: None }
            }
            _ => Reply::Done,
        };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((request, operator));
        if self.1.load(Ordering::Relaxed) {
            return Box::pin(std::future::pending());
        }
        Box::pin(async { Ok(reply) })
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
    let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, custom_mode: 5, ..Heartbeat::default() };
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
    assert_eq!(found.nodes.len(), 1);
    assert_eq!((found.nodes[0].name.as_str(), found.nodes[0].services), ("/plane_7/mavros", 10));
    assert_eq!(found.nodes[0].publishers, 18, "its topics, and its log");
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

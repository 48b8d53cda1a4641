//! Beginnings and ends of a station, and what other threads do meanwhile.

use std::net::UdpSocket;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use tokio::runtime::Handle;
use vencejo_flight::plan::{Command, MissionItem, PlanKind};
use vencejo_link::{Clock, LinkOptions, Origin, PeerId, SystemClock};
use vencejo_proto::dialect::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, MISSION_COUNT_DATA, MavMessage, RADIO_STATUS_DATA,
};
use vencejo_proto::{Address, CommandAck, Frame, FrameDecoder, Header, Heartbeat, MavVersion, Message, MissionAck};
use vencejo_vehicle::{Request, SpeedKind, VehicleError, VehicleEvent};

use super::*;
use crate::{SigningChange, StationConfig, Taken};

/// Vehicles that are followed at once.
const MAX_VEHICLES: u8 = 64;
/// Only ends a test that has failed.
const LIMIT: Duration = Duration::from_secs(30);

fn plane_heartbeat(system: u8) -> Frame {
    let message =
        Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, mavlink_version: 3, ..Heartbeat::default() });
    message.encode(Header { sequence: 0, source: Address::new(system, 1), version: MavVersion::V2 })
}

fn start() -> Station {
    Station::start(StationConfig::default(), Handle::current()).expect("a station starts")
}

impl Station {
    /// A plane is heard, on no link in particular.
    fn hear(&self, system: u8, now: MonoTime) {
        let origin = Origin { link: LinkId(0), peer: PeerId(0) };
        self.shared.on_frame(origin, &plane_heartbeat(system), now);
    }
}

async fn in_time<F: Future>(future: F) -> F::Output {
    tokio::time::timeout(LIMIT, future).await.expect("it ends")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn requests_and_links_begun_while_closing_end() {
    for _ in 0..200 {
        let station = start();
        station.hear(1, station.now());
        let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
        let go = Arc::new(AtomicBool::new(false));
        let other = std::thread::spawn({
            let (station, go) = (station.clone(), go.clone());
            move || {
                while !go.load(Ordering::Acquire) {}
                let requests: Vec<_> = (0..6).map(|_| vehicle.request(Request::ReturnToLaunch)).collect();
                let link = station.open_link("udpin:127.0.0.1:0", LinkOptions::default());
                (requests, link)
            }
        });
        go.store(true, Ordering::Release);
        in_time(station.close()).await;
        let (requests, link) = other.join().expect("no panic");
        for request in requests {
            assert!(matches!(in_time(request.wait()).await, Some(Err(_))));
        }
        if let Ok(link) = link {
            assert_eq!(station.local_address(link), None);
        }
        assert!(station.links().is_empty(), "{:?}", station.links());
    }
}

/// What two operators do at once: one has control and does it, the other is told who has.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_operators_one_acts_and_the_other_is_told() {
    let station = start();
    station.hear(1, station.now());
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let operators = ["Ana", "Luis"].map(|name| Arc::new(station.enlist(name)));
    let item = MissionItem::at(Command(5001), [4.0, 0.0, 0.0, 0.0], 40.0, -3.0, 0.0);
    let upload = Request::UploadPlan { kind: PlanKind::Fence, items: vec![item], home: None, despite_findings: false };
    let set = Request::ParamSet { name: "WP_RADIUS".into(), value: 90.0 };
    let mut told = 0;
    for race in 0..500 {
        let go = Arc::new(AtomicBool::new(false));
        let racers = operators.each_ref().map(|operator| {
            let (vehicle, go) = (vehicle.acting_as(operator.clone()), go.clone());
            let request = if race % 2 == 0 { upload.clone() } else { set.clone() };
            std::thread::spawn(move || {
                while !go.load(Ordering::Acquire) {}
                vehicle.request(request)
            })
        });
        go.store(true, Ordering::Release);
        let pending = racers.map(|racer| racer.join().expect("no panic"));
        let holder = station.control().holder().expect("one of them");
        for (operator, pending) in operators.iter().zip(&pending) {
            let refused = pending.end() == Some(Err(StationError::Control { holder: holder.clone(), vehicle: None }));
            assert_ne!(operator.name() == holder, refused, "race {race}: {:?}", pending.end());
            told += u32::from(refused);
            pending.cancel();
        }
        for operator in &operators {
            operator.release(station.now());
        }
    }
    assert_eq!(told, 500);
    station.close().await;
}

#[tokio::test]
async fn an_old_wait_cancels_no_new_one() {
    let station = start();
    let first = station.wait_vehicle(Some(VehicleId::new(1)));
    station.hear(1, station.now());
    assert!(matches!(first.wait().await, Some(Ok(_))));
    let second = station.wait_vehicle(Some(VehicleId::new(2)));
    first.cancel();
    assert!(second.end().is_none());
    second.cancel();
    let error = second.end().and_then(Result::err).expect("it was given up");
    assert!(matches!(&error, StationError::NoVehicle { wanted: Wanted::Id(id), .. } if *id == VehicleId::new(2)));
    assert!(error.to_string().ends_with("heard: 1"), "{error}");
    station.close().await;
}

#[tokio::test]
async fn a_link_without_a_vehicle_is_described_by_what_came_in() {
    let station = start();
    assert_eq!(station.describe_links(), "no link");
    let link = station.open_link("udpin:127.0.0.1:0", LinkOptions::default()).expect("a link");
    let said = |text: &'static str| {
        let station = &station;
        in_time(async move {
            while !station.describe_links().contains(text) {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        })
    };
    said("(open, nothing received)").await;
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let to = station.local_address(link).expect("it is open");
    socket.send_to(&[7; 40], to).expect("sent");
    said("(open, no MAVLink in 40 bytes)").await;
    let (info, stats) = station.links().pop().expect("it is open");
    let refused = settling::describe(&info, &LinkStats { refused: 1, ..stats });
    assert!(refused.ends_with("(open, 1 frame refused: signature missing, wrong or old)"), "{refused}");
    station.open_link("serial:/dev/no-such-port:57600", LinkOptions::default()).expect("a link");
    said("(not open: cannot open /dev/no-such-port").await;
    station.close().await;
}

#[tokio::test]
async fn a_request_to_a_vehicle_that_is_forgotten_ends_and_cancels_no_other() {
    let station = start();
    station.hear(1, station.now());
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let messages = vehicle.subscribe_messages(None, 8);
    let events = vehicle.subscribe_events(8);
    let (changes, seen) = (vehicle.changes(), vehicle.change_count());
    let old = vehicle.request(Request::ReturnToLaunch);
    // So many others are heard while it is silent that it makes room.
    let later = station.now() + Duration::from_secs(20);
    for system in 2..=MAX_VEHICLES + 1 {
        station.hear(system, later);
    }
    assert!(station.vehicle(VehicleId::new(1)).is_none());
    assert!(matches!(old.wait().await, Some(Err(StationError::Vehicle(_)))));
    assert_ne!(changes.count(), seen);
    let is_ended = |queue: &DropOldest<_>| loop {
        match queue.take_ready() {
            Taken::Item(_) => {}
            Taken::Closed => return true,
            Taken::TimedOut => return false,
        }
    };
    assert!(is_ended(&events));
    assert_eq!(messages.take_ready(), Taken::Closed);
    // It comes back: a new vehicle, whose requests the old handles do not touch.
    station.hear(1, later + Duration::from_secs(20));
    let again = vehicle.request(Request::ReturnToLaunch);
    old.cancel();
    assert!(again.end().is_none());
    again.cancel();
    assert_eq!(again.wait().await, Some(Err(StationError::Vehicle(VehicleError::Cancelled))));
    station.close().await;
}

#[tokio::test]
async fn one_queue_has_the_messages_of_all_vehicles_in_order_from_their_first() {
    let station = start();
    let (all, some) = (station.subscribe_messages(None, 8), station.subscribe_messages(Some(BTreeSet::from([30])), 8));
    for system in [1, 2, 1] {
        station.hear(system, station.now());
    }
    // A camera of no vehicle.
    let message = Message::Dialect(MavMessage::ATTITUDE(ATTITUDE_DATA::default()));
    let stray = message.encode(Header { sequence: 0, source: Address::new(9, 100), version: MavVersion::V2 });
    station.shared.on_frame(Origin { link: LinkId(0), peer: PeerId(0) }, &stray, station.now());
    for system in [1, 2, 1] {
        let Taken::Item(received) = all.take_ready() else { panic!("one more") };
        assert_eq!(received.frame, plane_heartbeat(system));
    }
    assert_eq!((all.take_ready(), some.take_ready()), (Taken::TimedOut, Taken::TimedOut));
    station.close().await;
    assert_eq!((all.take_ready(), station.subscribe_messages(None, 8).take_ready()), (Taken::Closed, Taken::Closed));
}

#[tokio::test]
async fn a_station_that_nobody_holds_ends_its_queues_and_links() {
    let station = start();
    station.hear(1, station.now());
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let weak = vehicle.downgrade();
    let (messages, events) = (vehicle.subscribe_messages(None, 8), vehicle.subscribe_events(8));
    let waiting = station.wait_vehicle(Some(VehicleId::new(9)));
    station.open_link("udpin:127.0.0.1:0", LinkOptions::default()).expect("opens");
    let hub = station.shared.hub.clone();
    drop((station, vehicle));
    assert!(matches!(in_time(waiting.wait()).await, None | Some(Err(StationError::Closed))));
    in_time(async { while messages.take().await.is_some() {} }).await;
    in_time(async { while events.take().await.is_some() {} }).await;
    assert!(weak.upgrade().is_none());
    in_time(async {
        while !hub.links().is_empty() {
            tokio::task::yield_now().await;
        }
    })
    .await;
}

/// A clock that breaks.
struct Breaking {
    clock: SystemClock,
    is_broken: AtomicBool,
}

impl Clock for Breaking {
    fn now(&self) -> MonoTime {
        assert!(!self.is_broken.load(Ordering::Relaxed), "the clock broke, as this test wants it");
        self.clock.now()
    }

    fn unix_us(&self) -> u64 {
        self.clock.unix_us()
    }
}

#[tokio::test]
async fn when_the_driver_panics_nobody_waits_for_ever() {
    let clock = Arc::new(Breaking { clock: SystemClock::new(), is_broken: AtomicBool::new(false) });
    let station = Station::with_clock(StationConfig::default(), Handle::current(), clock.clone()).expect("starts");
    station.hear(1, station.now());
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let (request, waiting) = (vehicle.request(Request::ReturnToLaunch), station.wait_vehicle(Some(VehicleId::new(2))));
    clock.is_broken.store(true, Ordering::Relaxed);
    assert!(matches!(in_time(waiting.wait()).await, Some(Err(StationError::Closed))));
    assert_eq!(in_time(request.wait()).await, Some(Err(StationError::Closed)));
    assert!(station.is_closed());
    clock.is_broken.store(false, Ordering::Relaxed);
    in_time(station.close()).await;
}

fn hears_heartbeat(plane: &UdpSocket, limit: Duration) -> bool {
    heartbeat_source(plane, limit).is_some()
}

/// Who says, by what comes next, that it is there.
fn heartbeat_source(plane: &UdpSocket, limit: Duration) -> Option<Address> {
    // A time-out of zero is none at all.
    plane.set_read_timeout(Some(limit.max(Duration::from_millis(1)))).expect("a time-out");
    let mut datagram = [0; 300];
    let size = plane.recv(&mut datagram).ok()?;
    let mut decoder = FrameDecoder::new();
    decoder.push(&datagram[..size]);
    decoder.next_frame().filter(|frame| frame.message_id() == 0).map(|frame| frame.source())
}

/// A clock that stands still: no second passes, so that no beat follows the first.
struct Still;

impl Clock for Still {
    fn now(&self) -> MonoTime {
        MonoTime::from_micros(1)
    }

    fn unix_us(&self) -> u64 {
        0
    }
}

#[tokio::test]
async fn a_link_that_opens_between_two_beats_is_greeted_at_once() {
    let station =
        Station::with_clock(StationConfig::default(), Handle::current(), Arc::new(Still)).expect("a station starts");
    // The driver, spawned before, has its turn: its first beat goes to nobody.
    tokio::task::yield_now().await;
    for _ in 0..2 {
        let plane = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let address = format!("udpout:{}", plane.local_addr().expect("bound"));
        let link = station.open_link(&address, LinkOptions::default()).expect("opens");
        let heard = tokio::task::spawn_blocking(move || hears_heartbeat(&plane, LIMIT));
        assert!(heard.await.expect("no panic"));
        station.close_link(link).await.expect("closes");
    }
    station.set_heartbeat(false);
    let plane = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let address = format!("udpout:{}", plane.local_addr().expect("bound"));
    let link = station.open_link(&address, LinkOptions::default()).expect("opens");
    in_time(async {
        while station.local_address(link).is_none() {
            tokio::task::yield_now().await;
        }
    })
    .await;
    station.close_link(link).await.expect("closes");
    assert!(!hears_heartbeat(&plane, Duration::ZERO), "who only listens greets nobody");
    station.close().await;
}

/// ArduPilot's failsafe counts the heartbeats of its ground stations' system id, and none of its own.
#[tokio::test]
async fn on_board_the_heartbeat_is_one_that_an_autopilot_counts() {
    for (address, heard) in [((1, 191), (255, 191)), ((254, 190), (254, 190))] {
        let [address, heard] = [address, heard].map(|(system, component)| Address::new(system, component));
        let config = StationConfig { address, ..StationConfig::default() };
        let station = Station::with_clock(config, Handle::current(), Arc::new(Still)).expect("a station starts");
        let plane = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let link = format!("udpout:{}", plane.local_addr().expect("bound"));
        station.open_link(&link, LinkOptions::default()).expect("opens");
        let source = tokio::task::spawn_blocking(move || heartbeat_source(&plane, LIMIT));
        assert_eq!(source.await.expect("no panic"), Some(heard));
        station.close().await;
    }
}

// fault 26: at most 1 heartbeat in 2.5 s from a core that is stuck
/// The vehicle's ground-station failsafe counts our heartbeats: they come from the loop that does the work, so that
/// they stop when it is stuck.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn heartbeats_stop_while_the_core_is_stuck_and_go_on_afterwards() {
    let plane = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let station = start();
    let address = format!("udpout:{}", plane.local_addr().expect("bound"));
    station.open_link(&address, LinkOptions::default()).expect("opens");
    let shared = station.shared.clone();
    let told = tokio::task::spawn_blocking(move || {
        assert!(hears_heartbeat(&plane, LIMIT), "the link's opening is followed by one");
        let stuck = shared.core();
        // One may have been on its way.
        let end = Instant::now() + Duration::from_millis(2_500);
        let mut late = 0;
        while hears_heartbeat(&plane, end.saturating_duration_since(Instant::now())) {
            late += 1;
        }
        drop(stuck);
        (late, hears_heartbeat(&plane, LIMIT))
    });
    let (late, goes_on) = told.await.expect("no panic");
    assert!(late <= 1, "{late} heartbeats from a core that is stuck");
    assert!(goes_on);
    station.close().await;
}

/// A link that listens, and where.
async fn listening(station: &Station) -> SocketAddr {
    let link = station.open_link("udpin:127.0.0.1:0", LinkOptions::default()).expect("opens");
    in_time(async {
        loop {
            match station.local_address(link) {
                Some(local) => return local,
                None => tokio::task::yield_now().await,
            }
        }
    })
    .await
}

/// An autopilot's end of a link, which has been up for so long.
struct Autopilot {
    socket: UdpSocket,
    sequence: u8,
    up_ms: u32,
    begun: Instant,
}

impl Autopilot {
    fn new(there: SocketAddr, up_ms: u32) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        socket.set_nonblocking(true).expect("set");
        socket.connect(there).expect("connected");
        Self { socket, sequence: 0, up_ms, begun: Instant::now() }
    }

    fn speak(&mut self) {
        self.socket.send(plane_heartbeat(1).bytes()).expect("sent");
        self.sequence = self.sequence.wrapping_add(1);
        let time_boot_ms = self.up_ms + self.begun.elapsed().as_millis() as u32;
        let attitude = MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..ATTITUDE_DATA::default() });
        let header = Header { sequence: self.sequence, source: Address::new(1, 1), version: MavVersion::V2 };
        self.socket.send(Message::Dialect(attitude).encode(header).bytes()).expect("sent");
    }

    /// How many messages with this id have come.
    fn heard(&self, id: u32) -> usize {
        let mut decoder = FrameDecoder::new();
        let mut datagram = [0; 300];
        while let Ok(size) = self.socket.recv(&mut datagram) {
            decoder.push(&datagram[..size]);
        }
        std::iter::from_fn(|| decoder.next_frame()).filter(|frame| frame.message_id() == id).count()
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_autopilots_with_one_id_the_first_is_followed_and_commanded() {
    let folder = std::env::temp_dir().join(format!("vencejo-station-two-{}", std::process::id()));
    let config = StationConfig { signing_dir: Some(folder.join("signing")), ..StationConfig::default() };
    let station = Station::start(config, Handle::current()).expect("a station starts");
    let there = listening(&station).await;
    let (mut first, mut second) = (Autopilot::new(there, 600_000), Autopilot::new(there, 90_000));
    first.speak();
    let vehicle = in_time(station.wait_vehicle(Some(VehicleId::new(1))).wait()).await.expect("open").expect("heard");
    let events = vehicle.subscribe_events(64);
    let begun = Instant::now();
    in_time(async {
        while vehicle.rival().is_none() {
            first.speak();
            second.speak();
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    assert!(vehicle.rival().expect("told").contains(&second.socket.local_addr().expect("bound").to_string()));
    let mut told = Vec::new();
    while let Taken::Item(observed) = events.take_ready() {
        told.push(observed.event);
    }
    assert!(told.contains(&VehicleEvent::Contested), "{told:?}");
    assert!(!told.contains(&VehicleEvent::Rebooted), "two clocks are no restart: {told:?}");
    // The second had been heard before it was known for what it is: what went there then does not count.
    let (_, _) = (first.heard(76), second.heard(76));
    let _request = vehicle.request(Request::ReturnToLaunch);
    in_time(async {
        while first.heard(76) + first.heard(75) == 0 {
            first.speak();
            second.speak();
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    assert_eq!(second.heard(76) + second.heard(75), 0, "not to the other");
    let _change = vehicle.change_signing(SigningChange::SetUp { key: None }, false);
    in_time(async {
        while first.heard(256) == 0 {
            first.speak();
            second.speak();
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    assert_eq!(second.heard(256), 0, "nor the key");
    // A person chooses the other one.
    assert_eq!(vehicle.follow_rival(), Ok(true));
    assert!(matches!(vehicle.plan_state(PlanKind::Mission), Some(vencejo_vehicle::PlanState::Unknown(_))));
    let _request = vehicle.request(Request::ReturnToLaunch);
    in_time(async {
        while second.heard(76) + second.heard(75) == 0 {
            second.speak();
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    station.close().await;
    let _ = std::fs::remove_dir_all(&folder);
}

fn roll(vehicle: &VehicleHandle) -> Option<f64> {
    vehicle.telemetry().0.attitude.and_then(|attitude| attitude.value.roll_rad)
}

/// What an autopilot says: its heartbeat, and an attitude at a time since boot.
fn speak(station: &Station, link: LinkId, (boot_ms, roll): (u64, f32), now: MonoTime) {
    let data = ATTITUDE_DATA { time_boot_ms: boot_ms as u32, roll, ..ATTITUDE_DATA::default() };
    let header = Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 };
    let attitude = Message::Dialect(MavMessage::ATTITUDE(data)).encode(header);
    for frame in [plane_heartbeat(1), attitude] {
        station.shared.on_frame(Origin { link, peer: PeerId(0) }, &frame, now);
    }
}

#[tokio::test]
async fn a_recording_takes_no_orders_and_no_live_vehicles_place() {
    let station = start();
    let played = station.open_link("tlog:/there/is/none.tlog", LinkOptions::default()).expect("opens");
    let (live, begun) = (LinkId(0), station.now());
    let at = |ms| begun + Duration::from_millis(ms);
    station.shared.on_frame(Origin { link: played, peer: PeerId(0) }, &plane_heartbeat(1), begun);
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let refused = |request| matches!(vehicle.request(request).end(), Some(Err(StationError::Replayed { .. })));
    let set = || Request::ParamSet { name: "WP_RADIUS".into(), value: 90.0 };
    assert!(refused(set()) && refused(Request::ParamList), "from its first message on");
    let message = Message::Heartbeat(Heartbeat::default());
    let error = vehicle.send(&message, false, None).expect_err("refused");
    assert_eq!(error.to_string(), "vehicle 1 is a recording that is replayed: it takes no orders");
    assert!(refused(Request::Disarm { force: true }), "before it is to be confirmed");
    let signing = vehicle.change_signing(SigningChange::SetUp { key: None }, true);
    assert_eq!(signing.end(), Some(Err(error)), "nor a key");
    assert_eq!(vehicle.is_reached(), None);
    speak(&station, played, (600_000, 0.5), at(0));
    assert_eq!(roll(&vehicle), Some(0.5));
    // What is live is followed at once, and stays so when it falls silent.
    speak(&station, live, (90_000, 0.1), at(100));
    speak(&station, played, (600_100, 0.5), at(200));
    assert_eq!(roll(&vehicle), Some(f64::from(0.1_f32)));
    assert!(vehicle.rival().is_some());
    for ms in (1_000..10_000).step_by(200) {
        speak(&station, played, (ms, 0.5), at(ms));
    }
    assert_eq!(roll(&vehicle), Some(f64::from(0.1_f32)));
    assert!(!refused(set()));
    // Nor is what another station was recorded to say done to what is live.
    let may_be_mixed = || vehicle.plan_state(PlanKind::Mission).is_some_and(|state| state.may_be_mixed());
    for (link, is_heard) in [(played, false), (live, true)] {
        let origin = Origin { link, peer: PeerId(0) };
        station.shared.on_frame(origin, &of_another_station(mission_count()), at(11_000));
        assert_eq!(may_be_mixed(), is_heard);
    }
    station.close().await;
}

fn mission_count() -> Message {
    let count = MISSION_COUNT_DATA { count: 9, target_system: 1, target_component: 1, ..Default::default() };
    Message::Dialect(MavMessage::MISSION_COUNT(count))
}

fn of_another_station(message: Message) -> Frame {
    message.encode(Header { sequence: 0, source: Address::new(245, 190), version: MavVersion::V2 })
}

/// A recorded flight in which another station's upload is cut or ends, played before the aircraft itself is heard: both
/// tell the same hardware.
#[tokio::test]
async fn a_recording_changes_nothing_in_what_is_remembered() {
    let folder = std::env::temp_dir().join(format!("vencejo-station-recorded-{}", std::process::id()));
    let of_plane =
        |message: Message| message.encode(Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 });
    let version = of_plane(Message::Dialect(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
        uid: 0x2a,
        ..Default::default()
    })));
    let ack = MissionAck { target: Address::new(245, 190), result: 0, mission_type: 0, opaque_id: 0 };
    let begins = of_another_station(mission_count());
    let whole = [plane_heartbeat(1), version, begins, of_plane(Message::MissionAck(ack))];
    let (told, cut) = (&whole[..2], &whole[..3]);
    // What is played and what is live, and whether the mission on board may be mixed after each.
    for (recorded, live, expected) in
        [(cut, told, [true, false]), (&[][..], cut, [false, true]), (&whole[..], told, [false, true])]
    {
        let config = StationConfig { missions_dir: Some(folder.clone()), ..StationConfig::default() };
        let station = Station::start(config, Handle::current()).expect("a station starts");
        let played = station.open_link("tlog:/there/is/none.tlog", LinkOptions::default()).expect("opens");
        for ((link, frames), expected) in [(played, recorded), (LinkId(0), live)].into_iter().zip(expected) {
            for frame in frames {
                station.shared.on_frame(Origin { link, peer: PeerId(0) }, frame, station.now());
            }
            let state = station.vehicle(VehicleId::new(1)).and_then(|vehicle| vehicle.plan_state(PlanKind::Mission));
            assert_eq!(state.is_some_and(|state| state.may_be_mixed()), expected, "{state:?}");
        }
        station.close().await;
        let is_written = crate::records::read_all(&folder).iter().any(|stored| stored.record.doubt.is_some());
        assert_eq!(is_written, expected[1]);
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[tokio::test]
async fn a_links_radio_is_that_of_the_vehicles_that_are_followed_there() {
    let station = start();
    let now = station.now();
    let hear = |(link, peer), frame: &Frame| {
        station.shared.on_frame(Origin { link: LinkId(link), peer: PeerId(peer) }, frame, now);
    };
    // The last two through bridges that send to one port.
    for (system, place) in [(1, (1, 0)), (2, (2, 0)), (3, (2, 1))] {
        hear(place, &plane_heartbeat(system));
    }
    let radio = MavMessage::RADIO_STATUS(RADIO_STATUS_DATA { rssi: 180, ..RADIO_STATUS_DATA::default() });
    let header = Header { sequence: 0, source: Address::new(51, 68), version: MavVersion::V2 };
    hear((2, 0), &Message::Dialect(radio).encode(header));
    let has_radio = |system| station.shared.telemetry(VehicleId::new(system)).0.radio.is_some();
    assert_eq!([1, 2, 3].map(has_radio), [false, true, false]);
    station.close().await;
}

#[tokio::test]
async fn a_second_link_that_is_seconds_late_overwrites_nothing_and_is_no_restart() {
    let station = start();
    let (begun, early, late) = (station.now(), LinkId(1), LinkId(2));
    let at = |ms| begun + Duration::from_millis(ms);
    speak(&station, early, (600_000, 0.25), begun);
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let events = vehicle.subscribe_events(64);
    let restarts = || {
        let mut told = 0;
        while let Taken::Item(observed) = events.take_ready() {
            told += u32::from(observed.event == VehicleEvent::Rebooted);
        }
        told
    };
    for ms in (100..10_000).step_by(100) {
        speak(&station, early, (600_000 + ms, 0.25), at(ms));
        speak(&station, late, (598_000 + ms, 0.5), at(ms));
        assert_eq!(roll(&vehicle), Some(0.25), "{ms}");
    }
    // The first falls silent: the other is taken from where the first ended.
    for ms in (10_000..15_000).step_by(100) {
        speak(&station, late, (598_000 + ms, 0.5), at(ms));
        assert_eq!(roll(&vehicle), Some(if ms < 11_900 { 0.25 } else { 0.5 }), "{ms}");
    }
    assert_eq!(restarts(), 0);
    for ms in (15_000..16_000).step_by(100) {
        speak(&station, late, (ms - 14_000, 0.5), at(ms));
    }
    assert_eq!(restarts(), 1, "that was one");
    station.close().await;
}

// fault 33: told within 5 s; our own echo is not
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_station_with_our_address_is_told_and_our_own_echo_is_not() {
    let station = start();
    let there = listening(&station).await;
    let peer = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    peer.connect(there).expect("connected");
    peer.send(plane_heartbeat(9).bytes()).expect("sent");
    // What we say comes back, twice each.
    peer.set_read_timeout(Some(LIMIT)).expect("set");
    let mut datagram = [0; 300];
    for _ in 0..3 {
        let size = peer.recv(&mut datagram).expect("we speak");
        for _ in 0..2 {
            peer.send(&datagram[..size]).expect("sent");
        }
    }
    peer.send(plane_heartbeat(8).bytes()).expect("sent");
    in_time(station.wait_vehicle(Some(VehicleId::new(8))).wait()).await.expect("open").expect("heard");
    assert_eq!(station.namesake(), None, "an echo is no station");
    let begun = Instant::now();
    for sequence in [200, 201] {
        let heartbeat = Message::Heartbeat(Heartbeat { custom_mode: 7, ..Heartbeat::default() });
        let header = Header { sequence, source: Address::new(255, 190), version: MavVersion::V2 };
        peer.send(heartbeat.encode(header).bytes()).expect("sent");
    }
    in_time(async {
        while station.namesake().is_none() {
            tokio::task::yield_now().await;
        }
    })
    .await;
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    assert!(station.namesake().expect("told").1.contains(&peer.local_addr().expect("bound").to_string()));
    station.close().await;
}

// fault 21: two answers in one reading: the caller hears of the first when the second has been heard too
#[tokio::test]
async fn a_caller_is_told_of_an_answer_when_all_that_came_with_it_has_been_heard() {
    let station = start();
    let now = station.now();
    station.hear(1, now);
    let vehicle = station.vehicle(VehicleId::new(1)).expect("heard");
    let speed = || Request::ChangeSpeed { kind: SpeedKind::Airspeed, speed_m_s: 20.0 };
    let answer = |result| {
        let ack = CommandAck { command: 178, result, progress: 0, result_param2: 0, target: Address::new(255, 190) };
        let header = Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 };
        let origin = Origin { link: LinkId(0), peer: PeerId(0) };
        station.shared.on_frame(origin, &Message::CommandAck(ack).encode(header), now);
    };
    let first = vehicle.request(speed());
    answer(0);
    assert!(first.end().is_none(), "not in the middle of it");
    answer(2);
    station.shared.on_read();
    assert!(matches!(first.end(), Some(Ok(_))));
    let second = vehicle.request(speed());
    station.shared.on_read();
    assert!(second.end().is_none(), "it waits for an answer of its own");
    answer(0);
    station.shared.on_read();
    assert!(matches!(second.end(), Some(Ok(_))));
}

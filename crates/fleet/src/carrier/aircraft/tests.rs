//! Lists and orders about them at a station on board, over real sessions: what arrives in parts, what is refused, what
//! is given to who asks.

use std::convert::Infallible;
use std::time::Duration;

use prost::Message as _;
use tokio::runtime::Handle;
use tokio::time::timeout;
use vencejo_flight::plan::{Mission, MissionItem};
use vencejo_link::LinkOptions;
use vencejo_proto::dialect::{MavMessage, MavParamType, PARAM_VALUE_DATA};
use vencejo_proto::{Address, FrameDecoder, Header, Heartbeat, MavVersion, Message};
use vencejo_station::StationConfig;
use zenoh::Session;

use super::*;
use crate::carrier::network::{Part as Place, Replies};
use crate::content::{Content, Part, pack_items};
use crate::deed::{Act, Deed, Nothing, PlanPut};
use crate::payload::{Answer, Ask, End, Order, Signed, State, VERSION, Want};
use crate::signature::Signer;

const WAIT: Duration = Duration::from_secs(20);

/// A ground station that says what a test wants it to say.
struct Bench {
    session: Session,
    state: State,
    operator: &'static str,
    epoch: u64,
    next: u128,
}

impl Bench {
    async fn tell(&mut self, signer: &Signer, want: Want) -> Answer {
        self.next += 1;
        let order = Order {
            version: VERSION,
            org: "acme".into(),
            aircraft: "plane7".into(),
            boot: self.state.boot,
            epoch: self.epoch,
            id: self.next.to_be_bytes().to_vec(),
            based_on_ms: self.state.clock_ms,
            operator: self.operator.into(),
            mark: self.state.mark,
            run: 0,
            want: Some(want),
        }
        .encode_to_vec();
        let signature = signer.sign(&order);
        let signed = Signed { key: signer.public().0.to_vec(), order, signature }.encode_to_vec();
        // Beside busy neighbours a reading that nobody answers at first takes its time.
        match network::ask(&self.session, "vencejo/1/acme/plane7/order", signed, 3 * WAIT).await {
            Replies::Answers(answers) => Answer::read(&answers[0]).expect("an answer"),
            other => panic!("{other:?}"),
        }
    }

    /// Looks until there is something to see.
    async fn look(&mut self) {
        let looked = timeout(WAIT, async {
            loop {
                let key = "vencejo/1/acme/plane7/state";
                if let Replies::Answers(states) = network::ask(&self.session, key, Vec::new(), WAIT).await {
                    return State::read(&states[0]).expect("a state");
                }
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        });
        self.state = looked.await.expect("the aircraft is there");
    }

    async fn piece(&self, digest: &str) -> Vec<Vec<u8>> {
        let key = format!("vencejo/1/acme/plane7/list?list={digest};from=0");
        match network::ask(&self.session, &key, Vec::new(), WAIT).await {
            Replies::Answers(answers) => answers,
            other => panic!("{other:?}"),
        }
    }
}

/// A station on board, which hears its plane.
pub(in super::super) async fn on_board() -> Station {
    beside_plane().await.0
}

/// The same, and the plane.
pub(in super::super) async fn beside_plane() -> (Station, Plane) {
    // What the plane hears is what was ordered.
    let config = StationConfig { request_streams: false, heartbeat: false, ..StationConfig::default() };
    let station = Station::start(config, Handle::current()).expect("a station");
    let link = station.open_link("udpin:127.0.0.1:0", LinkOptions::default()).expect("a link");
    let plane = tokio::net::UdpSocket::bind("127.0.0.1:0").await.expect("a socket");
    let at = timeout(WAIT, async {
        loop {
            if let Some(at) = station.local_address(link) {
                return at;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    });
    plane.connect(at.await.expect("it is open")).await.expect("connected");
    let plane = Plane(plane);
    let heard = station.wait_vehicle(None);
    let found = timeout(WAIT, async {
        while heard.end().is_none() {
            plane.say(&heartbeat()).await;
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    });
    found.await.expect("it is heard");
    (station, plane)
}

fn heartbeat() -> Message {
    Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() })
}

/// An autopilot that says what a test wants it to say.
pub(in super::super) struct Plane(tokio::net::UdpSocket);

impl Plane {
    pub(in super::super) async fn say(&self, message: &Message) {
        let frame = message.encode(Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 });
        self.0.send(frame.bytes()).await.expect("sent");
    }

    /// Waits until the station on board has sent it a message of this id.
    pub(in super::super) async fn hears(&self, id: u32) {
        let heard = timeout(WAIT, async {
            let (mut decoder, mut buffer) = (FrameDecoder::new(), [0; 2048]);
            loop {
                let count = self.0.recv(&mut buffer).await.expect("received");
                decoder.push_datagram(&buffer[..count]);
                while let Some(frame) = decoder.next_frame() {
                    if frame.message_id() == id {
                        return;
                    }
                }
            }
        });
        heard.await.unwrap_or_else(|_| panic!("no message {id}"));
    }

    /// Whether it was sent a message of these ids since this was asked last.
    pub(in super::super) fn has_heard(&self, ids: &[u32]) -> bool {
        let (mut decoder, mut buffer, mut has_heard) = (FrameDecoder::new(), [0; 2048], false);
        while let Ok(count) = self.0.try_recv(&mut buffer) {
            decoder.push_datagram(&buffer[..count]);
            has_heard |= std::iter::from_fn(|| decoder.next_frame()).any(|frame| ids.contains(&frame.message_id()));
        }
        has_heard
    }
}

async fn router() -> (Session, Endpoint) {
    let at: Endpoint = "tcp/127.0.0.1:0".parse().expect("an address");
    let at = at.with_port().expect("a port");
    (network::open(Place::Router(&at, &[], None), None).await.expect("a router"), at)
}

fn plane7(dial: Vec<Endpoint>, trust: BTreeMap<PublicKey, Role>) -> AircraftConfig {
    AircraftConfig {
        org: "acme".parse().expect("a name"),
        name: "plane7".parse().expect("a name"),
        dial,
        member: None,
        trust,
        uplink_bit_s: None,
        history: None,
    }
}

pub(in super::super) async fn until(what: &str, holds: impl Fn() -> bool) {
    // An aircraft that comes before the router has heard of it is admitted at its next attempt.
    let waited = timeout(3 * WAIT, async {
        while !holds() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    });
    assert!(waited.await.is_ok(), "{what}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn to_nobody_it_says_little_and_it_goes_to_the_next_router_when_one_has_gone() {
    let station = on_board().await;
    let ((first, at), (second, beside)) = (router().await, router().await);
    let aircraft = Aircraft::start(station.clone(), plane7(vec![at, beside], BTreeMap::new()), &Handle::current())
        .expect("aboard");
    until("it is there", || aircraft.status().is_connected).await;
    until("nobody hears it", || aircraft.status().rate_hz == 0.2).await;
    let states = first.declare_subscriber("vencejo/1/acme/*/state").await.expect("declared");
    until("somebody hears it", || aircraft.status().rate_hz >= 0.5).await;
    let told = timeout(WAIT, states.recv_async()).await.expect("a state").expect("a state");
    assert_eq!(told.key_expr().as_str(), "vencejo/1/acme/plane7/state");
    drop(states);
    until("nobody hears it any more", || aircraft.status().rate_hz == 0.2).await;

    let states = second.declare_subscriber("vencejo/1/acme/*/state").await.expect("declared");
    first.close().await.expect("closed");
    timeout(WAIT, states.recv_async()).await.expect("a state over the other router").expect("a state");
    aircraft.close().await;
    second.close().await.expect("closed");
    station.close().await;
}

/// Whether a link that opens now is greeted by a heartbeat.
async fn beats(station: &Station) -> bool {
    let peer = tokio::net::UdpSocket::bind("127.0.0.1:0").await.expect("a socket");
    let address = format!("udpout:{}", peer.local_addr().expect("bound"));
    let link = station.open_link(&address, LinkOptions::default()).expect("a link");
    until("it opens", || station.local_address(link).is_some()).await;
    station.close_link(link).await.expect("closed");
    peer.try_recv(&mut [0; 300]).is_ok()
}

/// An autopilot that has heard a ground station once waits for its next heartbeat: a failsafe would follow upon each
/// act.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_autopilot_hears_a_station_while_somebody_stays_and_not_for_one_act() {
    let station = on_board().await;
    let (session, at) = router().await;
    let config = plane7(vec![at], BTreeMap::new());
    let aircraft = Aircraft::start(station.clone(), config, &Handle::current()).expect("aboard");
    let node = station.enlist("node").asking();
    let has_it = || node.act(station.now()).is_ok() && aircraft.status().holder.as_deref() == Some("node");
    until("it is told who acts", has_it).await;
    assert!(!beats(&station).await);
    node.attach(station.now());
    let hears = timeout(WAIT, async { while !beats(&station).await {} });
    hears.await.expect("it stays");
    aircraft.close().await;
    session.close().await.expect("closed");
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_list_arrives_in_parts_and_an_order_that_is_about_another_plan_is_refused() {
    let station = on_board().await;
    let (ana, eve) = (Signer::from_seed(&[1; 32]), Signer::from_seed(&[2; 32]));
    let (session, at) = router().await;
    let config = plane7(vec![at], [(ana.public(), Role::Operator)].into());
    let aircraft = Aircraft::start(station.clone(), config, &Handle::current()).expect("an aircraft");
    let mut bench = Bench { session, state: State::default(), operator: "Ana", epoch: 0, next: 0 };
    bench.look().await;
    assert_eq!(bench.state.plans.len(), 3, "whoever has just come is told all");
    assert!(bench.state.plans.iter().all(|told| told.read().is_ok()));
    let granted = bench.tell(&ana, Want::Ask(Ask::default())).await;
    bench.epoch = granted.epoch;
    assert_eq!(station.control().holder().as_deref(), Some("Ana"));

    // A list of more than a part, of which no bytes are alike.
    let item =
        |n: i32| MissionItem::waypoint(f64::from(n).sin() * 80.0, f64::from(n).cos() * 170.0, f64::from(n) * 0.37);
    let packed = pack_items(&Mission { home: None, items: (0..900).map(item).collect() });
    let (parts, name) = (Part::all_of(&packed), Content::of(packed.clone()).at_most(0));
    assert!(parts.len() > 1);
    let put = |revision| {
        let list = Some(name.clone());
        let deed = Deed::PlanPut(PlanPut { kind: 0, revision, list, despite_findings: true });
        Want::Act(Act { deed: Some(deed), ..Act::default() })
    };
    assert_eq!(bench.tell(&ana, put(1)).await.end(), End::ListMissing);
    assert_eq!(bench.tell(&eve, Want::Part(parts[0].clone())).await.end(), End::Refused, "of somebody else");
    for part in parts.iter().rev().chain(&parts[..1]) {
        assert_eq!(bench.tell(&ana, Want::Part(part.clone())).await.end(), End::Done);
    }
    bench.operator = "Ben";
    let refused = bench.tell(&ana, put(99)).await;
    assert_eq!(station.control().holder().as_deref(), Some("Ben"), "who acts there now");
    assert_eq!(refused.end(), End::Refused);
    assert!(refused.why.contains("mission on board has changed"), "{}", refused.why);
    let digest = name.name().expect("a name").0.to_string();
    assert_eq!(bench.piece(&digest).await, [packed[..crate::pull::PIECE_BYTES].to_vec()], "what lies there is given");
    assert_eq!(bench.piece(&"0".repeat(64)).await, [Vec::<u8>::new()], "and nothing else");

    let read = Want::Act(Act { deed: Some(Deed::ParamRead("a b".into())), ..Act::default() });
    assert_eq!(bench.tell(&eve, read.clone()).await.end(), End::Refused, "to read a key has to be trusted");
    bench.epoch = 0;
    let read = bench.tell(&ana, read).await;
    assert_eq!(read.end(), End::Refused, "without control, and for its own reason: {read:?}");
    assert!(read.why.contains("not a parameter name"), "{}", read.why);
    aircraft.close().await;
    bench.session.close().await.expect("closed");
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_reading_that_one_gives_up_goes_on_for_the_others() {
    const PARAM_REQUEST_LIST: u32 = 21;
    const PARAMETERS: u16 = 900;
    let (station, plane) = beside_plane().await;
    let signers = [1, 2].map(|seed| Signer::from_seed(&[seed; 32]));
    let (session, at) = router().await;
    let trust = signers.iter().map(|signer| (signer.public(), Role::Observer)).collect();
    let aircraft = Aircraft::start(station.clone(), plane7(vec![at], trust), &Handle::current()).expect("an aircraft");
    let read = || Want::Act(Act { deed: Some(Deed::ParamList(Nothing {})), ..Act::default() });
    let bench = |next, state| Bench { session: session.clone(), state, operator: "", epoch: 0, next };
    // One look for all: with four, the first one's state would be too old on a busy machine.
    let mut first = bench(100, State::default());
    first.look().await;
    let [mut second, mut recalling, mut after_it] = [200, 300, 400].map(|next| bench(next, first.state.clone()));
    let (asked, asked_too, recalled) = {
        let [one, two] = &signers;
        (first.tell(one, read()), second.tell(two, read()), async {
            plane.hears(PARAM_REQUEST_LIST).await;
            // Orders are taken up as they come: with the answer to this one, the second waits for the reading as well.
            let no_name = Want::Act(Act { deed: Some(Deed::ParamRead("a b".into())), ..Act::default() });
            assert_eq!(after_it.tell(two, no_name).await.end(), End::Refused);
            recalling.tell(one, Want::Recall(101_u128.to_be_bytes().to_vec())).await
        })
    };
    // It is heard and answers, also where this takes long: a value at a time until one has given up, then all of them.
    let next = std::cell::Cell::new(0);
    let flies = async |at_once: u16| -> Infallible {
        loop {
            plane.say(&heartbeat()).await;
            for _ in 0..at_once {
                let param_index = next.replace((next.get() + 1) % PARAMETERS);
                let mut param_id = [0; 16];
                param_id[..4].copy_from_slice(format!("P{param_index:03}").as_bytes());
                let value = PARAM_VALUE_DATA {
                    param_id: param_id.into(),
                    param_value: 90.0,
                    param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
                    param_index,
                    param_count: PARAMETERS,
                };
                plane.say(&Message::Dialect(MavMessage::PARAM_VALUE(value))).await;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    let ended = async {
        let (answer, recalled) = tokio::select! {
            both = async { tokio::join!(asked, recalled) } => both,
            never = flies(1) => match never {},
        };
        assert_eq!((answer.end(), recalled.end()), (End::Unknown, End::Done));
        flies(100).await
    };
    let answer = timeout(3 * WAIT, async {
        tokio::select! {
            biased; // it is sent before the order after it
            answer = asked_too => answer,
            never = ended => match never {},
        }
    });
    let answer = answer.await.expect("it ends");
    assert_eq!(answer.end(), End::Done, "{}", answer.why);
    aircraft.close().await;
    session.close().await.expect("closed");
    station.close().await;
}

//! A load generator: many light aircraft in one process, with the payloads that a station on board sends and its authority over orders, over
//! sessions of fifty aircraft each. They circle around Getafe; with `troubled` some of each fifty are lost, late, low on battery, held by
//! somebody else, or warn.
//!
//! `crowd ROUTER ORG COUNT RATE_HZ [troubled]`, for instance `crowd tcp/127.0.0.1:7447 acme 1000 10`. Prints one line once all are there;
//! ends with its standard input.

#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::collections::BTreeMap;
use std::error::Error;
use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use prost::Message as _;
use vencejo_fleet::act;
use vencejo_fleet::authority::{Authority, Caller, Claim, Role, Verdict, Wish, answer};
use vencejo_fleet::key::{Kind, Name, aircraft_of, key_of};
use vencejo_fleet::operator::random;
use vencejo_fleet::payload::{Answer, End, Event, Order, Signed, Want};
use vencejo_fleet::signature::PublicKey;
use vencejo_fleet::speech::Speaker;
use vencejo_proto::dialect::{
    ATTITUDE_DATA, BATTERY_STATUS_DATA, EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA, MISSION_CURRENT_DATA,
    MavLandedState, MavMessage, VFR_HUD_DATA,
};
use vencejo_proto::{Address, Header, Heartbeat, MavVersion, Message, MonoTime, StatusText};
use vencejo_station::StationError;
use vencejo_vehicle::{Reply, Request, VehicleError};
use zenoh::Wait;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Query;

/// ArduPlane's mode numbers.
const MODES: [u32; 4] = [10, 12, 11, 5];
/// Every plane has the same on board, as most have.
const OWN: Address = Address::new(1, 1);
const AIRCRAFT_OF_SESSION: usize = 50;

/// What goes wrong with one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trouble {
    None,
    Lost,
    Late,
    LowBattery,
    HeldElsewhere,
    Warns,
    OnGround,
}

impl Trouble {
    fn of(index: usize) -> Self {
        match index % 50 {
            7 => Self::LowBattery,
            13 => Self::Lost,
            21 => Self::HeldElsewhere,
            29 => Self::Warns,
            37 => Self::Late,
            43 => Self::OnGround,
            _ => Self::None,
        }
    }
}

struct Plane {
    name: Name,
    index: usize,
    trouble: Trouble,
    speaker: Speaker,
    authority: Authority,
    mode: u32,
    is_armed: bool,
    next_slow: MonoTime,
}

impl Plane {
    fn new(index: usize, is_troubled: bool) -> Result<Self, Box<dyn Error>> {
        let boot = u64::from_be_bytes(random()?);
        let trouble = if is_troubled { Trouble::of(index) } else { Trouble::None };
        let mut authority = Authority::new(boot);
        if trouble == Trouble::HeldElsewhere {
            authority.set_local(Some("Field team".to_owned()));
        }
        Ok(Self {
            name: format!("plane{index:04}").parse()?,
            index,
            trouble,
            speaker: Speaker::new(boot, OWN),
            authority,
            mode: MODES[usize::from(index % 10 == 3) + 2 * usize::from(index % 25 == 11)],
            is_armed: trouble != Trouble::OnGround,
            next_slow: MonoTime::ZERO,
        })
    }

    fn say(&mut self, message: &Message, now: MonoTime) -> Option<Event> {
        let frame = message.encode(Header { sequence: 0, source: OWN, version: MavVersion::V2 });
        self.speaker.on_frame(&frame, now)
    }

    /// Flies on: what it says at its rate, and once a second the rest; the events that are to be told at once.
    fn fly(&mut self, now: MonoTime) -> Vec<Event> {
        let (t, n) = (now.as_duration().as_secs_f64(), self.index as f64);
        let (radius_m, speed_m_s) = (400.0 + n % 7.0 * 60.0, 17.0 + n % 5.0);
        let angle = t * speed_m_s / radius_m + n;
        let (sin, cos) = angle.sin_cos();
        let (row, column) = ((self.index / 32) as f64, (self.index % 32) as f64);
        let flies = f64::from(u8::from(self.is_armed));
        let lat_deg = 40.30 + row * 0.012 + flies * radius_m * cos / 111_200.0;
        let lon_deg = -3.90 + column * 0.016 + flies * radius_m * sin / 84_700.0;
        let height_m = flies * (80.0 + n % 40.0 * 3.0);
        let heading_deg = (angle.to_degrees() + 90.0).rem_euclid(360.0);
        let boot_ms = now.as_duration().as_millis() as u32;
        let fast = [
            MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
                time_boot_ms: boot_ms,
                lat: (lat_deg * 1e7) as i32,
                lon: (lon_deg * 1e7) as i32,
                alt: ((620.0 + height_m) * 1e3) as i32,
                relative_alt: (height_m * 1e3) as i32,
                vx: (-flies * speed_m_s * sin * 100.0) as i16,
                vy: (flies * speed_m_s * cos * 100.0) as i16,
                vz: 0,
                hdg: (heading_deg * 100.0) as u16,
            }),
            MavMessage::ATTITUDE(ATTITUDE_DATA {
                time_boot_ms: boot_ms,
                roll: 0.3,
                pitch: 0.05,
                yaw: heading_deg.to_radians() as f32,
                ..ATTITUDE_DATA::default()
            }),
            MavMessage::VFR_HUD(VFR_HUD_DATA {
                airspeed: (flies * speed_m_s) as f32,
                groundspeed: (flies * speed_m_s) as f32,
                alt: (620.0 + height_m) as f32,
                heading: heading_deg as i16,
                throttle: 45,
                ..VFR_HUD_DATA::default()
            }),
        ];
        let mut events: Vec<_> =
            fast.into_iter().filter_map(|message| self.say(&Message::Dialect(message), now)).collect();
        if now >= self.next_slow {
            self.next_slow = now + Duration::from_secs(1);
            events.extend(self.slow(now, t));
        }
        events
    }

    fn slow(&mut self, now: MonoTime, t: f64) -> Vec<Event> {
        let base_mode = if self.is_armed { 0x81 } else { 0x01 };
        let heartbeat = Heartbeat {
            mav_type: 1,
            autopilot: 3,
            base_mode,
            custom_mode: self.mode,
            system_status: 4,
            mavlink_version: 3,
        };
        let left = match self.trouble {
            Trouble::LowBattery => 12,
            _ => 98 - ((t as usize / 20 + self.index) % 60) as i8,
        };
        let landed = if self.is_armed {
            MavLandedState::MAV_LANDED_STATE_IN_AIR
        } else {
            MavLandedState::MAV_LANDED_STATE_ON_GROUND
        };
        let mut voltages = [u16::MAX; 10];
        voltages[0] = 11_400;
        let said = [
            Message::Heartbeat(heartbeat),
            Message::Dialect(MavMessage::BATTERY_STATUS(BATTERY_STATUS_DATA {
                battery_remaining: left,
                voltages,
                ..BATTERY_STATUS_DATA::default()
            })),
            Message::Dialect(MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA {
                seq: 1 + ((t as usize / 15 + self.index) % 24) as u16,
                total: 24,
                ..MISSION_CURRENT_DATA::default()
            })),
            Message::Dialect(MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
                landed_state: landed,
                ..EXTENDED_SYS_STATE_DATA::default()
            })),
        ];
        let mut events: Vec<_> = said.iter().filter_map(|message| self.say(message, now)).collect();
        if self.trouble == Trouble::Warns && t as u64 % 20 == 2 {
            let text = StatusText { severity: 2, text: "EKF3 lane switch 1".into(), id: 0, chunk_seq: 0 };
            events.extend(self.say(&Message::StatusText(text), now));
        }
        events
    }

    /// Whether it says something in this round.
    fn speaks(&self, round: u64, rate_hz: u64) -> bool {
        match self.trouble {
            Trouble::Lost => round < 8 * rate_hz,
            Trouble::Late => round.is_multiple_of(4 * rate_hz),
            _ => true,
        }
    }

    /// What becomes of an order.
    fn on_order(&mut self, bytes: &[u8], now: MonoTime) -> Option<Answer> {
        let signed = Signed::read(bytes).ok()?;
        let order = Order::read(&signed.order).ok()?;
        let wish = match order.want.as_ref()? {
            Want::Ask(_) => Wish::Ask,
            Want::Renew(_) => Wish::Renew,
            Want::Release(_) => Wish::Release,
            Want::Grant(_) | Want::Part(_) | Want::Recall(_) => return None,
            Want::Act(_) => Wish::Act,
        };
        let based_on = MonoTime::from_millis(order.based_on_ms);
        let claim = Claim { boot: order.boot, epoch: order.epoch, id: order.id(), based_on, wish };
        let key = PublicKey(signed.key.as_slice().try_into().ok()?);
        if !key.verifies(&signed.order, &signed.signature) {
            return Some(answer(&claim, End::Refused, "its signature is wrong"));
        }
        let caller = Caller { key, name: order.operator.clone(), role: Role::Operator };
        match self.authority.on_order(&caller, &claim, now) {
            Verdict::Answer(answer) => Some(*answer),
            Verdict::UnderWay => None,
            Verdict::Execute => {
                let Some(Want::Act(act)) = &order.want else { return None };
                let result = self.execute(&act::request_of(act).ok()?.0);
                let answer = act::answer_of(&claim, &result);
                self.authority.on_ended(claim.id, answer.clone(), now);
                Some(answer)
            }
        }
    }

    fn execute(&mut self, request: &Request) -> Result<Reply, StationError> {
        self.mode = match request {
            Request::DespiteMixedPlan(request) => return self.execute(request),
            Request::ReturnToLaunch => 11,
            Request::LoiterHere | Request::MissionPause => 12,
            Request::MissionResume | Request::MissionStart { .. } => 10,
            _ => return Err(StationError::Vehicle(VehicleError::Cancelled)),
        };
        // The next state shows it.
        self.next_slow = MonoTime::ZERO;
        Ok(Reply::Done)
    }
}

type Planes = Arc<BTreeMap<Name, Mutex<Plane>>>;

fn lock(plane: &Mutex<Plane>) -> MutexGuard<'_, Plane> {
    plane.lock().unwrap_or_else(PoisonError::into_inner)
}

fn open(router: &str) -> Result<zenoh::Session, Box<dyn Error>> {
    let mut config = zenoh::Config::default();
    let endpoints = format!("[\"{router}\"]");
    for (key, value) in [
        ("mode", "\"client\""),
        ("connect/endpoints", endpoints.as_str()),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
    ] {
        config.insert_json5(key, value).map_err(|error| error.to_string())?;
    }
    Ok(zenoh::open(config).wait().map_err(|error| error.to_string())?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<_> = std::env::args().skip(1).collect();
    let usage = "crowd ROUTER ORG COUNT RATE_HZ [troubled]";
    let [router, org, count, rate_hz, rest @ ..] = args.as_slice() else { return Err(usage.into()) };
    let (org, count, rate_hz): (Name, usize, u64) = (org.parse()?, count.parse()?, rate_hz.parse()?);
    if !(1..=50).contains(&rate_hz) {
        return Err("RATE_HZ goes from 1 to 50".into());
    }
    let is_troubled = rest.iter().any(|word| word == "troubled");
    let began = Instant::now();
    let now = move || MonoTime::from_origin(began.elapsed());
    let planes = (0..count).map(|index| Plane::new(index, is_troubled));
    let planes = planes.map(|plane| plane.map(|plane| (plane.name.clone(), Mutex::new(plane))));
    let planes: Planes = Arc::new(planes.collect::<Result<_, _>>()?);
    let all: Vec<Name> = planes.keys().cloned().collect();
    let mut sessions = Vec::new();
    let mut declared = Vec::new();
    for names in all.chunks(AIRCRAFT_OF_SESSION) {
        let session = open(router)?;
        for name in names {
            for kind in [Kind::Order, Kind::State, Kind::Event] {
                let (whose, planes) = (org.clone(), planes.clone());
                let answering = move |query: Query| on_query(&whose, &planes, kind, &query, now());
                let queryable = session.declare_queryable(key_of(&org, name, kind));
                declared.push(queryable.complete(true).callback(answering).wait().map_err(|error| error.to_string())?);
            }
            let token = session.liveliness().declare_token(key_of(&org, name, Kind::Alive));
            // For as long as the process lives.
            std::mem::forget(token.wait().map_err(|error| error.to_string())?);
        }
        sessions.push((session, names.to_vec()));
    }
    println!("{{\"aircraft\": {count}, \"took_s\": {:.2}}}", began.elapsed().as_secs_f64());
    let is_over = Arc::new(AtomicBool::new(false));
    let over = is_over.clone();
    std::thread::spawn(move || {
        // Whatever ends it, it is the end.
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        over.store(true, Ordering::Relaxed);
    });
    let period = Duration::from_secs(1) / u32::try_from(rate_hz)?;
    let (mut round, mut bytes) = (0_u64, 0_usize);
    while !is_over.load(Ordering::Relaxed) {
        for (session, names) in &sessions {
            for name in names {
                let mut plane = lock(&planes[name]);
                let events = plane.fly(now());
                if !plane.speaks(round, rate_hz) {
                    continue;
                }
                let held = plane.authority.held();
                plane.authority.on_time(now());
                let state = plane.speaker.sample(held, now());
                drop(plane);
                for event in events {
                    put(session, &key_of(&org, name, Kind::Event), event.encode_to_vec(), Priority::InteractiveHigh)?;
                }
                let state = state.encode_to_vec();
                bytes += state.len();
                put(session, &key_of(&org, name, Kind::State), state, Priority::Data)?;
            }
        }
        round += 1;
        let due = period * u32::try_from(round)?;
        std::thread::sleep(due.saturating_sub(began.elapsed()).min(period));
    }
    println!("{{\"rounds\": {round}, \"bytes\": {bytes}, \"s\": {:.1}}}", began.elapsed().as_secs_f64());
    Ok(())
}

fn put(session: &zenoh::Session, key: &str, payload: Vec<u8>, priority: Priority) -> Result<(), Box<dyn Error>> {
    let put = session.put(key, payload).congestion_control(CongestionControl::Drop).priority(priority);
    put.wait().map_err(|error| error.to_string().into())
}

fn on_query(org: &Name, planes: &Planes, kind: Kind, query: &Query, now: MonoTime) {
    let asked = query.key_expr().as_str().to_owned();
    let Some(plane) = aircraft_of(org, kind, &asked).and_then(|name| planes.get(&name)) else { return };
    let mut plane = lock(plane);
    let answers = match kind {
        Kind::Order => {
            let payload = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
            plane.on_order(&payload, now).map(|answer| answer.encode_to_vec()).into_iter().collect()
        }
        Kind::State => {
            let held = plane.authority.held();
            vec![plane.speaker.everything(held, now).encode_to_vec()]
        }
        Kind::Event => {
            let from = query.parameters().get("from").and_then(|from| from.parse().ok()).unwrap_or(1);
            plane.speaker.events_from(from).map(Event::encode_to_vec).collect::<Vec<_>>()
        }
        Kind::Alive | Kind::List | Kind::HistoryIndex | Kind::HistoryChunk => Vec::new(),
    };
    drop(plane);
    for bytes in answers {
        // Whoever asked asks again.
        let _ = query.reply(asked.clone(), bytes).wait();
    }
}

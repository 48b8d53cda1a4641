//! A load generator: many light aircraft in one process, each with a session of its own, the payloads that a station on
//! board sends, its authority over orders and its echo each second. They circle around Getafe; with `troubled` some of
//! each fifty are lost, late, low on battery, held by somebody else, or warn. With `stamped` each state carries its
//! number and when it was put, for `listen`, and the time in its ATTITUDE is UTC in µs, modulo 2^32.
//!
//! `crowd ROUTER ORG COUNT RATE_HZ [troubled] [stamped]`, for instance `crowd tcp/127.0.0.1:7447 acme 1000 10`. Prints
//! one line once all are there; ends with its standard input.

#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::error::Error;
use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use prost::Message as _;
use vencejo_fleet::act;
use vencejo_fleet::authority::{Authority, Caller, Claim, Role, Verdict, Wish, answer};
use vencejo_fleet::carrier::{Endpoint, session_of_an_aircraft};
use vencejo_fleet::key::{Kind, Name, echo_key, key_of};
use vencejo_fleet::operator::random;
use vencejo_fleet::payload::{Answer, End, Event, Order, Signed, Want};
use vencejo_fleet::signature::PublicKey;
use vencejo_fleet::stamp::{Stamper, StateStamp};
use vencejo_fleet::state_source::StateSource;
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
/// Sessions that are opened at once.
const OPENED_AT_ONCE: usize = 50;
/// The shortest sleep between two aircraft: they speak one after another, as if each had begun at another moment.
const NAP: Duration = Duration::from_millis(1);

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
    source: StateSource,
    authority: Authority,
    mode: u32,
    is_armed: bool,
    is_stamped: bool,
    next_slow: MonoTime,
}

/// UTC in µs.
fn utc_us() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| u64::try_from(since.as_micros()).unwrap_or(u64::MAX))
}

impl Plane {
    fn new(index: usize, is_troubled: bool, is_stamped: bool) -> Result<Self, Box<dyn Error>> {
        let boot = u64::from_be_bytes(random()?);
        let trouble = if is_troubled { Trouble::of(index) } else { Trouble::None };
        let stamper = Stamper::new(&random()?);
        let mut authority = Authority::new(boot, MonoTime::ZERO, stamper.clone());
        if trouble == Trouble::HeldElsewhere {
            authority.set_local(Some("Field team".to_owned()));
        }
        Ok(Self {
            name: format!("plane{index:04}").parse()?,
            index,
            trouble,
            source: StateSource::new(boot, OWN, stamper),
            authority,
            mode: MODES[usize::from(index % 10 == 3) + 2 * usize::from(index % 25 == 11)],
            is_armed: trouble != Trouble::OnGround,
            is_stamped,
            next_slow: MonoTime::ZERO,
        })
    }

    fn say(&mut self, message: &Message, now: MonoTime) -> Option<Event> {
        let frame = message.encode(Header { sequence: 0, source: OWN, version: MavVersion::V2 });
        self.source.on_frame(&frame, now)
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
                time_boot_ms: if self.is_stamped { utc_us() as u32 } else { boot_ms },
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
            Want::Ask(how) => Wish::Ask(*how),
            Want::Renew(_) => Wish::Renew,
            Want::Release(_) => Wish::Release,
            Want::Keep(_) | Want::Part(_) | Want::Recall(_) => return None,
            Want::Act(_) => Wish::Act,
        };
        let based_on = StateStamp { at: MonoTime::from_millis(order.based_on_ms), mark: order.mark };
        let claim = Claim { boot: order.boot, epoch: order.epoch, id: order.id(), based_on, wish };
        let key = PublicKey(signed.key.as_slice().try_into().ok()?);
        if !key.verifies(&signed.order, &signed.signature) {
            return Some(answer(&claim, End::Refused, "its signature is wrong"));
        }
        let caller = Caller { key, run: order.run, name: order.operator.clone(), role: Role::Operator };
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

fn lock(plane: &Mutex<Plane>) -> MutexGuard<'_, Plane> {
    plane.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An aircraft on the network.
struct Aloft {
    plane: Arc<Mutex<Plane>>,
    session: zenoh::Session,
    state_key: String,
    event_key: String,
}

impl Aloft {
    async fn new(router: Endpoint, org: Name, plane: Plane, began: Instant) -> Result<Self, String> {
        let words = |error: zenoh::Error| error.to_string();
        let session = session_of_an_aircraft(&router).await.map_err(|error| error.to_string())?;
        let key = |kind| key_of(&org, &plane.name, kind);
        let keys = [Kind::Order, Kind::State, Kind::Event, Kind::Alive].map(key);
        let [order_key, state_key, event_key, alive_key] = keys;
        let plane = Arc::new(Mutex::new(plane));
        for (kind, key) in [(Kind::Order, &order_key), (Kind::State, &state_key), (Kind::Event, &event_key)] {
            let (asked, runtime) = (plane.clone(), tokio::runtime::Handle::current());
            let answering = move |query: Query| {
                let answers = answers_to(&asked, kind, &query, MonoTime::from_origin(began.elapsed()));
                // Aside: an answer waits for the network, and what waits here reads nothing, not even that a router has
                // gone.
                runtime.spawn(async move {
                    for bytes in answers {
                        // Whoever asked asks again.
                        let _ = query.reply(query.key_expr().clone(), bytes).await;
                    }
                });
            };
            // For as long as the session lives, as the token.
            session.declare_queryable(key).complete(true).callback(answering).background().await.map_err(words)?;
        }
        std::mem::forget(session.liveliness().declare_token(alive_key).await.map_err(words)?);
        Ok(Self { plane, session, state_key, event_key })
    }

    /// Says what there is to say; the bytes of its state.
    fn speak(&self, now: MonoTime, says_state: bool) -> Result<usize, Box<dyn Error>> {
        let mut plane = lock(&self.plane);
        let events = plane.fly(now);
        if !says_state {
            return Ok(0);
        }
        let held = plane.authority.held();
        plane.authority.on_time(now);
        let state = plane.source.sample(held, now);
        let is_stamped = plane.is_stamped;
        drop(plane);
        for event in events {
            self.put(&self.event_key, event.encode_to_vec(), Priority::InteractiveHigh, None)?;
        }
        let payload = state.encode_to_vec();
        let bytes = payload.len();
        let stamp = is_stamped.then(|| [state.sequence.to_le_bytes(), utc_us().to_le_bytes()].concat());
        self.put(&self.state_key, payload, Priority::Data, stamp)?;
        Ok(bytes)
    }

    fn put(
        &self,
        key: &str,
        payload: Vec<u8>,
        priority: Priority,
        stamp: Option<Vec<u8>>,
    ) -> Result<(), Box<dyn Error>> {
        let put = self.session.put(key, payload).congestion_control(CongestionControl::Drop).priority(priority);
        put.attachment(stamp).wait().map_err(|error| error.to_string().into())
    }

    /// Asks the router for an echo; what comes back is not looked at.
    fn ask_echo(&self, key: &str) -> Result<(), Box<dyn Error>> {
        let get = self.session.get(key).congestion_control(CongestionControl::Drop).priority(Priority::RealTime);
        get.express(true).callback(drop).wait().map_err(|error| error.to_string().into())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<_> = std::env::args().skip(1).collect();
    let usage = "crowd ROUTER ORG COUNT RATE_HZ [troubled] [stamped]";
    let [router, org, count, rate_hz, rest @ ..] = args.as_slice() else { return Err(usage.into()) };
    let (router, org, count, rate_hz): (Endpoint, Name, usize, u64) =
        (router.parse()?, org.parse()?, count.parse()?, rate_hz.parse()?);
    if !(1..=50).contains(&rate_hz) || count == 0 {
        return Err("RATE_HZ goes from 1 to 50, COUNT begins with 1".into());
    }
    if let Some(word) = rest.iter().find(|word| !["troubled", "stamped"].contains(&word.as_str())) {
        return Err(format!("{word}: {usage}").into());
    }
    let has = |wanted: &str| rest.iter().any(|word| word == wanted);
    let began = Instant::now();
    let planes = (0..count).map(|index| Plane::new(index, has("troubled"), has("stamped")));
    let planes = planes.collect::<Result<Vec<_>, _>>()?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let aloft = runtime.block_on(all_aloft(&router, &org, planes, began))?;
    println!("{{\"aircraft\": {count}, \"took_s\": {:.2}}}", began.elapsed().as_secs_f64());
    let is_over = Arc::new(AtomicBool::new(false));
    let over = is_over.clone();
    std::thread::spawn(move || {
        // Whatever ends it, it is the end.
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        over.store(true, Ordering::Relaxed);
    });
    let (took_off, echo) = (began.elapsed(), echo_key(&org));
    let period = Duration::from_secs(1) / u32::try_from(rate_hz)?;
    let (mut round, mut bytes) = (0_u64, 0_usize);
    while !is_over.load(Ordering::Relaxed) {
        for (index, aircraft) in aloft.iter().enumerate() {
            let turn = period * u32::try_from(index)? / u32::try_from(count)?;
            let due = took_off + period * u32::try_from(round)? + turn;
            let early = due.saturating_sub(began.elapsed());
            if early > NAP {
                std::thread::sleep(early);
            }
            let says_state = lock(&aircraft.plane).speaks(round, rate_hz);
            bytes += aircraft.speak(MonoTime::from_origin(began.elapsed()), says_state)?;
            if round.is_multiple_of(rate_hz) {
                aircraft.ask_echo(&echo)?;
            }
        }
        round += 1;
    }
    println!("{{\"rounds\": {round}, \"bytes\": {bytes}, \"s\": {:.1}}}", (began.elapsed() - took_off).as_secs_f64());
    // The sessions end with the process: to end a thousand one by one takes long.
    std::process::exit(0)
}

async fn all_aloft(router: &Endpoint, org: &Name, planes: Vec<Plane>, began: Instant) -> Result<Vec<Aloft>, String> {
    let (mut aloft, mut planes, mut opening) = (Vec::new(), planes.into_iter(), tokio::task::JoinSet::new());
    loop {
        while opening.len() < OPENED_AT_ONCE
            && let Some(plane) = planes.next()
        {
            opening.spawn(Aloft::new(router.clone(), org.clone(), plane, began));
        }
        let Some(opened) = opening.join_next().await else { return Ok(aloft) };
        aloft.push(opened.map_err(|error| error.to_string())??);
    }
}

fn answers_to(plane: &Mutex<Plane>, kind: Kind, query: &Query, now: MonoTime) -> Vec<Vec<u8>> {
    let mut plane = lock(plane);
    match kind {
        Kind::Order => {
            let payload = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
            plane.on_order(&payload, now).map(|answer| answer.encode_to_vec()).into_iter().collect()
        }
        Kind::State => {
            let held = plane.authority.held();
            vec![plane.source.everything(held, now).encode_to_vec()]
        }
        Kind::Event => {
            let from = query.parameters().get("from").and_then(|from| from.parse().ok()).unwrap_or(1);
            plane.source.events_from(from).map(|event| event.encode_to_vec()).collect::<Vec<_>>()
        }
        Kind::Alive | Kind::List | Kind::HistoryIndex | Kind::HistoryChunk => Vec::new(),
    }
}
